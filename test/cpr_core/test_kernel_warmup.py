# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""When kernels are compiled: never on import, all at once on demand, and not without a word."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numba
from helpers.everything import EVERYTHING
from helpers.quick_end import QUICK_END

import cpr_core
from cpr_core.command_line import compile_command
from cpr_core.kernel_warmup import compile_kernels, kernel_names, watch_compilation

CPR = ("-m", "cpr_core.command_line")

#: Slow to import, and not needed to solve for an equilibrium.
HEAVY = (
    "distributed",
    "matplotlib",
    "pandas",
    "scipy.integrate",
    "scipy.interpolate",
    "scipy.linalg",
    "scipy.optimize",
    "scipy.sparse",
    "scipy.spatial",
    "tqdm",
    "xarray",
)

IMPORT = """
import json, sys
from numba.core import event
compiled = []
class Listener(event.Listener):
    def on_start(self, event):
        compiled.append(str(event.data["dispatcher"]))
    def on_end(self, event):
        pass
event.register("numba:compile", Listener())
brought = set(sys.modules)
import cpr_core
print(json.dumps({"compiled": compiled, "modules": sorted(set(sys.modules) - brought)}))
"""


def run(*arguments, cache=None):
    environment = os.environ | ({"NUMBA_CACHE_DIR": str(cache)} if cache else {})
    return subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        timeout=600,
        check=True,
        env=environment,
    )


def kept_kernels():
    """Names of the kernels whose machine code lies beside the package."""
    package = Path(cpr_core.__file__).parent
    indices = [index.relative_to(package) for index in package.rglob("__pycache__/*.nbi")]
    return {".".join([*index.parts[:-2], index.name.rpartition("-")[0]]) for index in indices}


def test_importing_compiles_nothing_and_imports_nothing_heavy(tmp_path):
    found = json.loads(run("-c", QUICK_END + IMPORT, cache=tmp_path).stdout)
    assert found["compiled"] == []
    assert "cpr_core.kernels.newton_kernel" in found["modules"]
    assert set(HEAVY) & set(found["modules"]) == set()


def test_kernels_once_compiled_are_not_compiled_again():
    assert list(compile_kernels()) == ["solver", "maps", "derivatives"]
    compiled = []
    with watch_compilation(compiled.append):
        assert list(compile_kernels()) == ["solver", "maps", "derivatives"]
    assert compiled == []


def test_a_command_that_has_to_compile_says_so_at_once(tmp_path):
    process = subprocess.Popen(
        [sys.executable, *CPR, "forward", "rfrfr", "--motors", "2.59", "0.55"],
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
    )
    try:
        assert process.stderr.readline().startswith("cpr: compiling kernels")
    finally:
        process.kill()
        process.communicate()


def test_compiling_ahead_leaves_nothing_to_compile(compiled):
    """The run of tests has begun with it (conftest.py), into a cache that a fresh clone finds empty."""
    again = run(*CPR, "compile")
    assert again.stdout == f"all {len(kernel_names())} kernels were compiled before\n"
    assert again.stderr == ""
    assert set(kernel_names()) <= kept_kernels()
    assert json.loads(run("-c", QUICK_END + EVERYTHING).stdout) == []


#: Prints kernels that are used, but not by what compiles them ahead. All are kept, so none is compiled.
USED_BUT_NOT_AHEAD = """
import importlib, json
from cpr_core.kernel_warmup import compile_kernels
from cpr_core.kernels.kernel_sources import kernel_modules, read_sources
def used():
    modules = [importlib.import_module("cpr_core." + name) for name in kernel_modules(read_sources())]
    return {
        module.__name__ + "." + name: len(member.signatures)
        for module in modules
        for name, member in vars(module).items()
        if getattr(getattr(member, "py_func", None), "__module__", None) == module.__name__
    }
list(compile_kernels())
ahead = used()
exec(EVERYTHING)
later = used()
assert sum(ahead.values()) > 10
print(json.dumps([name for name in later if later[name] > ahead[name]]))
"""


def test_compile_knows_all_that_is_used(compiled):
    """By itself: what else has compiled kernels beside it (conftest.py) hides what it leaves out."""
    program = USED_BUT_NOT_AHEAD.replace("exec(EVERYTHING)", EVERYTHING)
    *_, found = run("-c", QUICK_END + program).stdout.splitlines()
    assert json.loads(found) == []


def test_what_is_compiled_is_counted(monkeypatch):
    def doubled(number):
        return 2.0 * number

    doubled.__module__ = "cpr_core.kernels.some_kernel"
    kernel = numba.njit(doubled)
    monkeypatch.setattr(
        compile_command, "compile_kernels", lambda: (kernel(number) for number in (1.0, 2.0))
    )
    assert re.fullmatch("1 kernels compiled in [0-9]+ s", compile_command.compile_all())
    assert (
        compile_command.compile_all() == f"all {len(kernel_names())} kernels were compiled before"
    )

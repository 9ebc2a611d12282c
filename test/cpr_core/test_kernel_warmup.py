# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""When kernels are compiled: never on import, all at once on demand, and not without a word."""

import json
import os
import subprocess
import sys

import pytest

from cpr_core.kernel_warmup import compile_kernels, kernel_names, watch_compilation

#: Slow to import, and not needed to solve for an equilibrium.
HEAVY = (
    "distributed",
    "matplotlib",
    "pandas",
    "scipy.integrate",
    "scipy.interpolate",
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
import scipy.linalg  # what it brings along is its affair, and differs between versions
brought = set(sys.modules)
import cpr_core
print(json.dumps({"compiled": compiled, "modules": sorted(set(sys.modules) - brought)}))
"""

EVERYTHING = """
import json
import cpr_core
from cpr_core.kernel_warmup import watch_compilation
from cpr_core.description.description_file import shipped_robots
compiled = []
solvers = {
    "motors": cpr_core.solve_forward,
    "efforts": cpr_core.solve_forward_by_effort,
    "pose": cpr_core.solve_inverse,
}
with watch_compilation(compiled.append):
    for name in shipped_robots():
        robot = cpr_core.load_robot(name)
        home = cpr_core.solve_home(robot)
        for what, solve in solvers.items():
            values = getattr(home, what)
            if len(values):
                assert solve(robot, values, start=home).converged
        cpr_core.kinemato_statics(home)
        assert home.spectrum_free.eigenvalues.size
        cpr_core.leg_shapes(home)
        cpr_core.bending_strains(home)
print(json.dumps(compiled))
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


def kernel_of(index):
    """Name of the kernel of a file in the cache."""
    package = index.parent.name.rpartition("_")[0]
    return f"{package}.{index.name.rpartition('-')[0]}".removeprefix("cpr_core.")


def test_importing_compiles_nothing_and_imports_nothing_heavy(tmp_path):
    found = json.loads(run("-c", IMPORT, cache=tmp_path).stdout)
    assert found["compiled"] == []
    assert "cpr_core.kernels.newton_kernel" in found["modules"]
    assert set(HEAVY) & set(found["modules"]) == set()


def test_kernels_once_compiled_are_not_compiled_again():
    assert list(compile_kernels()) == ["solver", "maps"]
    compiled = []
    with watch_compilation(compiled.append):
        assert list(compile_kernels()) == ["solver", "maps"]
    assert compiled == []


@pytest.mark.slow
def test_a_cold_cache_is_said_and_filled_for_everything(tmp_path):
    cpr = ("-m", "cpr_core.command_line")
    cold = run(*cpr, "forward", "rfrfr", "--motors", "2.59", "0.55", cache=tmp_path)
    assert cold.stderr.startswith("cpr: compiling kernels")
    rest = run(*cpr, "compile", cache=tmp_path)
    assert "kernels compiled in" in rest.stdout
    again = run(*cpr, "compile", cache=tmp_path)
    assert again.stdout == f"all {len(kernel_names())} kernels were compiled before\n"
    assert again.stderr == ""
    assert set(kernel_names()) <= {kernel_of(index) for index in tmp_path.rglob("*.nbi")}
    assert json.loads(run("-c", EVERYTHING, cache=tmp_path).stdout) == []

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""numba behind its fence: nothing else imports it, and its private interfaces may be missing."""

import ast
import json
import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from helpers.import_statements import import_statements
from helpers.package_imports import modules_of
from helpers.quick_end import QUICK_END

from benchmarks.numba_without import INTERFACES
from cpr_core import numba_fence
from cpr_core.numba_fence import cache_stamp

ROOT = Path(__file__).parents[3]
#: What imports numba outside of the fence, and why.
OUTSIDE = {"benchmarks.numba_without": "hides interfaces of numba before the fence looks for them"}
#: What takes the place of an interface, by what is asked of numba for a kernel.
WITHOUT = {
    "loop hint": ("pipeline_class", "the lowering of its passes"),
    "cache stamp": ("cache", "the stamp of its cache"),
    "loaded code": ("", "the loading of its cache"),
    "compile events": ("", "events of compiling"),
    "_nrt": ("_nrt", "the option _nrt"),
    "forceinline": ("forceinline", "the option forceinline"),
    "no_cpython_wrapper": ("no_cpython_wrapper", "the option no_cpython_wrapper"),
    "no_cfunc_wrapper": ("no_cfunc_wrapper", "the option no_cfunc_wrapper"),
}

#: A kernel with every option, and what numba is asked for; nothing is compiled.
WIRING = """
import json, warnings
from benchmarks.numba_without import hide
hide(*{hidden!r})
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    from cpr_core import numba_fence
    import cpr_core
asked, njit = {{}}, numba_fence.njit
def listening(**options):
    asked.update(options)
    return njit(**options)
numba_fence.njit = listening
function = cpr_core.validation.checked_vector  # any: it is not called
options = dict(_nrt=False, forceinline=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)
numba_fence.compile_kernel(function, ("stamp", 0), False, **options)
with numba_fence.hear_compilation(lambda function: None):
    pass
print(json.dumps({{
    "asked": [name for name, value in asked.items() if value is not False or name == "_nrt"],
    "missing": numba_fence.MISSING,
    "warnings": [str(w.message) for w in caught if w.category is RuntimeWarning],
}}))
"""

#: Kernels of several kinds, none of the interfaces. All that a solve needs takes minutes to compile so;
#: benchmarks/numba_without.py does it.
RUN = """
import json, warnings
from benchmarks.numba_without import hide
hide({hidden})
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    import numpy as np
    import cpr_core
    from cpr_core.kernel_warmup import watch_compilation
    from cpr_core.kernels import lu_kernel, rotation_kernel
    from cpr_core.lie import rotation_exp
    named = []
    with watch_compilation(named.append):
        {kernels}
print(json.dumps({{
    "found": found,
    "named": named,
    "warnings": [str(w.message) for w in caught if w.category is RuntimeWarning],
}}))
"""

KERNELS = """
        vectors, pivots = np.empty((4, 3)), np.zeros(3, np.int64)
        moments = np.sin(np.arange(36.0)).reshape(4, 3, 3)
        rotation_kernel.rotation_steps(moments, np.linspace(0.1, 0.4, 4), vectors)
        matrix = rotation_exp(vectors[0]) + np.eye(3)
        assert lu_kernel.lu_factor(matrix, 3, pivots, 1e-14)
        solution = vectors[1].copy()
        lu_kernel.lu_solve(matrix, 3, pivots, solution)
        found = vectors.tolist() + [solution.tolist()]
"""


def run(code, cache, timeout=120):
    done = subprocess.run(
        [sys.executable, "-c", QUICK_END + code],
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
        cwd=ROOT,
        env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def imports_numba(path):
    for node in import_statements(path.read_text()):
        names = [name.name for name in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and not node.level:
            names = [node.module]
        if {name.partition(".")[0] for name in names} & {"numba", "llvmlite"}:
            return True
    return False


def test_nothing_but_the_fence_imports_numba():
    importing = {name for name, path in modules_of(ROOT).items() if imports_numba(path)}
    outside = {name for name in importing if not name.startswith("cpr_core.numba_fence")}
    assert "cpr_core.numba_fence.loop_hint" in importing
    assert outside == {*OUTSIDE}


def test_every_interface_can_be_missing():
    assert set(WITHOUT) == set(INTERFACES)
    assert numba_fence.MISSING == ()


@pytest.mark.parametrize("hidden", [(), *((name,) for name in WITHOUT), tuple(WITHOUT)], ids=str)
def test_what_is_missing_is_not_asked_for_and_said_once(tmp_path, hidden):
    found = run(WIRING.format(hidden=hidden), tmp_path)
    every = {name for name, _ in WITHOUT.values() if name}
    assert set(found["asked"]) & every == every - {WITHOUT[name][0] for name in hidden}
    assert set(found["missing"]) == {WITHOUT[name][1] for name in hidden}
    assert len(found["warnings"]) == (1 if hidden else 0)
    for name in hidden:
        assert WITHOUT[name][1] in found["warnings"][0]


def test_a_numba_without_any_of_them_runs_kernels_with_the_same_results(tmp_path):
    def results(*hidden):
        folder = tmp_path / str(len(hidden))
        code = RUN.format(hidden=", ".join(map(repr, hidden)), kernels=KERNELS.strip())
        return run(code, folder), list(folder.rglob("*.nbi"))

    expected, kept = results()
    assert expected["named"] and kept and not expected["warnings"]
    found, kept = results(*WITHOUT)
    np.testing.assert_allclose(found["found"], expected["found"], rtol=1e-13)
    assert len(found["warnings"]) == 1
    assert found["named"] == []  # nobody tells
    assert not [path for path in kept if "cpr_core" in path.parent.name]


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("numba.core.typing.templates", "AbstractTemplate"),
        ("numba.core.typing.templates", "AttributeTemplate"),
        ("numba.extending", "lower_getattr_generic"),
    ],
)
def test_a_numba_without_what_types_are_made_with_is_named(tmp_path, module, name):
    """There is no way without; a bare name of numba told nobody what to install."""
    code = f"import {module} as library\ndel library.{name}\nimport cpr_core"
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=ROOT,
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
    )
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert last.startswith(f"ImportError: numba {numba_fence.VERSION} lacks what types of kernels")
    assert name in last and last.endswith("setup.py names the versions that have it")


#: A kernel from disk, then one that is made of it and never was there.
LOADED = """
import json, sys
import numpy as np
from cpr_core.kernels.rotation_matrices import rotation_exp_into
from cpr_core.numba_fence import hear_compilation, njit
compiled = []
with hear_compilation(lambda function: compiled.append(function.__name__)):
    rotation = np.empty((3, 3))
    rotation_exp_into(0.1, 0.2, 0.3, rotation)
filled = "numba.typed.typeddict" in sys.modules
def first_entry(x, rotation):
    rotation_exp_into(0.1, 0.2, 0.3, rotation)
    return rotation[0, 0] * x
made = njit(first_entry)
print(json.dumps({
    "compiled": compiled, "filled": filled, "rotation": rotation.tolist(),
    "made of it": made(2.0, np.empty((3, 3))),
}))
"""


def test_machine_code_is_loaded_alone_and_other_kernels_are_made_of_it(tmp_path):
    first, again = run(LOADED, tmp_path), run(LOADED, tmp_path)
    assert "rotation_exp_into" in first["compiled"] and first["filled"]
    assert again["compiled"] == [] and not again["filled"]
    assert again["rotation"] == first["rotation"]
    assert again["made of it"] == first["made of it"] == 2.0 * first["rotation"][0][0]


#: A kernel that is compiled where nothing can be written, or not beyond the beginning of a file.
UNKEPT = """
import json, warnings
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    {before}
    import numpy as np
    from cpr_core.kernels.rotation_matrices import rotation_exp_into
    {after}
    rotation = np.empty((3, 3))
    rotation_exp_into(0.1, 0.2, 0.3, rotation)
print(json.dumps({{
    "rotation": rotation.tolist(),
    "warnings": [str(w.message) for w in caught if w.category is RuntimeWarning],
}}))
"""
#: numba finds no folder, as a user without a home who may not write beside the package.
NO_FOLDER = "from numba.core.caching import CacheImpl; CacheImpl._locator_classes = []"
#: As on a full disk, but for the number of the error.
NO_ROOM = (
    "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (100, resource.RLIM_INFINITY))"
)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [(NO_FOLDER, "", "can be kept nowhere"), ("", NO_ROOM, r"cannot be kept in .*File too large")],
)
def test_kernels_that_cannot_be_kept_are_compiled_all_the_same(tmp_path, before, after, said):
    """An import, or a solve that had its answer, ended with words of numba, or of no file at all."""
    expected = run(LOADED, tmp_path / "kept")["rotation"]
    found = run(UNKEPT.format(before=before, after=after), tmp_path / "new")
    assert found["rotation"] == expected
    assert len(found["warnings"]) == 1 and re.search(said, found["warnings"][0])
    assert "NUMBA_CACHE_DIR names" in found["warnings"][0]


def bounds(text):
    return tuple(re.search(r"numba>=([\d.]+),<([\d.]+)", text).groups())


def test_the_supported_versions_are_those_that_are_tested():
    lower, upper = bounds((ROOT / "setup.py").read_text())
    oldest = re.search(r"^numba==(\d+\.\d+)", (ROOT / "tools/oldest.txt").read_text(), re.M)[1]
    newest = re.search(r"^numba==(\d+\.\d+)", (ROOT / "constraints.txt").read_text(), re.M)[1]
    assert lower == oldest
    major, minor = newest.split(".")
    assert upper == f"{major}.{int(minor) + 1}"


def cache_file(folder, stamp="new"):
    return cache_stamp.CacheFile(str(folder), "kernel", (stamp, 0))


def meanwhile(monkeypatch, writer, step, function):
    """Begin something else in the middle of writing, and give it time to end if it does not wait."""
    thread, writes = threading.Thread(target=function), getattr(writer, step)

    def interrupted(*arguments):
        thread.start()
        thread.join(0.5)
        writes(*arguments)

    monkeypatch.setattr(writer, step, interrupted)
    return thread


def test_machine_code_that_two_processes_write_at_once_is_all_kept(tmp_path, monkeypatch):
    cache, other = cache_file(tmp_path), cache_file(tmp_path)
    thread = meanwhile(
        monkeypatch, cache, "_save_index", lambda: other.save("integers", "code for integers")
    )
    cache.save("numbers", "code for numbers")
    thread.join()
    assert cache_file(tmp_path).load("numbers") == "code for numbers"
    assert cache_file(tmp_path).load("integers") == "code for integers"


def test_machine_code_of_before_is_not_read_while_it_is_replaced(tmp_path, monkeypatch):
    cache_file(tmp_path, "old").save("numbers", "old code")
    cache, found = cache_file(tmp_path), []
    assert cache.load("numbers") is None
    thread = meanwhile(
        monkeypatch, cache, "_save_data", lambda: found.append(cache_file(tmp_path).load("numbers"))
    )
    cache.save("numbers", "new code")
    thread.join()
    assert found == ["new code"]

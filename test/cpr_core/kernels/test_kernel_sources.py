# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Compiled kernels: no edit of a kernel leaves stale machine code running."""

import ast
import importlib
import json
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import numba
import numpy as np
import pytest
from helpers.quick_end import QUICK_END
from numpy.testing import assert_allclose
from scipy.linalg import expm

import cpr_core
from cpr_core.kernel_warmup import compile_kernels, kernel_names
from cpr_core.kernels import kernel_decorators, rotation_matrices
from cpr_core.kernels.kernel_decorators import compiled
from cpr_core.kernels.kernel_sources import kernel_modules, kernel_sources, read_sources, stamp_of
from cpr_core.numba_fence.loop_hint import KernelCompiler
from cpr_core.reference import reference_decorators

PACKAGE = Path(cpr_core.__file__).parent
SOURCES = read_sources(PACKAGE)
VECTOR = (0.3, -0.2, 0.5)

#: A kernel that calls one of another module, as the kernels of the model do.
PROBE = f"""
from {compiled.__module__.removeprefix("cpr_core")} import compiled
from {rotation_matrices.__name__.removeprefix("cpr_core")} import rotation_exp_into


@compiled
def probe(vector, rotation):
    rotation_exp_into(vector[0], vector[1], vector[2], rotation)
"""

RUN = f"""
import json
import numpy as np
from cpr_core import probe
rotation = np.empty((3, 3))
probe.probe(np.array({VECTOR}), rotation)
print(json.dumps({{
    "file": probe.__file__,
    "rotation": rotation.tolist(),
    "from_disk": sum(probe.probe.stats.cache_hits.values()),
}}))
"""


def copy_to(path):
    """The package and its descriptions, without machine code."""
    folder = path / "cpr_core"
    shutil.copytree(PACKAGE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    if not (folder / "config").is_dir():
        shutil.copytree(PACKAGE.parent / "config", path / "config")
    return folder


@pytest.fixture
def copied(tmp_path):
    """A copy for one test."""
    return copy_to(tmp_path)


@pytest.fixture(scope="module")
def same_copy(tmp_path_factory):
    """A copy for tests that leave it as it was."""
    return copy_to(tmp_path_factory.mktemp("same_copy"))


def run(copied):
    # -I keeps this checkout out; the copy is put in front by hand.
    code = f"import sys; sys.path.insert(0, {str(copied.parent)!r}){RUN}"
    done = subprocess.run(
        [sys.executable, "-I", "-c", QUICK_END + code],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=copied.parent,
    )
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert Path(result["file"]).parent == copied
    return result


def path_of(folder, module):
    """Source of a module in a folder."""
    path = folder.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def stamp(folder):
    return stamp_of(read_sources(folder))


def replace_once(path, old, new):
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


def imports(module):
    """Modules of the package that a module imports but for annotations, and the names it takes."""
    path = path_of(PACKAGE, module)
    package = module.split(".") if path.name == "__init__.py" else module.split(".")[:-1]
    waiting, found = [ast.parse(path.read_text())], []
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        waiting += ast.iter_child_nodes(node)
        if isinstance(node, ast.Import):
            found += [(name.name.removeprefix("cpr_core."), "") for name in node.names]
        if isinstance(node, ast.ImportFrom):
            origin = (node.module or "").split(".") if node.module else []
            if node.level:
                origin = package[: len(package) - node.level + 1] + origin
            elif origin[0] == "cpr_core":
                origin = origin[1:]
            else:
                continue
            for name in node.names:
                inner = ".".join([*origin, name.name])
                outer = ".".join(origin)
                found.append(
                    (inner, "") if path_of(PACKAGE, inner).exists() else (outer, name.name)
                )
    return [(other, name) for other, name in found if path_of(PACKAGE, other).exists()]


@cache
def decorated(module):
    """Functions of a module under a decorator of kernels."""
    decorators = {
        name
        for other, name in imports(module)
        if f"cpr_core.{other}" == kernel_decorators.__name__ and name in kernel_decorators.__all__
    }
    return [
        node.name
        for node in ast.walk(ast.parse(path_of(PACKAGE, module).read_text()))
        if isinstance(node, ast.FunctionDef)
        and {ast.unparse(decorator) for decorator in node.decorator_list} & decorators
    ]


def test_the_list_of_sources_is_complete():
    found = {path_of(PACKAGE, module) for module in SOURCES}
    assert found == set(PACKAGE.rglob("*.py"))


def test_every_kernel_is_found():
    kernels = {f"{module}.{function}" for module in SOURCES for function in decorated(module)}
    assert len({kernel.rpartition(".")[0] for kernel in kernels}) > 10
    assert kernels == set(kernel_names())


def test_every_module_that_kernels_depend_on_is_stamped():
    waiting = [module for module in SOURCES if decorated(module)]
    depended = set()
    while waiting:
        module = waiting.pop()
        if module not in depended:
            depended.add(module)
            waiting += [other for other, _ in imports(module)]
    assert len(depended) > 20
    assert depended <= set(kernel_sources(SOURCES))


def test_the_values_that_kernels_take_are_stamped():
    assert list(compile_kernels())
    taken = set()
    for module in kernel_modules(SOURCES):
        for member in vars(importlib.import_module(f"cpr_core.{module}")).values():
            for kinds in getattr(member, "signatures", ()):
                waiting = list(kinds)
                while waiting:
                    kind = waiting.pop()
                    waiting += getattr(kind, "types", ())
                    if hasattr(kind, "instance_class"):
                        taken.add(kind.instance_class.__module__.removeprefix("cpr_core."))
    assert len(taken) > 2
    assert taken <= set(kernel_sources(SOURCES))


def test_the_stamp_of_a_copy_is_the_same(copied):
    assert stamp(copied) == kernel_decorators._STAMP


@pytest.mark.parametrize("module", kernel_sources(SOURCES))
def test_the_stamp_changes_with_every_source(same_copy, module):
    before = kernel_decorators._STAMP
    path = path_of(same_copy, module)
    source = path.read_bytes()
    path.write_bytes(source + b"\n# another line\n")
    assert stamp(same_copy) != before
    # As long as before, another content.
    path.write_bytes(source[:-2] + bytes([source[-2] ^ 1]) + source[-1:])
    assert stamp(same_copy) != before
    path.write_bytes(source)
    assert stamp(same_copy) == before


def test_the_stamp_does_not_change_with_other_sources(copied):
    before = stamp(copied)
    others = set(SOURCES) - set(kernel_sources(SOURCES))
    assert len(others) > 20
    for module in others:
        path = path_of(copied, module)
        path.write_bytes(path.read_bytes() + b"\n# another line\n")
    assert stamp(copied) == before


def test_a_new_kernel_and_what_it_imports_are_found_wherever_they_are(copied):
    folder = copied / "new" / "folder"
    folder.mkdir(parents=True)
    up = "from ...{} import (  # one\n    {},  # (two)\n)\n"
    decorators = compiled.__module__.removeprefix("cpr_core.")
    (folder / "late.py").write_text(
        f"\n{up.format(decorators, 'compiled')}from . import constants as c\n"
    )
    (folder / "constants.py").write_text("from ..table import TABLE\n")
    (folder.parent / "table.py").write_text("TABLE = 1.0\n")
    sources = read_sources(copied)
    assert "new.folder.late" in kernel_modules(sources)
    new = {"new.folder.late", "new.folder.constants", "new.table"}
    assert set(kernel_sources(sources)) - set(kernel_sources(SOURCES)) == new


def square_sums(values, result):
    for i in range(values.shape[0]):
        for j in range(i):
            result[i] += values[j] * values[j]


def test_loops_of_kernels_are_left_as_they_are_written():
    as_written = numba.njit(pipeline_class=KernelCompiler)(square_sums)
    values, result = np.random.default_rng(1).normal(size=40), np.zeros(40)
    as_written(values, result)
    expected = np.concatenate([[0.0], np.cumsum(values**2)[:-1]])
    assert_allclose(result, expected, rtol=1e-13)
    numbas_own = numba.njit(square_sums)
    numbas_own(values, result)
    wish = "llvm.loop.unroll.disable"
    unoptimised = [kernel.library for kernel in as_written.overloads.values()]
    assert all(wish in library.get_llvm_str() for library in unoptimised)
    sizes = [
        len(next(iter(kernel.inspect_asm().values())).splitlines())
        for kernel in (as_written, numbas_own)
    ]
    assert sizes[0] <= sizes[1]


def test_everything_that_is_compiled_carries_a_stamp():
    """Of what it is decorated with: numba's own is of one file alone."""
    stamps = {}
    for decorators in (kernel_decorators, reference_decorators):
        name = decorators.__name__.rpartition(".")[2]
        assert stamp_of(SOURCES, name) == decorators._STAMP
        stamps |= dict.fromkeys(kernel_modules(SOURCES, name), decorators._STAMP)
    assert len(set(stamps.values())) == 2
    compiled_in = set()
    for module in filter(None, SOURCES):
        if module.endswith("__main__"):
            continue
        imported = importlib.import_module(f"cpr_core.{module}")
        for member in vars(imported).values():
            if getattr(getattr(member, "py_func", None), "__module__", None) == imported.__name__:
                assert member._cache._cache_file._source_stamp == stamps[module]
                compiled_in.add(module)
    assert compiled_in == set(stamps)


def test_what_is_frozen_in_references_is_stamped():
    found = kernel_sources(SOURCES, reference_decorators.__name__.rpartition(".")[2])
    assert {"kernels.natural_units", "reference.rod_equations", "numba_fence"} <= set(found)
    assert not set(found) & set(kernel_modules(SOURCES))


def test_machine_code_is_reused_until_a_called_kernel_changes(copied):
    (copied / "probe.py").write_text(PROBE)
    x, y, z = VECTOR
    expected = expm(np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]))
    first = run(copied)
    assert first["from_disk"] == 0
    assert_allclose(first["rotation"], expected, rtol=0.0, atol=1e-14)
    again = run(copied)
    assert again["from_disk"] == 1
    assert again["rotation"] == first["rotation"]

    # Another module than that of the kernel which is run; no line moves.
    replace_once(
        path_of(copied, rotation_matrices.__name__.removeprefix("cpr_core.")),
        "rotation[0, 0] = 1.0 - versine * (y * y + z * z)",
        "rotation[0, 0] = 2.0 - versine * (y * y + z * z)",
    )
    changed = run(copied)
    expected[0, 0] += 1.0
    assert changed["from_disk"] == 0
    assert_allclose(changed["rotation"], expected, rtol=0.0, atol=1e-14)

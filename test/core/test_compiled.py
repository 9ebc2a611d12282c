# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Compiled kernels: no edit of a kernel leaves stale machine code running."""

import importlib
import importlib.util
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher
from numpy.testing import assert_allclose
from scipy.linalg import expm

from cpr_core.kernels import kernel_decorators
from cpr_core.numba_fence.loop_hint import KernelCompiler

PACKAGE = Path(kernel_decorators.__file__).parent
VECTOR = (0.3, -0.2, 0.5)

#: A kernel that calls one of another module, as the kernels of the model do.
PROBE = """
from .kernel_decorators import compiled
from .rotation_matrices import rotation_exp_into


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


@pytest.fixture
def copied(tmp_path):
    """The package and its descriptions, without machine code."""
    folder = tmp_path / "cpr_core"
    shutil.copytree(PACKAGE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    if not (folder / "config").is_dir():
        shutil.copytree(PACKAGE.parent / "config", tmp_path / "config")
    return folder


def run(copied):
    # -I keeps this checkout out; the copy is put in front by hand.
    code = f"import sys; sys.path.insert(0, {str(copied.parent)!r}){RUN}"
    done = subprocess.run(
        [sys.executable, "-I", "-c", code],
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


def stamp(folder):
    """Stamp of the sources in a folder, by the module of that folder."""
    spec = importlib.util.spec_from_file_location(
        "cpr_core.copied_decorators", folder / "kernel_decorators.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module._STAMP


def replace_once(path, old, new):
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


def test_every_module_with_kernels_is_stamped():
    with_kernels = {
        path.stem
        for path in PACKAGE.glob("*.py")
        if re.search(r"^@compiled\b", path.read_text(), re.MULTILINE)
    }
    assert with_kernels
    assert with_kernels <= set(kernel_decorators.KERNEL_MODULES)


def test_the_stamp_of_a_copy_is_the_same(copied):
    assert stamp(copied) == kernel_decorators._stamp()


@pytest.mark.parametrize("module", kernel_decorators.KERNEL_MODULES)
def test_the_stamp_changes_with_every_kernel_source(copied, module):
    before = stamp(copied)
    path = copied / f"{module.replace('.', '/')}.py"
    source = path.read_bytes()
    path.write_bytes(source + b"\n# another line\n")
    assert stamp(copied) != before
    # As long as before, another content.
    path.write_bytes(source[:-2] + bytes([source[-2] ^ 1]) + source[-1:])
    assert stamp(copied) != before
    path.write_bytes(source)
    assert stamp(copied) == before


def test_the_stamp_changes_with_the_way_of_compiling(copied):
    before = stamp(copied)
    replace_once(copied / "kernel_decorators.py", 'error_model="numpy"', 'error_model="python"')
    assert stamp(copied) != before


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


@pytest.mark.parametrize("module", kernel_decorators.KERNEL_MODULES)
def test_every_kernel_carries_the_stamp(module):
    members = vars(importlib.import_module(f"cpr_core.{module}"))
    kernels = [member for member in members.values() if isinstance(member, Dispatcher)]
    assert kernels
    for kernel in kernels:
        assert kernel._cache._cache_file._source_stamp == kernel_decorators._STAMP


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
        copied / "lie.py",
        "rotation[0, 0] = 1.0 - versine * (y * y + z * z)",
        "rotation[0, 0] = 2.0 - versine * (y * y + z * z)",
    )
    changed = run(copied)
    expected[0, 0] += 1.0
    assert changed["from_disk"] == 0
    assert_allclose(changed["rotation"], expected, rtol=0.0, atol=1e-14)

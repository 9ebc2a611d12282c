# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How the kernels of this package are compiled: numba, cached on disk, free of the GIL."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core.caching import IndexDataCacheFile

from .kernel_compiler import KernelCompiler

__all__ = [
    "KERNEL_MODULES",
    "allocating_part",
    "compiled",
    "compiled_strictly",
    "inlined",
    "kernel",
    "part",
]

Function = TypeVar("Function", bound=Callable[..., Any])

#: Modules whose functions call each other in compiled code.
KERNEL_MODULES = (
    "lane_vectors",
    "lie",
    "rotation_kernel",
    "rod_kernel",
    "base_kernel",
    "tip_kernel",
    "stiffness_kernel",
    "leg_kernel",
    "model_kernel",
    "condensation_kernel",
    "inertia_kernel",
    "newton_kernel",
    "step_kernel",
    "pencil_kernel",
    "first_order_kernel",
    "bound_robot",
    "workspace.eigenvalue_kernel",
    "workspace.step_kernel",
    "workspace.analysis_kernel",
    "workspace.batch_kernel",
)
#: What else the compiled code depends on: how it is compiled and what its data look like.
_CONTEXT_MODULES = ("compiled", "kernel_compiler", "arrays", "slots", "pencil", "lanes")

#: Sums may be reordered so that they vectorise; NaN and infinity keep their meaning.
FASTMATH = {"contract", "nsz", "reassoc"}


def _stamp() -> tuple[str, int]:
    """Fingerprint of every kernel source, in the form of a numba source stamp."""
    digest = hashlib.sha256()
    size = 0
    for module in (*_CONTEXT_MODULES, *KERNEL_MODULES):
        source = (Path(__file__).parent / f"{module.replace('.', '/')}.py").read_bytes()
        digest.update(source)
        size += len(source)
    return digest.hexdigest(), size


_STAMP = _stamp()


class _CacheFile(IndexDataCacheFile):
    """What is on disk may name types that an earlier version had: then it is as good as not there."""

    def _load_index(self) -> Any:
        try:
            return super()._load_index()
        except (AttributeError, ImportError):
            return {}


def compiled(function: Function) -> Function:
    """Compile a kernel on its first call and keep the machine code on disk.

    numba renews a cached function when the file that defines it changes, but not when a function it
    calls from another file does; after an edit or an upgrade stale code would run. Every kernel is
    therefore stamped with all kernel sources together.
    """
    return _stamped(function, FASTMATH)


def kernel(function: Function) -> Function:
    """Compile a kernel that allocates nothing.

    References to its arrays are not counted: with the hundred arrays of a robot and a workspace that
    would cost more than the work on them.
    """
    return _stamped(function, FASTMATH, _nrt=False)


def part(function: Function) -> Function:
    """Compile a kernel that only kernels call: what Python would enter by takes as long to compile."""
    return _stamped(function, FASTMATH, _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def allocating_part(function: Function) -> Function:
    """The same of a kernel that needs memory of its own."""
    return _stamped(function, FASTMATH, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def inlined(function: Function) -> Function:
    """Compile a part of a kernel that is only cut out to be read; Python cannot call it.

    A robot and a workspace are several hundred words, which a call would copy.
    """
    return _stamped(
        function,
        FASTMATH,
        _nrt=False,
        forceinline=True,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
    )


def compiled_strictly(function: Function) -> Function:
    """Compile a kernel whose sums are not reordered.

    Its result is the same to the last bit whether it was just compiled or loaded from disk: the linker
    may take either of two copies of a function, which were optimised differently.
    """
    return _stamped(function, False)


def _stamped(function: Function, fastmath: Any, **options: Any) -> Function:
    dispatcher = numba.njit(
        cache=True,
        nogil=True,
        error_model="numpy",
        fastmath=fastmath,
        pipeline_class=KernelCompiler,
        **options,
    )(function)
    dispatcher._cache._cache_file._source_stamp = _STAMP
    dispatcher._cache._cache_file.__class__ = _CacheFile
    return dispatcher

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How the kernels of this package are compiled: numba, cached on disk, free of the GIL."""

from __future__ import annotations

from ..numba_fence import REORDERED_SUMS, Function, compile_kernel
from .kernel_sources import read_sources, stamp_of

__all__ = [
    "allocating_part",
    "compiled",
    "inlined",
    "kernel",
    "part",
    "strict_allocating_part",
    "strict_part",
]

#: Of all sources: kernels call each other across modules.
_STAMP = stamp_of(read_sources())


def compiled(function: Function) -> Function:
    """Compile a kernel on its first call and keep the machine code on disk."""
    return compile_kernel(function, _STAMP, REORDERED_SUMS, no_cfunc_wrapper=True)


def kernel(function: Function) -> Function:
    """Compile a kernel that allocates nothing.

    References to its arrays are not counted: with the hundred arrays of a robot and a workspace that
    would cost more than the work on them.
    """
    return compile_kernel(function, _STAMP, REORDERED_SUMS, _nrt=False, no_cfunc_wrapper=True)


def part(function: Function) -> Function:
    """Compile a kernel that only kernels call: what Python would enter by takes as long to compile."""
    return compile_kernel(
        function, _STAMP, REORDERED_SUMS, _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True
    )


def allocating_part(function: Function) -> Function:
    """The same of a kernel that needs memory of its own."""
    return compile_kernel(
        function, _STAMP, REORDERED_SUMS, no_cpython_wrapper=True, no_cfunc_wrapper=True
    )


def inlined(function: Function) -> Function:
    """Compile a part of a kernel that is only cut out to be read; Python cannot call it.

    A robot and a workspace are several hundred words, which a call would copy.
    """
    return compile_kernel(
        function,
        _STAMP,
        REORDERED_SUMS,
        _nrt=False,
        forceinline=True,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
    )


def strict_part(function: Function) -> Function:
    """A part whose sums are not reordered.

    Its result is the same to the last bit whether it was just compiled or loaded from disk: the linker
    may take either of two copies of a function, which were optimised differently.
    """
    return compile_kernel(
        function,
        _STAMP,
        fastmath=False,
        _nrt=False,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
    )


def strict_allocating_part(function: Function) -> Function:
    """The same of a kernel that needs memory of its own."""
    return compile_kernel(
        function, _STAMP, fastmath=False, no_cpython_wrapper=True, no_cfunc_wrapper=True
    )

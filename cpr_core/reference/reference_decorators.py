# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How the references are compiled: with loops as numba makes them, cached on disk.

They are no kernels of the library: nobody waits for them ahead, and an edit of the library renews only
the machine code of references that it is frozen in. Their machine code has a stamp of its own.
"""

from __future__ import annotations

from ..kernels.kernel_sources import read_sources, stamp_of
from ..numba_fence import REORDERED_SUMS, Function, compile_kernel

__all__ = ["in_order", "reference", "reference_part"]

_STAMP = stamp_of(read_sources(), __name__.rpartition(".")[2])


def reference(function: Function) -> Function:
    """Compile a function on its first call."""
    return compile_kernel(function, _STAMP, REORDERED_SUMS, unrolled=True)


def reference_part(function: Function) -> Function:
    """Compile a part that is only cut out to be read: a call counts all arrays of a robot."""
    return compile_kernel(function, _STAMP, REORDERED_SUMS, unrolled=True, inline="always")


def in_order(function: Function) -> Function:
    """Compile a function whose sums are made in the order in which they are written."""
    return compile_kernel(function, _STAMP, {"contract"}, unrolled=True)

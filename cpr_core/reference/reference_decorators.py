# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How the references are compiled: with loops as numba makes them, cached on disk.

They are no kernels of the library: nobody waits for them ahead, and an edit of the library renews only
the machine code of references that it is frozen in. Their machine code has a stamp of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from ..kernels.kernel_sources import read_sources, stamp_of
from ..numba_fence import compile_kernel

__all__ = ["in_order", "reference", "reference_part"]

Function = TypeVar("Function", bound=Callable[..., Any])

#: Sums may be reordered so that they vectorise; NaN and infinity keep their meaning.
FASTMATH = {"contract", "nsz", "reassoc"}

_STAMP = stamp_of(read_sources(), __name__.rpartition(".")[2])


def reference(function: Function) -> Function:
    """Compile a function on its first call."""
    return compile_kernel(function, _STAMP, FASTMATH, unrolled=True)


def reference_part(function: Function) -> Function:
    """Compile a part that is only cut out to be read: a call counts all arrays of a robot."""
    return compile_kernel(function, _STAMP, FASTMATH, unrolled=True, inline="always")


def in_order(function: Function) -> Function:
    """Compile a function whose sums are made in the order in which they are written."""
    return compile_kernel(function, _STAMP, {"contract"}, unrolled=True)

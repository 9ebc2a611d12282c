# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One thread for LAPACK, whose matrices here have a hundred rows or so.

Its threads wait for each other at every step: on busy cores that takes many times longer than the work.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

__all__ = ["on_one_blas_thread"]

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

_lock = threading.Lock()
#: Calls that are under way in all threads of the process, and what the first of them has limited.
_under_way = 0
_limited: Any = None


@cache
def _controller() -> Any:
    """Looking for the libraries takes milliseconds."""
    import scipy.linalg  # noqa: F401  brings its own BLAS, which has to be there to be found
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def on_one_blas_thread(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Let a function use one thread of BLAS. The number is the process's: the last call restores it."""

    @wraps(function)
    def limited(*args: Parameters.args, **kwargs: Parameters.kwargs) -> Result:
        _begin()
        try:
            return function(*args, **kwargs)
        finally:
            _end()

    return limited


def _begin() -> None:
    global _under_way, _limited
    with _lock:
        if _under_way == 0:
            _limited = _controller().limit(limits=1, user_api="blas")
            _limited.__enter__()
        _under_way += 1


def _end() -> None:
    global _under_way, _limited
    with _lock:
        _under_way -= 1
        if _under_way == 0:
            _limited.__exit__(None, None, None)
            _limited = None

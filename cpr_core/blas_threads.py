# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One thread for LAPACK, whose matrices here have a hundred rows or so.

Its threads wait for each other at every step: on busy cores that takes many times longer than the work.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

__all__ = ["on_one_blas_thread", "on_one_numpy_thread"]

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

_lock = threading.Lock()
#: Calls that are under way in all threads of the process, the files of libraries that are limited for
#: them, and what gives these their threads back.
_under_way = 0
_limited: set[str] = set()
_limits = ExitStack()


@cache
def _libraries(with_scipy: bool) -> dict[str, Any]:
    """The libraries by file, looked for once without and once with scipy, which brings its own."""
    from threadpoolctl import ThreadpoolController

    found = ThreadpoolController().select(user_api="blas")
    return {
        library.filepath: found.select(filepath=library.filepath)
        for library in found.lib_controllers
    }


def on_one_blas_thread(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Let a function use one thread of BLAS. The number is the process's: the last call restores it."""
    return _on_one_thread(function, with_scipy=True)


def on_one_numpy_thread(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """The same of a function that uses numpy only: it does not wait for scipy to be imported."""
    return _on_one_thread(function, with_scipy=False)


def _on_one_thread(
    function: Callable[Parameters, Result], with_scipy: bool
) -> Callable[Parameters, Result]:
    @wraps(function)
    def limited(*args: Parameters.args, **kwargs: Parameters.kwargs) -> Result:
        _begin(with_scipy)
        try:
            return function(*args, **kwargs)
        finally:
            _end()

    return limited


def _begin(with_scipy: bool) -> None:
    global _under_way
    if with_scipy:
        import scipy.linalg  # noqa: F401  brings its own BLAS, which has to be there to be found
    with _lock:
        for path, library in _libraries(with_scipy).items():
            if path not in _limited:
                _limited.add(path)
                if library.lib_controllers[0].num_threads != 1:  # to limit it takes 10 us
                    _limits.enter_context(library.limit(limits=1, user_api="blas"))
        _under_way += 1


def _end() -> None:
    global _under_way
    with _lock:
        _under_way -= 1
        if _under_way == 0:
            _limited.clear()
            _limits.close()

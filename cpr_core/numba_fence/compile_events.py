# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Hearing when numba compiles; loading from disk is no such event."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

from numba.core.event import Listener, install_listener

__all__ = ["hear_compilation"]


class _Listener(Listener):
    def __init__(self, begun: Callable[[Callable[..., Any]], None]) -> None:
        self._begun = begun

    def on_start(self, event: Any) -> None:
        self._begun(event.data["dispatcher"].py_func)

    def on_end(self, event: Any) -> None:
        pass


def hear_compilation(
    begun: Callable[[Callable[..., Any]], None],
) -> AbstractContextManager[Any]:
    """Call ``begun`` with every function that numba begins to compile, in any thread."""
    return install_listener("numba:compile", _Listener(begun))

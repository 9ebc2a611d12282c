# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Hearing when numba compiles; loading from disk is no such event."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.event import Listener, install_listener, register

__all__ = ["hear_compilation"]

_PACKAGE = __name__.partition(".")[0]
#: Who listens now, and whether compiling was told where nobody did.
_listeners: list[Listener] = []
_told: list[str] = []


class _Listener(Listener):
    def __init__(self, begun: Callable[[Callable[..., Any]], None]) -> None:
        self._begun = begun

    def on_start(self, event: Any) -> None:
        self._begun(event.data["dispatcher"].py_func)

    def on_end(self, event: Any) -> None:
        pass


@contextmanager
def hear_compilation(begun: Callable[[Callable[..., Any]], None]) -> Iterator[None]:
    """Call ``begun`` with every function that numba begins to compile, in any thread."""
    listener = _Listener(begun)
    _listeners.append(listener)
    try:
        with install_listener("numba:compile", listener):
            yield
    finally:
        _listeners.remove(listener)


def _tell_once(function: Callable[..., Any]) -> None:
    """Say why a first call takes long, unless somebody else shows it."""
    if _told or _listeners or not (function.__module__ or "").startswith(f"{_PACKAGE}."):
        return
    _told.append(function.__name__)
    logging.getLogger(_PACKAGE).warning(
        "%s: compiling kernels, once after an installation or an upgrade (one or two minutes; "
        "`cpr compile` does it ahead, but for those of cpr_core.reference)",
        _PACKAGE,
    )


register("numba:compile", _Listener(_tell_once))

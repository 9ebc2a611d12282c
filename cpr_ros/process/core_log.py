# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the core logs, and warnings of Python, go into the log of the node."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import rclpy

__all__ = ["core_log_in"]

#: Who speaks, and how loud that is here. The core logs nothing to be warned of: only what takes long,
#: as a warning so that Python shows it where nobody has set logging up.
_SOURCES = {"cpr_core": "info", "py.warnings": "warning"}


class _Forwarding(logging.Handler):
    """Hands records on to a logger of ROS, one line each."""

    def __init__(self, say: Callable[[str], object]) -> None:
        super().__init__()
        self._say = say

    def emit(self, record: logging.LogRecord) -> None:
        if rclpy.ok():  # work that was abandoned at the end may still say something
            self._say(" ".join(record.getMessage().split()))


@contextmanager
def core_log_in(logger: Any) -> Iterator[None]:
    """Hand what the core says on to a logger of ROS, as long as this lasts."""
    handlers = {
        logging.getLogger(name): _Forwarding(getattr(logger, level))
        for name, level in _SOURCES.items()
    }
    for source, handler in handlers.items():
        source.addHandler(handler)
    logging.captureWarnings(True)
    try:
        yield
    finally:
        logging.captureWarnings(False)
        for source, handler in handlers.items():
            source.removeHandler(handler)

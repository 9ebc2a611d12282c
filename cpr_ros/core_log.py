# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the core logs, and warnings of Python, go into the log of the node."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import rclpy

__all__ = ["core_log_in"]

_SOURCES = ("cpr_core", "py.warnings")


class _Forwarding(logging.Handler):
    """Hands records on to a logger of ROS."""

    def __init__(self, logger: Any) -> None:
        super().__init__()
        self._logger = logger

    def emit(self, record: logging.LogRecord) -> None:
        if rclpy.ok():  # work that was abandoned at the end may still say something
            say = self._logger.warning if record.levelno >= logging.WARNING else self._logger.info
            say(" ".join(record.getMessage().split()))


@contextmanager
def core_log_in(logger: Any) -> Iterator[None]:
    """Hand what the core says on to a logger of ROS, as long as this lasts."""
    handler = _Forwarding(logger)
    sources = [logging.getLogger(name) for name in _SOURCES]
    for source in sources:
        source.addHandler(handler)
    logging.captureWarnings(True)
    try:
        yield
    finally:
        logging.captureWarnings(False)
        for source in sources:
            source.removeHandler(handler)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The node that a benchmark measures, and nodes that measure it."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
from cpr_ros.process.interrupted import interrupted
from cpr_ros.process.own_domain import enter_own_domain
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node

__all__ = ["Spun", "running_node"]


@contextmanager
def running_node(
    *arguments: str, module: str = "cpr_ros.cpr_node"
) -> Iterator[subprocess.Popen[bytes]]:
    """A node in a process of its own, in a domain that nobody else uses; this process is in it too.

    It begins at home, whatever was done before. In the end it is interrupted; its status is known then.

    Args:
        arguments: Of its process.
        module: Which runs it.
    """
    domain = enter_own_domain()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["ROS_HOME"] = folder
        process = subprocess.Popen([sys.executable, "-m", module, *arguments])
        try:
            yield process
        finally:
            interrupted(process)
            domain.close()


class Spun(Node):
    """A node with an executor of its own."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.executor_ = EventsExecutor()
        self.executor_.add_node(self)

    def spin(self, seconds: float) -> None:
        """Let time go by."""
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            self.executor_.spin_once(timeout_sec=max(0.0, end - time.perf_counter()))

    def end(self) -> None:
        """Leave the domain."""
        self.executor_.shutdown()
        self.destroy_node()

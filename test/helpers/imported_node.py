# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Nodes from the end of their imports on: copies of a process that has done nothing but these.

As it stands before the first line of its log: of robots, kernels and ROS nothing is loaded or begun.
"""

from __future__ import annotations

import gc
import json
import os
import selectors
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

__all__ = ["ImportedNode", "imported_node"]


class ImportedNode:
    """One copy after the other; the last one is to be used like ``subprocess.Popen``."""

    def __init__(self, original: subprocess.Popen[bytes]) -> None:
        self._original = original
        self.pid = 0
        self.returncode: int | None = None

    def start(self, arguments: Sequence[str], environment: Mapping[str, str], log: Path) -> None:
        """Start the next copy; the one before has ended."""
        order = {"arguments": arguments, "environment": environment, "log": str(log)}
        self._original.stdin.write(f"{json.dumps(order)}\n".encode())
        self.pid, self.returncode = int(self._original.stdout.readline()), None

    def poll(self) -> int | None:
        try:
            return self.wait(0.0)
        except subprocess.TimeoutExpired:
            return None

    def wait(self, timeout: float | None = None) -> int:
        if self.returncode is None:
            with selectors.DefaultSelector() as told:
                told.register(self._original.stdout, selectors.EVENT_READ)
                if not told.select(timeout):
                    raise subprocess.TimeoutExpired("a copy", timeout or 0.0)
            self.returncode = int(self._original.stdout.readline())
        return self.returncode

    def send_signal(self, number: int) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)


@contextmanager
def imported_node() -> Iterator[ImportedNode]:
    """A process that is copied."""
    program = [sys.executable, "-m", "helpers.imported_node"]
    # Without a buffer, in which a status could be that nobody waits for any more.
    with subprocess.Popen(
        program, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0
    ) as original:
        yield ImportedNode(original)


def _copies() -> None:
    """Import what ``cpr_node`` does, and be one whenever a line asks for it; tell pid and status."""
    from cpr_ros import cpr_node

    gc.disable()
    import cpr_ros.node  # noqa: F401
    import cpr_ros.node_run  # noqa: F401

    gc.freeze()
    gc.enable()
    for line in sys.stdin:
        order = json.loads(line)
        pid = os.fork()
        if pid == 0:
            os.environ.clear()
            os.environ.update(order["environment"])
            output = os.open(order["log"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            for stream in (1, 2):
                os.dup2(output, stream)
            sys.argv = ["cpr_node", *order["arguments"]]
            sys.exit(cpr_node.main())
        print(pid, flush=True)
        print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), flush=True)


if __name__ == "__main__":
    _copies()

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Processes that are copies of one which has loaded everything: a node starts in a fifth of the time.

Each is a process of its own with its own DDS, like any other. What is shown of the start of Python
itself needs processes that begin there.
"""

from __future__ import annotations

import multiprocessing
import os
import runpy
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

_LOADED = "helpers.loaded_node"
_context = multiprocessing.get_context("forkserver")
_context.set_forkserver_preload([_LOADED])


class CopiedProcess:
    """A module run as a program; to be used like ``subprocess.Popen``."""

    def __init__(
        self, module: str, arguments: Sequence[str], environment: Mapping[str, str], log: Path
    ) -> None:
        self._process = _context.Process(
            target=_run, args=(module, list(arguments), dict(environment), str(log))
        )
        before = dict(os.environ)
        os.environ.update(environment)  # of whoever is copied: it finds modules by PYTHONPATH
        try:
            self._process.start()
        finally:
            os.environ.clear()
            os.environ.update(before)
        self.pid: int = self._process.pid

    @property
    def returncode(self) -> int | None:
        return self._process.exitcode

    def poll(self) -> int | None:
        return self._process.exitcode

    def wait(self, timeout: float | None = None) -> int:
        self._process.join(timeout)
        if self._process.exitcode is None:
            raise subprocess.TimeoutExpired(str(self._process), timeout or 0.0)
        return self._process.exitcode

    def send_signal(self, number: int) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)


def _run(module: str, arguments: list[str], environment: dict[str, str], log: str) -> None:
    assert _LOADED in sys.modules, f"{_LOADED} could not be imported"
    os.environ.clear()
    os.environ.update(environment)
    output = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for stream in (1, 2):
        os.dup2(output, stream)
    os.close(output)
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Processes that end when they are interrupted, that have ended, and that do not."""

import subprocess
import sys

from cpr_ros.process.interrupted import interrupted


def started(code):
    """A process that has said that it listens."""
    process = subprocess.Popen(
        [sys.executable, "-c", f"import signal, time\n{code}"], stdout=subprocess.PIPE
    )
    process.stdout.readline()
    return process


def test_one_that_listens_ends_by_itself():
    process = started(
        "signal.signal(signal.SIGINT, lambda *_: exit(3))\nprint(flush=True)\ntime.sleep(60)"
    )
    assert interrupted(process) == 3


def test_one_that_has_ended_has_its_status():
    process = started("print(flush=True)\nexit(2)")
    process.wait()
    assert interrupted(process) == 2


def test_one_that_does_not_listen_is_killed():
    """It was left behind, and its ``TimeoutExpired`` took the place of what had been found out."""
    process = started(
        "signal.signal(signal.SIGINT, signal.SIG_IGN)\nprint(flush=True)\ntime.sleep(60)"
    )
    assert interrupted(process, patience=0.2) == -9

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Interrupts of the command ``cpr`` while it is imported, each time in a process of its own."""

import subprocess
import sys

import pytest

SCRIPT = """
import signal, sys

class Interrupting:
    def find_spec(self, name, *_):
        if name == {module!r}:
            print("begun", flush=True)
            signal.raise_signal(signal.SIGINT)

{first}
sys.meta_path.insert(0, Interrupting())
from cpr_ros.cpr_command import main
sys.argv = ["cpr", "--version"]
sys.exit(main())
"""


#: As in a terminal; tests that run in the background of a script inherit that it is ignored.
HEARD = "signal.signal(signal.SIGINT, signal.default_int_handler)"
IGNORED = "signal.signal(signal.SIGINT, signal.SIG_IGN)"


def interrupted(module, first=HEARD):
    """What became of the command that was interrupted as it began to import a module."""
    script = SCRIPT.format(module=module, first=first)
    ended = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60
    )
    return ended.returncode, ended.stdout, ended.stderr


@pytest.mark.parametrize(
    "module", ["cpr_core", "numpy", "llvmlite", "scipy", "cpr_core.command_line.command"]
)
def test_an_interrupt_within_the_imports_is_told_in_one_line(module):
    assert interrupted(module) == (130, "begun\n", "cpr: interrupted\n")


def test_an_interrupt_that_is_ignored_ends_nothing():
    status, said, problems = interrupted("numpy", IGNORED)
    assert (status, problems) == (0, "")
    assert said.startswith("begun\ncpr ")

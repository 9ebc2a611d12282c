# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Kernels on disk before tests begin whose time would otherwise go into compiling them."""

from __future__ import annotations

import json
import subprocess
import sys

from helpers.everything import EVERYTHING

__all__ = ["compile_beside", "compile_kernels"]


def compile_kernels() -> str:
    """Run `cpr compile`, in a second or two if there is nothing to compile; returns what it says."""
    compiling = [sys.executable, "-m", "cpr_core.command_line", "compile"]
    return subprocess.run(compiling, check=True, stdout=subprocess.PIPE, text=True).stdout


def compile_beside() -> None:
    """The same on two cores, with what only tests use.

    Whatever else had to be compiled afterwards, `cpr compile` has forgotten; tests would fill the gap.
    """
    with subprocess.Popen([sys.executable, "-m", "helpers.compiled_beside"]) as beside:
        if "kernels compiled in" in compile_kernels():
            everything = [sys.executable, "-c", EVERYTHING]
            left = subprocess.run(everything, check=True, stdout=subprocess.PIPE, text=True).stdout
            assert json.loads(left) == [], f"`cpr compile` has left out {left}"
    assert beside.returncode == 0, "what `cpr compile` comes to last was not compiled beside it"


if __name__ == "__main__":
    compile_beside()

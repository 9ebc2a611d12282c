# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Programs without a package that they need."""

import subprocess
import sys

import pytest
from helpers.quick_end import QUICK_END

#: What brings a package.
HOW = {"rclpy": "source /opt/ros/", "cpr_msgs": "./msg_defs", "numba": "pip install ."}

#: A finder that knows no such package stands for an environment without it.
WITHOUT = """
import importlib.abc, sys
class Without(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == {missing!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Without())
from cpr_ros.{program} import main
sys.exit(main())
"""


@pytest.mark.parametrize("missing", HOW)
@pytest.mark.parametrize("program", ["cpr_node", "cpr_view", "cpr_demo"])
def test_a_program_without_what_it_needs_says_what_to_install(program, missing):
    done = subprocess.run(
        [sys.executable, "-c", QUICK_END + WITHOUT.format(program=program, missing=missing)],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 1
    assert done.stderr.startswith(f"{program}: No module named '{missing}")
    assert HOW[missing] in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""

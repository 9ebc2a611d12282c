# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A test that crashes or hangs fails, by its name, and the others are run."""

import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
CRASHING = """
import os
import time

import pytest

@pytest.mark.parametrize("number", range(6))
def test_many(number):
    if number == 2:
        {crash}
"""


@pytest.mark.parametrize("folder", ["over_dds", "solving"])  # files that stay together, and others
@pytest.mark.parametrize("crash", ["os.abort()", "time.sleep(60)"])
def test_it_is_run_once_and_the_others_too(tmp_path, folder, crash):
    (tmp_path / folder).mkdir()
    (tmp_path / folder / "test_crashing.py").write_text(CRASHING.format(crash=crash))
    options = ["-n", "2", "-rfE", "-o", "pythonpath=", "-o", "faulthandler_timeout=3"]
    options += ["-p", "helpers.scheduling", "-c", str(TESTS.parent / "pyproject.toml")]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, f"--rootdir={tmp_path}", str(tmp_path)],
        env={"PYTHONPATH": str(TESTS), "PATH": ""},
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 1, done.stdout
    assert "1 failed, 5 passed" in done.stdout
    assert done.stdout.count("node down") == 1
    crashed = f"{folder}/test_crashing.py::test_many[2]"
    assert f"crashed while running '{crashed}'" in done.stdout

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


#: Other tests of the run may wait for a processor for long, too: that is no hang.
@pytest.mark.parametrize(
    ("crash", "folder", "longest"),
    [
        ("os.abort()", "over_dds", 900),  # its files stay together
        ("os.abort()", "solving", 900),
        ("time.sleep(600)", "over_dds", 20),
    ],
)
def test_it_is_run_once_and_the_others_too(tmp_path, crash, folder, longest):
    (tmp_path / folder).mkdir()
    (tmp_path / folder / "test_crashing.py").write_text(CRASHING.format(crash=crash))
    options = ["-n", "2", "-rfE", "-o", "pythonpath=", "-o", f"faulthandler_timeout={longest}"]
    options += ["-p", "helpers.scheduling", "-c", str(TESTS.parent / "pyproject.toml")]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, f"--rootdir={tmp_path}", str(tmp_path)],
        env={"PYTHONPATH": str(TESTS), "PATH": ""},
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        check=False,
    )
    assert done.returncode == 1, done.stdout
    assert "1 failed, 5 passed" in done.stdout
    assert done.stdout.count("node down") == 1
    crashed = f"{folder}/test_crashing.py::test_many[2]"
    assert f"crashed while running '{crashed}'" in done.stdout

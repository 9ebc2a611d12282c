# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""docs/bench.md from its first command to a felt wrench, against a real node."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers.node_process import NodeProcess, free_domain
from numpy.testing import assert_allclose

from cpr_core import load_robot
from cpr_core.command_line import main

BENCH = Path(__file__).parents[3] / "examples" / "bench_robot.py"
PATHS = ["rod.young_modulus", *(f"legs[{number}].motor.offset" for number in range(6))]
KNOWN = ["--parameters", *PATHS, "--deviations", "position=5e-4", "rotation=2e-3"]
#: What the example hides from the calibration.
REALITY = [197e9, 0.0, 0.0, 0.02, 0.0, 0.0, 0.0]


def bench(folder, *arguments, domain=0):
    done = subprocess.run(
        [sys.executable, BENCH, *arguments],
        cwd=folder,
        env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    poses, data, found = (str(folder / name) for name in ("poses.csv", "data.csv", "found.yaml"))
    asked = ["measure", "six_rfs", "--count", "20", "--reach", "0.3", "--out", poses]
    assert main([*asked, "--wrench", "0", "0", "0", "0", "0", "-1", *KNOWN]) == 0
    bench(folder, "measure", poses, data)
    assert main(["calibrate", "six_rfs", data, "--out", found, *KNOWN]) == 0
    return folder, found


def test_the_calibration_finds_what_the_bench_hides(calibrated, capsys):
    folder, found = calibrated
    values = load_robot(found).parameter_values(PATHS)
    # Three of the standard deviations it tells.
    assert np.all(np.abs(values - REALITY) < [6e9, *[3e-3] * 6]), values
    assert main(["calibrate", found, str(folder / "data.csv"), *KNOWN]) == 0
    again = capsys.readouterr().out
    assert re.search(r"standard deviations say: (0\.[89]|1\.[01])", again), again


def test_the_hand_is_felt(calibrated):
    folder, found = calibrated
    domain = free_domain()
    node = NodeProcess(folder / "node.log", domain, ["-p", f"robot:={found}"])
    try:
        said = bench(folder, "push", "--seconds", "7", domain=domain)
    finally:
        assert node.stop() == 0, node.output()
    lines = re.findall(r"hand \[(.*)\] N, felt \[(.*)\] N", said)
    assert len(lines) >= 3, said
    hand, felt = (np.array([line[part].split() for line in lines], float) for part in (0, 1))
    assert np.ptp(hand[:, 0]) > 0.1  # it moves
    assert_allclose(felt, hand, atol=0.1)

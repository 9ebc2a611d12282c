# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The examples against a real node."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from cpr_msgs.msg import StabilityMetrics
from helpers.driver import Driver
from helpers.node_process import TIMEOUT, free_domain

EXAMPLES = Path(__file__).parents[3] / "examples"


def started(running, name, *arguments):
    domain = str(running.client.context.get_domain_id())
    return subprocess.Popen(
        [sys.executable, EXAMPLES / name, *arguments],
        env=os.environ | {"ROS_DOMAIN_ID": domain, "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def test_the_supervisor_sends_a_halted_robot_home(rfrfr, drive):
    supervisor = started(rfrfr, "supervisor.py")
    try:
        drive.client.spin_until(
            lambda: drive.client.node.count_subscribers("/cpr_node/stability") >= 2
        )
        drive.send_platform(0.0, -0.2)
        drive.until_state(StabilityMetrics.STATE_HALTED)
        drive.until(lambda: np.array_equal(drive.motors, [2.59, 0.55]), timeout=TIMEOUT)
        drive.until_state(StabilityMetrics.STATE_IDLE)
    finally:
        supervisor.send_signal(signal.SIGINT)
        said, _ = supervisor.communicate(timeout=TIMEOUT)
    assert supervisor.returncode == 0, said
    assert "HALT: halted: the next margin" in said
    assert "reset: True" in said


@pytest.mark.alone(reason="measures how far the robot lags behind")
def test_the_circle_is_driven(six_rfs):
    drive = Driver(six_rfs.client)
    try:
        drive.until(lambda: True)
        first = drive.position
        circle = started(six_rfs, "circle.py", "--radius", "0.03", "--period", "4")
        drive.client.spin_until(lambda: circle.poll() is not None, timeout=60.0)
        said = circle.stdout.read()
        assert circle.returncode == 0, said
        away = float(re.search(r"setpoint: ([\d.]+) mm", said)[1])
        assert away < 10.0
        drive.until_state(StabilityMetrics.STATE_IDLE)
        poses = [
            [pose.pose.position.x, pose.pose.position.y, pose.pose.position.z]
            for kind, messages in drive.outputs.items()
            if kind.__name__ == "PoseStamped"
            for pose in messages
        ]
        drive.go_home()
    finally:
        drive.close()
    assert poses
    assert np.linalg.norm(np.array(poses)[-1] - first) < 0.01


def test_a_map_is_made_cancelled_and_gone_on_with(rfrfr, tmp_path):
    file = tmp_path / "map.nc"
    command = ("map.py", str(file), "x=-0.9:0.9", "y=-1:1", "--resolution", "0.01")
    cancelled = started(rfrfr, *command)
    said = ""
    while "/s" not in said:  # feedback on one line, or the end
        read = cancelled.stdout.read(1)
        assert read, said
        said += read
    cancelled.send_signal(signal.SIGINT)
    rest, _ = cancelled.communicate(timeout=60)
    assert cancelled.returncode == 1, said + rest
    assert "-7: the map was cancelled" in rest
    whole = started(rfrfr, *command)
    said, _ = whole.communicate(timeout=120)
    assert whole.returncode == 0, said
    assert f"{file}: 23450 of 36381 cells are reached" in said
    assert "border stability:" in said


def test_the_circle_says_when_nobody_is_there():
    """A domain of its own, without a node."""
    done = subprocess.run(
        [sys.executable, EXAMPLES / "circle.py"],
        env=os.environ | {"ROS_DOMAIN_ID": str(free_domain())},
        capture_output=True,
        text=True,
        timeout=90,
    )
    assert done.returncode == 1
    assert "no cpr_node" in done.stderr

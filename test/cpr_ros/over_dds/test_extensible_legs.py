# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot whose motors are rod lengths, without limits of its own."""

import pytest
import yaml
from cpr_msgs.msg import ErrorCode
from cpr_msgs.srv import SolveForward
from helpers.driver import Driver
from helpers.node_process import running_node
from helpers.yaml_content import yaml_content
from sensor_msgs.msg import JointState

from cpr_core.description.description_file import shipped_robots

NAMES = [f"motor{number}" for number in range(1, 7)]


@pytest.fixture(scope="module")
def unlimited(tmp_path_factory):
    content = yaml_content(shipped_robots()["gough_stewart"].read_text().replace("e9", ".0e+9"))
    for leg in content["legs"]:
        del leg["motor"]["limits"]
    folder = tmp_path_factory.mktemp("unlimited")
    description = folder / "robot.yaml"
    description.write_text(yaml.safe_dump(content))
    with running_node(folder, f"robot:={description}") as running:
        yield running


@pytest.mark.parametrize("length", [0.0, -0.3])
def test_a_rod_length_of_zero_or_less_is_refused_at_once(unlimited, length):
    wanted = [0.45, 0.45, length, 0.45, 0.45, 0.45]
    answer = unlimited.client.call(
        SolveForward,
        "/cpr_node/solve_forward",
        SolveForward.Request(motors=JointState(name=NAMES, position=wanted)),
    )
    assert answer.error_code.val == ErrorCode.INVALID_ROBOT_STATE
    assert f"motor3: expected a rod length above 0 m, got {length:g} m" in answer.error_code.message


def test_a_setpoint_of_no_rod_length_is_dropped(unlimited):
    driver = Driver(unlimited.client)
    try:
        driver.motor_setpoint.publish(JointState(name=["motor3"], position=[-0.3]))
        refused = "motor3: expected a rod length above 0 m, got -0.3 m"
        unlimited.client.spin_until(lambda: refused in unlimited.process.output())
        driver.until(lambda: True)  # of what came before nothing counts
        assert driver.metrics.state == driver.metrics.STATE_IDLE
    finally:
        driver.close()

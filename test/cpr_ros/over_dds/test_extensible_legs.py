# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot whose motors are rod lengths, without limits of its own."""

import pytest
import yaml
from cpr_msgs.msg import ErrorCode
from cpr_msgs.srv import SolveForward
from helpers.driver import Driver
from helpers.node_process import NodeProcess, free_domain, running_node
from helpers.yaml_content import shipped_content
from sensor_msgs.msg import JointState

NAMES = [f"motor{number}" for number in range(1, 7)]


@pytest.fixture(scope="module")
def unlimited(tmp_path_factory):
    content = shipped_content("gough_stewart")
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


def fed_strips():
    """Three strips that screws feed, clamped to the platform: soft beside their axial stiffness."""
    motor = {"type": "extensible", "lead": 0.002, "offset": 0.3}
    places = ((-0.1, -0.05, 0.05), (0.0, 0.0, 0.0), (0.1, 0.05, -0.02))
    return {
        "name": "fed_strips",
        "space": "planar",
        "rod": {
            "length": 0.4,
            "section": {"shape": "rectangular", "width": 0.0005, "height": 0.01},
            "young_modulus": 200.0e9,
            "shear_modulus": 80.0e9,
        },
        "strain": {"bending_3": 6},
        "platform": {"shape": "body", "mass": 0.1},
        "legs": [
            {
                "base": {"position": [base, 0, 0], "tangent": [0, 1, 0]},
                "motor": motor | {"name": f"feed{number}"},
                "tip": {"type": "fixed", "position": [tip, height, 0], "tangent": [0, 1, 0]},
            }
            for number, (base, tip, height) in enumerate(places, 1)
        ],
        "controlled": ["x", "y", "angle"],
        "home": {"motors": [318, 314, 318], "bow": "left", "platform": {"position": [0, 0.37, 0]}},
    }


def test_thresholds_that_halt_a_robot_at_home_are_told_when_it_is_configured(tmp_path):
    """Its platform setpoints were halted by thresholds of other robots, and nothing said so before."""
    file = tmp_path / "robot.yaml"
    file.write_text(yaml.safe_dump(fed_strips()))
    others = {"inverse_singularity_warning": 0.02, "inverse_singularity_stop": 0.01}
    arguments = [f"robot:={file}", *(f"{name}:={value}" for name, value in others.items())]
    given = [word for argument in arguments for word in ("-p", argument)]
    process = NodeProcess(tmp_path / "node.log", free_domain(), given)
    process.wait_for_log("ready")
    assert process.stop() == 0
    warnings = [line for line in process.output().splitlines() if "[WARN]" in line]
    bow, warned = sorted(warnings, key=lambda line: "home.bow" not in line)
    assert "home.bow: leg" in bow and "to the other side" in bow
    assert "inverse.smallest_singular_value 0.0029" in warned
    assert "is below inverse_singularity_stop 0.01 here: platform setpoints" in warned
    assert "are halted" in warned

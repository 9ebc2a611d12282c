# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Position and orientation of a robot in space are met as measured, also in the frame of a tracker."""

import numpy as np
import pytest
import yaml
from cpr_msgs.msg import StabilityMetrics
from geometry_msgs.msg import PoseStamped
from helpers.camera import Camera
from helpers.node_process import running_node
from helpers.tracked_robots import tracked_content

from cpr_core.lie import quaternion_from_rotation, rotation_exp, rotation_from_quaternion

pytestmark = pytest.mark.waits(seconds=15)


def test_position_and_orientation_are_met(six_rfs):
    camera = Camera(six_rfs.client, "six_rfs")
    try:
        camera.go_home()
        assert camera.set_parameters(loop_gain=4.0, loop_max_rate=1.0).successful
        camera.spin(0.1)
        camera.heard.clear()
        camera.until(lambda: True)
        setpoint = camera.all(PoseStamped)[-1]
        setpoint.pose.position.z -= 0.03
        camera.platform.publish(setpoint)
        z = setpoint.pose.position.z
        camera.until(lambda: abs(camera.position[2] - z) < 1e-9)
        camera.until_state(StabilityMetrics.STATE_IDLE)
        camera.measure(50.0)
        camera.until(lambda: camera.metrics.loop == StabilityMetrics.LOOP_CLOSED)
        begun = next(m for m in camera.all(StabilityMetrics) if m.loop == m.LOOP_CLOSED)
        off = begun.position_error, begun.rotation_error
        camera.until_met(1e-6)
        met = camera.metrics.position_error, camera.metrics.rotation_error
        print(f"six_rfs: begun {off}, met {met} m, rad")
        assert max(off) > 5e-3
        camera.check_commands()
    finally:
        camera.close()


def test_it_is_met_in_the_frame_of_a_tracker(tmp_path):
    """A camera above the robot, of which the description says where it is; poses by matrices."""
    content = tracked_content(
        "six_rfs", [0.4, -0.6, 1.8, 3.0, 0.3, -0.4], [0.02, 0.03, 0.1, 0.2, 0.1, 1]
    )
    file = tmp_path / "tracked.yaml"
    file.write_text(yaml.safe_dump(content))
    tracker, marker = content["tracker"], content["tracker"]["marker"]
    into_tracker, onto_marker = np.linalg.inv(_motion(tracker)), _motion(marker)
    with running_node(tmp_path, f"robot:={file}", "max_speed:=4.0") as node:
        camera = Camera(node.client, "six_rfs")

        def in_tracker(message):
            message.header.frame_id = "tracker"
            point, turn = message.pose.position, message.pose.orientation
            platform = np.eye(4)
            platform[:3, :3] = rotation_from_quaternion([turn.w, turn.x, turn.y, turn.z])
            platform[:3, 3] = point.x, point.y, point.z
            told = into_tracker @ platform @ onto_marker
            point.x, point.y, point.z = told[:3, 3].tolist()
            turn.w, turn.x, turn.y, turn.z = quaternion_from_rotation(told[:3, :3]).tolist()
            return message

        try:
            assert camera.set_parameters(loop_gain=4.0, loop_max_rate=1.0).successful
            camera.spin(0.1)
            camera.changed = in_tracker
            camera.until(lambda: True)
            setpoint = camera.all(PoseStamped)[-1]
            setpoint.pose.position.z -= 0.03
            point, turn = setpoint.pose.position, setpoint.pose.orientation
            camera.platform.publish(setpoint)
            camera.until(lambda: abs(camera.position[2] - point.z) < 1e-9)
            camera.until_state(StabilityMetrics.STATE_IDLE)
            camera.measure(50.0)
            camera.until_met(5e-7)
            camera.spin(0.1)
            camera.obey()
            real = camera.real.equilibrium
            np.testing.assert_allclose(
                real.platform_position, [point.x, point.y, point.z], atol=1e-6
            )
            wanted = rotation_from_quaternion([turn.w, turn.x, turn.y, turn.z])
            np.testing.assert_allclose(real.platform_rotation, wanted, atol=1e-6)
            camera.check_commands()
        finally:
            camera.close()


def _motion(frame):
    """A frame as a matrix that moves points, (4, 4)."""
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = rotation_exp(frame["rotation_vector"]), frame["position"]
    return found

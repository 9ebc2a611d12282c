# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The node as an observer of motors that somebody else drives."""

import numpy as np
import pytest
from cpr_msgs.msg import StabilityMetrics
from helpers.driver import EVERY_MESSAGE, Driver
from helpers.node_process import Client, NodeProcess, free_domain
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray


@pytest.fixture
def observer(tmp_path):
    domain = free_domain()
    arguments = ["-p", "robot:=rfrfr", "-p", "motor_source:=measured"]
    process = NodeProcess(tmp_path / "node.log", domain, arguments)
    process.wait_for_log("ready")
    client = Client(domain)
    try:
        yield process, Driver(client)
    finally:
        client.close()
        assert process.stop() == 0, process.output()


def test_measured_motors_are_tracked(observer):
    process, drive = observer
    commands, streamed = [], []  # the driver forgets while it waits
    drive.client.node.create_subscription(
        StabilityMetrics, "/cpr_node/stability", streamed.append, EVERY_MESSAGE
    )
    drive.client.node.create_subscription(
        Float64MultiArray, "/cpr_node/motor_commands", commands.append, EVERY_MESSAGE
    )
    publisher = drive.client.node.create_publisher(JointState, "/measured_joint_states", 10)

    def measure(first, second):
        # A machine has other joints, too, and does not know the node's order.
        publisher.publish(
            JointState(name=["gripper", "motor2", "motor1"], position=[float("nan"), second, first])
        )

    # Nothing is known yet.
    assert drive.metrics.state == StabilityMetrics.STATE_IDLE
    assert drive.metrics.action == StabilityMetrics.ACTION_HALT
    assert drive.metrics.speed_scale == 0.0
    for k in range(60):
        measure(2.59 + 0.005 * k, 0.55 - 0.005 * k)
        drive.spin(0.02)
    last = [2.59 + 0.005 * 59, 0.55 - 0.005 * 59]

    def tracked():
        measure(*last)
        told = drive.metrics.state == StabilityMetrics.STATE_TRACKING
        return told and np.allclose(drive.motors, last, atol=1e-12)

    drive.until(tracked)

    # Nobody measures any more.
    drive.until_state(StabilityMetrics.STATE_STALE)
    assert drive.metrics.status == StabilityMetrics.STATUS_STALE_COMMAND
    assert drive.metrics.action == StabilityMetrics.ACTION_HALT
    drive.spin(0.5)
    # Told once each time; a busy computer may have been late with measurements before.
    stale = [metrics.state == StabilityMetrics.STATE_STALE for metrics in streamed]
    halts = sum(now and not before for before, now in zip([False, *stale], stale, strict=False))
    assert halts >= 1
    assert process.output().count("halt (STALE, STALE_COMMAND)") == halts

    # A setpoint is refused, and there is nothing to pause.
    drive.send_motors(2.6, 0.5)
    process.wait_for_log("takes no setpoints", timeout=20.0)
    assert not drive.pause(True).success

    # What cannot be is dropped.
    publisher.publish(JointState(name=["motor1"], position=[2.6]))
    process.wait_for_log("missing: motor2", timeout=20.0)

    # From home again.
    assert drive.reset().success
    drive.until(lambda: np.array_equal(drive.motors, [2.59, 0.55]))

    # No command has ever gone out.
    assert drive.client.node.count_publishers("/cpr_node/motor_commands") == 1
    assert commands == []

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The motor command first, then all the rest, of which nothing is lost."""

import numpy as np
import pytest
from cpr_msgs.msg import StabilityMetrics
from geometry_msgs.msg import PoseStamped
from helpers.driver import EVERY_MESSAGE
from helpers.node_process import Client, NodeProcess, Running, free_domain
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from cpr_core import load_robot, solve_forward

HOME = [2.59, 0.55]


@pytest.fixture
def noteless(tmp_path):
    domain = free_domain()
    process = NodeProcess(
        tmp_path / "node.log", domain, ["-p", "robot:=rfrfr"], "helpers.noteless_node"
    )
    try:
        process.wait_for_log("ready")
        client = Client(domain)
        yield Running(process, client)
        client.close()
    finally:
        assert process.stop() == 0, process.output()


def test_a_command_waits_for_nothing_that_comes_after_it(noteless):
    client, commands = noteless.client, []
    setpoint = client.node.create_publisher(Float64MultiArray, "/cpr_node/commands", 1)
    client.node.create_subscription(
        Float64MultiArray,
        "/cpr_node/motor_commands",
        lambda message: commands.append(list(message.data)),
        EVERY_MESSAGE,
    )
    client.spin_until(
        lambda: (
            setpoint.get_subscription_count() > 0
            and client.node.count_publishers("/cpr_node/motor_commands") > 0
        )
    )
    wanted = [2.592, 0.551]  # a tick away
    setpoint.publish(Float64MultiArray(data=wanted))
    client.spin_until(lambda: wanted in commands)
    client.spin_until(lambda: "forced by a test" in noteless.process.output())


def test_every_command_has_a_state_that_is_published_after_it(drive):
    """Stamps of DDS are of one clock, of the process that publishes."""
    node, heard = drive.client.node, {}

    def listen(kind, topic, numbers):
        def keep(message, info):
            heard.setdefault(kind, {}).setdefault(numbers(message), info["source_timestamp"])

        return node.create_subscription(kind, topic, keep, EVERY_MESSAGE)

    subscriptions = [
        listen(Float64MultiArray, "/cpr_node/motor_commands", lambda said: tuple(said.data)),
        listen(JointState, "/joint_states", lambda said: tuple(said.position)),
    ]
    drive.client.spin_until(lambda: len(heard) == 2)  # it is known that somebody listens
    wanted = (2.75, 0.45)
    drive.commands.publish(Float64MultiArray(data=list(wanted)))
    drive.client.spin_until(lambda: all(wanted in found for found in heard.values()))
    for subscription in subscriptions:
        node.destroy_subscription(subscription)
    commands, states = heard[Float64MultiArray], heard[JointState]
    commands.pop(tuple(HOME), None)
    assert len(commands) >= 8  # 0.16 rad, 0.02 a tick
    missing = [command for command in commands if command not in states]
    assert missing == []
    assert all(commands[place] < states[place] for place in commands)


def test_at_rest_all_streams_go_on_with_new_stamps_and_nothing_else(drive):
    """Most of them as bytes that were made once."""
    wanted = [2.60, 0.56]
    drive.commands.publish(Float64MultiArray(data=wanted))
    drive.until(lambda: np.array_equal(drive.motors, wanted))
    drive.until(lambda: drive.metrics.state == StabilityMetrics.STATE_IDLE)
    kinds = JointState, PoseStamped, StabilityMetrics
    drive.until(lambda: all(len(drive.all(kind)) >= 12 for kind in kinds))
    for kind in kinds:
        messages = drive.all(kind)[-8:]
        stamps = [message.header.stamp for message in messages]
        times = [stamp.sec + 1e-9 * stamp.nanosec for stamp in stamps]
        assert np.all(np.diff(times) > 0.0)
        if kind is StabilityMetrics:
            ages = [message.setpoint_age for message in messages]
            assert np.all(np.diff(ages) > 0.0)
            assert ages[0] > 0.0
            assert {message.margin_trend for message in messages} == {0.0}
        for message in messages:
            message.header.stamp = stamps[0]
            if kind is StabilityMetrics:
                message.setpoint_age = 0.0
        assert all(str(message) == str(messages[0]) for message in messages)
    found = solve_forward(load_robot("rfrfr"), wanted)
    metrics = drive.metrics
    np.testing.assert_allclose(drive.motors, wanted)
    np.testing.assert_allclose(drive.position, found.platform_position, atol=1e-9)
    np.testing.assert_allclose(metrics.margin, found.spectrum_locked.margin, rtol=1e-6)
    assert (metrics.wrench_age, metrics.measured_pose_age) == (-1.0, -1.0)

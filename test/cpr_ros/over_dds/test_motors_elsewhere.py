# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that others move, or that do not follow their commands."""

import itertools

import numpy as np
import pytest
from cpr_msgs.action import MoveTo
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from helpers.driver import Driver
from helpers.goal_client import GoalClient
from helpers.node_process import change
from lifecycle_msgs.msg import Transition
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState

pytestmark = pytest.mark.waits(seconds=20)


def test_motors_that_others_have_moved_and_that_are_measured_are_not_sent_back(bench):
    """The command of before was said again, and the next motion began there: 124 ticks' ways at once."""
    bench.measure([3.2, -0.1])
    bench.start("start_from:=measured", until="")
    bench.until_said("ready")
    bench.until_heard()
    bench.measure([2.7, 0.4])  # by hand
    bench.until_said("where it is measured, motors (2.7, 0.4)")
    assert "somebody else has moved the motors: one was measured 0.5 " in bench.process.output()
    bench.spin(0.2)  # what is on the way
    heard = len(bench.commands)
    bench.spin(2.2)
    assert len(bench.commands) == heard
    bench.commands = [np.array([2.7, 0.4])]
    bench.send(2.75, 0.35)
    bench.until_at([2.75, 0.35])
    assert bench.longest_step() <= 1.0 + 2e-5


def test_commands_do_not_run_away_from_motors_that_do_not_follow(bench):
    """Without power, or jammed: commands went all the way, and the node began again where they were."""
    still, slow = [2.7, 0.4], 0.25
    bench.measure(still)
    # On its way for several seconds: a busy machine says late what is measured.
    bench.start("start_from:=measured", f"max_speed:={slow}", "max_lead:=0.0", until="")
    bench.until_said("ready")
    bench.until_heard()
    bench.send(3.6, -0.4)
    bench.until_said("the motors do not follow: one was measured ")
    begun = "where it is measured, motors (2.7, 0.4)"
    bench.client.spin_until(lambda: bench.process.output().count(begun) == 2)
    bench.spin(0.2)  # what is on the way
    ahead = max(float(np.abs(command - still).max()) for command in bench.commands)
    assert 0.1 < ahead < 0.8  # of 0.9
    bench.commands = [np.array(still)]
    bench.send(2.75, 0.35)
    bench.until_at([2.75, 0.35])
    assert bench.longest_step() <= 1.0 + 2e-5


def test_commands_wait_for_motors_that_do_not_follow(bench):
    """They go no farther ahead than max_lead allows; motors that stay where they are end what waits."""
    still, slow, lead = [2.7, 0.4], 0.25, 0.2
    bench.measure(still)
    bench.start("start_from:=measured", f"max_speed:={slow}", until="")
    bench.until_said("ready")
    bench.until_heard()
    bench.send(3.6, -0.4)
    bench.until_said("as far as max_lead allows, and all at rest for 0.5 s while commands waited")
    bench.spin(0.2)  # what is on the way
    ahead = max(float(np.abs(command - still).max()) for command in bench.commands)
    assert 0.9 * lead * slow < ahead <= lead * slow * (1.0 + 1e-5)
    bench.commands = [bench.commands[-1]]
    bench.send(*still)  # as near as the last command was
    bench.until_at(still)
    assert bench.longest_step() <= 1.0 + 2e-5


def test_a_goal_is_not_reached_by_motors_that_stay_where_they_are(bench):
    """It was said to be, as soon as the commands were there, and of a short way nobody found out."""
    still = [2.7, 0.4]
    bench.measure(still)
    # Measurements are not old while this process, which measures, is held up.
    bench.start("start_from:=measured", "measured_timeout:=600.0", until="")
    bench.until_said("ready")
    bench.until_heard()
    drive = Driver(bench.client)
    moves = GoalClient(bench.client, MoveTo, "/cpr_node/move_to")
    motors = JointState(name=["motor1", "motor2"], position=[2.75, 0.4])
    goal = {"given": MoveTo.Goal.GIVEN_MOTORS, "motors": motors}
    result = moves.result(moves.send(**goal)).result
    assert result.error_code.val == ErrorCode.CONTROL_FAILED
    assert "motor1 is measured at 2.7 rad, its command is 2.75" in result.error_code.message
    bench.until_at([2.75, 0.4])  # the result may be taken first
    # Who knows that a load holds them off says so.
    assert drive.set_parameters(arrived_tolerance=0.06).successful
    assert moves.result(moves.send(**goal)).result.error_code.val == ErrorCode.SUCCESS
    assert drive.set_parameters(arrived_tolerance=0.01).successful
    bench.measure([2.75, 0.4])
    bench.spin(0.3)  # what is on the way
    assert moves.result(moves.send(**goal)).result.error_code.val == ErrorCode.SUCCESS
    moves.close()
    drive.close()


def test_motors_that_were_moved_and_are_measured_no_more_are_sent_nowhere(bench):
    """Setpoints were refused for ever, HALT was never said, and after a clean-up they jumped."""
    bench.measure([2.7, 0.4])
    bench.start(until="")
    bench.until_said("ready")
    node, streamed = bench.client.node, []
    node.create_subscription(StabilityMetrics, "/cpr_node/stability", streamed.append, 10)
    bench.until_heard()
    steps = itertools.count(1)
    publisher = node.create_publisher(JointState, "/measured_joint_states", qos_profile_sensor_data)
    bench.measure_no_more()
    timer = node.create_timer(
        0.05,
        lambda: publisher.publish(
            JointState(name=["motor1", "motor2"], position=[2.7 + 0.02 * next(steps), 0.4])
        ),
    )

    def until_action(action):
        streamed.clear()
        bench.client.spin_until(lambda: streamed and streamed[-1].action == action)
        return streamed[-1]

    told = until_action(StabilityMetrics.ACTION_HALT)
    assert "somebody else has moved the motors" in told.status_text
    node.destroy_timer(timer)
    node.destroy_publisher(publisher)
    bench.spin(2.0)  # until nobody is found any more who publishes
    bench.commands = []
    deactivate, activate = Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_ACTIVATE
    clean, configure = Transition.TRANSITION_CLEANUP, Transition.TRANSITION_CONFIGURE
    bench.change(deactivate, activate)
    assert "somebody else" in until_action(StabilityMetrics.ACTION_HALT).status_text
    refused = bench.process.output().count("~/commands: dropped: somebody else has moved")
    bench.send(2.75, 0.35)
    bench.client.spin_until(
        lambda: bench.process.output().count("~/commands: dropped: somebody else") > refused
    )
    bench.change(deactivate, clean, configure)
    assert not change(bench.client, activate)
    assert "and nothing publishes measured_joint_states" in bench.process.output()
    assert not bench.commands
    measured = [3.1, 0.2]
    bench.measure(measured)
    bench.client.spin_until(lambda: change(bench.client, activate))
    until_action(StabilityMetrics.ACTION_NONE)
    bench.commands = [np.array(measured)]
    bench.send(3.0, 0.3)
    bench.until_at([3.0, 0.3])
    assert bench.longest_step() <= 1.0 + 2e-5

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A node begins where its motors are measured, or says why it does not begin."""

import os
import random

import numpy as np
import pytest
from helpers.node_process import change
from helpers.robot_bench import HOME
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from sensor_msgs.msg import JointState

from cpr_core import load_robot, solve_forward, solve_inverse

pytestmark = pytest.mark.waits(seconds=40)

#: Ends of a node in motion; the variable asks for more of them.
MOMENTS = int(os.environ.get("CPR_MOMENTS", "3"))


def test_what_is_measured_is_where_the_node_begins(bench):
    """Also if it was elsewhere last."""
    measured, robot = [3.2, -0.1], load_robot("rfrfr")
    bench.keep(robot)
    bench.measure(measured)
    bench.start("start_from:=measured", until="")
    bench.client.spin_until(lambda: "ready" in bench.process.output(), timeout=240.0)
    assert "where it is measured, motors (3.2, -0.1)" in bench.process.output()
    bench.until_heard()
    states = bench.client.messages(JointState, "/joint_states", 1)
    np.testing.assert_array_equal(states[0].position, measured)
    expected = solve_forward(robot, measured)
    np.testing.assert_allclose(states[0].effort, expected.efforts, rtol=0.0, atol=1e-8)
    assert all(np.array_equal(command, measured) for command in bench.commands)


def test_after_an_end_in_motion_the_first_command_is_where_the_motors_are(bench):
    """They follow late, go on to the last command while there is no node, and are moved by hand."""
    chance = random.Random(2)
    bench.measure_followers([2.7, 0.4])
    for moment in range(MOMENTS):
        bench.spin(0.5)
        bench.commands = []
        bench.motors += chance.uniform(-0.05, 0.05)
        stood = bench.motors.copy()
        bench.start(until="")
        bench.until_said("ready")
        bench.client.spin_until(lambda: bench.commands)
        np.testing.assert_allclose(bench.commands[0], stood, rtol=0.0, atol=1e-6)
        bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
        bench.send(*(HOME + chance.uniform(0.2, 1.0) * np.array([0.9, -0.9])))
        bench.until_heard(2)
        bench.spin(chance.uniform(0.0, 0.4))
        before = bench.longest_step()
        if moment % 2:
            assert bench.process.stop() == 0
        else:
            bench.kill()
        assert max(before, bench.longest_step()) <= 1.0 + 2e-5


def test_who_measured_the_motors_before_is_waited_for(bench):
    """A busy computer finds others late: the last command went out, though somebody measured."""
    bench.keep(load_robot("rfrfr"), measured=True)
    bench.start(until="")
    bench.until_said("configured")
    bench.spin(3.0)  # longer than nodes take to find each other at rest, and repeat a command
    bench.measure([2.75, 0.35])
    bench.until_said("ready")
    bench.client.spin_until(lambda: bench.commands)
    assert all(np.array_equal(command, [2.75, 0.35]) for command in bench.commands)


def test_where_it_was_measured_it_is_after_a_restart_without_any_motion(bench):
    """The last state was that of long ago, and commands sprang to it."""
    bench.keep(load_robot("rfrfr"))
    bench.measure([3.2, -0.1])
    bench.start("start_from:=measured", until="")
    bench.client.spin_until(lambda: "ready" in bench.process.output(), timeout=240.0)
    assert bench.process.stop() == 0
    bench.ended.append(bench.commands)
    bench.commands = []
    bench.start("start_from:=last")
    assert "where it was last, motors (3.2, -0.1)" in bench.process.output()
    bench.until_heard()
    np.testing.assert_array_equal(bench.commands[-1], [3.2, -0.1])


def test_setpoints_sent_while_the_node_becomes_active_are_not_followed(bench):
    """It waits for measured motors meanwhile; they were in its queues and delivered as if new."""
    bench.start("autostart:=false", "start_from:=measured", until="")
    bench.change(Transition.TRANSITION_CONFIGURE)
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    node = bench.client.node
    by_name = node.create_publisher(JointState, "/cpr_node/motor_setpoint", 10)
    bench.client.spin_until(lambda: by_name.get_subscription_count() > 0)
    client = node.create_client(ChangeState, "/cpr_node/change_state")
    client.wait_for_service()
    request = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_ACTIVATE))
    activated = client.call_async(request)
    bench.spin(1.0)  # it waits for up to 5 s
    for motor in (3.0, 3.1):
        by_name.publish(JointState(name=["motor1"], position=[motor]))
        bench.send(motor, 0.1)
    bench.spin(0.5)
    assert not activated.done()
    bench.measure([3.2, -0.1])
    bench.client.spin_until(activated.done)
    assert activated.result().success
    bench.until_heard(2)
    assert all(np.array_equal(command, [3.2, -0.1]) for command in bench.commands)
    bench.send(3.19, -0.09)
    bench.until_at([3.19, -0.09])  # what comes afterwards is
    assert "Traceback" not in bench.process.output()


def test_what_no_equilibrium_explains_keeps_the_node_from_being_active(bench):
    bench.measure([20.0, 0.55])
    bench.start("start_from:=measured", until="")
    bench.client.spin_until(lambda: bench.process.process.poll() is not None, timeout=240.0)
    assert bench.process.process.returncode == 1
    assert "the robot is measured at motors (20, 0.55)" in bench.process.output()
    assert not bench.commands


def test_a_node_that_is_to_start_measured_says_that_nothing_is(bench):
    bench.start("start_from:=measured", until="")
    bench.client.spin_until(lambda: bench.process.process.poll() is not None, timeout=240.0)
    assert bench.process.process.returncode == 1
    said = bench.process.output()
    expected = "no measured_joint_states with its motors (motor1, motor2) that tells it came in 5 s"
    assert f"{expected}: no message " in said
    assert "nobody publishes it" in said


def test_a_topic_with_joints_of_others_alone_is_told_by_their_names(bench):
    """Nobody knows whether they are the motors under other names: it moves nothing, and ends."""
    bench.measure([3.2, -0.1], names=["finger", "thumb"])
    bench.start(until="")
    bench.client.spin_until(lambda: bench.process.process.poll() is not None, timeout=240.0)
    assert bench.process.process.returncode == 1
    said, name = bench.process.output(), bench.client.node.get_name()
    assert f"came in 5 s: of other joints only: finger, thumb; published by /{name}. If" in said
    assert "start_from:=last or start_from:=home begins without" in said
    assert not bench.commands


@pytest.mark.parametrize("start_from", ["auto", "measured"])
def test_where_it_cannot_have_stayed_it_has_to_be_measured(bench, start_from):
    """A last state that is no place to begin is no reason not to begin where motors are measured."""
    robot = load_robot("rfrfr")
    bench.keep(robot, solve_inverse(robot, [0.0, 0.0]))
    bench.start("autostart:=false", f"start_from:={start_from}", until="")
    bench.change(Transition.TRANSITION_CONFIGURE)
    assert "is not used: the robot cannot rest at its last eq" in bench.process.output()
    assert "where the robot is has to be measured" in bench.process.output()
    for _ in range(2):
        assert not change(bench.client, Transition.TRANSITION_ACTIVATE)
    reason = {"auto": "nothing publishes", "measured": "no measured_joint_states with"}[start_from]
    assert bench.process.output().count(reason) == 2
    bench.measure([3.2, -0.1])
    bench.spin(1.0)  # the node has to discover who measures
    bench.change(Transition.TRANSITION_ACTIVATE)
    bench.until_heard()
    assert all(np.array_equal(command, [3.2, -0.1]) for command in bench.commands)


def test_a_measurement_that_comes_late_places_a_robot_that_has_not_moved(bench):
    """Its publisher was discovered after the node was active, or started later."""
    bench.start("moved_tolerance:=0.0", "max_lead:=0.0")  # it goes on saying the same
    assert "nothing is known of where the robot is" in bench.process.output()
    bench.measure([3.2, -0.1])
    bench.client.spin_until(lambda: "where it is measured" in bench.process.output())
    bench.until_heard()
    assert all(np.array_equal(command, [3.2, -0.1]) for command in bench.commands)
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(3.0, 0.1)
    bench.until_at([3.0, 0.1])
    bench.spin(0.5)
    np.testing.assert_array_equal(bench.commands[-1], [3.0, 0.1])  # placed once, not again
    assert bench.process.output().count("where it is measured") == 1
    assert bench.longest_step() <= 1.0 + 2e-5


def test_a_late_measurement_that_nothing_explains_makes_the_node_inactive(bench):
    bench.start()
    bench.measure([20.0, 0.55])
    bench.client.spin_until(
        lambda: "deactivated: the robot is measured at motors (20, 0.55)" in bench.process.output(),
        timeout=60.0,
    )
    state = bench.client.call(GetState, "/cpr_node/get_state", GetState.Request())
    assert state.current_state.label == "inactive"
    assert not bench.commands


def test_a_robot_that_moves_is_not_placed_by_a_measurement(bench):
    """Where nobody moves motors but the node: a load may hold them off their command."""
    bench.start("moved_tolerance:=0.0", "max_lead:=0.0")
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(2.7, 0.4)
    bench.until_at([2.7, 0.4])
    bench.measure([3.2, -0.1])
    node = bench.client.node
    bench.client.spin_until(lambda: node.count_subscribers("/measured_joint_states") > 0)
    bench.until_heard(2)
    assert "where it is measured" not in bench.process.output()
    np.testing.assert_array_equal(bench.commands[-1], [2.7, 0.4])

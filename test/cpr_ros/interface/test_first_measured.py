# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a node that is about to become active hears of its motors, over real DDS."""

import threading
import time

import numpy as np
import pytest
import rclpy
from helpers.drive import robot
from helpers.node_process import free_domain
from rclpy.context import Context
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState

from cpr_ros.interface.first_measured import first_measured

TOPIC = "/measured_joint_states"
GRIPPER = JointState(name=["finger"], position=[0.1])
MOTORS = JointState(name=["motor2", "motor1"], position=[0.5, 2.6])
ONE_MOTOR = JointState(name=["motor1"], position=[2.6])


class Arm:
    """A node that waits for its motors, and others who publish."""

    def __init__(self):
        self._context, domain = Context(), free_domain()
        rclpy.init(context=self._context, domain_id=domain)
        self.node = rclpy.create_node("waiting", context=self._context)
        self._others = rclpy.create_node("gripper", context=self._context, namespace="left")
        self._over, self._threads = threading.Event(), []

    def say(self, period, *messages):
        """All of them at once, again and again."""
        publisher = self._others.create_publisher(JointState, TOPIC, qos_profile_sensor_data)

        def go_on():
            while not self._over.wait(period):
                for message in messages:
                    publisher.publish(message)

        self._threads.append(threading.Thread(target=go_on))
        self._threads[-1].start()

    def hear(self, wait, tolerance=0.1):
        return first_measured(self.node, robot("rfrfr"), wait, lambda: False, tolerance)

    def until_published(self, count):
        """Wait until so many publishers are found."""
        end = time.monotonic() + 20.0
        while self.node.count_publishers(TOPIC) < count:
            assert time.monotonic() < end
            time.sleep(0.01)

    def close(self):
        self._over.set()
        for thread in self._threads:
            thread.join()
        for node in (self.node, self._others):
            node.destroy_node()
        rclpy.shutdown(context=self._context)


@pytest.fixture
def arm():
    made = Arm()
    yield made
    made.close()


def test_seldom_measured_motors_are_heard_among_many_joints_of_others(arm):
    """One message in 0.2 s was looked at: that of the gripper."""
    arm.say(0.2, MOTORS, *[GRIPPER] * 50)
    motors, instead = arm.hear(5.0)
    np.testing.assert_array_equal(motors, [2.6, 0.5])
    assert instead == ""


def test_what_came_instead_is_told(arm):
    assert arm.hear(0.1) == (None, "no message came; nobody publishes it")
    arm.say(0.05, GRIPPER)
    told = "of other joints only: finger; published by /left/gripper"
    assert arm.hear(2.0) == (None, told)
    arm.say(0.05, ONE_MOTOR)
    motors, instead = arm.hear(2.0)
    assert motors is None
    assert instead.startswith("what came is of no use: name: expected every motor once (motor1,")
    assert instead.endswith("missing: motor2; published by /left/gripper")


ELSEWHERE = JointState(name=["motor1", "motor2"], position=[3.1, 0.5])


def test_publishers_that_contradict_each_other_tell_nothing(arm):
    """The robot began where whichever came first had it, and jumped."""
    arm.say(0.02, MOTORS)
    arm.say(0.013, ELSEWHERE)
    arm.until_published(2)
    motors, instead = arm.hear(5.0)
    assert motors is None
    assert instead.startswith(
        "the motors are measured in two places in turn, 0.5 (rad or rod lengths)"
    )
    assert instead.endswith("published by /left/gripper")
    motors, instead = arm.hear(5.0, tolerance=0.6)
    assert motors is not None and instead == ""


def test_publishers_that_agree_are_heard(arm):
    near = JointState(name=["motor1", "motor2"], position=[2.65, 0.5])
    arm.say(0.02, MOTORS, GRIPPER)
    arm.say(0.013, near)
    arm.until_published(2)
    motors, instead = arm.hear(5.0)
    assert motors[0] in (2.6, 2.65) and instead == ""


def test_of_several_publishers_the_newest_measurement_counts(arm):
    """The first one was half a second old by then."""
    moving = JointState(name=["motor1", "motor2"], position=[2.6, 0.5])
    arm.say(0.05, GRIPPER)
    arm.say(0.02, moving)
    arm.until_published(2)
    begun = moving.position[0] = 2.6

    def go_on():
        while not arm._over.wait(0.01):
            moving.position[0] += 0.001

    arm._threads.append(threading.Thread(target=go_on))
    arm._threads[-1].start()
    motors, _ = arm.hear(5.0)
    assert begun + 0.02 < motors[0] and moving.position[0] - motors[0] < 0.02


def test_motors_that_run_on_are_waited_for(arm):
    """A second later they were sent back, in one step, to where they were on the way."""
    moving = JointState(name=["motor1", "motor2"], position=[2.0, 0.5])
    arm.say(0.005, moving)
    arm.until_published(1)

    def go_on():
        begun = time.monotonic()
        while not arm._over.wait(0.005):
            moving.position[0] = 2.6 - 0.6 * np.exp((begun - time.monotonic()) / 0.08)

    arm._threads.append(threading.Thread(target=go_on))
    arm._threads[-1].start()
    motors, instead = arm.hear(5.0)
    assert instead == ""
    assert abs(motors[0] - 2.6) < 5e-3


def test_a_wrong_number_beside_a_gripper_is_none_of_two_places(arm):
    wrong = JointState(name=["motor1", "motor2"], position=[9.9, 0.5])
    arm.say(0.05, GRIPPER)
    arm.say(0.8, *[MOTORS] * 3, wrong, *[MOTORS] * 3)  # once while it is listened to
    arm.until_published(2)
    motors, instead = arm.hear(5.0)
    assert instead == "" and motors[0] == 2.6

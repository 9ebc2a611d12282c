# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot and its node, which may be ended and started again, and begins where it finds the robot."""

import signal
import time

import numpy as np
from lifecycle_msgs.srv import GetState
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from cpr_core import load_robot, solve_forward
from cpr_ros.operation.kept_state import KeptState
from helpers.driver import EVERY_MESSAGE
from helpers.node_process import Client, NodeProcess, change, free_domain

__all__ = ["HOME", "RATE", "SPEED", "STEP", "RobotBench"]

HOME = np.array([2.59, 0.55])
SPEED, RATE = 0.8, 200.0
#: Longest way of a motor in a tick [rad].
STEP = SPEED / RATE


class RobotBench:
    """A robot's side: hears commands, sends setpoints, says what it measures."""

    def __init__(self, folder):
        self.folder, self.domain, self.starts = folder, free_domain(), 0
        self.client = Client(self.domain)
        self.commands, self.ended = [], []
        node = self.client.node
        node.create_subscription(
            Float64MultiArray,
            "/cpr_node/motor_commands",
            lambda message: self.commands.append(np.array(message.data)),
            EVERY_MESSAGE,
        )
        self.setpoints = node.create_publisher(Float64MultiArray, "/cpr_node/commands", 1)
        self.measured = self.motors = None
        self.process = None

    def start(self, *parameters, until="ready"):
        arguments = ["-p", "robot:=rfrfr", "-p", f"max_speed:={SPEED}", "-p", f"tick_rate:={RATE}"]
        arguments += ["-p", f"state_directory:={self.folder / 'states'}"]
        for parameter in parameters:
            arguments += ["-p", parameter]
        self.starts += 1
        self.process = NodeProcess(self.folder / f"node{self.starts}.log", self.domain, arguments)
        if until:
            self.process.wait_for_log(until)

    @property
    def file(self):
        """In which the node keeps where it is."""
        return self.folder / "states" / f"cpr_node.{self.domain}.state"

    def kept(self, robot):
        """The file of the node, which nobody else may open meanwhile."""
        return KeptState(self.file, robot)

    def keep(self, robot, found=None, measured=False):
        """Leave a last state, somewhere beside home if not said where."""
        kept = self.kept(robot)
        found = found or solve_forward(robot, [2.7, 0.4])
        kept.keep(found, found.motors, measured)
        kept.close()

    def measure(self, motors, names=("motor1", "motor2")):
        """Say ten times a second where the motors are, and nothing else any more."""
        message = JointState(name=names, position=[float(q) for q in motors])
        self._measure(0.1, lambda: message)

    def measure_followers(self, motors, lag=0.03):
        """Motors that follow the commands, late by a time constant [s], from where they are now on."""
        self.motors = np.array(motors, float)

        def follow():
            if self.commands:
                self.motors += 0.01 / lag * (self.commands[-1] - self.motors)
            return JointState(name=["motor1", "motor2"], position=self.motors.tolist())

        self._measure(0.01, follow)

    def _measure(self, period, message):
        node = self.client.node
        self.measure_no_more()
        publisher = node.create_publisher(
            JointState, "/measured_joint_states", qos_profile_sensor_data
        )
        timer = node.create_timer(period, lambda: publisher.publish(message()))
        self.measured = timer, publisher

    def measure_no_more(self):
        if self.measured is not None:
            timer, publisher = self.measured
            self.client.node.destroy_timer(timer)
            self.client.node.destroy_publisher(publisher)
            self.measured = None

    def send(self, *motors):
        self.setpoints.publish(Float64MultiArray(data=[float(motor) for motor in motors]))

    def until_heard(self, count=1):
        heard = len(self.commands)
        self.client.spin_until(lambda: len(self.commands) >= heard + count)

    def until_said(self, text):
        """In the log; meanwhile the robot measures."""
        self.client.spin_until(lambda: text in self.process.output(), timeout=240.0)

    def until_answered(self):
        """By the node of now: a request goes to one that was killed, while nobody else is known yet."""
        states = self.client.node.create_client(GetState, "/cpr_node/get_state")
        asked = []

        def answered():
            if not asked or time.monotonic() > asked[-1][0] + 0.5:
                asked.append((time.monotonic(), states.call_async(GetState.Request())))
            return any(future.done() for _, future in asked)

        self.client.spin_until(answered)
        self.client.node.destroy_client(states)

    def until_at(self, motors):
        def arrived():
            return self.commands and np.array_equal(self.commands[-1], motors)

        self.client.spin_until(arrived)

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.client.executor.spin_once(timeout_sec=0.005)

    def change(self, *transitions):
        if self.ended:
            self.until_answered()
        for transition in transitions:
            assert change(self.client, transition), self.process.output()

    def kill(self, afterwards=lambda: None):
        """Kill the node. What it was about to send, or sent to nobody, is in its file."""
        self.process.process.send_signal(signal.SIGKILL)
        self.process.process.wait()
        afterwards()
        heard = -1
        while heard < len(self.commands):  # what is on the way
            heard = len(self.commands)
            self.spin(0.2)
        kept = self.kept(load_robot("rfrfr"))
        last = kept.last()
        kept.close()
        assert np.abs(last.motors - self.commands[-1]).max() <= 5.0 * STEP
        self.ended.append(self.commands)
        self.commands = [last.motors]

    def longest_step(self):
        """Longest way of a motor between two commands, in ticks."""
        lives = [life for life in (*self.ended, self.commands) if len(life) > 1]
        return max(np.abs(np.diff(life, axis=0)).max() for life in lives) / STEP

    def close(self):
        self.client.close()
        assert self.process.stop() in (0, -signal.SIGKILL, 1), self.process.output()

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The side of a controller and a supervisor: setpoints out, state and stability in."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from cpr_msgs.srv import SolveForward
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import SetBool, Trigger

from helpers.node_process import TIMEOUT, Client

#: Depth of subscriptions of tests that look at every message: DDS forgets the oldest of a full queue,
#: and a process that gets no processor for half a second finds a hundred of the 200 a second.
EVERY_MESSAGE = 10_000


def pose_at(x: float, y: float, z: float = 0.0) -> PoseStamped:
    """A place of the platform, not turned."""
    message = PoseStamped()
    point = message.pose.position
    point.x, point.y, point.z = float(x), float(y), float(z)
    return message


def set_parameters(client: Client, node: str, **values: float) -> Any:
    """Set parameters of a node, all or none; its answer."""
    parameters = [
        Parameter(
            name=name,
            value=ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value),
        )
        for name, value in values.items()
    ]
    return client.call(
        SetParametersAtomically,
        f"{node}/set_parameters_atomically",
        SetParametersAtomically.Request(parameters=parameters),
    ).result


class Driver:
    """Publishers and the newest of what the node publishes."""

    def __init__(self, client: Client, name: str = "/cpr_node", namespace: str = "") -> None:
        self.client, self.name = client, f"{namespace}{name}"
        node = client.node
        self.outputs: dict[type, list[Any]] = {}
        self._forgotten = 0  # stamps up to here [ns]
        self.motor_setpoint = node.create_publisher(JointState, f"{self.name}/motor_setpoint", 10)
        self.commands = node.create_publisher(Float64MultiArray, f"{self.name}/commands", 1)
        self.platform = node.create_publisher(PoseStamped, f"{self.name}/platform_setpoint", 1)
        self.wrench = node.create_publisher(
            WrenchStamped, f"{self.name}/external_wrench", qos_profile_sensor_data
        )
        self._subscriptions = [
            node.create_subscription(kind, topic, self._keeping(kind), EVERY_MESSAGE)
            for kind, topic in (
                (StabilityMetrics, f"{self.name}/stability"),
                (JointState, f"{namespace}/joint_states"),
                (PoseStamped, f"{self.name}/platform_pose"),
                (Float64MultiArray, f"{self.name}/motor_commands"),
            )
        ]
        publishers = (self.motor_setpoint, self.commands, self.platform, self.wrench)
        self._publishers = publishers
        client.spin_until(
            lambda: (
                all(publisher.get_subscription_count() for publisher in publishers)
                and JointState in self.outputs
                and StabilityMetrics in self.outputs
            ),
            timeout=TIMEOUT,
        )

    def close(self) -> None:
        for publisher in self._publishers:
            self.client.node.destroy_publisher(publisher)
        for subscription in self._subscriptions:
            self.client.node.destroy_subscription(subscription)

    def _keeping(self, kind: type) -> Callable[[Any], None]:
        def keep(message: Any) -> None:
            if not hasattr(message, "header") or _stamp(message) > self._forgotten:
                self.outputs.setdefault(kind, []).append(message)

        return keep

    def all(self, kind: type) -> list[Any]:
        return self.outputs.get(kind, [])

    def forget(self) -> None:
        """Forget what was published until now, also what has not been taken from its queue yet."""
        self._forgotten = time.time_ns()
        for messages in self.outputs.values():
            messages.clear()

    @property
    def metrics(self) -> StabilityMetrics:
        return self.all(StabilityMetrics)[-1]

    @property
    def motors(self) -> np.ndarray:
        return np.array(self.all(JointState)[-1].position)

    @property
    def position(self) -> np.ndarray:
        point = self.all(PoseStamped)[-1].pose.position
        return np.array([point.x, point.y, point.z])

    def spin(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.client.executor.spin_once(timeout_sec=0.02)

    def until(
        self, done: Callable[[], bool], timeout: float = TIMEOUT, *, forget: bool = True
    ) -> None:
        """Wait until something holds that follows from messages yet to come.

        Args:
            done: Whether it does.
            timeout: How long it may take [s].
            forget: Not for what passes: this process may have been held up since it asked for it. Then
                messages count that came since they were forgotten last.
        """
        if forget:
            self.forget()
        self.client.spin_until(
            lambda: bool(
                self.all(StabilityMetrics)
                and self.all(JointState)
                and self.all(PoseStamped)
                and done()
            ),
            timeout,
        )

    def until_state(self, state: int) -> None:
        """Wait until the stream tells a state, and for where the robot is then.

        Topics come on their own: on a busy machine poses may be read a while after the metrics of then.
        """
        self.until(lambda: self.metrics.state == state)
        self.catch_up(
            next(metrics for metrics in self.all(StabilityMetrics) if metrics.state == state)
        )

    def catch_up(self, told: StabilityMetrics) -> None:
        """Wait for where the robot was when something was told, or after it."""
        self.client.spin_until(
            lambda: all(
                self.all(kind) and _stamp(self.all(kind)[-1]) >= _stamp(told)
                for kind in (JointState, PoseStamped)
            ),
            TIMEOUT,
        )

    def until_commands_rest(self) -> None:
        """Wait until the motors are sent nowhere else: then the last command is all that is repeated.

        Commands have no stamps: those of a motion before may be in their queue still. In motion one may
        come twice, as once a second the last one is repeated, but none three times.
        """

        def resting() -> bool:
            last = [command.data for command in self.all(Float64MultiArray)[-3:]]
            return len(last) == 3 and last[0] == last[1] == last[2]

        self.until(resting)

    def send_motors(self, *positions: float, names: list[str] | None = None) -> None:
        names = names or [f"motor{k + 1}" for k in range(len(positions))]
        message = JointState(name=names, position=[float(value) for value in positions])
        self.motor_setpoint.publish(message)

    def send_platform(self, x: float, y: float, z: float = 0.0) -> None:
        self.platform.publish(pose_at(x, y, z))

    def pause(self, paused: bool) -> SetBool.Response:
        return self.client.call(SetBool, f"{self.name}/pause", SetBool.Request(data=paused))

    def reset(self) -> Trigger.Response:
        return self.client.call(Trigger, f"{self.name}/reset", Trigger.Request())

    def go_home(self) -> None:
        """Whatever it did before: idle at home."""
        self.pause(False)
        assert self.reset().success
        self.until_state(StabilityMetrics.STATE_IDLE)

    def set_parameters(self, **values: float) -> Any:
        return set_parameters(self.client, self.name, **values)

    def dropped(self, topic: str) -> int:
        """How many messages of a topic the node has dropped, as its diagnostics tell next."""
        (array,) = self.client.messages(DiagnosticArray, "/diagnostics", 1)
        values = {pair.key: pair.value for status in array.status for pair in status.values}
        return int(values.get(f"dropped {topic}", 0))

    def forward(self, *positions: float) -> SolveForward.Response:
        request = SolveForward.Request(start=SolveForward.Request.START_HOME)
        request.motors.name = [f"motor{k + 1}" for k in range(len(positions))]
        request.motors.position = [float(value) for value in positions]
        return self.client.call(SolveForward, f"{self.name}/solve_forward", request)

    def assert_correct(self, *motors: float, expected: np.ndarray) -> None:
        """The node answers and the answer is right."""
        answer = self.forward(*motors)
        assert answer.error_code.val == ErrorCode.SUCCESS, answer.error_code.message
        point = answer.solution.platform_in_base.position
        np.testing.assert_allclose([point.x, point.y, point.z], expected, atol=1e-10)


def _stamp(message: Any) -> int:
    """When a message was published [ns]."""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec

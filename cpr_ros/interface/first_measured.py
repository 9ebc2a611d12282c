# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measured motors for a node that is about to become active, and what came instead of them."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from cpr_core import CprError, Robot

from ..following.motor_ways import largest_way
from ..following.two_places import TwoPlaces, apart_in_words
from ..messages.motor_messages import measured_motors
from ..middleware.publishers import other_publisher_names, other_publishers, own_topic

__all__ = ["MEASURED", "FirstMeasured", "first_measured"]

#: Topic of the motors as they are measured.
MEASURED = "measured_joint_states"
#: How often it is looked whether a message has come [s].
_LOOK = 0.02
#: How long it is looked whether several publishers agree, and how long a second message of one is waited
#: for, which tells whether the motors move [s].
_SEVERAL = 0.5
#: Motors that go no farther in this time are at rest [s; rad, rod lengths]: others may run on to their
#: last command, from which one where they were measured on the way would lead them back.
_REST, _STILL = 0.1, 2e-3
#: How long motors are waited for to come to rest [s]; noisy ones never do.
_MOVING = 1.0
#: Between two looks: others may say on the same topic, and much oftener, where their joints are.
_QUEUE = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)


class FirstMeasured(NamedTuple):
    """What came while measured motors were waited for.

    Attributes:
        motors: (n,) [rad or m]; None: none that are of use.
        instead: What came instead, for a person; empty if they came.
    """

    motors: NDArray[np.float64] | None
    instead: str


def first_measured(
    node: Node,
    robot: Robot,
    wait: float,
    given_up: Callable[[], bool],
    tolerance: float = 0.0,
) -> FirstMeasured:
    """Motors as they are measured at rest; of several publishers the newest, if they agree.

    Of motors that do not come to rest within a second the newest count. Waits without an executor, for
    a node that is about to become active.

    Args:
        node: The node.
        robot: The robot.
        wait: How long to wait [s].
        given_up: Asked many times a second: whether to stop waiting.
        tolerance: How far publishers may be apart [rad, rod lengths]; 0: as far as they like.
    """
    own = own_topic(node, MEASURED)
    if own:
        return FirstMeasured(None, f"{MEASURED} is {own}, where the node itself publishes")
    joints, useless = dict[str, None](), ""
    subscription = node.create_subscription(JointState, MEASURED, lambda _: None, _QUEUE)
    newest: NDArray[np.float64] | None = None
    units, first, since, place = robot.motor_units.tolist(), 0.0, 0.0, np.zeros(robot.motor_count)
    places = TwoPlaces(robot, often=2)  # one wrong number is one time
    try:
        end = time.monotonic() + wait
        while time.monotonic() < end and not given_up():
            with subscription.handle:
                came = subscription.handle.take_message(JointState, False)
            if came is None:
                time.sleep(_LOOK)
                continue
            try:
                motors = measured_motors(robot, came[0])
            except CprError as error:
                names = came[0].name
                if names and set(names).isdisjoint(robot.motor_names):
                    joints.update(dict.fromkeys(names))
                else:
                    useless = str(error)
                continue
            now = time.monotonic()
            if newest is None:
                first, end = now, now + _SEVERAL
            if newest is None or largest_way(place, motors, units) > _STILL:
                place, since = motors, now
                end = max(end, min(first + _MOVING, now + _SEVERAL))
            newest = motors
            if not tolerance or other_publishers(node, MEASURED) < 2:
                if now - since >= _REST:
                    break
            elif apart := places.take(motors, None, tolerance, now):
                return FirstMeasured(None, f"{apart_in_words(apart)} {_publishers(node)}")
    finally:
        node.destroy_subscription(subscription)
    if newest is not None:
        return FirstMeasured(newest, "")
    return FirstMeasured(None, f"{_came(list(joints), useless)}; {_publishers(node)}")


def _came(joints: list[str], useless: str) -> str:
    """What was said, as far as it helps who looks for the mistake."""
    if useless:
        return f"what came is of no use: {useless:.300}"
    if joints:
        return f"of other joints only: {', '.join(joints):.200}"
    return "no message came"


def _publishers(node: Node) -> str:
    found = other_publisher_names(node, MEASURED)
    return f"published by {', '.join(found)}" if found else "nobody publishes it"

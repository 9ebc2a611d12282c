# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the node says again and again, and how its end is noticed."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rclpy.duration import Duration
from rclpy.qos import LivelinessPolicy, QoSProfile

from ..operation.session import Session
from ..process.in_pieces import Work

__all__ = ["Stream", "promised"]

#: The shortest time between two messages that is promised [s]: the machine may be busy.
_SHORTEST_PROMISE = 0.1


def promised(rate: float) -> QoSProfile:
    """For a stream whose end somebody has to notice.

    The next message comes within two periods, or 0.1 s if that is longer; else the stream is late
    (deadline) and its publisher no longer alive (liveliness), be the process dead or its thread stuck.

    Args:
        rate: Of the stream [Hz].
    """
    longest = Duration(seconds=max(_SHORTEST_PROMISE, 2.0 / rate))
    return QoSProfile(
        depth=10,
        deadline=longest,
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,  # only a message is a sign of life
        liveliness_lease_duration=longest,
    )


class Stream(NamedTuple):
    """What is said again and again while the node is active.

    Attributes:
        name: Of the work that telling it is.
        rate: How often [Hz].
        wanted: Whether anybody listens, at a steady time [s].
        tell: Tells of the robot at a steady time [s], or gives the work of doing so, in pieces.
    """

    name: str
    rate: float
    wanted: Callable[[float], bool]
    tell: Callable[[Session, float], Work | None]

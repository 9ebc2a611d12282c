# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The robot as URDF: base, platform and motors, for RobotModel in rviz and robot_state_publisher.

URDF knows trees of rigid links only. What motors move from the base on is one: motors, cranks and
carriages, up to the first passive joint or rod of a leg. The platform hangs on no such tree: it is a
child of the base by a floating joint, whose transform the node sends. Rods are shown by markers.
A tracker stands on the base, its marker on the platform.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot
from cpr_core.description.chain import ChainJoint, ChainRod
from cpr_core.description.chain_element import ChainElement
from cpr_core.description.leg_description import LegDescription
from cpr_core.description.motors import MotorLimits
from cpr_core.lie import roll_pitch_yaw

__all__ = ["marker_frame", "robot_urdf"]

Floats = NDArray[np.float64]

#: For limits that URDF wants and the motor does not have [rad or m, their rates, N m or N].
_UNLIMITED = 1e6
#: Radius of what is drawn, in mean rod lengths.
_THICKNESS = 0.01


def marker_frame(tracker: str) -> str:
    """Name of the frame of the marker of a tracker."""
    return f"{tracker}_marker"


def robot_urdf(robot: Robot, base: str, platform: str, tracker: str = "tracker") -> str:
    """The description of a robot as URDF.

    The position of a joint with the name of a motor is that of the motor in ``joint_states``. Further
    joints that the same motor moves, and those with a ratio, follow it by ``mimic``. Motors behind a
    passive joint or a rod are left out: where they are depends on the equilibrium.

    Args:
        robot: The robot.
        base: Name of the frame fixed in space.
        platform: Name of the frame of the platform.
        tracker: Name of the frame of the tracker, if there is one; its marker is called after it.
    """
    return _Writer(robot, base, platform, tracker).text()


@dataclass(frozen=True, eq=False)
class _Place:
    """A frame that is fixed to a link.

    Attributes:
        link: Name of the link.
        rotation: Of the frame in the link, (3, 3).
        position: Of its origin in the link, (3,) [m].
    """

    link: str
    rotation: Floats
    position: Floats

    def behind(self, element: ChainElement) -> _Place:
        """Where an element leads, its coordinate at zero."""
        # With its zero a joint is where it is with the motor at zero; the motor turns it on.
        return _Place(self.link, *element.behind(self.rotation, self.position, 0.0))


class _Driven(NamedTuple):
    """How a motor moves a joint.

    Attributes:
        motor: Name of the motor.
        axis: Of the joint, in its frame.
        ratio: Way of the joint by that of the motor.
    """

    motor: str
    axis: tuple[float, float, float]
    ratio: float


class _Writer:
    """Writes one robot."""

    def __init__(self, robot: Robot, base: str, platform: str, tracker: str) -> None:
        self._robot, self._base = robot, base
        self._radius = _THICKNESS * robot.mean_length
        self._limits = {motor.name: motor.limits for motor in robot.description.motors}
        self._moved: set[str] = set()  # motors that have their joint
        self._root = Element("robot", name=robot.description.name)
        SubElement(self._root, "link", name=base)
        self._add_platform(platform)
        if (seen := robot.description.tracker) is not None:
            self._add_fixed(base, tracker, seen.position, seen.rotation)
            self._add_fixed(
                platform, marker_frame(tracker), seen.marker_position, seen.marker_rotation
            )
        for leg in robot.description.legs:
            self._add_leg(leg)

    def text(self) -> str:
        ElementTree.indent(self._root)
        declaration = '<?xml version="1.0"?>\n'
        return f"{declaration}{ElementTree.tostring(self._root, encoding='unicode')}\n"

    def _add_platform(self, name: str) -> None:
        link = SubElement(self._root, "link", name=name)
        for leg in self._robot.description.legs:
            self._draw_bar(link, np.array(leg.joint.position))
        joint = self._joint(f"{self._base}_to_{name}", "floating", self._base, name)
        SubElement(joint, "origin", xyz="0 0 0", rpy="0 0 0")

    def _add_fixed(self, parent: str, child: str, position: Floats, rotation: Floats) -> None:
        """A frame that stands on a link."""
        SubElement(self._root, "link", name=child)
        joint = self._joint(f"{parent}_to_{child}", "fixed", parent, child)
        angles = roll_pitch_yaw(rotation)
        SubElement(joint, "origin", xyz=_numbers(position), rpy=_numbers(angles))

    def _add_leg(self, leg: LegDescription) -> None:
        """What of a leg the motors alone move."""
        place = _Place(self._base, leg.base_rotation, leg.base_position)
        for number, element in enumerate(leg.chain):
            if isinstance(element, ChainJoint) and element.motor is not None:
                child = f"{leg.name}.{number + 1}"
                place = place.behind(element)
                shaft = "revolute" if element.motor_unit == "rad" else "prismatic"
                driven = _Driven(element.motor, element.axis, element.ratio)
                self._add_motor(driven, (element.shown_kind, shaft), place, child)
                place = _Place(child, np.eye(3), np.zeros(3))
            elif isinstance(element, ChainRod) and element.motor is not None:
                child = f"{leg.name}.{number + 1}"
                kinds = "prismatic", "revolute" if element.drive.screw else "prismatic"
                began = place.position + element.zero * place.rotation[:, 0]
                place = _Place(place.link, place.rotation, began)
                driven = _Driven(element.motor, (1.0, 0.0, 0.0), element.ratio)
                self._add_motor(driven, kinds, place, child)
                return
            elif isinstance(element, ChainJoint | ChainRod):
                return
            else:
                before, place = place.position, place.behind(element)
                if place.link != self._base:
                    links = self._root.iter("link")
                    link = next(link for link in links if link.get("name") == place.link)
                    self._draw_bar(link, place.position, before)

    def _add_motor(
        self, driven: _Driven, kinds: tuple[str, str], place: _Place, child: str
    ) -> None:
        """A joint that a motor moves, of a kind with that of the motor; the first has its name."""
        (kind, kind_of_motor), motor = kinds, driven.motor
        own = motor not in self._moved and driven.ratio == 1.0 and kind == kind_of_motor
        if motor not in self._moved and not own:  # the motor itself, for others to follow
            shaft = f"{child}.motor"
            SubElement(self._root, "link", name=shaft)
            self._add_joint(motor, kind_of_motor, place, shaft, driven._replace(ratio=1.0))
        self._moved.add(motor)
        link = SubElement(self._root, "link", name=child)
        self._draw_motor(link, kind, driven.axis)
        name = motor if own else f"{child}.joint"
        joint = self._add_joint(name, kind, place, child, driven)
        if not own:
            SubElement(joint, "mimic", joint=motor, multiplier=_number(driven.ratio), offset="0")

    def _add_joint(
        self, name: str, kind: str, place: _Place, child: str, driven: _Driven
    ) -> Element:
        limits = self._limits[driven.motor]
        endless = kind == "revolute" and math.isinf(limits.lower) and math.isinf(limits.upper)
        joint = self._joint(name, "continuous" if endless else kind, place.link, child)
        angles = roll_pitch_yaw(place.rotation)
        SubElement(joint, "origin", xyz=_numbers(place.position), rpy=_numbers(angles))
        SubElement(joint, "axis", xyz=_numbers(driven.axis))
        SubElement(joint, "limit", _limit(limits, driven.ratio, endless))
        return joint

    def _joint(self, name: str, kind: str, parent: str, child: str) -> Element:
        joint = SubElement(self._root, "joint", name=name, type=kind)
        SubElement(joint, "parent", link=parent)
        SubElement(joint, "child", link=child)
        return joint

    def _draw_motor(self, link: Element, kind: str, axis: tuple[float, float, float]) -> None:
        """A drum about its axis, or a block."""
        visual = SubElement(link, "visual")
        SubElement(visual, "origin", xyz="0 0 0", rpy=_numbers(_angles_of(np.array(axis))))
        geometry, size = SubElement(visual, "geometry"), self._radius
        if kind == "revolute":
            SubElement(geometry, "cylinder", radius=_number(2.0 * size), length=_number(4.0 * size))
        else:
            SubElement(geometry, "box", size=_numbers([3.0 * size, 3.0 * size, 3.0 * size]))

    def _draw_bar(self, link: Element, end: Floats, start: Floats | None = None) -> None:
        """A bar between two points of a link, if it has a length."""
        begin = np.zeros(3) if start is None else start
        way = end - begin
        length = float(np.linalg.norm(way))
        if length < 1e-9:
            return
        visual = SubElement(link, "visual")
        middle = 0.5 * (begin + end)
        SubElement(visual, "origin", xyz=_numbers(middle), rpy=_numbers(_angles_of(way / length)))
        geometry = SubElement(visual, "geometry")
        SubElement(geometry, "cylinder", radius=_number(self._radius), length=_number(length))


def _limit(limits: MotorLimits, ratio: float, endless: bool) -> dict[str, str]:
    """Attributes of a limit: of the motor, or of a joint that goes a multiple of its way."""
    ends = sorted(ratio * end for end in (limits.lower, limits.upper))
    speed, effort = abs(ratio) * limits.speed, limits.effort / abs(ratio)
    # With one end only: the other is beyond it.
    beyond = max([_UNLIMITED, *(2.0 * abs(end) for end in ends if math.isfinite(end))])
    lower, upper = (_finite(end, beyond) for end in ends)
    range_ = {} if endless else {"lower": lower, "upper": upper}
    return range_ | {"effort": _finite(effort), "velocity": _finite(speed)}


def _angles_of(direction: Floats) -> Floats:
    """Roll, pitch, yaw of a frame whose z axis has a direction."""
    x, y, z = direction.tolist()
    return np.array([0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x)])


def _finite(value: float, beyond: float = _UNLIMITED) -> str:
    """A limit as it is, however large, since motors may count in small steps; where none is, one."""
    return _number(value if math.isfinite(value) else math.copysign(beyond, value))


def _number(value: float) -> str:
    return f"{value + 0.0:.12g}"  # no -0


def _numbers(values: Floats | tuple[float, ...] | list[float]) -> str:
    return " ".join(_number(float(value)) for value in values)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot at given motors, as a program that knows rods, rigid pieces and joints is told of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from cpr_core.description.chain import ChainJoint, ChainRod, Link
from cpr_core.description.joints import Fixed, Joint
from cpr_core.description.leg_description import LegDescription
from cpr_core.description.robot_description import RobotDescription

__all__ = [
    "BOW",
    "Frame",
    "NotPossible",
    "PlacedLeg",
    "PlacedRobot",
    "PlacedRod",
    "placed",
    "tip_frame",
]

Floats = NDArray[np.float64]

#: Turn of a bowed leg from base to tip before it is pulled into its joint [rad].
BOW = 1.5


class NotPossible(Exception):
    """A program cannot express a robot; the message says what of it."""


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame in another one.

    Attributes:
        rotation: Axes as columns, (3, 3).
        position: (3,) [m].
    """

    rotation: Floats
    position: Floats

    def __matmul__(self, other: Frame) -> Frame:
        """A frame given in this one, in the frame this one is given in."""
        place = self.position + self.rotation @ other.position
        return Frame(self.rotation @ other.rotation, place)

    @property
    def inverse(self) -> Frame:
        """The other frame, in this one."""
        return Frame(self.rotation.T, -self.rotation.T @ self.position)


@dataclass(frozen=True, eq=False)
class PlacedRod:
    """A rod of a leg.

    Attributes:
        length: [m].
        rigidities: G J1, E J2, E J3, (3,) [N m^2].
        stretch: E A [N].
        shear: G A [N].
        mass: Per length [kg/m].
        before: The rigid piece in front of it, that before the first rod left out.
    """

    length: float
    rigidities: Floats
    stretch: float
    shear: float
    mass: float
    before: Link | None


@dataclass(frozen=True, eq=False)
class PlacedLeg:
    """A leg whose motors stand still: clamped where its first rod begins.

    Attributes:
        clamp: Frame (d1, d2, d3) of the clamp in the world.
        motor_axis: Unit axis of a revolute motor in the world, (3,); None: its motor feeds the rod.
        motor_position: A point of that axis, (3,) [m].
        rods: From base to tip.
        end: The rigid piece behind the last rod.
        hub: The rigid piece between motor and first rod, and its frame in the world.
        tip: What holds the tip.
        bow: Side to which the middle stands out, (3,); None where it is not known.
    """

    clamp: Frame
    motor_axis: Floats | None
    motor_position: Floats
    rods: tuple[PlacedRod, ...]
    end: Link | None
    hub: tuple[Link, Frame] | None
    tip: Joint
    bow: Floats | None

    @property
    def reach(self) -> float:
        """Length from clamp to tip joint, the leg straight [m]."""
        links = [rod.before for rod in self.rods[1:]] + [self.end]
        rigid = sum(float(link.offset[0]) for link in links if link is not None)
        return sum(rod.length for rod in self.rods) + rigid

    def effort(self, moment: Floats, force: Floats, gravity: Floats) -> float:
        """What its motor does, of what the clamp does to the first rod.

        Args:
            moment: At the clamp, in the world, (3,) [N m].
            force: In the world, (3,) [N].
            gravity: (3,) [m/s^2].
        """
        local_moment, local_force = self.clamp.rotation.T @ moment, self.clamp.rotation.T @ force
        if self.motor_axis is None:
            # Fed out by ds, a rod gains its energy per length and yields to the force along it.
            energy = 0.5 * float(local_moment @ (local_moment / self.rods[0].rigidities))
            return float(local_force[0]) - energy
        about = moment + np.cross(self.clamp.position - self.motor_position, force)
        if self.hub is not None:
            link, frame = self.hub
            arm = frame.position + frame.rotation @ link.center_of_mass - self.motor_position
            about = about - np.cross(arm, link.mass * gravity)
        return float(self.motor_axis @ about)

    def bowed_tip(self, part: float) -> Floats:
        """Where the tip is with the leg bent evenly by a part of the whole bow, (3,) [m]."""
        tangent = self.clamp.rotation[:, 0]
        if self.bow is None or part == 0.0:
            return self.clamp.position + self.reach * tangent
        side = self.bow - tangent * (self.bow @ tangent)
        side = side / np.linalg.norm(side)
        turn = BOW * part
        along, across = np.sin(turn), 1.0 - np.cos(turn)
        return self.clamp.position + self.reach / turn * (along * tangent - across * side)


@dataclass(frozen=True, eq=False)
class PlacedRobot:
    """A robot whose motors stand still.

    Attributes:
        description: What it was made of.
        motors: Motor positions, (n,) [rad or m].
        legs: Its legs.
        platform: Roughly where the platform is.
    """

    description: RobotDescription
    motors: Floats
    legs: tuple[PlacedLeg, ...]
    platform: Frame

    @property
    def stiffness(self) -> float:
        """Natural unit of stiffness, E J / l^3 [N/m]."""
        rod = self.legs[0].rods[0]
        return float(rod.rigidities[2]) / rod.length**3


def placed(description: RobotDescription, motors: ArrayLike) -> PlacedRobot:
    """A robot at given motors.

    Args:
        description: The robot.
        motors: Motor positions, (n,) [rad or m].

    Raises:
        NotPossible: It has passive joints in its legs, rods that are bent at rest or not uniform.
    """
    positions = np.asarray(motors, np.float64)
    by_name = dict(zip(description.motor_names, positions.tolist(), strict=True))
    bows = description.home.bow or (None,) * len(description.legs)
    legs = tuple(
        _placed_leg(leg, by_name, bow) for leg, bow in zip(description.legs, bows, strict=True)
    )
    return PlacedRobot(description, positions, legs, _rough_platform(description, legs))


def _placed_leg(leg: LegDescription, motors: dict[str, float], bow: Floats | None) -> PlacedLeg:
    frame = Frame(leg.base_rotation, leg.base_position)
    axis, origin, hub = None, leg.base_position, None
    elements: Iterator = iter(leg.chain)
    rods: list[PlacedRod] = []
    link: Link | None = None
    for element in elements:
        if isinstance(element, ChainJoint):
            if element.motor is None or rods:
                raise NotPossible(f"{leg.name}: a passive joint in the leg")
            if element.kind != "turn":
                raise NotPossible(f"{leg.name}: a prismatic motor")
            axis, origin = frame.rotation @ element.axis, frame.position
            at = motors[element.motor]
        elif isinstance(element, Link):
            if not np.allclose(element.offset[1:], 0.0) or not np.allclose(
                element.rotation, np.eye(3)
            ):
                raise NotPossible(f"{leg.name}: a rigid piece across the leg")
            if rods:
                link = element
                continue
            at, hub = 0.0, (element, frame)
        else:
            rods.append(_placed_rod(element, motors, link))
            link = None
            continue
        frame = Frame(*element.behind(frame.rotation, frame.position, at))
    return PlacedLeg(frame, axis, origin, tuple(rods), link, hub, leg.joint, bow)


def _placed_rod(element: ChainRod, motors: dict[str, float], before: Link | None) -> PlacedRod:
    rod = element.rod
    if not rod.uniform or any(np.any(series) for series in rod.rest_curvature):
        raise NotPossible("a rod that is not uniform or bent at rest")
    area = getattr(rod.section, "area", None)
    if area is None:
        raise NotPossible("a rod of given stiffness, whose stretch is not known")
    length = rod.length if element.motor is None else element.length_at(motors[element.motor])
    return PlacedRod(
        length,
        rod.rigidities,
        rod.young_modulus * area,
        rod.shear_modulus * area,
        rod.mass_per_length,
        before,
    )


def _rough_platform(description: RobotDescription, legs: tuple[PlacedLeg, ...]) -> Frame:
    """Where the description says it is; else between the tips of the bowed legs, turned to them.

    One whose place alone is said is not turned.
    """
    home = description.home
    if home.platform_position is not None:
        rotation = np.eye(3) if home.platform_rotation is None else home.platform_rotation
        return Frame(rotation, home.platform_position)
    tips = np.array([leg.bowed_tip(1.0) for leg in legs])
    joints = np.array([leg.tip.position for leg in legs])
    if description.point_platform:
        return Frame(np.eye(3), tips.mean(axis=0))
    turn, _ = Rotation.align_vectors(tips - tips.mean(axis=0), joints - joints.mean(axis=0))
    rotation = turn.as_matrix()
    return Frame(rotation, tips.mean(axis=0) - rotation @ joints.mean(axis=0))


def tip_frame(joint: Joint) -> Frame:
    """The frame of the tip in the platform; of joints that hold the point alone it has no meaning."""
    rotation = joint.rotation() if isinstance(joint, Fixed) else np.eye(3)
    return Frame(rotation, np.array(joint.position))

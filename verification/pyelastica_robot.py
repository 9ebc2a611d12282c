# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A planar robot whose tips meet in a point, in PyElastica, damped until it stands still."""

from __future__ import annotations

import elastica
import numpy as np
from numpy.typing import NDArray

from cpr_core.description.joints import RevoluteJoint

from .placed_robot import BOW, NotPossible, PlacedLeg, PlacedRobot

__all__ = ["NotRelaxed", "PyelasticaRobot"]

Floats = NDArray[np.float64]

#: Of the largest time step at which a wave of stretch passes one element.
STEP = 0.7
#: Rate at which velocities decay, in natural units: twice the lowest frequency of such robots, as found.
DAMPING = 14.0
#: It stands still when no node is faster, in lengths per natural unit of time.
STILL = 1e-9
#: It is given up after so many natural units of time.
LONGEST = 40.0
#: Steps between two looks at the velocities.
LOOK = 100
#: Its features, put together as its manual does.
COLLECTION = type(
    "Collection",
    (
        elastica.BaseSystemCollection,
        elastica.Constraints,
        elastica.Connections,
        elastica.Damping,
    ),
    {},
)


class NotRelaxed(Exception):
    """The robot does not come to rest."""


class PyelasticaRobot:
    """Rods as thick as an element is long, so thin and stiff with them; their bending is the real one.

    Stretch, shear and rotary inertia of real rods would ask for much smaller time steps. E of the thick
    rods is lower by the fourth power of the radius.
    """

    def __init__(
        self,
        robot: PlacedRobot,
        elements: int,
        turns: tuple[Floats, ...] | None = None,
        joint: float | None = None,
    ) -> None:
        """Build it.

        Args:
            robot: The robot at its motors.
            elements: Of a rod; half of the first lies behind the clamp, which holds its middle.
            turns: Of the elements of each leg, where it begins [rad]; None: bent evenly.
            joint: Stiffness of the spring between the tips [N/m]; None: the stiffest one.

        Raises:
            NotPossible: It was not built for such a robot.
        """
        _check(robot)
        self.robot = robot
        self.elements = elements
        rod = robot.legs[0].rods[0]
        rigidity = float(rod.rigidities[2])
        self.size = rod.length / (elements - 0.5)
        self.radius = self.size
        self.stretch = 4.0 * rigidity / self.radius**2
        self.unit = rod.length**2 * float(np.sqrt(rod.mass / rigidity))
        self.speed_limit = STILL * rod.length / self.unit
        self.time_step = STEP * self.size * float(np.sqrt(rod.mass / self.stretch))
        self.collection = COLLECTION()
        self.rods = [self._rod(leg) for leg in robot.legs]
        for number, (built, leg) in enumerate(zip(self.rods, robot.legs, strict=True)):
            self._lay(built, leg, _bent(self, leg) if turns is None else turns[number])
            self.collection.append(built)
            self.collection.constrain(built).using(
                elastica.OneEndFixedBC,
                constrained_position_idx=(0,),
                constrained_director_idx=(0,),
            )
            self.collection.dampen(built).using(
                elastica.AnalyticalLinearDamper,
                uniform_damping_constant=DAMPING / self.unit,
                time_step=self.time_step,
            )
        stiffness = self.stiffest_joint if joint is None else joint
        self.collection.connect(*self.rods, -1, -1).using(elastica.FreeJoint, k=stiffness, nu=0.0)
        self.collection.finalize()

    @property
    def stiffest_joint(self) -> float:
        """The spring between the tips that goes with the elements [N/m]."""
        return 4.0 * self.stretch / self.robot.legs[0].rods[0].length

    @property
    def turns(self) -> tuple[Floats, ...]:
        """Turns of the elements of each leg from the clamp on, (elements,) [rad]."""
        found = []
        for built, leg in zip(self.rods, self.robot.legs, strict=True):
            tangent, normal = leg.clamp.rotation[:, 0], _across(leg)
            axes = built.director_collection[2]
            found.append(np.unwrap(np.arctan2(normal @ axes, tangent @ axes)))
        return tuple(found)

    @property
    def answer(self) -> Floats:
        """Position of the point where the tips meet [m], then efforts [N m], (3 + legs,)."""
        tips = [built.position_collection[:, -1] for built in self.rods]
        efforts = [
            _effort(leg, built) for leg, built in zip(self.robot.legs, self.rods, strict=True)
        ]
        return np.concatenate([np.mean(tips, axis=0), efforts])

    def settle(self) -> None:
        """Step in time until nothing moves.

        Raises:
            NotRelaxed: Something still moves after a long time.
        """
        stepper, time = elastica.PositionVerlet(), np.float64(0.0)
        while time < LONGEST * self.unit:
            for _ in range(LOOK):
                time = stepper.step(self.collection, time, np.float64(self.time_step))
            fastest = max(np.abs(built.velocity_collection).max() for built in self.rods)
            if fastest < self.speed_limit:
                return
        raise NotRelaxed(f"{self.elements} elements still move after {LONGEST:g} units of time")

    def _rod(self, leg: PlacedLeg) -> elastica.CosseratRod:
        rod, tangent = leg.rods[0], leg.clamp.rotation[:, 0]
        area = np.pi * self.radius**2
        young = self.stretch / area
        return elastica.CosseratRod.straight_rod(
            self.elements,
            leg.clamp.position - 0.5 * self.size * tangent,
            tangent,
            np.array([0.0, 0.0, 1.0]),
            self.elements * self.size,
            self.radius,
            rod.mass / area,
            youngs_modulus=young,
            shear_modulus=young * rod.shear / rod.stretch,
        )

    def _lay(self, built: elastica.CosseratRod, leg: PlacedLeg, turns: Floats) -> None:
        """Give a rod its shape to begin with; what it was at rest stays."""
        tangent, normal = leg.clamp.rotation[:, 0], _across(leg)
        axes = np.outer(tangent, np.cos(turns)) + np.outer(normal, np.sin(turns))
        built.position_collection[:, 1:] = built.position_collection[:, :1] + np.cumsum(
            self.size * axes, axis=1
        )
        built.director_collection[1] = np.cross(axes.T, built.director_collection[0].T).T
        built.director_collection[2] = axes


def _check(robot: PlacedRobot) -> None:
    description = robot.description
    if not description.planar or not description.point_platform or len(robot.legs) != 2:
        raise NotPossible(
            "a platform that is a body: not built, its rigid bodies are spheres and cylinders"
        )
    for leg in robot.legs:
        if len(leg.rods) != 1 or leg.end is not None or leg.hub is not None:
            raise NotPossible("legs of several pieces: not built")
        if leg.motor_axis is None:
            raise NotPossible("rods that are fed: not built")
        if not isinstance(leg.tip, RevoluteJoint):
            raise NotPossible("tips without a hinge: not built")
        if leg.rods[0].length != robot.legs[0].rods[0].length:
            raise NotPossible("rods of different lengths: not built")
    if np.any(description.gravity):
        raise NotPossible("weight: not built")


def _across(leg: PlacedLeg) -> Floats:
    """The direction in the plane to the left of the clamp, (3,)."""
    along = leg.clamp.rotation[:, 0]
    return np.array([-along[1], along[0], 0.0])


def _bent(built: PyelasticaRobot, leg: PlacedLeg) -> Floats:
    """Turns of the elements of a leg bent evenly, its middle to the side of the description."""
    side = 0.0 if leg.bow is None else -float(np.sign(_across(leg) @ leg.bow))
    stations = built.size * np.arange(built.elements, dtype=np.float64)
    turns: Floats = side * BOW / leg.rods[0].length * stations
    return turns


def _effort(leg: PlacedLeg, built: elastica.CosseratRod) -> float:
    """What the motor does: the clamp balances what the rod does to its first node and element."""
    assert leg.motor_axis is not None
    force = -built.internal_forces[:, 0]
    moment = -built.director_collection[:, :, 0].T @ built.internal_torques[:, 0]
    arm = built.position_collection[:, 0] - leg.motor_position
    return float(leg.motor_axis @ (moment + np.cross(arm, force)))

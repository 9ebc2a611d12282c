# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot of continuous rods as the shooting sees it: without dimensions, ready for the kernel."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.joints import Joint, RevoluteJoint, Spherical
from ..description.leg_description import LegDescription
from ..description.loads import Loads
from ..description.motors import RevoluteMotor
from ..errors import InvalidRequest
from ..model.robot import Robot
from .shooting_linearisation import Shooting, ShootingState, balance
from .shooting_method import TABLEAUS, ShootingMethod

__all__ = [
    "ShootingUnits",
    "balance_rows",
    "check_leg",
    "check_robot",
    "check_square",
    "check_unloaded",
    "force_per_length",
    "integrated_by",
    "shooting_knows",
    "shooting_of",
]

Floats = NDArray[np.float64]


class ShootingUnits(NamedTuple):
    """What lengths [m] and wrenches, (6,) [N m, N], are counted in."""

    length: float
    wrench: Floats

    def without_dimensions(self, state: ShootingState) -> ShootingState:
        """A state in SI units as the kernel takes it, in memory of its own."""
        motors, wrenches, rotation, position = map(np.array, state)
        return ShootingState(motors, wrenches / self.wrench, rotation, position / self.length)

    def with_dimensions(self, state: ShootingState) -> ShootingState:
        """States of the kernel in SI units: one, or arrays of many with a leading dimension."""
        return state._replace(
            wrenches=self.wrench * state.wrenches, position=self.length * state.position
        )


def shooting_of(
    robot: Robot, loads: Loads, method: ShootingMethod
) -> tuple[Shooting, ShootingUnits]:
    """The robot without dimensions, and its units."""
    legs = robot.description.legs
    length = robot.mean_length
    stiffness = np.array([leg.rod.rigidities[2] for leg in legs])
    moment = float(stiffness.mean()) / length
    force = moment / length
    platform_loads = _platform_loads(robot, loads)
    platform_loads /= np.array([force, length, moment, force, moment, force])[:, None]
    shooting = Shooting(
        planar=robot.planar,
        base_position=np.array([leg.base_position for leg in legs]) / length,
        base_tangent=np.array([leg.base_at(0.0).rotation[:, 0] for leg in legs]),
        motor_axis=_motor_axes(robot),
        tip_position=np.array([leg.joint.position for leg in legs], float) / length,
        length=np.array([leg.rod.length for leg in legs]) / length,
        stiffness=stiffness / (moment * length),
        distributed=force_per_length(robot, loads) * (length / force),
        platform_loads=platform_loads,
        axes=robot.platform_axes.copy(),  # read-only is another type to numba
        **_integration(method),
    )
    return shooting, ShootingUnits(length, np.repeat([moment, force], 3))


def integrated_by(shooting: Shooting, method: ShootingMethod) -> Shooting:
    """The same robot, its rods integrated by another method."""
    return shooting._replace(**_integration(method))


def _integration(method: ShootingMethod) -> dict[str, Any]:
    """What a method is to the kernel, by its fields."""
    nodes, weights = TABLEAUS[method.tableau]
    return {
        "nodes": nodes,
        "weights": weights,
        "abscissae": nodes.sum(axis=1),
        "steps": method.steps,
    }


def _motor_axes(robot: Robot) -> Floats:
    """Motor axes in the world, (n, 3)."""
    axes = [leg.motor.axis for leg in robot.description.legs]  # type: ignore[attr-defined]
    return np.array(axes, np.float64)


def force_per_length(robot: Robot, loads: Loads) -> Floats:
    """Force per length on every rod, in the world, (L, 3) [N/m]."""
    return np.array(
        [
            leg.rod.mass_per_length * loads.gravity + loads.rod_force
            for leg in robot.description.legs
        ]
    )


def _platform_loads(robot: Robot, loads: Loads) -> Floats:
    """As ``Shooting.platform_loads``, in SI units."""
    description = robot.description
    return np.array(
        [
            description.platform_mass * loads.gravity,
            description.center_of_mass,
            loads.wrench_world[:3],
            loads.wrench_world[3:],
            loads.wrench_body[:3],
            loads.wrench_body[3:],
        ]
    )


def balance_rows(robot: Robot, loads: Loads, rotation: Floats, tip_forces: Floats) -> Floats:
    """Derivative of moment and force on the platform by its world twist and the tip forces.

    Args:
        robot: The robot.
        loads: The loads.
        rotation: Platform rotation, (3, 3).
        tip_forces: Forces on the rod tips, in the world, (L, 3) [N].

    Returns:
        (6, 6 + 3 L), in N m and N per rad, m and N.
    """
    tips = np.array([leg.joint.position for leg in robot.description.legs], float)
    residual, rows = np.empty(6), np.empty((6, 6 + 3 * len(tips)))
    balance(_platform_loads(robot, loads), tips, np.array(rotation), tip_forces, residual, rows)
    return rows


def check_square(robot: Robot) -> None:
    """Whether the platform can be held in place of the motors.

    Raises:
        InvalidRequest: Not as many motors as platform coordinates.
    """
    if robot.motor_count != len(robot.platform_axes):
        raise InvalidRequest("held", "expected as many motors as platform coordinates")


def shooting_knows(robot: Robot, loads: Loads) -> bool:
    """Whether the compiled shooting knows robots and loads of this kind."""
    try:
        check_robot(robot, loads)
    except InvalidRequest:
        return False
    return True


def check_leg(leg: LegDescription, *tip_joints: type[Joint]) -> None:
    """Whether a leg is one of the paper: turned by a motor, with a joint of some kinds at its tip.

    Raises:
        InvalidRequest: It is not.
    """
    if not isinstance(leg.motor, RevoluteMotor) or leg.drive.motor is None:
        raise InvalidRequest("robot", f"{leg.name}: expected a revolute motor")
    if not isinstance(leg.joint, tip_joints):
        raise InvalidRequest("robot", f"{leg.name}: expected a tip joint that takes no moment")
    if not leg.rod.uniform or any(np.any(series) for series in leg.rod.rest_curvature):
        raise InvalidRequest("robot", f"{leg.name}: expected a uniform rod, straight at rest")


def check_unloaded(robot: Robot, loads: Loads) -> None:
    """Whether nothing acts on a robot but its motors.

    Raises:
        InvalidRequest: Something does.
    """
    acting = [loads.rod_force, loads.wrench_world, loads.wrench_body]
    description = robot.description
    if description.platform_mass or any(leg.rod.mass_per_length for leg in description.legs):
        acting.append(loads.gravity)
    if loads.distributed or loads.points or any(np.any(vector) for vector in acting):
        raise InvalidRequest("loads", "expected none")


def check_robot(robot: Robot, loads: Loads) -> None:
    """Whether the compiled shooting knows robots and loads of this kind.

    Raises:
        InvalidRequest: It does not.
    """
    if robot.motor_count != len(robot.description.legs):
        raise InvalidRequest("robot", "expected a motor for every leg")
    for leg in robot.description.legs:
        if leg.elements is not None:
            raise InvalidRequest("robot", f"{leg.name}: expected a motor and a rod, not a chain")
        check_leg(leg, RevoluteJoint if robot.planar else Spherical, Spherical)
        bending = leg.rod.rigidities[1:]
        if not robot.planar and abs(bending[0] - bending[1]) > 1e-12 * bending[1]:
            raise InvalidRequest("robot", f"{leg.name}: expected a rod equally stiff to all sides")
    if loads.distributed or loads.points:
        raise InvalidRequest("loads", "expected gravity, rod_force and platform wrenches only")

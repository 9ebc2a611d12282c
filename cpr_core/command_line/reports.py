# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the command line prints: results as plain values for JSON, and as text for people."""

from __future__ import annotations

import json
import math
from typing import Any, cast

import numpy as np

from ..errors import InvalidRequest
from ..model.bending_strain import bending_strains
from ..model.equilibrium import Equilibrium, spectrum
from ..model.kinemato_statics import KinematoStatics
from ..model.stability import MotorReading
from ..solving.discretisation_error import DiscretisationError
from ..solving.requests import pose_meaning

__all__ = [
    "as_json",
    "equilibrium_as_dict",
    "equilibrium_as_text",
    "error_as_dict",
    "error_as_text",
    "json_number",
    "kinemato_statics_as_dict",
    "kinemato_statics_as_text",
    "stability_as_dict",
    "stability_as_text",
]

_TWIST = ("omega_x", "omega_y", "omega_z", "v_x", "v_y", "v_z")
#: The same as small motions, and the components of a wrench, with their units.
_MOTION = (*(f"{name} [rad]" for name in _TWIST[:3]), *(f"{name} [m]" for name in _TWIST[3:]))
_WRENCH = ("m_x [N m]", "m_y [N m]", "m_z [N m]", "f_x [N]", "f_y [N]", "f_z [N]")


def as_json(values: dict[str, Any]) -> str:
    """Plain values as every command prints them."""
    return json.dumps(values, indent=2, allow_nan=False)


def json_number(value: float) -> float | None:
    """A number as JSON can hold it; None: it is not finite."""
    return float(value) if math.isfinite(value) else None


def equilibrium_as_dict(equilibrium: Equilibrium) -> dict[str, Any]:
    """An equilibrium as plain values, SI units; what a JSON value cannot hold becomes None."""
    robot = equilibrium.robot
    locked, free = equilibrium.spectrum_locked, equilibrium.spectrum_free
    return {
        "robot": robot.description.name,
        "converged": equilibrium.converged,
        "residual": equilibrium.residual,
        "iterations": equilibrium.iterations,
        "motor_names": list(robot.motor_names),
        "motors": equilibrium.motors.tolist(),
        "efforts": equilibrium.efforts.tolist(),
        "platform": {
            "position": equilibrium.platform_position.tolist(),
            "quaternion_wxyz": equilibrium.platform_quaternion.tolist(),
        },
        "pose_names": list(pose_meaning(robot)),
        "pose": equilibrium.pose.tolist(),
        "leg_coordinates": equilibrium.leg_coordinates.tolist(),
        "multipliers": equilibrium.multipliers.tolist(),
        "bending_strains": [*map(json_number, bending_strains(equilibrium).tolist())],
        "energy": equilibrium.energy,
        "index_locked": locked.index,
        "index_free": free.index,
        "smallest_eigenvalue_locked": json_number(locked.smallest),
        "smallest_eigenvalue_free": json_number(free.smallest),
        "margin_locked": json_number(locked.margin),
        "energy_criterion_applies": locked.energy_criterion_applies,
    }


def equilibrium_as_text(equilibrium: Equilibrium) -> str:
    """An equilibrium in a few lines."""
    robot = equilibrium.robot
    lines = [f"{robot.description.name}: equilibrium, residual {equilibrium.residual:.1e}"]
    moved = zip(robot.description.motors, equilibrium.motors, equilibrium.efforts, strict=True)
    for motor, at, effort in moved:
        lines.append(
            f"  {motor.name:<12} {at:14.10f} {motor.unit:<3} {effort:14.10f} {motor.effort_unit}"
        )
    position = " ".join(f"{value:14.10f}" for value in equilibrium.platform_position)
    lines.append(f"  platform     {position} m")
    if not robot.description.point_platform:
        quaternion = " ".join(f"{value:14.10f}" for value in equilibrium.platform_quaternion)
        lines.append(f"  quaternion   {quaternion} (w x y z)")
    lines += _strain_as_text(equilibrium)
    locked, free = equilibrium.spectrum_locked, equilibrium.spectrum_free
    verdict = "stable" if locked.index == 0 else "UNSTABLE"
    if not locked.energy_criterion_applies:
        lines.append("  stability not decided by energy: a non-conservative load acts")
        verdict = "by its energy alone " + verdict
    lines.append(
        f"  {verdict} with motors held (index {locked.index}, margin {locked.margin:.4f}); "
        f"index {free.index} at constant effort"
    )
    if names := pose_meaning(robot):  # as --pose takes them
        pose = " ".join(f"{value:14.10f}" for value in equilibrium.pose)
        lines.append(f"  controlled   {pose} ({' '.join(names)})")
    else:
        lines.append("  controlled   nothing")
    if equilibrium.objective:
        lines.append(f"  redundant    {equilibrium.objective.replace('_', ' ')}")
    return "\n".join(lines)


def _strain_as_text(equilibrium: Equilibrium) -> list[str]:
    """The bending strain nearest to its limit, else the largest; no line where none is known."""
    robot, strains = equilibrium.robot, bending_strains(equilibrium)
    limits = robot.yield_strains
    counts = np.where(np.isfinite(limits), strains / limits, np.nan)
    if not robot.limits_strain:
        counts = strains
    if np.isnan(counts).all():
        return []
    rod = int(np.nanargmax(counts))
    told = f"nearest to its yield strain {limits[rod]:g}" if robot.limits_strain else "the largest"
    return [f"  bending      {strains[rod]:14.10f} strain of {robot.rod_names[rod]}, {told}"]


def error_as_dict(error: DiscretisationError) -> dict[str, Any]:
    """An estimated error as plain values, SI units: continuous rods minus the equilibrium."""
    return {
        "held": error.problem,
        "platform": {"position": error.position.tolist(), "rotation": error.rotation.tolist()},
        "motors": error.motors.tolist(),
        "efforts": error.efforts.tolist(),
    }


def error_as_text(equilibrium: Equilibrium, error: DiscretisationError) -> str:
    """The same for people: continuous rods minus the equilibrium."""
    lines = [f"  continuous rods with the same {error.problem} would change, by estimate:"]
    moved = zip(equilibrium.robot.description.motors, error.motors, error.efforts, strict=True)
    for motor, way, effort in moved:
        lines.append(
            f"  {motor.name:<12} {way:14.1e} {motor.unit:<3} {effort:14.1e} {motor.effort_unit}"
        )
    lines.append(f"  platform     {error.distance:14.1e} m   {error.angle:14.1e} rad")
    return "\n".join(lines)


def stability_as_dict(equilibrium: Equilibrium, motors_are: MotorReading) -> dict[str, Any]:
    """Stability of an equilibrium: the spectrum of H_r and its smallest eigenvector as a motion."""
    robot, found = equilibrium.robot, spectrum(equilibrium, motors_are)
    motion = found.softest_motion
    return {
        "robot": robot.description.name,
        "motors": equilibrium.motors.tolist(),
        "motors_are": motors_are,
        "stable": found.index == 0 if found.energy_criterion_applies else None,
        "index": found.index,
        "eigenvalues": found.eigenvalues[:6].tolist(),
        "margin": json_number(found.margin),
        "inverse_condition_number": found.inverse_condition_number,
        "energy_criterion_applies": found.energy_criterion_applies,
        "softest_motion": {
            "motors": motion[robot.motor_indices].tolist(),
            "platform_in_world": {
                _TWIST[axis]: float(value)
                for axis, value in zip(
                    robot.platform_axes, motion[robot.platform_indices], strict=True
                )
            },
            "legs": motion[robot.elastic_indices].tolist(),
        },
    }


def stability_as_text(equilibrium: Equilibrium, motors_are: MotorReading) -> str:
    """The same for people."""
    values = stability_as_dict(equilibrium, motors_are)
    verdict = {True: "stable", False: "UNSTABLE", None: "not decided by energy"}[values["stable"]]
    eigenvalues = " ".join(f"{value:.5g}" for value in values["eigenvalues"])
    margin = "-" if values["margin"] is None else f"{values['margin']:.5f}"
    motion = values["softest_motion"]
    platform = " ".join(
        f"{name} {value:.3f}" for name, value in motion["platform_in_world"].items()
    )
    motors = " ".join(f"{value:.3f}" for value in motion["motors"])
    return "\n".join(
        [
            f"{values['robot']}: {verdict} with motors {motors_are}, index {values['index']}",
            f"  margin                    {margin} (1 without forces, 0 where stability is lost)",
            f"  smallest eigenvalues      {eigenvalues} J",
            f"  inverse condition number  {values['inverse_condition_number']:.5g}",
            f"  softest motion            motors {motors}; platform {platform} (world)",
        ]
    )


def kinemato_statics_as_dict(
    model: KinematoStatics, characteristic_length: float | None
) -> dict[str, Any]:
    """Jacobians, compliance, stiffness and singularities; platform rows are body twists."""
    robot = model.equilibrium.robot
    singularities = {}
    for problem in model.problems:
        found = model.singularity(problem, characteristic_length)
        singularities[problem] = {
            "smallest_singular_value": found.smallest,
            "inverse_condition_number": found.inverse_condition_number,
            "sign": found.sign,
            "null_motors": found.motors.tolist(),
            "null_platform": found.platform.tolist(),
        }
    return {
        "robot": robot.description.name,
        "motors": model.equilibrium.motors.tolist(),
        "motor_names": list(robot.motor_names),
        "platform_coordinates": [_TWIST[axis] for axis in robot.platform_axes],
        "jacobian": model.jacobian.tolist(),
        "efforts_by_motors": model.efforts_by_motors.tolist(),
        "efforts_by_wrench": model.efforts_by_wrench.tolist(),
        "compliance_motors_held": model.compliance().tolist(),
        "stiffness_motors_held": _stiffness(model),
        "compliance_constant_effort": _compliance_constant_effort(model),
        "singularities": singularities,
    }


def _stiffness(model: KinematoStatics) -> list[list[float]] | None:
    """Stiffness of the platform; None where it cannot move in some direction."""
    try:
        return cast(list[list[float]], model.stiffness().tolist())
    except InvalidRequest:
        return None


def _compliance_constant_effort(model: KinematoStatics) -> list[list[float]] | None:
    """Compliance with motors at constant effort; None where they do not hold the robot."""
    try:
        stiffness = np.zeros(model.equilibrium.robot.motor_count)
        return cast(list[list[float]], model.compliance(stiffness).tolist())
    except InvalidRequest:
        return None


def kinemato_statics_as_text(model: KinematoStatics, characteristic_length: float | None) -> str:
    """The same for people."""
    values = kinemato_statics_as_dict(model, characteristic_length)
    robot = model.equilibrium.robot
    motions = [_MOTION[axis] for axis in robot.platform_axes]
    wrenches = [_WRENCH[axis] for axis in robot.platform_axes]
    motors = [f"{motor.name} [{motor.unit}]" for motor in robot.description.motors]
    lines = [f"{values['robot']}: kinemato-statics, platform in its own frame"]
    for title, key, columns in (
        ("platform Jacobian dSigma_p/dq_a", "jacobian", motors),
        ("compliance dSigma_p/dw_p, motors held", "compliance_motors_held", wrenches),
    ):
        width = max(12, *(len(column) + 2 for column in columns)) if columns else 12
        lines.append(f"  {title}: row per column")
        lines.append("  " + " " * 14 + "".join(f"{column:>{width}}" for column in columns))
        lines += [
            f"  {row:<14}" + "".join(f"{value:{width}.4g}" for value in numbers)
            for row, numbers in zip(motions, values[key], strict=True)
        ]
    if values["compliance_constant_effort"] is None:
        lines.append(
            "  motors at constant effort do not hold the robot: it moves without any force"
        )
    for problem, found in values["singularities"].items():
        lines.append(
            f"  {problem:<18} smallest singular value {found['smallest_singular_value']:.4g}, "
            f"inverse condition number {found['inverse_condition_number']:.4g}, "
            + (
                f"sign {found['sign']:+d}"
                if found["sign"]
                else "no sign: more unknowns than equations"
            )
        )
    return "\n".join(lines)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a robot can do without resistance, and what its joints hold twice, in words."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from ..kernels.twist_layout import ANGULAR, LINEAR
from ..model.equilibrium import Equilibrium, spectrum
from ..model.platform_coordinates import six_components
from ..model.robot import Robot

__all__ = ["held_twice", "loose_motion"]

Floats = NDArray[np.float64]

#: Eigenvalue of H_r, relative to the largest one, that counts as no stiffness: in equilibrium, and where
#: springs hold the robot, at rest to 1e-6 only.
_NO_STIFFNESS, _NO_STIFFNESS_HELD = 1e-9, 1e-6
#: How much of a motion without stiffness the platform has at least for it to be its own.
_LOOSE = 0.1


def loose_motion(found: Equilibrium) -> str:
    """What the platform or a joint can do without resistance, in words; empty if all is held.

    What is negligible beside a spring, and not beside rods, is held: the spring is named instead.
    """
    robot = found.robot
    whole = spectrum(found)
    sizes = np.abs(whole.eigenvalues)
    if not len(sizes):
        return ""
    negligible = _NO_STIFFNESS if found.converged else _NO_STIFFNESS_HELD
    loose = _in_words(robot, whole.motions[:, sizes < negligible * sizes.max()])
    stiffness, by_springs = _springs(robot), np.zeros_like(sizes)
    for (_, index), each in zip(robot.passive_joints, stiffness, strict=True):
        by_springs += each * (whole.motions[index] / robot.kernel_arrays.unit[index]) ** 2
    of_rods = np.max(sizes, where=by_springs < 0.5 * sizes, initial=0.0)
    if not loose or np.any(sizes < negligible * of_rods):
        return loose
    stiffest = int(np.argmax(stiffness))
    times = stiffness[stiffest] / robot.kernel_arrays.energy_unit
    return (
        f"the spring of joint {robot.passive_joints[stiffest][0].name} is {times:.1g} times as stiff as "
        "the rods (E J / l), which rounding hides beside it; leave the joint out, or give it a softer "
        "spring"
    )


def _springs(robot: Robot) -> Floats:
    """Stiffness of the springs of the passive joints, per natural unit of their motion [J]."""
    return np.array(
        [
            joint.stiffness * robot.kernel_arrays.unit[index] ** 2
            for joint, index in robot.passive_joints
        ]
    )


def _in_words(robot: Robot, loose: Floats) -> str:
    """Motions of the state without stiffness, columns, as those of the platform or a joint."""
    motions = loose[robot.platform_indices]
    lengths = robot.kernel_arrays.unit[robot.platform_indices]
    moved = np.linalg.norm(motions / lengths[:, None], axis=0)
    if not np.any(moved > _LOOSE):
        return _loose_joint(robot, loose)
    motion = (motions / lengths[:, None])[:, int(moved.argmax())]
    twist = six_components(robot.platform_axes, motion)
    turns = np.linalg.norm(twist[ANGULAR]) > np.linalg.norm(twist[LINEAR])
    part = twist[ANGULAR] if turns else twist[LINEAR]
    axis = ", ".join(f"{value:.2g}" for value in part / np.linalg.norm(part) + 0.0)
    return (
        f"nothing holds the platform: it can {'turn about' if turns else 'move along'} "
        f"({axis}) freely; it needs more legs, or tip joints that hold more"
    )


def held_twice(held: Equilibrium, negligible: float) -> str:
    """How many motions joints hold that others hold already, in words; empty if there are none."""
    robot = held.robot
    moving = robot.moving_indices
    constraints, unit = robot.multiplier_indices, robot.kernel_arrays.unit
    slopes = unit[constraints, None] * held.tangent[np.ix_(constraints, moving)] * unit[moving]
    sizes = scipy.linalg.svdvals(slopes)
    independent = int(np.sum(sizes > negligible * sizes.max(initial=0.0)))
    if independent == len(constraints):
        return ""
    return (
        f"of the {len(constraints)} constraints of its joints only {independent} are independent "
        "there: some motion is held twice, or a leg is straight; let a tip joint hold less, or "
        "leave a leg out"
    )


def _loose_joint(robot: Robot, motions: Floats) -> str:
    """A passive joint of a leg that some of the motions without stiffness move, in words."""
    for joint, index in robot.passive_joints:
        if np.any(np.abs(motions[index]) > _LOOSE * robot.kernel_arrays.unit[index]):
            return (
                f"nothing holds joint {joint.name}: with the others it moves freely; give it a spring, "
                "or leave it out"
            )
    return ""

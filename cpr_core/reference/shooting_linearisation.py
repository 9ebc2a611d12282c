# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Gaps of the legs and balance of the platform at a state, linearised; legs are eliminated.

Every leg gives its base wrench in terms of platform and motor increments; what is left is a system
of the platform's size. All quantities are dimensionless: lengths in rod lengths l, moments in
E J / l, forces in E J / l^2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .reference_decorators import reference, reference_part
from .shooting_algebra import add_cross, add_product, add_skew, eliminate
from .shooting_rod_kernel import (
    COLUMNS,
    FIRST,
    PLANAR_COLUMNS,
    PLANAR_FIRST,
    integrate,
    start_rod,
)

__all__ = ["Linearisation", "Shooting", "ShootingState", "balance", "linear_memory", "linearise"]

Floats = NDArray[np.float64]


class Shooting(NamedTuple):
    """A robot as the shooting sees it, dimensionless.

    Attributes:
        planar: Whether everything stays in the plane z = 0.
        base_position: Bases in the world, (L, 3).
        base_tangent: Tangents at the bases with the motors at zero, (L, 3).
        motor_axis: Motor axes in the world, (L, 3).
        tip_position: Tip joints in the platform frame, (L, 3).
        length: Rod lengths, (L,).
        stiffness: E J, (L,).
        distributed: Force per length on the rods, in the world, (L, 3).
        platform_loads: Weight, centre of mass in the platform frame, moment and force fixed in
            space, moment and force fixed in the platform, (6, 3).
        axes: Components of the world twist the platform has, (P,).
        nodes, weights, abscissae: Explicit Runge-Kutta tableau.
        steps: Steps along every rod.
    """

    planar: bool
    base_position: Floats
    base_tangent: Floats
    motor_axis: Floats
    tip_position: Floats
    length: Floats
    stiffness: Floats
    distributed: Floats
    platform_loads: Floats
    axes: NDArray[np.int64]
    nodes: Floats
    weights: Floats
    abscissae: Floats
    steps: int


class ShootingState(NamedTuple):
    """What the shooting finds, written in place.

    Attributes:
        motors: Motor positions [rad], (L,).
        wrenches: Moment and force the rods exert on their bases, in the world, (L, 6).
        rotation: Platform rotation, (3, 3).
        position: Platform position, (3,).
    """

    motors: Floats
    wrenches: Floats
    rotation: Floats
    position: Floats


class Linearisation(NamedTuple):
    """Linearisation at the last state.

    ``legs[i]`` holds the increments of the base wrench: that which closes the gap, then those that go
    with unit increments of the platform and of the motor. ``gap`` is the imbalance of the platform,
    ``motion`` its derivative by the platform, ``turns`` by the motors, legs eliminated.
    """

    legs: Floats
    gap: Floats
    motion: Floats
    turns: Floats


@reference
def linear_memory(robot):
    """Memory of a linearisation."""
    legs, free = len(robot.length), len(robot.axes)
    return Linearisation(
        np.zeros((legs, 6, 2 + free)),
        np.zeros(6),
        np.zeros((6, 6)),
        np.zeros((6, legs)),
    )


@reference
def linearise(robot, state, linear):
    """Linearise at a state; returns the largest gap or imbalance."""
    legs, free = len(robot.length), len(robot.axes)
    rod = np.empty(81)
    inner, slopes = np.empty(81), np.empty((len(robot.weights), 81))
    forces = np.empty((legs, 3))
    tangent, arm = np.empty((3, 1)), np.empty(3)
    largest, total = 0.0, 0.0  # a maximum passes over a NaN, a sum does not
    for number in range(legs):
        wrench = state.wrenches[number]
        start_rod(robot, number, state.motors[number], wrench, tangent, rod)
        integrate(robot, number, wrench[3:], rod, inner, slopes)
        for i in range(3):
            arm[i] = 0.0
            for j in range(3):
                arm[i] += state.rotation[i, j] * robot.tip_position[number, j]
            forces[number, i] = wrench[3 + i] - robot.length[number] * robot.distributed[number, i]
        gap, sum_of_gaps = _close_leg(robot, state.position, arm, rod, linear.legs[number])
        largest, total = max(largest, gap), total + sum_of_gaps

    residual, rows = np.empty(6), np.empty((6, 6 + 3 * legs))
    balance(robot.platform_loads, robot.tip_position, state.rotation, forces, residual, rows)
    for i in range(free):
        largest = max(largest, abs(residual[robot.axes[i]]))
        total += residual[robot.axes[i]]
    _condense(robot, residual, rows, linear)
    return largest if math.isfinite(total) else math.inf


@reference_part
def _close_leg(robot, position, arm, rod, right):
    """Increments of the base wrench, a leg of ``legs``; returns the largest gap and the sum of gaps."""
    planar, free = robot.planar, len(robot.axes)
    block = 3 if planar else 6
    stride = PLANAR_COLUMNS if planar else COLUMNS
    first = PLANAR_FIRST if planar else FIRST
    matrix = np.empty((6, 6))
    along = np.zeros((3, 6))  # derivative of the gap by the platform's twist
    add_skew(1.0, arm, along[:, :3])
    for i in range(3):
        along[i, 3 + i] = -1.0
    right[:] = 0.0
    gaps = block - (1 if planar else 3)
    largest, total = 0.0, 0.0
    for row in range(block):
        if row < gaps:
            source = row
            gap = rod[row] - position[row] - arm[row]
            for column in range(free):
                right[row, 1 + column] = along[row, robot.axes[column]]
        else:
            source = 3 if planar else 6 + row - gaps
            gap = rod[source]
        for column in range(block):
            matrix[row, column] = rod[first + source * stride + column]
        right[row, 1 + free] = rod[first + source * stride + block]
        right[row, 0] = gap
        largest = max(largest, abs(gap))
        total += gap
    eliminate(matrix, right, block, 2 + free)
    return largest, total


@reference_part
def _condense(robot, residual, rows, linear):
    """Balance of the platform with the legs eliminated, from what ``balance`` gives."""
    legs, free = len(robot.length), len(robot.axes)
    block, force_rows = (3, 2) if robot.planar else (6, 3)
    for i in range(free):
        row = robot.axes[i]
        linear.gap[i] = residual[row]
        for j in range(free):
            linear.motion[i, j] = rows[row, robot.axes[j]]
        for number in range(legs):
            linear.turns[i, number] = 0.0
            for k in range(force_rows):
                by_force = rows[row, 6 + 3 * number + k]
                leg = linear.legs[number, block - force_rows + k]
                linear.gap[i] -= by_force * leg[0]
                for j in range(free):
                    linear.motion[i, j] -= by_force * leg[1 + j]
                linear.turns[i, number] -= by_force * leg[1 + free]


@reference
def balance(loads, tips, rotation, forces, residual, rows):
    """Moment about P and force on the platform, and their derivatives.

    Args:
        loads: As ``Shooting.platform_loads``.
        tips: Tip joints in the platform frame, (L, 3).
        rotation: Platform rotation, (3, 3).
        forces: Forces on the rod tips, in the world, (L, 3).
        residual: Overwritten, (6,).
        rows: Overwritten; derivative by the world twist of the platform and the forces, (6, 6 + 3 L).
    """
    arm = np.empty(3)
    rows[:] = 0.0
    for i in range(3):
        residual[i], residual[3 + i] = loads[2, i], loads[3, i] + loads[0, i]
    for part in range(2):
        for i in range(3):
            arm[i] = 0.0
            for j in range(3):
                arm[i] += rotation[i, j] * loads[4 + part, j]
            residual[3 * part + i] += arm[i]
        add_skew(-1.0, arm, rows[3 * part : 3 * part + 3, :3])
    for i in range(3):
        arm[i] = 0.0
        for j in range(3):
            arm[i] += rotation[i, j] * loads[1, j]
    add_cross(1.0, arm, loads[0], residual[:3])
    add_product(1.0, loads[0], arm, rows[:3, :3])  # d(r x f) = f^ r^ dtheta
    for number in range(len(forces)):
        for i in range(3):
            arm[i] = 0.0
            for j in range(3):
                arm[i] += rotation[i, j] * tips[number, j]
        force, first = forces[number], 6 + 3 * number
        add_cross(-1.0, arm, force, residual[:3])
        add_product(-1.0, force, arm, rows[:3, :3])
        add_skew(-1.0, arm, rows[:3, first : first + 3])
        for i in range(3):
            residual[3 + i] -= force[i]
            rows[3 + i, first + i] = -1.0

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shooting along the continuous rods of a whole robot: Newton's method, and paths.

Compiled from the integration (``shooting_rod_kernel``) over the linearisation to the path.
"""

from __future__ import annotations

import math

import numpy as np

from ..kernels.natural_units import LONGEST_STEP
from .reference_decorators import reference
from .shooting_algebra import eliminate, turn
from .shooting_linearisation import ShootingState, linear_memory, linearise

__all__ = ["shoot_along", "shoot_at"]

#: Smallest part of a longest step before giving up.
SMALLEST_STEP = 1e-4
#: Newton corrections of a step; each must be smaller than this times the one before.
CORRECTIONS = 12
CONTRACTION = 0.5


@reference
def shoot_at(robot, state, motors_held, tolerance, iterations):
    """Damped Newton from a rough state, in place.

    Returns:
        Largest gap or imbalance, and the number of steps.
    """
    linear, trial = linear_memory(robot), _duplicate(state)
    nothing = np.zeros(max(6, len(robot.length)))
    largest = linearise(robot, state, linear)
    for iteration in range(iterations):
        if not largest >= tolerance:
            return largest, iteration
        share = 1.0
        while True:
            _copy(state, trial)
            _move(robot, trial, linear, motors_held, nothing, 0.0, share)
            other = linear_memory(robot)
            ahead = linearise(robot, trial, other)
            if ahead < tolerance or ahead <= (1.0 - 0.25 * share) * largest or share < 1e-3:
                break
            share *= 0.5
        _copy(trial, state)
        linear, largest = other, ahead
    return largest, iterations


@reference
def shoot_along(robot, state, motors_held, changes, tolerance, states, residuals, iterations):
    """Follow a path from an equilibrium: Euler predictor, Newton corrector, halved steps.

    Args:
        robot: The robot.
        state: The equilibrium to start from; overwritten with the last one.
        motors_held: Whether motors are imposed, or the platform.
        changes: Imposed change from one point to the next: motors [rad] or world twist, (K, L or 6).
        tolerance: Largest gap or imbalance.
        states: Overwritten with the equilibria, arrays of ``ShootingState`` with a leading K.
        residuals: Overwritten, (K,).
        iterations: Overwritten with the Jacobians used, (K,).

    Returns:
        Number of points reached.
    """
    linear, before = linear_memory(robot), _duplicate(state)
    nothing = np.zeros(max(6, len(robot.length)))
    largest = linearise(robot, state, linear)
    for k in range(len(changes)):
        far = 0.0
        for value in changes[k]:
            far = max(far, abs(value))
        longest = 1.0 / max(1.0, far / LONGEST_STEP)
        reached, step, used = 0.0, longest, 0
        while reached < 1.0:
            share = min(step, 1.0 - reached)
            _copy(state, before)
            length = _move(robot, state, linear, motors_held, changes[k], share, 1.0)
            good = False
            for _ in range(CORRECTIONS):
                used += 1
                largest = linearise(robot, state, linear)
                if largest < tolerance:
                    good = True
                    break
                if not math.isfinite(largest):
                    break
                correction = _move(robot, state, linear, motors_held, nothing, 0.0, 1.0)
                if not correction < CONTRACTION * length:
                    break
                length = correction
            if good:
                reached = 1.0 if share == 1.0 - reached else reached + share
                step = min(longest, 2.0 * share)
                continue
            _copy(before, state)
            linearise(robot, state, linear)
            step = 0.5 * share
            if step < SMALLEST_STEP * longest:
                return k
        states.motors[k], states.wrenches[k] = state.motors, state.wrenches
        states.rotation[k], states.position[k] = state.rotation, state.position
        residuals[k], iterations[k] = largest, used
    return len(changes)


@reference
def _move(robot, state, linear, motors_held, imposed, share, correct):
    """Move by the linearisation; returns the length of the step.

    ``share`` of the imposed change of motors or platform is made, and where ``correct`` is not zero
    that part of gaps and imbalance is removed.
    """
    planar, legs, free = robot.planar, len(robot.length), len(robot.axes)
    block = 3 if planar else 6
    turns, twist = np.zeros(legs), np.zeros(6)
    size = free if motors_held else legs
    matrix, right = np.empty((size, size)), np.empty((size, 1))
    for i in range(size):
        right[i, 0] = -correct * linear.gap[i]
        if motors_held:
            for j in range(size):
                matrix[i, j] = linear.motion[i, j]
            for number in range(legs):
                right[i, 0] -= share * linear.turns[i, number] * imposed[number]
        else:
            for j in range(size):
                matrix[i, j] = linear.turns[i, j]
                right[i, 0] -= share * linear.motion[i, j] * imposed[robot.axes[j]]
    eliminate(matrix, right, size, 1)
    for i in range(free):
        axis = robot.axes[i]
        twist[axis] = right[i, 0] if motors_held else share * imposed[axis]
    for number in range(legs):
        turns[number] = share * imposed[number] if motors_held else right[number, 0]
    squared = 0.0
    for number in range(legs):
        for row in range(block):
            leg = linear.legs[number, row]
            change = -correct * leg[0] - leg[1 + free] * turns[number]
            for j in range(free):
                change -= leg[1 + j] * twist[robot.axes[j]]
            state.wrenches[number, 2 + row if planar else row] += change
            squared += change * change
        state.motors[number] += turns[number]
        squared += turns[number] ** 2
    turned = np.empty((3, 3))
    turn(twist[:3], state.rotation, turned)
    state.rotation[:] = turned
    for i in range(3):
        state.position[i] += twist[3 + i]
    for i in range(6):
        squared += twist[i] ** 2
    return math.sqrt(squared)


@reference
def _copy(source, target):
    target.motors[:] = source.motors
    target.wrenches[:] = source.wrenches
    target.rotation[:] = source.rotation
    target.position[:] = source.position


@reference
def _duplicate(state):
    return ShootingState(
        state.motors.copy(), state.wrenches.copy(), state.rotation.copy(), state.position.copy()
    )

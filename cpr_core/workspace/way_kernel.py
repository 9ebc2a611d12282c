# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From one cell to the next along the branch, in compiled code.

The rules of `cpr_core.continuation`: every Newton correction is smaller than a quarter of the one
before, and the sign of the problem does not change. A step that fails is halved. Where none succeeds the
way ends; the fraction that was reached is where the border is.
"""

from __future__ import annotations

import math

import numpy as np

from ..compiled import allocating_part, compiled
from ..condensation_kernel import lu_factor
from ..inertia_kernel import SINGULAR_LEG, signs_of
from ..lie import roll_pitch_yaw_into, rotation_from_angles_into
from ..model_kernel import tangent_into
from ..newton_kernel import CONVERGED, newton
from .eigenvalue_kernel import count_below, eigenvalues_of_tridiagonal, tridiagonalise

__all__ = ["ARRIVED", "BLOCKED", "FLIPPED", "advance", "signs_at"]

ARRIVED = 0
BLOCKED = 1  # Newton's method does not contract, however small the step
FLIPPED = 2  # it does, but the sign of the problem changes

_LOCKED, _FREE, _INVERSE, _BRANCH = 0, 1, 2, 3


@compiled
def impose(problem, first, last, fraction, state, rotation, position):
    """Write what holds at a fraction of the straight way between two cells."""
    if problem.given_motors:
        for i in range(first.shape[0]):
            value = (1.0 - fraction) * first[i] + fraction * last[i]
            state[problem.robot.motor_index + i] = value
        return
    angles = np.empty(3)
    if problem.orientation == 3:
        roll_pitch_yaw_into(rotation, angles)
    for i in range(3):
        if problem.held[i]:
            position[i] = (1.0 - fraction) * first[i] + fraction * last[i]
        if problem.held[3 + i]:
            angles[i] = (1.0 - fraction) * first[3 + i] + fraction * last[3 + i]
    if problem.orientation == 1:
        _rotation_zyz(angles[0], angles[1], angles[2], rotation)
    elif problem.orientation == 4:
        rotation_from_angles_into(0.0, 0.0, angles[2], rotation)
    elif problem.orientation != 0:
        rotation_from_angles_into(angles[0], angles[1], angles[2], rotation)


@allocating_part
def _rotation_zyz(one, two, three, rotation):
    """``Rz(one) Ry(two) Rz(three)``."""
    ca, sa = math.cos(one), math.sin(one)
    cb, sb = math.cos(two), math.sin(two)
    cc, sc = math.cos(three), math.sin(three)
    rotation[0, 0], rotation[0, 1] = ca * cb * cc - sa * sc, -ca * cb * sc - sa * cc
    rotation[1, 0], rotation[1, 1] = sa * cb * cc + ca * sc, -sa * cb * sc + ca * cc
    rotation[2, 0], rotation[2, 1] = -sb * cc, sb * sc
    rotation[0, 2], rotation[1, 2], rotation[2, 2] = ca * sb, sa * sb, cb


@allocating_part
def signs_at(problem, tangent, rotation, scratch, work, signs):
    """Stability indices, side of the inverse singularity, and the sign that tells branches apart.

    Args:
        problem: CellProblem.
        tangent: Memory, (N, N), zero where the model has no entries.
        rotation: Platform rotation at an equilibrium.
        scratch: Memory, (N, N).
        work: Workspace with the tangent of the model there and its factors.
        signs: Result, (4,).
    """
    signs_of(problem.robot, rotation, work.factors, work, signs)
    read = tangent
    if signs[_LOCKED] == SINGULAR_LEG or not problem.conservative:
        tangent_into(problem.robot, work, tangent)
        if problem.angles:
            _copy_matrix(tangent, scratch)
            _rows_and_columns_by_angles(problem.robot, rotation, scratch)
            read = scratch
    if signs[_LOCKED] == SINGULAR_LEG:
        _dense_signs(problem, read, signs)
    if not problem.conservative:
        signs[_BRANCH] = _determinant_sign(problem, read, problem.columns, problem.rows)
    elif problem.given_motors:
        signs[_BRANCH] = signs[_LOCKED]
    else:
        signs[_BRANCH] = signs[_INVERSE]


@allocating_part
def _rows_and_columns_by_angles(robot, rotation, tangent):
    """World rotations replaced by roll, pitch and yaw, in rows and columns."""
    first, size = robot.platform_index, tangent.shape[0]
    angles = np.empty(3)
    roll_pitch_yaw_into(rotation, angles)
    cosine, sine = math.cos(angles[2]), math.sin(angles[2])
    for i in range(size):
        x, y, z = tangent[i, first], tangent[i, first + 1], tangent[i, first + 2]
        tangent[i, first] = rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z
        tangent[i, first + 1] = cosine * y - sine * x
    for j in range(size):
        x, y, z = tangent[first, j], tangent[first + 1, j], tangent[first + 2, j]
        tangent[first, j] = rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z
        tangent[first + 1, j] = cosine * y - sine * x


@allocating_part
def _copy_matrix(source, target):
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


@allocating_part
def _dense_signs(problem, tangent, signs):
    """The same from eigenvalues, where a leg cannot be eliminated on its own (a straight one)."""
    constraints = problem.multipliers.shape[0]
    signs[_LOCKED] = _negative(problem.robot, tangent, problem.robot.motor_index) - constraints
    signs[_FREE] = _negative(problem.robot, tangent, tangent.shape[0]) - constraints
    signs[_INVERSE] = 0
    if problem.inverse_columns.shape[0] > 0:
        signs[_INVERSE] = _determinant_sign(
            problem, tangent, problem.inverse_columns, problem.platform_rows
        )


@allocating_part
def _negative(robot, tangent, size):
    """Number of negative eigenvalues of a leading square."""
    square = np.empty((size, size))
    for i in range(size):
        for j in range(size):
            value = 0.5 * (tangent[i, j] + tangent[j, i])
            square[i, j] = value * robot.unit[i] * robot.unit[j] / robot.energy_unit
    diagonal, beside = np.empty(size), np.empty(size)
    tridiagonalise(square, size, diagonal, beside, np.empty(size), np.empty(size))
    ends, wanted = np.empty(2), np.empty(2, np.int64)
    wanted[0], wanted[1] = 0, size - 1
    eigenvalues_of_tridiagonal(diagonal, beside, size, wanted, ends)
    return count_below(diagonal, beside, size, -1e-11 * max(abs(ends[0]), abs(ends[1])))


@allocating_part
def _determinant_sign(problem, tangent, columns, rows):
    """Sign of the determinant of a square problem, without symmetry."""
    robot = problem.robot
    inner, size = robot.platform_index, robot.platform_index + rows.shape[0]
    square, pivots = np.empty((size, size)), np.empty(size, np.int64)
    for i in range(size):
        row = i if i < inner else rows[i - inner]
        for j in range(size):
            column = j if j < inner else columns[j - inner]
            value = tangent[row, column] * robot.unit[row] * robot.unit[column]
            square[i, j] = value / robot.energy_unit
    if not lu_factor(square, size, pivots, 0.0):
        return 0
    sign = 1
    for i in range(size):
        if (square[i, i] < 0.0) != (pivots[i] != i):
            sign = -sign
    return sign


@allocating_part
def advance(
    problem, first, last, longest, smallest, guess, state, rotation, position, signs,
    residual, tangent, scratch, work,
):  # fmt: skip
    """Go straight from one cell to another, in place.

    The whole way is tried first from a guess of its end, if there is one, and then from its start.

    Args:
        problem: CellProblem.
        first: Coordinates of the start, (C,).
        last: Coordinates of the end, (C,).
        longest: Longest step, as a fraction of the way.
        smallest: Steps below this fraction of the way are not tried.
        guess: State, rotation and position expected at the end, (N + 12,); NaN first: none.
        state: At the start, overwritten by the last point that was reached, (N,).
        rotation: The same for the platform's rotation.
        position: The same for its position.
        signs: The same for the signs, (4,).
        residual: Of the model where it was reached, (N,); undefined where the way ended short.
        tangent: Memory, (N, N), zero where the model has no entries.
        scratch: Memory, (N, N).
        work: Workspace.

    Returns:
        ARRIVED, BLOCKED or FLIPPED, the fraction reached, and the energy there [J].
    """
    trial_state, trial_rotation, trial_position = state.copy(), rotation.copy(), position.copy()
    found = signs.copy()
    effort = np.zeros(state.shape[0] - problem.robot.motor_index)
    here, step, energy = 0.0, longest, 0.0
    beyond, passed = np.inf, 0  # where a step failed from farther off, and steps since then
    guessed = longest == 1.0 and not math.isnan(guess[0])
    while here < 1.0:
        ahead = here + step
        if ahead > 1.0 - 0.5 * smallest:
            ahead = 1.0
        _begin_trial(
            guess, guessed, state, rotation, position, trial_state, trial_rotation, trial_position
        )
        impose(problem, first, last, ahead, trial_state, trial_rotation, trial_position)
        status, _, _, energy = newton(
            problem.robot, problem.loads, trial_state, trial_rotation, trial_position,
            problem.columns, problem.rows, problem.solved_by_angles, effort,
            _distance(problem, state, trial_state) if guessed else 0.0,
            problem.tolerance, problem.iterations, problem.contraction, residual, work,
            work.factors,
        )  # fmt: skip
        ok = status == CONVERGED
        for i in range(problem.lengths.shape[0]):
            ok = ok and trial_state[problem.lengths[i]] > 0.0
        flipped = False
        if ok:
            signs_at(problem, tangent, trial_rotation, scratch, work, found)
            flipped = found[_BRANCH] != signs[_BRANCH]
        if ok and not flipped:
            for i in range(state.shape[0]):
                state[i] = trial_state[i]
            for i in range(3):
                position[i] = trial_position[i]
                for j in range(3):
                    rotation[i, j] = trial_rotation[i, j]
            for i in range(4):
                signs[i] = found[i]
            here, step, passed = ahead, min(longest, 2.0 * step), passed + 1
            if here >= beyond:
                beyond = np.inf
            elif here + step >= beyond:  # at a fold it would fail again: half of that way first
                step = beyond - here
                if passed == 1 and 0.5 * step >= smallest:
                    step *= 0.5
        elif guessed:
            guessed = False
        else:
            beyond, step, passed = ahead, 0.5 * (ahead - here), 0
            if step < smallest:
                return (FLIPPED if flipped else BLOCKED), here, energy
    return ARRIVED, here, energy


@allocating_part
def _distance(problem, state, trial_state):
    """How far legs and motors have moved, dimensionless."""
    total = 0.0
    for i in range(state.shape[0]):
        change = (trial_state[i] - state[i]) / problem.robot.unit[i]
        total += change * change
    return math.sqrt(total)


@allocating_part
def _begin_trial(
    guess, guessed, state, rotation, position, trial_state, trial_rotation, trial_position
):
    """Write where Newton's method begins."""
    size = state.shape[0]
    for i in range(size):
        trial_state[i] = guess[i] if guessed else state[i]
    for i in range(3):
        trial_position[i] = guess[size + 9 + i] if guessed else position[i]
        for j in range(3):
            trial_rotation[i, j] = guess[size + 3 * i + j] if guessed else rotation[i, j]

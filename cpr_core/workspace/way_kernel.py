# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From one cell to the next along the branch, in compiled code.

The rules of `solving.continuation`: every Newton correction is smaller than a quarter of the one
before, or as small as rounding, and the sign of the problem does not change. A step that fails is
halved. Where none succeeds the way ends; the fraction that was reached is where the border is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.inertia_kernel import signs_of
from ..kernels.kernel_decorators import allocating_part, compiled
from ..kernels.kernel_records import rods_exist
from ..kernels.lu_kernel import lu_factor, lu_sign
from ..kernels.model_kernel import tangent_into
from ..kernels.newton_kernel import CONVERGED, copy_configuration, newton
from ..kernels.record_layout import INDEX_LOCKED, INVERSE_SIGN, POSITION, ROTATION
from ..kernels.rotation_matrices import roll_pitch_yaw_into, rotation_from_angles_into
from ..kernels.square_problem import Configuration
from .cell_layout import BRANCH_SIGN, SIGN_COUNT
from .orientations import Orientation

__all__ = ["ARRIVED", "BLOCKED", "FLIPPED", "Way", "advance", "impose"]

ARRIVED = 0
BLOCKED = 1  # Newton's method does not contract, however small the step
FLIPPED = 2  # it does, but the sign of the problem changes


class Way(NamedTuple):
    """A straight way from a cell."""

    start: NDArray[np.float64]  # coordinates imposed there, (C,)
    end: NDArray[np.float64]  # the same at the end, (C,)
    longest: float  # longest step, as a fraction of the way
    smallest: float  # steps below this fraction of the way are not tried
    guess: NDArray[np.float64]  # configuration expected at the end, (N + 12,); NaN first: none


@compiled
def impose(problem, first, last, fraction, configuration):
    """Write what holds at a fraction of the straight way between two cells."""
    state, rotation, position = configuration
    if problem.given_motors:
        for i in range(first.shape[0]):
            value = (1.0 - fraction) * first[i] + fraction * last[i]
            state[problem.robot.motor_index + i] = value
        return
    angles = np.empty(3)
    if problem.orientation == Orientation.SINGLE_ANGLES:
        roll_pitch_yaw_into(rotation, angles)
    for i in range(3):
        if problem.held[i]:
            position[i] = (1.0 - fraction) * first[i] + fraction * last[i]
        if problem.held[3 + i]:
            angles[i] = (1.0 - fraction) * first[3 + i] + fraction * last[3 + i]
    if problem.orientation == Orientation.ZYZ:
        _rotation_zyz(angles[0], angles[1], angles[2], rotation)
    elif problem.orientation == Orientation.PLANAR:
        rotation_from_angles_into(0.0, 0.0, angles[2], rotation)
    elif problem.orientation != Orientation.NONE:
        rotation_from_angles_into(angles[0], angles[1], angles[2], rotation)


@allocating_part
def _rotation_zyz(first, second, third, rotation):
    """``Rz(first) Ry(second) Rz(third)``."""
    ca, sa = math.cos(first), math.sin(first)
    cb, sb = math.cos(second), math.sin(second)
    cc, sc = math.cos(third), math.sin(third)
    rotation[0, 0], rotation[0, 1] = ca * cb * cc - sa * sc, -ca * cb * sc - sa * cc
    rotation[1, 0], rotation[1, 1] = sa * cb * cc + ca * sc, -sa * cb * sc + ca * cc
    rotation[2, 0], rotation[2, 1] = -sb * cc, sb * sc
    rotation[0, 2], rotation[1, 2], rotation[2, 2] = ca * sb, sa * sb, cb


@allocating_part
def _signs_at(problem, rotation, scratch, work, signs):
    """Signs of a cell at an equilibrium, see `cell_layout`."""
    signs_of(problem.robot, rotation, work, signs)
    signs[BRANCH_SIGN] = signs[INDEX_LOCKED if problem.given_motors else INVERSE_SIGN]
    if problem.given_motors and not problem.conservative:
        tangent_into(problem.robot, work, scratch)
        signs[BRANCH_SIGN] = _determinant_sign(problem.robot, problem.square, scratch)


@allocating_part
def _determinant_sign(robot, square, tangent):
    """Sign of the determinant of a square problem, without symmetry.

    It tells branches apart where energy does not.

    Args:
        robot: RobotArrays.
        square: SquareProblem.
        tangent: Tangent of the model at an equilibrium, (N, N).
    """
    inner, own = robot.platform_index, square.equations.shape[0]
    size = inner + own
    matrix, pivots = np.empty((size, size)), np.empty(size, np.int64)
    for i in range(size):
        row = i if i < inner else square.equations[i - inner]
        for j in range(size):
            column = j if j < inner else square.unknowns[j - inner]
            value = tangent[row, column] * robot.unit[row] * robot.unit[column]
            matrix[i, j] = value / robot.energy_unit
    if not lu_factor(matrix, size, pivots, 0.0):
        return 0
    return lu_sign(matrix, size, pivots)


@allocating_part
def advance(problem, way, configuration, signs, scratch, work):
    """Go straight from one cell to another, in place.

    The whole way is tried first from a guess of its end, if there is one, and then from its start.

    Args:
        problem: CellProblem.
        way: Way.
        configuration: At the start, overwritten by the last point that was reached.
        signs: The same for the signs, see `cell_layout`.
        scratch: Memory, (N, N), zero where the model has no entries.
        work: Workspace; where the end was reached on return with the residual of the model there.

    Returns:
        ARRIVED, BLOCKED or FLIPPED, the fraction reached, and the energy there [J].
    """
    state, rotation, position = configuration
    trial = Configuration(state.copy(), rotation.copy(), position.copy())
    found = signs.copy()
    longest, smallest = way.longest, way.smallest
    reached, step, energy = 0.0, longest, 0.0
    beyond, passed = np.inf, 0  # where a step failed from farther off, and steps since then
    guessed = longest == 1.0 and not math.isnan(way.guess[0])
    for i in range(work.given_efforts.shape[0]):
        work.given_efforts[i] = 0.0
    while reached < 1.0:
        ahead = reached + step
        if ahead > 1.0 - 0.5 * smallest:
            ahead = 1.0
        _begin_trial(way.guess, guessed, configuration, trial)
        impose(problem, way.start, way.end, ahead, trial)
        predicted = _distance(problem.robot.unit, state, trial.state) if guessed else 0.0
        status, _, _, energy = newton(
            problem.robot,
            problem.loads,
            trial,
            problem.square,
            work.given_efforts,
            predicted,
            problem.tolerances,
            work,
        )
        ok = status == CONVERGED and rods_exist(problem.robot, trial.state)
        flipped = False
        if ok:
            _signs_at(problem, trial.platform_rotation, scratch, work, found)
            flipped = found[BRANCH_SIGN] != signs[BRANCH_SIGN]
        if ok and not flipped:
            copy_configuration(trial, configuration)
            for i in range(SIGN_COUNT):
                signs[i] = found[i]
            reached, step, passed = ahead, min(longest, 2.0 * step), passed + 1
            if reached >= beyond:
                beyond = np.inf
            elif reached + step >= beyond:  # at a fold it would fail again: half of that way first
                step = beyond - reached
                if passed == 1 and 0.5 * step >= smallest:
                    step *= 0.5
        elif guessed:
            guessed = False
        else:
            beyond, step, passed = ahead, 0.5 * (ahead - reached), 0
            if step < smallest:
                return (FLIPPED if flipped else BLOCKED), reached, energy
    return ARRIVED, reached, energy


@allocating_part
def _distance(unit, state, trial_state):
    """How far legs and motors have moved, dimensionless."""
    total = 0.0
    for i in range(state.shape[0]):
        change = (trial_state[i] - state[i]) / unit[i]
        total += change * change
    return math.sqrt(total)


@allocating_part
def _begin_trial(guess, guessed, configuration, trial):
    """Write where Newton's method begins."""
    if not guessed:
        copy_configuration(configuration, trial)
        return
    size = trial.state.shape[0]
    for i in range(size):
        trial.state[i] = guess[i]
    for i in range(3):
        trial.platform_position[i] = guess[size + POSITION + i]
        for j in range(3):
            trial.platform_rotation[i, j] = guess[size + ROTATION + 3 * i + j]

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a flood begins, and how grids relate to equilibria."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..errors import distinct
from ..kernels.natural_units import LONGEST_STEP
from ..kernels.square_problem import Configuration
from ..lie import roll_pitch_yaw
from ..model.equilibrium import Equilibrium
from ..model.model_state import configuration_of
from ..model.robot import Robot
from ..solving.path import Path
from ..solving.targets import MotorTarget, PoseTarget, Target
from .cell_layout import BRANCH_SIGN, SIGN_COUNT
from .cell_problem import CellProblem
from .grid import Grid
from .orientations import Orientation
from .way_kernel import impose

__all__ = [
    "first_cells",
    "held_elsewhere",
    "place_of",
    "reached_cells_near",
    "signs_at_equilibrium",
    "signs_row",
    "step_fractions",
    "target_at",
    "target_of_cell",
    "without_limits",
]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Smallest steps, as fractions of the way between neighbours: below, numbers of the way are rounded.
_SMALLEST_STEP = (1e-12, 1e-2)
#: Nearer to a fold than 1.5 steps they do not contract; the last that fails is below two smallest ones.
_STEPS_BEFORE_FOLD = 3.0
#: Distance between where a coordinate is held and where it is that is worth a word [natural units].
_ELSEWHERE = 0.01
#: Cells per axis that are tried as the first one, beside the nearest.
_TRIED_ALONG = 5


def without_limits(robot: Robot) -> Robot:
    """The same robot, with motors and rods that bear everything: maps show what is beyond limits too."""
    return robot.with_description(replace(robot.description.without_limits(), written=None))


def step_fractions(robot: Robot, grid: Grid, tolerance: float) -> tuple[Floats, Floats]:
    """Longest and smallest step along every axis, as fractions of the way between neighbours, (D,)."""
    natural = _natural_units(robot, grid)
    largest = np.array([np.diff(values).max() for values in grid.values])
    moved = np.abs(grid.directions / natural).max(axis=1) * largest
    longest = np.minimum(1.0, LONGEST_STEP / moved)
    step = tolerance / _STEPS_BEFORE_FOLD if tolerance else 1e-3 * grid.steps
    smallest = np.clip(step / largest, *_SMALLEST_STEP)
    return longest, np.minimum(smallest, 0.25 * longest)


def place_of(equilibrium: Equilibrium, grid: Grid) -> Floats:
    """Numbers along the axes of the place in the grid nearest to an equilibrium, (D,)."""
    way = _coordinates_of(equilibrium, grid) - grid.origin
    return np.asarray(np.linalg.lstsq(grid.directions.T, way, rcond=None)[0])


def held_elsewhere(start: Equilibrium, grid: Grid) -> str:
    """Which coordinates a grid holds elsewhere than the start is, in words; empty: none.

    Whoever does not name a coordinate may not know that it is held at 0.
    """
    at, natural, held = _coordinates_of(start, grid), _natural_units(start.robot, grid), grid.origin
    gaps = at - held
    if grid.given == "pose":
        angles = np.array([unit == "rad" for unit in grid.units])
        gaps[angles] -= math.tau * np.round(gaps[angles] / math.tau)
    unmoved = ~grid.directions.any(axis=0) & (np.abs(gaps) > _ELSEWHERE * natural)
    upright = math.hypot(*start.platform_rotation[:2, 2]) < _ELSEWHERE
    told = []
    for number in np.flatnonzero(unmoved).tolist():
        name, unit = grid.names[number], grid.units[number]
        if upright and name in ("phi", "psi"):
            continue  # turned about z by both together, and each may be anything
        held_at, starts_at = distinct(held[number], at[number])
        unnamed = " as what is not named is" if grid.given == "pose" and not held[number] else ""
        told.append(f"{name}, held at {held_at}{unnamed}, is {starts_at} {unit} at the start")
    return "; ".join(told)


def _coordinates_of(equilibrium: Equilibrium, grid: Grid) -> Floats:
    """What a grid imposes as it is at an equilibrium, (C,)."""
    if grid.given == "motors":
        return equilibrium.motors[grid.index]
    turn = equilibrium.platform_rotation
    angles = roll_pitch_yaw(turn)
    if grid.orientation == Orientation.ZYZ.key:
        angles = np.array(
            [
                math.atan2(turn[1, 2], turn[0, 2]),
                math.acos(min(1.0, max(-1.0, turn[2, 2]))),
                math.atan2(turn[2, 1], -turn[2, 0]),
            ]
        )
    return np.concatenate([equilibrium.platform_position, angles])[grid.index]


def _natural_units(robot: Robot, grid: Grid) -> Floats:
    """Natural units of what a grid imposes, (C,)."""
    if grid.given == "motors":
        return robot.motor_units
    return np.array([robot.mean_length if unit == "m" else 1.0 for unit in grid.units])


def first_cells(grid: Grid, place: Floats) -> list[int]:
    """Cells to begin with, the nearest first, then a few all over the grid by their distance."""
    coarse = [
        values[np.unique(np.linspace(0, len(values) - 1, _TRIED_ALONG + 2)[1:-1].astype(int))]
        for values in grid.values
    ]
    places = np.stack(np.meshgrid(*coarse, indexing="ij"), axis=-1).reshape(-1, len(coarse))
    near = np.abs((places - place) / grid.steps).max(axis=1)
    others = [grid.nearest(nearby) for nearby in places[np.argsort(near, kind="stable")]]
    nearest = grid.nearest(place)
    return [nearest, *(cell for cell in others if cell != nearest)]


def reached_cells_near(grid: Grid, place: Floats, reached: NDArray[np.bool_]) -> list[int]:
    """Reached cells to find a map again from: the nearest first, then those of ``first_cells``.

    Args:
        grid: The grid.
        place: Numbers along the axes, (D,).
        reached: Cells that were reached, at least one, (M,).
    """
    cells = np.flatnonzero(reached)
    distances = np.abs((grid.places(cells) - place) / grid.steps).max(axis=1)
    nearest = int(cells[np.argmin(distances)])
    others = (cell for cell in first_cells(grid, place) if reached[cell])
    return list(dict.fromkeys([nearest, *others]))


def target_of_cell(grid: Grid, problem: CellProblem, cell: int, start: Equilibrium) -> Target:
    """A cell as the target of a walk from an equilibrium."""
    return target_at(problem, grid.kernel_coordinates(grid.places(np.array([cell])))[0], start)


def target_at(problem: CellProblem, values: Floats, start: Equilibrium) -> Target:
    """What the kernels' coordinates of a place impose, (C,), as the target of a walk."""
    if problem.given_motors:
        return MotorTarget(values)
    imposed = Configuration(*(part.copy() for part in configuration_of(start)))
    impose(problem, values, values, 1.0, imposed)
    return PoseTarget(imposed.platform_rotation, imposed.platform_position)


def signs_at_equilibrium(problem: CellProblem, found: Equilibrium) -> Integers:
    """Signs as the kernels have them; between poses of redundant motors no sign tells branches apart."""
    if problem.given_motors and not problem.conservative:
        branch = Path(found, MotorTarget(found.motors), found.loads).begin().sign
    else:
        signs = found.signs
        branch = signs.index_locked if problem.given_motors else signs.inverse_sign
    return signs_row(found, branch)


def signs_row(found: Equilibrium, branch: int) -> Integers:
    """The signs of an equilibrium and the one that tells branches apart, as cells have them."""
    row = np.empty(SIGN_COUNT, np.int64)
    row[:BRANCH_SIGN], row[BRANCH_SIGN] = found.signs, branch
    return row

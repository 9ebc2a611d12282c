# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Goals, feedback and results of ``~/map_workspace`` as messages."""

from __future__ import annotations

import math
from pathlib import Path

from cpr_msgs.action import MapWorkspace
from cpr_msgs.msg import ErrorCode, MapBorder

from cpr_core import Equilibrium, InvalidRequest, NonFiniteInput, Robot
from cpr_core.solving.objectives import objective_of
from cpr_core.workspace import Grid, MapSummary, motor_grid, pose_grid
from cpr_core.workspace.map_files import check_replaceable, check_writable

from ..operation.solver import Solver
from .map_folder import MapFolder
from .map_order import MapOrder, MapState

__all__ = ["map_feedback", "map_order", "map_result"]

#: No robot has more coordinates of the platform, and no coordinate or motor has a longer name.
_POSE_COORDINATES, _LONGEST_NAME = 6, 1000
#: More cells along one axis are no map, but take long to number.
_MOST_ALONG = 1_000_000


def map_order(solver: Solver, goal: MapWorkspace.Goal, folder: MapFolder) -> MapOrder:
    """What a goal orders.

    Raises:
        CprError: It cannot be made.
    """
    grid = _grid(solver.robot, goal)
    for name in ("tolerance", "threshold"):
        value = getattr(goal, name)
        if not math.isfinite(value):
            raise NonFiniteInput(name, f"expected a finite number, got {value}")
        if value < 0.0:
            raise InvalidRequest(name, f"expected a positive number or 0, got {value}")
    file = _file(solver.robot, grid, goal, folder)
    start, loads = solver.start_and_loads(goal)
    return MapOrder(
        start=start,
        loads=loads,
        grid=grid,
        tolerance=goal.tolerance,
        threshold=goal.threshold,
        workers=goal.workers,
        file=file,
        resume=goal.existing_file == MapWorkspace.Goal.RESUME,
        objective=_objective(start, grid, goal),
    )


def _objective(start: Equilibrium, grid: Grid, goal: MapWorkspace.Goal) -> str | None:
    """What is least in every cell, checked before a process is started for it."""
    objective_of(start, grid.given, goal.objective or None)
    return goal.objective or None


def _grid(robot: Robot, goal: MapWorkspace.Goal) -> Grid:
    if goal.given not in (MapWorkspace.Goal.GIVEN_POSE, MapWorkspace.Goal.GIVEN_MOTORS):
        raise InvalidRequest("given", f"expected GIVEN_POSE 0 or GIVEN_MOTORS 1, got {goal.given}")
    if len(goal.held) != len(goal.held_values):
        raise InvalidRequest(
            "held_values", f"expected {len(goal.held)} numbers, got {len(goal.held_values)}"
        )
    names = [axis.name for axis in goal.axes] + list(goal.held)
    # Before anything that takes the longer the more there is: the node stands still meanwhile.
    most = max(_POSE_COORDINATES, robot.motor_count)
    longest = max(map(len, [*names, goal.objective]))
    if len(names) > most or longest > _LONGEST_NAME:
        raise InvalidRequest(
            "axes",
            f"expected at most {most} axes and held coordinates, with names of at most "
            f"{_LONGEST_NAME} letters",
        )
    for name in names:
        if names.count(name) > 1:
            raise InvalidRequest("axes", f"{name} is given twice")
    for axis in goal.axes:
        finite = math.isfinite(axis.first) and math.isfinite(axis.last)
        many = axis.last - axis.first > _MOST_ALONG * axis.resolution > 0.0
        if finite and many:
            raise InvalidRequest(
                "axes", f"{axis.name}: expected at most {_MOST_ALONG:,} cells along an axis"
            )
    make = motor_grid if goal.given == MapWorkspace.Goal.GIVEN_MOTORS else pose_grid
    return make(
        robot,
        {axis.name: (axis.first, axis.last) for axis in goal.axes},
        dict(zip(goal.held, goal.held_values, strict=True)),
        resolution={axis.name: axis.resolution for axis in goal.axes},
    )


def _file(robot: Robot, grid: Grid, goal: MapWorkspace.Goal, folder: MapFolder) -> Path:
    """Where the map goes; nothing is written over that nobody meant."""
    file = folder.file(goal.file)
    check_writable(file, robot, grid)
    if goal.existing_file not in (
        MapWorkspace.Goal.REFUSE,
        MapWorkspace.Goal.RESUME,
        MapWorkspace.Goal.REPLACE,
    ):
        raise InvalidRequest(
            "existing_file", f"expected REFUSE 0, RESUME 1 or REPLACE 2, got {goal.existing_file}"
        )
    if not file.exists() or goal.existing_file == MapWorkspace.Goal.RESUME:
        return file
    if goal.existing_file == MapWorkspace.Goal.REFUSE:
        raise InvalidRequest(
            "file", f"{file} exists: set existing_file to RESUME or REPLACE, or name another file"
        )
    check_replaceable(file)
    return file


def map_feedback(state: MapState) -> MapWorkspace.Feedback:
    """How far a map is."""
    return MapWorkspace.Feedback(
        done=state.done, reached=state.reached, total=state.total, rate=state.rate
    )


def map_result(code: ErrorCode, file: str, summary: MapSummary | None) -> MapWorkspace.Result:
    """What a map came to.

    Args:
        code: Whether it is complete, and why not.
        file: Where it is; empty if there is no file.
        summary: The map in a few numbers, if it is known.
    """
    result = MapWorkspace.Result(error_code=code, file=file)
    if summary is None:
        return result
    result.complete = summary.complete
    result.shape = list(summary.shape)
    for name in (
        "cells",
        "reached",
        "stable",
        "usable",
        "beyond_limits",
        "below_threshold",
        "disagreements",
        "cell_area",
    ):
        setattr(result, name, getattr(summary, name))
    result.borders = [
        MapBorder(
            kind=border.kind,
            points=border.points,
            lower=list(border.lower),
            upper=list(border.upper),
        )
        for border in summary.borders
    ]
    return result

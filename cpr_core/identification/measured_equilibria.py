# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The equilibria at which measurements were made: found once, then followed as the robot changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..description.inherited_loads import inherited_loads
from ..description.loads import Loads
from ..description.other_units import in_other_units
from ..errors import CprError, InvalidRequest
from ..kernels.problems import ProblemName
from ..kernels.square_problem import Tolerances
from ..model.equilibrium import Equilibrium
from ..model.equilibrium_steps import corrected
from ..model.robot import Robot
from ..model.world_response import effort_units
from ..solving.continued import continued
from ..solving.geometrico_statics import checked_start
from ..solving.near_request import solve_near
from ..solving.not_reached import MotorLimitExceeded, NotReached
from ..solving.solve_from import solve_from
from ..solving.targets import MotorTarget
from .compared import measured_numbers, predicted_numbers
from .compared_layout import POSE, joined
from .effort_doubts import BETTER
from .limit_doubts import BEYOND
from .measurement_doubts import unit_doubt
from .measurements import DrivenBy, Measurement, driven_by
from .tried_robot import free_robot

__all__ = ["first_equilibria", "followed"]

Floats = NDArray[np.float64]

#: Rows without an equilibrium that an error names one by one.
_NAMED = 5


def first_equilibria(
    robot: Robot,
    rows: Sequence[Measurement],
    start: Equilibrium | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Equilibrium]:
    """The equilibrium of every row, on the branch of a start; each from it or the nearest one known.

    They are those of the ``free_robot``: what was measured has happened, whatever limits say. Only
    motors that are measured far beyond their range are another robot's, or in another unit.

    Args:
        robot: The robot as it is described.
        rows: Checked measurements.
        start: Equilibrium whose branch is followed; default home.
        progress: Called with the fraction of rows that are done.

    Raises:
        InvalidRequest: A start of another robot; rows that have no equilibrium on the branch, named; a
            row without one that looks like other units, or those that fit in other units.
    """
    home = replace(checked_start(robot, start), robot=free_robot(robot))
    known, found = [home], []
    failures: list[tuple[Measurement, str]] = []
    for number, row in enumerate(rows):
        try:
            _check_range(robot, row)
            found.append(_solved(known, row))
            known.append(found[-1])
        except CprError as error:
            doubt = unit_doubt(robot, row)
            if doubt:
                raise InvalidRequest(row.label, doubt) from error
            failures.append((row, f"{row.label}: {error}"))
        if progress is not None:
            progress((number + 1) / len(rows))
    if failures:
        more = f"; and {len(failures) - _NAMED} more" if len(failures) > _NAMED else ""
        named, told = zip(*failures[:_NAMED], strict=True)
        text = "; ".join([*_other_units(home, named), *told])
        counted = (
            f"{len(failures)} of {len(rows)} rows have no equilibrium near the described robot"
        )
        raise InvalidRequest("measurements", f"{counted}: {text}{more}")
    return found


def _check_range(robot: Robot, row: Measurement) -> None:
    """Whether motors are measured where they can be, or next to it.

    Raises:
        MotorLimitExceeded: One is not.
    """
    values = row.motors if row.motors is not None else np.full(robot.motor_count, np.nan)
    motors = zip(robot.description.motors, values.tolist(), robot.motor_units, strict=True)
    for motor, value, unit in motors:
        lower, upper = motor.limits.lower, motor.limits.upper
        if max(lower - value, value - upper) > BEYOND * unit:
            raise MotorLimitExceeded(motor.name, "position", value, (lower, upper), motor.unit)


def _other_units(home: Equilibrium, rows: Sequence[Measurement]) -> list[str]:
    """As which other unit motors of rows that have no equilibrium tell what was measured, in words."""
    driven = [
        row.motors for row in rows if row.motors is not None and np.isfinite(row.motors).all()
    ]
    if len(driven) < len(rows):
        return []
    blind = [replace(row, motors=None) for row in rows]
    before = sum(_contradiction(row, home) for row in blind)
    readings = zip(
        *(in_other_units(home.robot.description, motors) for motors in driven), strict=True
    )
    for reading in readings:
        try:
            meant = [
                _solved([home], replace(row, motors=motors))
                for row, (motors, _) in zip(rows, reading, strict=True)
            ]
        except CprError:
            continue
        if sum(map(_contradiction, blind, meant)) < BETTER**2 * before:
            return [reading[0][1]]
    return []


def _solved(known: Sequence[Equilibrium], row: Measurement) -> Equilibrium:
    """The equilibrium of a row, from the nearest of some or from the first one.

    Both ways may end, each at another stable equilibrium: then that is meant which was measured.

    Raises:
        CprError: There is none.
    """
    robot = known[0].robot
    drive = driven_by(robot, row)
    loads = robot.default_loads if row.loads is None else row.loads
    nearest = min(known, key=lambda other: _distance(other, drive))
    found: list[Equilibrium] = []
    for begin in [nearest] if nearest is known[0] else [nearest, known[0]]:
        try:
            found.append(_reached(begin, drive, loads))
        except NotReached:
            if begin is known[0] and not found:
                raise
    return found[0] if len(found) == 1 else min(found, key=lambda each: _contradiction(row, each))


def _reached(start: Equilibrium, drive: DrivenBy, loads: Loads) -> Equilibrium:
    """The equilibrium of a row from a start.

    Raises:
        CprError: The way does not lead there.
    """
    if drive.problem == "motors" and (found := _beside(start, drive.values, loads)) is not None:
        return found
    return solve_from(start, drive.problem, drive.values, loads=loads)


def _contradiction(row: Measurement, equilibrium: Equilibrium) -> float:
    """How far a row is from an equilibrium, in natural units, squared.

    Where a tracker is may have to be found yet: poses in its frame do not count.
    """
    robot = equilibrium.robot
    apart = predicted_numbers(row, equilibrium) - measured_numbers(robot, row)
    if row.frame == "tracker":
        apart[POSE] = np.nan
    lengths = {"position": np.full(3, robot.mean_length), "rotation": np.ones(3)}
    units = joined(robot, lengths | {"motors": robot.motor_units, "efforts": effort_units(robot)})
    return float(np.nansum((apart / units) ** 2))


def _distance(equilibrium: Equilibrium, drive: DrivenBy) -> float:
    """How far an equilibrium is from what drives another one, in what that is measured in."""
    own: Floats = getattr(equilibrium, drive.problem)
    return float(np.linalg.norm(own - drive.values))


def _beside(start: Equilibrium, motors: Floats, loads: Loads) -> Equilibrium | None:
    """The equilibrium of a row in two single steps, of motors and of loads; None: a walk has to tell."""
    robot = start.robot
    if not robot.has_potential(start.loads) or not robot.has_potential(loads):
        return None
    moved = solve_near(start, MotorTarget(motors), stable_only=False)
    if moved is None or moved.loads is loads:
        return moved
    return _under(moved, robot, loads)


def _under(before: Equilibrium, robot: Robot, loads: Loads) -> Equilibrium | None:
    """The equilibrium at the same motors in one step; None where something may happen on it."""
    found = corrected(robot, loads, robot.load_arrays(loads), before.record, Tolerances())
    return found if found.converged and found.index_locked == before.index_locked else None


def followed(
    before: Sequence[Equilibrium], robot: Robot, problems: Sequence[ProblemName]
) -> list[Equilibrium]:
    """The same equilibria of a robot with other parameters, on their branches.

    Args:
        before: Equilibria of the robot as it was.
        robot: The robot as it is.
        problems: What every one of them is driven by.

    Raises:
        NotReached: A branch ends between the two, or the robots are too far from each other.
    """
    own: dict[int, Loads] = {}  # one for all rows that share them: what is found for loads is kept
    for equilibrium in before:
        loads, first = equilibrium.loads, equilibrium.robot
        if id(loads) not in own:
            own[id(loads)] = inherited_loads(loads, first.default_loads, robot.default_loads)
    return [
        _followed(equilibrium, robot, problem, own[id(equilibrium.loads)])
        for equilibrium, problem in zip(before, problems, strict=True)
    ]


def _followed(before: Equilibrium, robot: Robot, problem: ProblemName, loads: Loads) -> Equilibrium:
    """One of them, with the motors held in one step: whoever tries robots tries one that is nearer."""
    if before.robot is robot:
        return before
    if problem == "motors" and robot.has_potential(loads):
        found = _under(before, robot, loads)
        if found is None:
            raise NotReached("no equilibrium is near the one of another robot", 0.0, before)
        return found
    return continued(before, robot, problem)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The equilibria at which measurements were made: found once, then followed as the robot changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..description.inherited_loads import inherited_loads
from ..errors import CprError, InvalidRequest
from ..kernels.square_problem import Tolerances
from ..lie import roll_pitch_yaw
from ..model.equilibrium import Equilibrium, corrected
from ..model.robot import Robot
from ..solving.continued import continued
from ..solving.geometrico_statics import solve_forward, solve_forward_by_effort, solve_inverse
from ..solving.home import solve_home
from ..solving.limits import check_limits
from ..solving.not_reached import NotReached
from ..solving.requests import pose_meaning
from ..solving.targets import ProblemName
from .measurements import Measurement, driven_by

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
    """The equilibrium of every row, on the branch of a start; each from the nearest one known.

    Args:
        robot: The robot as it is described.
        rows: Checked measurements.
        start: Equilibrium whose branch is followed; default home.
        progress: Called with the fraction of rows that are done.

    Raises:
        InvalidRequest: Rows have no equilibrium on the branch; names them.
    """
    home = solve_home(robot) if start is None else start
    known, found = [home], []
    failures: list[str] = []
    for number, row in enumerate(rows):
        try:
            found.append(_solved(known, row))
            known.append(found[-1])
        except CprError as error:
            failures.append(f"{row.label}: {error}")
        if progress is not None:
            progress((number + 1) / len(rows))
    if failures:
        more = f"; and {len(failures) - _NAMED} more" if len(failures) > _NAMED else ""
        text = "; ".join(failures[:_NAMED])
        counted = f"{len(failures)} of {len(rows)} rows have no equilibrium near the described robot"
        raise InvalidRequest("measurements", f"{counted}: {text}{more}")
    return found


def _solved(known: Sequence[Equilibrium], row: Measurement) -> Equilibrium:
    """The equilibrium of a row, from the nearest of some; from the first one where that fails.

    Raises:
        CprError: There is none.
    """
    robot = known[0].robot
    problem = driven_by(robot, row)
    loads = robot.default_loads if row.loads is None else row.loads
    if problem == "motors":
        solve, given = solve_forward, row.motors
        ways = [np.abs(row.motors - other.motors).max() for other in known]
    elif problem == "efforts":
        solve, given = solve_forward_by_effort, row.efforts
        ways = [np.abs(row.efforts - other.efforts).max() for other in known]
    else:
        solve, given = solve_inverse, _pose(robot, row)
        size = 3 if row.position is not None else 0
        ways = [np.linalg.norm(given[:size] - other.pose[:size]) for other in known]
    nearest = known[int(np.argmin(ways))]
    try:
        return solve(robot, given, start=nearest, loads=loads)
    except NotReached:
        if nearest is known[0]:
            raise
        return solve(robot, given, start=known[0], loads=loads)


def _pose(robot: Robot, row: Measurement) -> Floats:
    """The controlled coordinates of a row, as the inverse problem takes them."""
    values: dict[str, float] = {}
    if row.position is not None:
        values |= dict(zip("xyz", row.position, strict=True))
    if row.rotation is not None and row.quaternion_wxyz is not None:
        rotation = row.rotation
        values |= dict(zip(("qw", "qx", "qy", "qz"), row.quaternion_wxyz, strict=True))
        values |= dict(zip(("roll", "pitch", "yaw"), roll_pitch_yaw(rotation), strict=True))
        values["angle"] = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
    return np.array([values[name] for name in pose_meaning(robot)])


def followed(
    before: Sequence[Equilibrium], robot: Robot, problems: Sequence[ProblemName]
) -> list[Equilibrium]:
    """The same equilibria of a robot with other parameters, on their branches.

    Args:
        before: Equilibria of the robot as it was.
        robot: The robot as it is.
        problems: What every one of them is driven by.

    Raises:
        NotReached: A branch ends between the two.
    """
    return [
        _followed(equilibrium, robot, problem)
        for equilibrium, problem in zip(before, problems, strict=True)
    ]


def _followed(before: Equilibrium, robot: Robot, problem: ProblemName) -> Equilibrium:
    """One of them: in one step where nothing happens on it, else as `continued` goes."""
    if before.robot is robot:
        return before
    if problem == "motors":
        own = inherited_loads(before.loads, before.robot.default_loads, robot.default_loads)
        found = corrected(robot, own, robot.load_arrays(own), before.record, Tolerances())
        if found.converged and found.signs == before.signs:
            check_limits(found)
            return found
    return continued(before, robot, problem)

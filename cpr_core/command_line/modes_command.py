# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Command ``cpr modes``: how exact numbers of modes are, also those written, and which are enough."""

from __future__ import annotations

import argparse
import math
from typing import Any

from ..description.loads import Loads
from ..errors import CprError
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..solving.chosen_modes import (
    ComparedModes,
    choose_modes,
    compared_modes,
    exactness_of,
    with_many_modes,
)
from ..solving.not_reached import NotReached
from .answer import Answer
from .argument_types import length
from .reports import as_json

__all__ = ["add_modes_options"]

#: Numbers of modes in every direction that are compared.
_COMPARED = (2, 3, 4, 5, 6, 8, 10)
_TOLERANCE = 1e-5
#: What others are compared with is for a tolerance of this at most [m].
_TRUTH = 1e-9


def add_modes_options(parser: argparse.ArgumentParser) -> None:
    """Options of ``cpr modes``."""
    parser.set_defaults(run=_modes, modes=None, gravity=None, wrench=None)
    parser.add_argument("robot", metavar="ROBOT", help="name of a shipped robot, or YAML file")
    parser.add_argument(
        "--tolerance",
        type=length,
        metavar="T",
        help=f"largest error of the platform position, m; else the description's, or {_TOLERANCE:g}",
    )
    parser.add_argument("--json", action="store_true", help="print JSON; else text")


def _modes(robot: Robot, loads: Loads | None, options: argparse.Namespace) -> Answer:
    """Compare numbers of modes, and choose the fewest."""
    tolerance = options.tolerance
    if tolerance is None:
        asked = robot.description.tolerance
        tolerance = asked if math.isfinite(asked) else _TOLERANCE
    chosen = choose_modes(robot, tolerance)
    exact = _nearly_exact(robot, tolerance)
    own = exactness_of(exact)
    uniform = {str(modes): chosen.description.with_modes(modes) for modes in _COMPARED}
    robots = {name: robot.with_description(described) for name, described in uniform.items()}
    if not math.isfinite(robot.description.tolerance):
        robots |= {"written": robot}
    rows: list[tuple[str, ComparedModes | None]] = []
    for name, tried in (robots | {"chosen": chosen}).items():
        try:
            rows.append((name, compared_modes(tried, exact)))
        except NotReached:
            rows.append((name, None))
    if options.json:
        return Answer(as_json(_as_dict(chosen, tolerance, own, rows)), True)
    return Answer(_as_text(chosen, tolerance, own, rows), True)


def _nearly_exact(robot: Robot, tolerance: float) -> tuple[Equilibrium, ...]:
    """What all are compared with: as exact as can be, and as the tolerance wants at least."""
    try:
        return with_many_modes(robot, min(tolerance, _TRUTH))
    except CprError:
        return with_many_modes(robot, tolerance)


def _as_dict(
    chosen: Robot, tolerance: float, own: float, rows: list[tuple[str, ComparedModes | None]]
) -> dict[str, Any]:
    compared = [
        {
            "modes": name,
            "strain_coordinates": None if row is None else _coordinates(row.robot),
            "estimated_error": None if row is None else row.estimated,
            "difference": None if row is None else row.true,
            "solve_time": None if row is None else row.solve_time,
        }
        for name, row in rows
    ]
    return {
        "robot": chosen.description.name,
        "tolerance": tolerance,
        "reference_error": own,
        "compared": compared,
        "chosen": {
            name: list(rod.modes.counts)
            for name, rod in zip(chosen.rod_names, chosen.description.rods, strict=True)
        },
    }


def _as_text(
    chosen: Robot, tolerance: float, own: float, rows: list[tuple[str, ComparedModes | None]]
) -> str:
    lines = [
        f"{chosen.description.name} near home, tolerance {tolerance:g} m",
        f"difference: from many modes, which themselves are exact to {own:.0e} m or so",
        "",
        "   modes  coordinates  estimated error [m]  difference [m]  solve [us]",
    ]
    for name, row in rows:
        if row is None:
            lines.append(f"{name:>8}  no equilibrium at all motors compared")
            continue
        lines.append(
            f"{name:>8}  {_coordinates(row.robot):>11}  {row.estimated:>19.1e}  {row.true:>14.1e}  "
            f"{1e6 * row.solve_time:>10.0f}"
        )
    lines += ["", "chosen: torsion, bending_2, bending_3"]
    lines += [
        f"{name:>8}  {rod.modes.counts[0]} {rod.modes.counts[1]} {rod.modes.counts[2]}"
        for name, rod in zip(chosen.rod_names, chosen.description.rods, strict=True)
    ]
    return "\n".join(lines)


def _coordinates(robot: Robot) -> int:
    """Number of strain coordinates of all rods."""
    return sum(rod.modes.total for rod in robot.description.rods)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measurements in CSV files: a header with names of columns, a row for every equilibrium.

docs/calibration.md has the columns. SI units; an empty cell was not measured.
"""

from __future__ import annotations

import csv
import difflib
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..description.loads import WRENCH_NAMES, Loads
from ..errors import InvalidRequest
from ..lie import quaternion_from_rotation
from ..model.equilibrium import Equilibrium, check_equilibrium
from ..model.robot import Robot
from .measurements import Measurement, StandardDeviations, driven_by

__all__ = ["read_measurements", "write_poses"]

_POSITION = ("x", "y", "z")
_QUATERNION = ("qw", "qx", "qy", "qz")
#: Before their names where they are those of the marker in the tracker's frame.
_TRACKER = "tracker:"
#: Mistakes that an error names one by one.
_NAMED = 8


def read_measurements(
    robot: Robot, file: str | Path, loads: Loads | None = None
) -> tuple[Measurement, ...]:
    """Measurements of a robot from a CSV file.

    Args:
        robot: The robot; its motors name columns.
        file: The file.
        loads: Loads in force where a row has no wrench of its own; default those of the description.

    Raises:
        InvalidRequest: A file that cannot be read, columns that are not known or there twice, or rows
            that are no measurements; names lines and columns.
    """
    place = Path(file)
    try:
        with place.open(newline="", encoding="utf-8-sig") as opened:
            lines = _lines(place, opened.read().splitlines())
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidRequest("measurements", f"{place}: cannot be read: {error}") from None
    if len(lines) < 2:
        raise InvalidRequest("measurements", f"{place}: expected a header and at least one row")
    header = [name.strip() for name in lines[0][1]]
    _check_header(robot, place, header)
    found, problems = [], []
    for number, cells in lines[1:]:
        try:
            found.append(_measurement(robot, header, number, cells, loads))
        except InvalidRequest as error:
            problems.append(str(error))
    if problems:
        more = f"; and {len(problems) - _NAMED} more" if len(problems) > _NAMED else ""
        raise InvalidRequest("measurements", f"{place}: {'; '.join(problems[:_NAMED])}{more}")
    return tuple(found)


def _lines(place: Path, texts: Sequence[str]) -> list[tuple[int, list[str]]]:
    """Lines that are neither empty nor comments, with their numbers.

    Raises:
        InvalidRequest: One has no cells that can be read, such as one without an end.
    """
    found = []
    for number, text in enumerate(texts, start=1):
        if text.strip().strip(",") and not text.lstrip().startswith("#"):
            try:
                found.append((number, next(csv.reader([text]))))
            except csv.Error as error:
                problem = f"{place}: line {number}: cannot be read: {error}"
                raise InvalidRequest("measurements", problem) from None
    return found


def _motors(robot: Robot) -> tuple[str, ...]:
    """Columns of the motors: their names, unless something else is called so."""
    others = (*_POSITION, *_QUATERNION, *_of_tracker(robot), *WRENCH_NAMES)
    return tuple(f"motor:{name}" if name in others else name for name in robot.motor_names)


def _columns(robot: Robot) -> tuple[str, ...]:
    """Names that columns can have."""
    efforts = tuple(f"effort:{name}" for name in robot.motor_names)
    return (*_motors(robot), *_POSITION, *_QUATERNION, *_of_tracker(robot), *efforts, *WRENCH_NAMES)


def _of_tracker(robot: Robot) -> tuple[str, ...]:
    """Columns of what the tracker tells; none of a robot that has none."""
    if robot.description.tracker is None:
        return ()
    return tuple(f"{_TRACKER}{name}" for name in (*_POSITION, *_QUATERNION))


def _check_header(robot: Robot, place: Path, header: Sequence[str]) -> None:
    """Whether all columns are known.

    Raises:
        InvalidRequest: One is not, or is there twice.
    """
    known = _columns(robot)
    if len(header) == 1 and (between := re.search(r"[;\t]", header[0])):
        problem = f"expected commas between cells, and decimal points, got {between[0]!r}"
        raise InvalidRequest("measurements", f"{place}: line 1: {problem}")
    for name in header:
        if name not in known:
            nearest = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
            meant = f", did you mean {nearest[0]}?" if nearest else ""
            if not name.strip():
                meant = " (of row numbers? pandas leaves them out with index=False)"
            raise InvalidRequest(
                "measurements",
                f"{place}: line 1: no column is called {name!r:.60}{meant}; "
                f"expected some of {', '.join(known)}",
            )
        if list(header).count(name) > 1:
            raise InvalidRequest("measurements", f"{place}: line 1: column {name} is there twice")
    tracked = [name for name in header if name in _of_tracker(robot)]
    others = [name for name in header if name in (*_POSITION, *_QUATERNION)]
    if tracked and others:
        problem = f"{place}: line 1: expected poses in one frame, got {tracked[0]} and {others[0]}"
        raise InvalidRequest("measurements", problem)


def _measurement(
    robot: Robot, header: Sequence[str], number: int, cells: Sequence[str], loads: Loads | None
) -> Measurement:
    """A row.

    Raises:
        InvalidRequest: It is none; names line and column.
    """
    line = f"line {number}"
    if len(cells) != len(header):
        raise InvalidRequest(line, f"expected {len(header)} cells, got {len(cells)}")
    values: dict[str, float] = {}
    for name, cell in zip(header, cells, strict=True):
        text = cell.strip()
        if not text:
            continue
        try:
            # Underscores, which Python takes between digits, are slips here.
            value = float(text.replace("_", "no digit"))
        except ValueError:
            expected = "expected a number, or nothing where nothing was measured"
            raise InvalidRequest(
                f"{line}, column {name}", f"{expected}, got {text!r:.60}"
            ) from None
        if not math.isfinite(value):
            raise InvalidRequest(f"{line}, column {name}", f"expected a finite number, got {text}")
        values[name] = value

    def some(names: Sequence[str]) -> list[float | None] | None:
        each = [values.get(name) for name in names]
        return each if any(value is not None for value in each) else None

    wrench = some(WRENCH_NAMES)
    if wrench is not None:
        base = robot.default_loads if loads is None else loads
        loads = base.with_(wrench_world=[value or 0.0 for value in wrench])
    tracked = any(name in _of_tracker(robot) for name in header)
    frame = _TRACKER if tracked else ""
    row = Measurement(
        motors=some(_motors(robot)),  # type: ignore[arg-type]
        position=some([f"{frame}{name}" for name in _POSITION]),  # type: ignore[arg-type]
        quaternion_wxyz=some([f"{frame}{name}" for name in _QUATERNION]),  # type: ignore[arg-type]
        efforts=some([f"effort:{name}" for name in robot.motor_names]),  # type: ignore[arg-type]
        loads=loads,
        label=line,
        frame="tracker" if tracked else "world",
    )
    driven_by(robot, row)
    return row


def write_poses(
    file: str | Path,
    equilibria: Sequence[Equilibrium],
    deviations: StandardDeviations | None = None,
    *,
    loads: Loads | None = None,
    home_first: Sequence[bool] = (),
) -> None:
    """Write motors, wrench and expected poses: to be measured, and replaced by what is.

    Of a robot with a tracker they are those that the tracker is expected to tell. Of loads a file has
    ``wrench_world`` only: others are those that ``read_measurements`` is told.

    Args:
        file: CSV file to write, in the format ``read_measurements`` takes.
        equilibria: What to go to, of one robot.
        deviations: Of what will be measured: poses without one are left out; default all are written.
        loads: What acts beside their wrenches; default what the description names.
        home_first: Before which the robot has to go home, as of ``ProposedPoses``: a line that begins
            with ``#`` says so above them; default none.

    Raises:
        InvalidRequest: No equilibria, or of several robots; other loads; ``home_first`` of other poses;
            or the file cannot be written.
    """
    robot = _checked_poses(equilibria, loads)
    by_homes = list(home_first) or [False] * len(equilibria)
    if len(by_homes) != len(equilibria):
        problem = f"expected one for each of {len(equilibria)} equilibria, got {len(by_homes)}"
        raise InvalidRequest("home_first", problem)
    # No wrench is told too where the description has one: a row without cells stands for that.
    acting = [robot.default_loads, *(equilibrium.loads for equilibrium in equilibria)]
    loaded = any(loads.wrench_world.any() for loads in acting)
    frame = "" if robot.description.tracker is None else _TRACKER
    placed = deviations is None or deviations.position is not None
    turned = deviations is None or deviations.rotation is not None
    turned = turned and not robot.description.point_platform
    names = (*_POSITION * placed, *_QUATERNION * turned)
    posed = [f"{frame}{name}" for name in names]
    header = [*_motors(robot), *posed, *(WRENCH_NAMES if loaded else ())]
    try:
        with Path(file).open("w", newline="", encoding="utf-8") as opened:
            writer = csv.writer(opened)
            writer.writerow(header)
            for equilibrium, by_home in zip(equilibria, by_homes, strict=True):
                if by_home:
                    opened.write("# back home first\r\n")
                values = _values(equilibrium)
                writer.writerow([f"{values[name]:.12g}" for name in header])
    except OSError as error:
        raise InvalidRequest("out", f"{file}: cannot be written: {error}") from None


def _checked_poses(equilibria: Sequence[Equilibrium], loads: Loads | None) -> Robot:
    """The robot whose equilibria these are.

    Raises:
        InvalidRequest: None are, or they are not of one robot under these loads but for a wrench.
    """
    if not isinstance(equilibria, Sequence) or not equilibria:
        raise InvalidRequest("equilibria", f"expected a list of equilibria, got {equilibria!r:.80}")
    for equilibrium in equilibria:
        check_equilibrium(equilibrium)
    robot = equilibria[0].robot
    known = robot.default_loads if loads is None else loads
    for number, equilibrium in enumerate(equilibria):
        if equilibrium.robot is not robot:
            raise InvalidRequest(
                f"equilibria[{number}]", "expected one of the same robot as the first"
            )
        if set(equilibrium.loads.differences(known)) - {"wrench_world"}:
            raise InvalidRequest(
                f"equilibria[{number}]",
                "acted on by more than a file has of loads, which is wrench_world: give the others, "
                "the same for all rows, as loads here and to read_measurements",
            )
    return robot


def _values(equilibrium: Equilibrium) -> Mapping[str, float]:
    """Numbers of an equilibrium by column."""
    robot = equilibrium.robot
    names = [*_motors(robot), *_POSITION, *_QUATERNION, *WRENCH_NAMES]
    parts = [
        equilibrium.motors,
        equilibrium.platform_position,
        equilibrium.platform_quaternion,
        equilibrium.loads.wrench_world,
    ]
    if robot.description.tracker is not None:
        names += _of_tracker(robot)
        position, rotation = Measurement(frame="tracker").predicted_pose(equilibrium)
        parts += [position, quaternion_from_rotation(rotation)]
    return dict(zip(names, np.concatenate(parts).tolist(), strict=True))

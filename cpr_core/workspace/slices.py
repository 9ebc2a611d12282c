# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Grids from what is varied and what is held, by name: slices of poses, or of motor positions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.controlled_coordinates import CONTROLLED_COORDINATES
from ..description.other_units import degrees_doubt
from ..errors import InvalidRequest, NonFiniteInput
from ..kernels.twist_layout import FIRST_LINEAR
from ..model.robot import Robot, checked_robot
from ..solving.home import solve_home
from ..validation import checked_number, checked_vector, checked_word
from .grid import Grid
from .orientations import Orientation

__all__ = ["check_grid", "motor_grid", "pose_grid"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Grids with more cells are refused: their states would not fit in the memory of most machines.
MOST_CELLS = 20_000_000
_ZYZ = ("phi", "theta", "psi")
_RPY = ("roll", "pitch", "yaw")
#: Places of coordinates among x y z and three angles.
_PLACES = {name: FIRST_LINEAR + number for number, name in enumerate(_ZYZ)} | {
    name: (coordinate.axes[0] + FIRST_LINEAR) % 6  # twists have rotations first
    for name, coordinate in CONTROLLED_COORDINATES.items()
}


def pose_grid(
    robot: Robot,
    vary: Mapping[str, ArrayLike],
    held: Mapping[str, float] | None = None,
    *,
    resolution: float | Mapping[str, float] | None = None,
    directions: Mapping[str, Mapping[str, float]] | None = None,
) -> Grid:
    """A slice of the controlled platform coordinates (inverse problem in every cell).

    Args:
        robot: The robot. All its controlled coordinates have to be varied or held, and no other.
        vary: Axes by name: the coordinate along the axis, and its numbers; with ``resolution`` the first
            and the last of them. A name that is no coordinate needs a direction.
        held: The other coordinates [m, rad]; those not named are zero. An orientation is given by the
            ZYZ Euler angles ``phi``, ``theta``, ``psi`` of Rz(phi) Ry(theta) Rz(psi), or by ``roll``,
            ``pitch``, ``yaw`` of Rz(yaw) Ry(pitch) Rx(roll).
        resolution: Distance of neighbours, for all axes or by name; a little less where the ends ask
            for it.
        directions: What an axis changes per unit, for skew slices: ``{"s": {"x": 0.6, "y": 0.8}}``.

    Raises:
        InvalidRequest: Coordinates the robot does not control, angles beyond a whole turn, or axes that
            make no grid.
        NonFiniteInput: A NaN or an infinity.
    """
    checked_robot(robot)
    if not robot.description.controlled:
        raise InvalidRequest(
            "grid", f"{robot.description.name} has no inverse problem: map its motors instead"
        )
    asked = _asked(vary, held, resolution, directions)
    names, orientation = _pose_names(robot, {*asked.held} | asked.moved)
    units = tuple("m" if name in "xyz" else "rad" for name in names)
    index = np.array([_PLACES[name] for name in names])
    imposed = _Imposed("pose", names, units, orientation, index)
    grid = _grid(imposed, asked)
    _check_angles(grid, single=orientation is Orientation.SINGLE_ANGLES)
    return grid


def _check_angles(grid: Grid, single: bool) -> None:
    """Whether angles of the poses are in radians: degrees would be mapped, whole turns less.

    Where angles are controlled one by one, a pitch beyond pi/2 would be that of other angles.
    """
    ends = grid.origin[None, :].repeat(2, axis=0)  # the lowest and the highest
    for values, direction in zip(grid.values, grid.directions, strict=True):
        ends += np.sort(values[[0, -1], None] * direction, axis=0)
    for name, unit, *both in zip(grid.names, grid.units, *ends.tolist(), strict=True):
        for value in both if unit == "rad" else ():
            if doubt := degrees_doubt(name, value):
                raise InvalidRequest("grid", doubt)
            if single and name == "pitch" and abs(value) > 0.5 * math.pi:
                raise InvalidRequest(
                    "grid", f"expected a pitch of at most pi/2 rad, got {value:g} rad"
                )


def motor_grid(
    robot: Robot,
    vary: Mapping[str, ArrayLike],
    held: Mapping[str, float] | None = None,
    *,
    resolution: float | Mapping[str, float] | None = None,
    directions: Mapping[str, Mapping[str, float]] | None = None,
) -> Grid:
    """A slice of the motor positions (forward problem in every cell).

    Args:
        robot: The robot.
        vary: Axes by motor name, as in :func:`pose_grid`.
        held: Positions of the other motors [rad or m]; those not named are as at home.
        resolution: Distance of neighbours.
        directions: What an axis changes per unit, by motor.

    Raises:
        InvalidRequest: Names that are no motors, or axes that make no grid.
        NonFiniteInput: A NaN or an infinity.
    """
    checked_robot(robot)
    asked, names = _asked(vary, held, resolution, directions), robot.motor_names
    home = zip(names, solve_home(robot).motors.tolist(), strict=True)
    at_home = {name: position for name, position in home if name not in asked.moved}
    asked = replace(asked, held={**at_home, **asked.held})
    units = tuple(motor.unit for motor in robot.description.motors)
    imposed = _Imposed("motors", names, units, Orientation.NONE, np.arange(len(names)))
    return _grid(imposed, asked)


def check_grid(robot: Robot, grid: Grid) -> None:
    """Whether a grid is one of a robot.

    Raises:
        InvalidRequest: No grid, or one that imposes what this robot does not have.
    """
    if not isinstance(grid, Grid):
        raise InvalidRequest("grid", f"expected a Grid, got {grid!r:.200}")
    if grid.given == "motors":
        if grid.names != robot.motor_names:
            raise InvalidRequest("grid", "expected a grid of this robot's motors")
        return
    names, orientation = _pose_names(robot, {*grid.names})
    if (names, orientation.key) != (grid.names, grid.orientation):
        named = ", ".join(grid.names)
        raise InvalidRequest("grid", f"expected a grid of what this robot controls, got {named}")


def _pose_names(robot: Robot, used: set[str]) -> tuple[tuple[str, ...], Orientation]:
    """Names of the coordinates of a robot's poses, and how its orientation is given."""
    controlled = robot.description.controlled
    names = tuple(name for name in controlled if name in ("x", "y", "z"))
    if "orientation" in controlled:
        if used & {*_ZYZ} and used & {*_RPY}:
            raise InvalidRequest(
                "grid", "expected phi theta psi or roll pitch yaw, got some of both"
            )
        if used & {*_RPY}:
            return names + _RPY, Orientation.ROLL_PITCH_YAW
        return names + _ZYZ, Orientation.ZYZ
    if "angle" in controlled:
        return (*names, "angle"), Orientation.PLANAR
    single = tuple(name for name in _RPY if name in controlled)
    return names + single, Orientation.SINGLE_ANGLES if single else Orientation.NONE


@dataclass(frozen=True, eq=False)
class _Imposed:
    """The coordinates that the cells of a grid impose, as ``Grid`` has them."""

    given: Literal["pose", "motors"]
    names: tuple[str, ...]
    units: tuple[str, ...]
    orientation: Orientation
    index: Integers


@dataclass(frozen=True, eq=False)
class _Asked:
    """A slice as it is asked for.

    Attributes:
        vary: Numbers along the axes, by their names.
        held: What coordinates are where no axis moves them.
        resolution: Distance of neighbours, for all axes or by name; None: all numbers are given.
        directions: What skew axes change per unit.
    """

    vary: Mapping[str, ArrayLike]
    held: Mapping[str, float]
    resolution: float | Mapping[str, float] | None
    directions: Mapping[str, Mapping[str, float]]

    def rates(self, axis: str) -> Mapping[str, float]:
        """What an axis changes per unit, by coordinate."""
        return self.directions.get(axis, {axis: 1.0})

    @property
    def moved(self) -> set[str]:
        """Coordinates that axes change."""
        return {name for axis in self.vary for name in self.rates(axis)}

    def resolution_of(self, axis: str) -> float | None:
        """Distance of neighbours along an axis; None: its numbers are given."""
        if isinstance(self.resolution, Mapping):
            return self.resolution.get(axis)
        return self.resolution


def _asked(vary: object, held: object, resolution: Any, directions: object) -> _Asked:
    """What is given by name."""
    numbers, places = _by_name("vary", vary), _by_name("held", held)
    by_axis = _by_name("directions", directions)
    for axis, rates in by_axis.items():
        by_axis[axis] = _by_name(f"directions of {axis}", rates)
    return _Asked(numbers, places, resolution, by_axis)


def _grid(imposed: _Imposed, asked: _Asked) -> Grid:
    """The grid of some coordinates, every axis checked."""
    names, units, vary = imposed.names, imposed.units, asked.vary
    if len(vary) < 2:
        line = "; for a line there is trace" if len(vary) == 1 else ""
        raise InvalidRequest("grid", f"expected at least two axes, got {len(vary)}{line}")
    for name in asked.resolution if isinstance(asked.resolution, Mapping) else ():
        checked_word("resolution", name, tuple(vary))
    for name in asked.directions:
        checked_word("directions", name, tuple(vary))
    origin, rows, axis_units = np.zeros(len(names)), [], []
    for name, value in asked.held.items():
        origin[_place_of(name, names)] = _finite(name, value)
    for axis in vary:
        row = np.zeros(len(names))
        for name, rate in asked.rates(axis).items():
            if axis not in asked.directions and name in asked.held:
                raise InvalidRequest("grid", f"{name} is both an axis and held")
            row[_place_of(name, names)] = _finite(name, rate)
        rows.append(row)
        moved = {units[number] for number in np.flatnonzero(row)}
        axis_units.append(moved.pop() if len(moved) == 1 else "1")
    if np.linalg.matrix_rank(np.array(rows)) < len(rows):
        raise InvalidRequest("grid", "expected axes in independent directions")
    values = tuple(
        _axis_values(axis, given, asked.resolution_of(axis)) for axis, given in vary.items()
    )
    size = math.prod(len(along) for along in values)
    if size > MOST_CELLS:
        raise InvalidRequest("grid", f"expected at most {MOST_CELLS:,} cells, got {size:,}")
    return Grid(
        given=imposed.given,
        names=names,
        units=units,
        orientation=imposed.orientation.key,
        origin=origin,
        directions=np.array(rows),
        axis_names=tuple(vary),
        axis_units=tuple(axis_units),
        values=values,
        index=imposed.index,
    )


def _by_name(argument: str, value: object) -> dict[str, Any]:
    """What is given by name; None: nothing."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise InvalidRequest("grid", f"{argument}: expected values by name, got {value!r:.200}")
    return dict(value)


def _place_of(name: str, names: tuple[str, ...]) -> int:
    if name not in names:
        raise InvalidRequest(
            "grid", f"expected coordinates out of {', '.join(names)}, got {name!r}"
        )
    return names.index(name)


def _finite(name: str, value: float) -> float:
    try:
        return checked_number("grid", value)
    except NonFiniteInput:
        raise NonFiniteInput("grid", f"{name} is {value}") from None
    except InvalidRequest as error:
        raise InvalidRequest("grid", f"{name}: {error.problem}") from None


def _axis_values(name: str, values: ArrayLike, resolution: float | None) -> Floats:
    try:
        found = checked_vector("grid", values, np.size(values))
    except NonFiniteInput:
        raise NonFiniteInput(
            "grid", f"{name}: expected a list of finite numbers, got {values!r:.200}"
        ) from None
    except (InvalidRequest, ValueError):
        problem = f"{name}: expected a list of numbers, got {values!r:.200}"
        if np.ndim(values) == 0 and isinstance(values, int | float | np.number):
            problem += f"; held={{{name!r}: {values}}} holds it there"
        raise InvalidRequest("grid", problem) from None
    if resolution is not None:
        resolution = _finite(f"{name}: resolution", resolution)
        if len(found) != 2 or not found[0] < found[1]:
            raise InvalidRequest(
                "grid", f"{name}: expected the first and a larger last number, got {values!r:.200}"
            )
        if resolution <= 0.0:
            raise InvalidRequest(
                "grid", f"{name}: expected a positive resolution, got {resolution}"
            )
        intervals = (float(found[1]) - float(found[0])) / resolution
        if intervals > MOST_CELLS:
            raise InvalidRequest("grid", f"{name}: {intervals:.3g} cells are too many")
        return np.linspace(found[0], found[1], max(1, math.ceil(intervals - 1e-9)) + 1)
    if len(found) < 2 or not np.all(np.diff(found) > 0.0):
        raise InvalidRequest("grid", f"{name}: expected at least two increasing numbers")
    return found

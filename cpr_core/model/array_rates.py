# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How the arrays of the kernels answer to a number of the description, number by number.

A robot near by is built twice for every parameter; after that a residual near by only needs some numbers
written into arrays that are there.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.changed_description import shifted
from ..description.inherited_loads import inherited_loads, overridden_loads
from ..description.loads import Loads
from ..description.parameters import Parameter
from ..errors import DescriptionError, InvalidRequest
from ..kernels.kernel_arrays import Element, LoadArrays, RobotArrays, workspace
from ..kernels.pencil import pencil_of
from ..kernels.prepared_robot import PreparedRobot
from .robot import Robot

__all__ = [
    "ArrayRates",
    "Nearby",
    "VariedArrays",
    "load_rates",
    "nearby_robots",
    "robot_rates",
    "varied_loads",
]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: What the residual is made of; natural units change with the description too, but it has none.
_MECHANICS = (
    "groups",
    "motor_ratio",
    "elements",
    "rods",
    "functions",
    "step_functions",
    "elastic",
    "rest_moment",
    "weights",
    "integration",
    "steps",
)
_LOADS = ("gravity", "distributed", "point", "platform")
#: Changes by which rates are found, of the size of a number: their square is lost in rounding.
_CHANGE = 1e-5


@dataclass(frozen=True, eq=False)
class ArrayRates:
    """Numbers of arrays that change with a parameter.

    Attributes:
        name: Name of the array.
        places: Where in it, counted in numbers of eight bytes, (K,).
        rates: Change per change of the parameter, (K,).
    """

    name: str
    places: Integers
    rates: Floats


class Nearby(NamedTuple):
    """Robots beside one in a parameter.

    Attributes:
        robots: The robots.
        weights: What adds up to the rate of anything: its values there times these.
    """

    robots: tuple[Robot, ...]
    weights: tuple[float, ...]


def nearby_robots(robot: Robot, parameter: Parameter) -> Nearby:
    """Robots by which rates are found: on both sides, or on one where there are none on the other.

    Raises:
        InvalidRequest: The number is not finite.
        DescriptionError: There are none on either side.
    """

    def beside(change: float) -> Robot:
        return Robot(shifted(robot.description, parameter, change), robot.held_motors)

    def found() -> Nearby:
        change = _CHANGE * (parameter.size or 1.0)
        if not np.isfinite(change):
            problem = f"{parameter.path} is not given: expected a number to vary, got {change}"
            raise InvalidRequest("parameters", problem)
        ahead = beside(change)
        try:
            return Nearby((ahead, beside(-change)), (0.5 / change, -0.5 / change))
        except DescriptionError:
            weights = (2.0 / change, -0.5 / change, -1.5 / change)
            return Nearby((ahead, beside(2.0 * change), robot), weights)

    return robot.kept(f"beside in {parameter.path}", found)


def robot_rates(robot: Robot, parameter: Parameter) -> tuple[ArrayRates, ...]:
    """How the arrays of a robot change with a parameter.

    Raises:
        InvalidRequest: The number says how many there are of something.
        DescriptionError: No robot is near this one in this number.
    """

    def found() -> tuple[ArrayRates, ...]:
        near = nearby_robots(robot, parameter)
        sides = [beside.arrays for beside in near.robots]
        return _rates(robot.arrays, sides, near.weights, _MECHANICS, parameter)

    return robot.kept(f"rates by {parameter.path}", found)


def load_rates(robot: Robot, loads: Loads, parameter: Parameter) -> tuple[ArrayRates, ...]:
    """How loads in force change with a parameter, the last ones kept.

    Raises:
        InvalidRequest: The loads have been given in place of those the parameter is of.
        DescriptionError: No robot is near this one in this number.
    """
    name = f"loads by {parameter.path}"
    last: list[Any] = robot.kept(name, lambda: [None, ()])
    if last[0] is not loads:
        near, before = nearby_robots(robot, parameter), robot.default_loads
        for beside in near.robots:
            own = overridden_loads(loads, before, beside.default_loads)
            if own:
                problem = (
                    f"{parameter.path} has no effect: {', '.join(own)} of the request is in force"
                )
                raise InvalidRequest("parameters", problem)
        sides = [
            beside.load_arrays(inherited_loads(loads, before, beside.default_loads))
            for beside in near.robots
        ]
        rates = _rates(robot.load_arrays(loads), sides, near.weights, _LOADS, parameter)
        last[:] = loads, rates
    rates_found: tuple[ArrayRates, ...] = last[1]
    return rates_found


def _rates(
    middle: Any,
    sides: list[Any],
    weights: tuple[float, ...],
    names: tuple[str, ...],
    parameter: Parameter,
) -> tuple[ArrayRates, ...]:
    """Rates of all arrays that change."""
    found = []
    for name in names:
        array = getattr(middle, name)
        beside = [getattr(side, name) for side in sides]
        if any(other.shape != array.shape for other in beside):
            raise InvalidRequest(
                "parameters", f"{parameter.path} cannot be varied: the quadrature depends on it"
            )
        words = [_words(other) for other in beside]
        changed = np.any([own != words[0] for own in words[1:]], axis=0) & _is_float(array)
        places = np.flatnonzero(changed)
        if len(places):
            rates = sum(weight * own[places] for weight, own in zip(weights, words, strict=True))
            found.append(ArrayRates(name, places, np.asarray(rates)))
    return tuple(found)


def _words(array: NDArray[Any]) -> Floats:
    """An array as numbers of eight bytes, one after the other: a view."""
    return array.reshape(-1).view(np.float64)


def _is_float(array: NDArray[Any]) -> NDArray[np.bool_]:
    """Which of them are floats; the others are whole numbers, which no parameter changes."""
    if array.dtype.names is None:
        return np.ones(len(_words(array)), np.bool_)
    row = np.zeros(array.dtype.itemsize // 8, np.bool_)
    for name in array.dtype.names:
        kind, offset = array.dtype.fields[name][:2]  # type: ignore[index]
        row[offset // 8 : (offset + kind.itemsize) // 8] = kind.base.kind == "f"
    return np.tile(row, array.size)


class VariedArrays:
    """Arrays of a robot of their own, into which other numbers can be written; for one thread.

    Attributes:
        prepared: The robot as kernels take it.
    """

    def __init__(self, robot: Robot) -> None:
        """Copy them."""
        own = {name: getattr(robot.arrays, name).copy() for name in _MECHANICS}
        # A link without mass may be varied in it.
        own["elements"]["heavy"] |= own["elements"]["kind"] == Element.LINK
        arrays: RobotArrays = robot.arrays._replace(**own)
        self.prepared = PreparedRobot(
            arrays, workspace(arrays), pencil_of(arrays, robot.strain_grams)
        )
        self._words = {name: _words(array) for name, array in own.items()}

    @staticmethod
    def of(robot: Robot) -> VariedArrays:
        """Those of a robot and this thread."""
        memory = robot.kept("varied arrays", threading.local)
        if not hasattr(memory, "varied"):
            memory.varied = VariedArrays(robot)
        found: VariedArrays = memory.varied
        return found

    def add(self, changes: tuple[ArrayRates, ...], factor: float) -> list[Floats]:
        """Add so many times the rates; returns what was there, for ``restore``."""
        before = []
        for change in changes:
            words = self._words[change.name]
            kept = words[change.places]
            words[change.places] = kept + factor * change.rates
            before.append(kept)
        return before

    def restore(self, changes: tuple[ArrayRates, ...], before: list[Floats]) -> None:
        """Undo ``add``, to the last bit."""
        for change, kept in zip(changes, before, strict=True):
            self._words[change.name][change.places] = kept


def varied_loads(loads: LoadArrays, changes: tuple[ArrayRates, ...], factor: float) -> LoadArrays:
    """Loads with so many times the rates added."""
    if not changes:
        return loads
    own = {}
    for change in changes:
        own[change.name] = getattr(loads, change.name).copy()
        _words(own[change.name])[change.places] += factor * change.rates
    varied: LoadArrays = loads._replace(**own, on_rods=np.ones(1))
    return varied

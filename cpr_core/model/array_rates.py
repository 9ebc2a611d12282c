# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How the arrays of the kernels answer to a number of the description, number by number.

A robot near by is built for every parameter, or two; for parameters of different legs together, as each
changes numbers of its own legs only. After that a residual near by only needs some
numbers written into arrays that are there.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..description.inherited_loads import inheritance, inherited_loads, overridden_loads
from ..description.loads import Loads
from ..description.parameters import Parameter
from ..errors import DescriptionError, InvalidRequest
from .nearby_robots import AHEAD, CENTRAL, Stencil, change_of, kept_beside, nearby
from .robot import Robot, kept_with_robot
from .varied_numbers import are_floats, array_starts, legs_of_numbers, numbers_of

__all__ = ["ArrayRates", "array_rates"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Part of a change by which rates from one side may miss it: rounding, over the change.
_MISSED = 1e-9
#: How far from the change of another one that of a parameter is, so that no two misses cancel.
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
#: They say where nodes are and nothing else: what moves with one alone is the error of the quadrature.
_STATIONS = "stations"
#: For how many kinds of loads rates are kept: every question may have other forces on rods.
_KEPT = 100


@dataclass(frozen=True, eq=False)
class ArrayRates:
    """Numbers that change with a parameter, see ``VariedNumbers``.

    Attributes:
        places: Where they are, (K,).
        rates: Change per change of the parameter, (K,).
    """

    places: Integers
    rates: Floats


def array_rates(
    robot: Robot, loads: Loads, parameters: Sequence[Parameter]
) -> tuple[ArrayRates, ...]:
    """How the numbers of a robot and of loads in force change with parameters.

    Args:
        robot: The robot.
        loads: Loads in force.
        parameters: Of its description.

    Raises:
        InvalidRequest: A number that is not given, that says how many there are of something, or that
            has no effect: the request has put other loads in its place.
        DescriptionError: No robot is near this one in a number.
    """
    known = _known(robot, inheritance(loads, robot.default_loads))
    known |= _found(robot, loads, [own for own in parameters if own.path not in known])
    return tuple([known[parameter.path] for parameter in parameters])


@partial(kept_with_robot, most=_KEPT)
def _known(robot: Robot, kind: Hashable) -> dict[str, ArrayRates]:
    """Rates by path, for what loads in force have of their own, to be filled."""
    return {}


def _holding(
    robot: Robot, loads: Loads, parameters: Sequence[Parameter], rates: Sequence[ArrayRates]
) -> list[ArrayRates | None]:
    """Rates from one side that are those of the other too; None where they may not be.

    Tried with all parameters changed at once, then with halves of those that do not hold together.
    """
    if not parameters:
        return []
    if _hold(robot, loads, parameters, rates):
        return list(rates)
    if len(parameters) == 1:
        return [None]
    half = len(parameters) // 2
    return [
        *_holding(robot, loads, parameters[:half], rates[:half]),
        *_holding(robot, loads, parameters[half:], rates[half:]),
    ]


def _hold(
    robot: Robot, loads: Loads, parameters: Sequence[Parameter], rates: Sequence[ArrayRates]
) -> bool:
    """Whether rates tell the numbers of a robot beside this one in all these parameters."""
    changes = [
        -change_of(parameter) * (0.5 + _GOLDEN * number % 1.0)
        for number, parameter in enumerate(parameters)
    ]
    try:
        pairs = tuple(zip(parameters, changes, strict=True))
        beside = kept_beside(robot, pairs)
    except DescriptionError:
        return False
    middle, true = _numbers(robot, loads), _numbers_beside(robot, beside, loads)
    if len(true) != len(middle):
        return False
    told = np.zeros(len(middle))
    for change, single in zip(changes, rates, strict=True):
        told[single.places] += change * single.rates
    floats, starts = _kinds(robot)
    missed = np.where(floats, true - middle - told, 0.0)
    by_array = [np.maximum.reduceat(np.abs(values), starts) for values in (missed, told)]
    return bool(np.all(by_array[0] <= _MISSED * by_array[1]))


def _found(robot: Robot, loads: Loads, parameters: Sequence[Parameter]) -> dict[str, ArrayRates]:
    """Rates from robots near by, by path.

    One robot ahead of this one is enough for a number that all others are linear in, which one robot
    behind in all parameters tells.

    Raises:
        InvalidRequest: A number is not given or says how many there are of something, or the loads have
            been given in place of those it is of.
        DescriptionError: There are no robots.
    """
    found: dict[str, ArrayRates] = {}
    for apart in _of_different_legs(parameters):
        found |= _rates_apart(robot, loads, apart) or {
            parameter.path: _rates(robot, loads, parameter, AHEAD) for parameter in apart
        }
    rates = [found[parameter.path] for parameter in parameters]
    held = _holding(robot, loads, parameters, rates)
    return {
        parameter.path: own or _rates(robot, loads, parameter, CENTRAL)
        for parameter, own in zip(parameters, held, strict=True)
    }


def _of_different_legs(parameters: Sequence[Parameter]) -> list[list[Parameter]]:
    """Parameters in sets within which no two are of the same leg; what is of no leg is alone."""
    sets: list[tuple[set[int], list[Parameter]]] = []
    for parameter in parameters:
        legs = _legs_of(parameter)
        fitting = (others for others in sets if legs and others[0] and not legs & others[0])
        known, members = next(fitting, (set(), []))
        if not members:
            sets.append((known, members))
        known |= legs
        members.append(parameter)
    return [members for _, members in sets]


def _legs_of(parameter: Parameter) -> set[int]:
    """Legs in whose fields a parameter is; none where it is elsewhere too."""
    legs = {int(place[1]) for place in parameter.places if place[0] == "legs"}
    return legs if all(place[0] == "legs" for place in parameter.places) else set()


def _rates_apart(
    robot: Robot, loads: Loads, parameters: Sequence[Parameter]
) -> dict[str, ArrayRates] | None:
    """Rates of parameters of different legs from one robot ahead in all of them.

    None where they have to be asked one by one: there is no such robot, loads have been given in place
    of what a parameter is of, or other numbers change than those of the legs.
    """
    if len(parameters) == 1:
        return None
    changes = [change_of(parameter) for parameter in parameters]
    try:
        pairs = tuple(zip(parameters, changes, strict=True))
        beside = kept_beside(robot, pairs)
    except DescriptionError:
        return None
    if overridden_loads(loads, robot.default_loads, beside.default_loads):
        return None
    middle, ahead = _numbers(robot, loads), _numbers_beside(robot, beside, loads)
    if len(ahead) != len(middle):
        return None
    legs = _legs(robot)
    changed = (ahead != middle) & _kinds(robot)[0]
    found, told = {}, np.zeros(len(middle), np.bool_)
    for parameter, change in pairs:
        places = np.flatnonzero(changed & np.isin(legs, list(_legs_of(parameter))))
        told[places] = True
        found[parameter.path] = ArrayRates(places, (ahead - middle)[places] / change)
    return found if np.array_equal(told, changed) else None


def _rates(
    robot: Robot, loads: Loads, parameter: Parameter, stencils: Sequence[Stencil]
) -> ArrayRates:
    """Rates from some robots.

    Raises:
        InvalidRequest: The number is not given, the quadrature is another one, or the loads have been
            given in place of those the parameter is of.
        DescriptionError: There are no robots.
    """
    near = nearby(robot, parameter, stencils, change_of(parameter), kept_beside)
    problem = f"{parameter.path} cannot be varied: the quadrature depends on it"
    if any(place[0] == _STATIONS for place in parameter.places):
        raise InvalidRequest("parameters", problem)
    before = robot.default_loads
    for beside in near.robots:
        own = overridden_loads(loads, before, beside.default_loads)
        if own:
            others = f"{parameter.path} has no effect: {', '.join(own)} of the request is in force"
            raise InvalidRequest("parameters", others)
    sides = [_numbers_beside(robot, beside, loads) for beside in near.robots]
    if any(len(side) != len(_numbers(robot, loads)) for side in sides):
        raise InvalidRequest("parameters", problem)
    changed = np.any([side != sides[0] for side in sides[1:]], axis=0)
    places = np.flatnonzero(changed & _kinds(robot)[0])
    rates = sum(weight * side[places] for weight, side in zip(near.weights, sides, strict=True))
    return ArrayRates(places, np.asarray(rates, float))


@kept_with_robot
def _kinds(robot: Robot) -> tuple[NDArray[np.bool_], Integers]:
    """Which numbers are floats, and where arrays begin: the same for all loads."""
    own = robot.kernel_arrays, robot.load_arrays(robot.default_loads)
    return are_floats(*own), array_starts(*own)


@kept_with_robot
def _legs(robot: Robot) -> Floats:
    """Which leg a number is of: as above."""
    return legs_of_numbers(robot, robot.load_arrays(robot.default_loads))


def _numbers(robot: Robot, loads: Loads) -> Floats:
    return numbers_of(robot.kernel_arrays, robot.load_arrays(loads))


def _numbers_beside(robot: Robot, beside: Robot, loads: Loads) -> Floats:
    """Numbers of another robot under the same loads, but for those of the description."""
    if beside is robot:
        return _numbers(robot, loads)
    theirs = inherited_loads(loads, robot.default_loads, beside.default_loads)
    return numbers_of(beside.kernel_arrays, beside.load_arrays(theirs))

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How the residual of the model changes with numbers of the description, the state held."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..description.inherited_loads import inheritance
from ..description.parameters import Parameter
from ..kernels.parameter_kernel import Variations, vary_residual
from ..kernels.prepared_robot import evaluate_prepared
from ..kernels.record_layout import ENERGY, POSITION, ROTATION
from .array_rates import ArrayRates, array_rates
from .displacement import displaced
from .equilibrium import Equilibrium
from .model_state import configuration_of
from .robot import Robot, kept_with_robot
from .varied_numbers import VariedNumbers

__all__ = ["ResidualRates", "parameter_scales", "residual_rates", "small_change"]

Floats = NDArray[np.float64]

#: Step of central differences, in what changes the residual of a bent state by one natural unit, or in
#: so many sizes of the number if that is less; but no less than a part of the former, for rounding.
_STEP, _OWN, _LEAST = 1e-5, 1.0, 1e-3
#: A number that is less than this part of what means a natural unit is next to zero.
_NEXT_TO_ZERO = 1e-6
#: How much a number is changed at first, in its sizes and in SI units, and the change of the residual by
#: that which is rounding, in natural units.
_FIRST, _FIRST_SI, _ROUNDING = 1e-2, 1e-5, 1e-11
#: How far a state is bent where a parameter is tried, in natural units.
_BENT = 0.3
#: Second differences below this, over first ones, are rounding: the residual is linear.
_LINEAR = 1e-12
#: For how many ways of varying a robot rates are kept.
_KEPT = 100


@dataclass(frozen=True, eq=False)
class ResidualRates:
    """Derivatives of the model at an equilibrium, in the state order of the robot, SI units.

    Attributes:
        rates: Of the residual by the parameters, one row each, (P, N); motor columns are those of
            efforts.
        residuals: How many residuals it took.
    """

    rates: Floats
    residuals: int


@dataclass(frozen=True, eq=False)
class _Plan:
    """How parameters are varied.

    Attributes:
        variations: As the kernels take it.
        sizes: What changes the residual of a bent state by about a natural unit; 0 where nothing
            does, (P,).
        loads: Whether loads change with them.
    """

    variations: Variations
    sizes: Floats
    loads: bool


def residual_rates(equilibrium: Equilibrium, parameters: Sequence[Parameter]) -> ResidualRates:
    """Derivatives of the residual by parameters.

    Central differences; where the residual is linear in a parameter a single one, exact.

    Args:
        equilibrium: Where.
        parameters: Of its robot.

    Raises:
        InvalidRequest: A number that is not given, or that says how many there are of something.
        DescriptionError: No robot is near this one in a number.
    """
    plan = _plan(equilibrium.robot, equilibrium, parameters)
    rates = np.empty((len(parameters), equilibrium.robot.state_size))
    count = _vary(equilibrium, equilibrium.record, plan.variations, plan.loads, rates)
    return ResidualRates(rates, count)


def parameter_scales(equilibrium: Equilibrium, parameters: Sequence[Parameter]) -> Floats:
    """Changes of parameters that mean as much as a natural unit, (P,); 0 where they mean nothing."""
    return _plan(equilibrium.robot, equilibrium, parameters).sizes


def small_change(natural: Floats, size: Floats, own: float, least: float) -> Floats:
    """What changes neither the robot by more than a natural unit, nor a number by much of itself.

    How large a number is tells nothing where it is next to zero.

    Args:
        natural: Changes that mean as much as a natural unit, (P,).
        size: Of the numbers, (P,).
        own: How many of these are no more than a natural unit.
        least: Part of a natural unit that is small, whatever the size.
    """
    small = np.minimum(natural, np.maximum(own * size, least * natural))
    return np.where(size < _NEXT_TO_ZERO * natural, natural, small)


def _vary(
    equilibrium: Equilibrium, record: Floats, variations: Variations, loads: bool, rates: Floats
) -> int:
    """Derivatives of the residual at a record into ``rates``; returns how many residuals it took."""
    load_arrays = equilibrium.load_arrays
    varied = VariedNumbers.of(equilibrium.robot, load_arrays)
    if loads:
        load_arrays = varied.loads(load_arrays)
    memory = varied.numbers, varied.memory
    return int(vary_residual(varied.prepared, load_arrays, *memory, variations, record, rates))


def _asked(equilibrium: Equilibrium, parameters: Sequence[Parameter]) -> Hashable:
    """What a plan is for: parameters, and what loads have of their own."""
    own = inheritance(equilibrium.loads, equilibrium.robot.default_loads)
    return tuple([parameter.path for parameter in parameters]), own


@partial(kept_with_robot, most=_KEPT, by=_asked)
def _plan(robot: Robot, equilibrium: Equilibrium, parameters: Sequence[Parameter]) -> _Plan:
    """How parameters are varied, tried at a bent state."""
    arrays = robot.kernel_arrays
    rates = array_rates(robot, equilibrium.loads, parameters)
    first_load = VariedNumbers.of(robot, equilibrium.load_arrays).robot_count
    loads = any(len(own.places) and own.places[-1] >= first_load for own in rates)
    size = robot.state_size
    record = _bent(equilibrium)
    natural, changes = arrays.unit / arrays.energy_unit, np.empty((len(parameters), size))
    bent, other = record[:size].copy(), changes.copy()
    pose = record[size:]
    place = pose[ROTATION:POSITION].reshape(3, 3).copy(), pose[POSITION:ENERGY].copy()
    middle, unused = np.empty(size), np.empty((size, size))
    evaluate_prepared(robot.prepared, equilibrium.load_arrays, bent, *place, middle, unused)

    def tried(steps: Floats, linear: bool, result: Floats) -> Variations:
        variations = _variations(rates, steps, np.full(len(steps), linear))
        _vary(equilibrium, record, variations, loads, result)
        result *= natural
        return variations

    numbers = np.array([parameter.size for parameter in parameters])
    steps = np.zeros(len(numbers))
    for first in (np.full(len(numbers), _FIRST_SI), _FIRST * numbers):
        tried(first, False, changes)
        told = np.abs(changes).max(axis=1) * first > _ROUNDING
        steps[told] = first[told]
    sizes = np.zeros(len(steps))
    for _ in range(2):  # the first guess may be far off
        tried(steps, False, changes)
        response = np.abs(changes).max(axis=1)
        sizes = np.divide(1.0, response, out=np.zeros(len(steps)), where=response > 0.0)
        steps = _STEP * small_change(sizes, numbers, _OWN, _LEAST)
    tried(sizes, True, changes)
    tried(-sizes, True, other)
    second = sizes * np.abs(changes - other).max(axis=1)
    linear = second < _LINEAR * max(1.0, float(np.abs(natural * middle).max()))
    return _Plan(_variations(rates, np.where(linear, sizes, steps), linear), sizes, loads)


def _bent(equilibrium: Equilibrium) -> Floats:
    """A record near an equilibrium, under forces and in no special place.

    At home a motor at zero, or a level platform, hides what a parameter does elsewhere.
    """
    robot, arrays = equilibrium.robot, equilibrium.robot.kernel_arrays
    size = robot.state_size
    record, change = equilibrium.record.copy(), _BENT * np.cos(1.0 + 2.3 * np.arange(size))
    for rod in robot.fed_rods.rods:  # none becomes as short as nothing
        motor = rod.length_index
        way = abs(rod.length(record[:size]) / rod.element.ratio)
        most = _BENT * way / arrays.unit[motor]
        change[motor] = np.clip(change[motor], -most, most)
    place = displaced(robot, *configuration_of(equilibrium), arrays.unit * change)
    record[:size] = place.state
    record[size:][ROTATION : ROTATION + 9] = place.platform_rotation.ravel()
    record[size:][POSITION : POSITION + 3] = place.platform_position
    return record


def _variations(
    rates: Sequence[ArrayRates], steps: Floats, linear: NDArray[np.bool_]
) -> Variations:
    """Rates one behind the other."""
    starts = np.concatenate([[0], np.cumsum([len(own.places) for own in rates])])
    return Variations(
        starts,
        np.concatenate([own.places for own in rates]),
        np.concatenate([own.rates for own in rates]),
        steps,
        linear,
    )

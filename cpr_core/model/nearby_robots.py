# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots beside one in numbers of its description, for differences."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np

from ..description.changed_description import shifted_together
from ..description.parameters import Parameter
from ..errors import DescriptionError, InvalidRequest
from .robot import Robot, kept_with_robot

__all__ = [
    "AHEAD",
    "CENTRAL",
    "FOURTH_ORDER",
    "Nearby",
    "Stencil",
    "change_of",
    "kept_beside",
    "nearby",
]

#: Relative change of a number by which rates are found: its square is lost in rounding.
_CHANGE = 1e-5
#: How many robots are kept, of a tenth of a megabyte each.
_KEPT = 1000

Changes: TypeAlias = tuple[tuple[Parameter, float], ...]


class Stencil(NamedTuple):
    """Where values are taken for a derivative.

    Attributes:
        steps: How many steps away.
        weights: What values there, times these, add up to: the derivative times the step.
    """

    steps: tuple[float, ...]
    weights: tuple[float, ...]


#: Stencils, each with the one for where there are robots on one side only.
AHEAD = (Stencil((1.0, 0.0), (1.0, -1.0)),) * 2
CENTRAL = (Stencil((1.0, -1.0), (0.5, -0.5)), Stencil((1.0, 2.0, 0.0), (2.0, -0.5, -1.5)))
FOURTH_ORDER = (
    Stencil((-2.0, -1.0, 1.0, 2.0), (1.0 / 12.0, -8.0 / 12.0, 8.0 / 12.0, -1.0 / 12.0)),
    Stencil((0.0, 1.0, 2.0, 3.0, 4.0), (-25.0 / 12.0, 4.0, -3.0, 4.0 / 3.0, -0.25)),
)


class Nearby(NamedTuple):
    """Robots beside one in a parameter.

    Attributes:
        robots: The robots.
        changes: Of the parameter in them.
        weights: What adds up to the rate of anything: its values there times these.
    """

    robots: tuple[Robot, ...]
    changes: tuple[float, ...]
    weights: tuple[float, ...]


def change_of(parameter: Parameter) -> float:
    """By how much a parameter is changed.

    Raises:
        InvalidRequest: The number is not finite.
    """
    change = _CHANGE * (parameter.size or 1.0)
    if not np.isfinite(change):
        problem = (
            f"{parameter.path} is not given: expected a number to vary, got {parameter.values[0]}"
        )
        raise InvalidRequest("parameters", problem)
    return change


def _robot_beside(robot: Robot, changes: Changes) -> Robot:
    """The robot with some numbers changed.

    Raises:
        DescriptionError: There is none.
    """
    try:
        return robot.with_description(shifted_together(robot.description, changes))
    except InvalidRequest as error:  # of loads, which requests have too
        source = robot.description.source
        raise DescriptionError(source, f"loads.{error.argument}", error.problem) from None


#: The same, which robots keep.
kept_beside = partial(kept_with_robot, most=_KEPT)(_robot_beside)


def nearby(
    robot: Robot,
    parameter: Parameter,
    stencils: Sequence[Stencil],
    step: float,
    beside: Callable[[Robot, Changes], Robot] = _robot_beside,
) -> Nearby:
    """Robots beside one: on one side, ahead or else behind, where there are none on both.

    Args:
        robot: The robot.
        parameter: Of its description.
        stencils: What is tried, see above.
        step: Between them, in the unit of the parameter.
        beside: Makes a robot, or has it already.

    Raises:
        DescriptionError: There are none: what is wrong with those ahead.
    """
    both, single = stencils
    refused: list[DescriptionError] = []
    for stencil, signed in ((both, step), (single, step), (single, -step)):
        changes = tuple([factor * signed for factor in stencil.steps])
        try:
            robots = tuple(
                [beside(robot, ((parameter, change),)) if change else robot for change in changes]
            )
        except DescriptionError as error:
            refused.append(error)
        else:
            weights = tuple([weight / signed for weight in stencil.weights])
            return Nearby(robots, changes, weights)
    raise refused[1] from None

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What numbers of the description do to an equilibrium, to first order.

The derivation is in docs/derivations.md, "Derivatives by parameters"; docs/parameters.md shows the use.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..description.changed_description import named_parameters
from ..description.parameters import Parameter, checked_paths
from ..errors import CprError, InvalidRequest
from ..kernels.parameter_kernel import answer_rates
from ..kernels.problems import PROBLEMS, ProblemName
from ..kernels.twist_layout import ANGULAR, LINEAR
from ..model.equilibrium import Equilibrium, check_equilibrium
from ..model.platform_coordinates import six_components
from ..model.residual_rates import residual_rates
from ..model.robot import Robot, kept_with_robot
from ..validation import ReadOnlyArrays
from .held_problem import checked_problem
from .stability_slopes import stability_slopes

__all__ = ["Derivative", "ParameterDerivatives", "derivatives"]

Floats = NDArray[np.float64]

#: What derivatives can be asked for.
Derivative = Literal["pose", "motors", "efforts", "margin", "smallest_eigenvalue"]
_KNOWN = get_args(Derivative)


@dataclass(frozen=True, eq=False)
class ParameterDerivatives(ReadOnlyArrays):
    """Derivatives of an equilibrium by P parameters, one column each.

    The unit of every derivative is that of the quantity over that of the parameter. What was not asked
    for is empty, (0, P) or (0,).

    Attributes:
        problem: What is held: ``motors``, ``pose`` or ``efforts``.
        parameters: Paths of the parameters. One with ``[*]`` or ``[0,1]`` stands for the
            same change in all its places.
        position: Of the platform origin in the world, (3, P) [m].
        rotation: Of the platform as a rotation vector in the world, (3, P) [rad].
        twist_body: Both as a twist in the axes of the platform, rotation first, (6, P) [rad, m]: as
            ``KinematoStatics.jacobian`` has them.
        motors: Of the motor positions, (n, P) [rad or m].
        efforts: Of the motor efforts, (n, P) [N m or N].
        margin: Of ``Equilibrium.margin``, (P,); NaN where there is none, and as below.
        smallest_eigenvalue: Of ``Equilibrium.spectrum_locked.smallest``, (P,) [J]; NaN by what parts
            equal ones, which has no derivative.
    """

    problem: ProblemName
    parameters: tuple[str, ...]
    position: Floats
    rotation: Floats
    twist_body: Floats
    motors: Floats
    efforts: Floats
    margin: Floats
    smallest_eigenvalue: Floats
    _states: Floats = field(repr=False)


def derivatives(
    equilibrium: Equilibrium,
    parameters: str | Sequence[str],
    of: str | Sequence[str] = ("pose", "motors", "efforts"),
    problem: ProblemName = "motors",
) -> ParameterDerivatives:
    """Derivatives of an equilibrium by numbers of the description.

    Args:
        equilibrium: Any regular equilibrium.
        parameters: Paths of the numbers, see ``Robot.parameter_values``.
        of: What is asked for: ``pose``, ``motors``, ``efforts``, ``margin``, ``smallest_eigenvalue``.
            The last two take milliseconds for every parameter that a robot is asked for first.
        problem: What is held while a parameter changes: ``motors``, ``pose`` or ``efforts``. Loads of
            the description change with it, those of the request do not.

    Raises:
        UnknownParameter: There is no such number.
        InvalidRequest: What is there is no number that can be varied, or no problem that this robot has.
        DescriptionError: No robot is near this one in a number.
        CprError: The equilibrium is singular with these held.
    """
    check_equilibrium(equilibrium)
    wanted = _checked_quantities(of)
    checked_problem(equilibrium.robot, problem)
    named = _named(equilibrium.robot, checked_paths(parameters))
    states, efforts = _state_derivatives(equilibrium, named, problem)
    robot, count = equilibrium.robot, len(named)
    twist = six_components(robot.platform_axes, states[robot.platform_indices])
    turned = equilibrium.platform_rotation.T
    body = (turned @ twist.reshape(2, 3, count)).reshape(6, count)
    slopes = stability_slopes(equilibrium, named, states, wanted)
    none, rows = np.zeros((0, count)), states[robot.motor_indices]
    pose = "pose" in wanted
    return ParameterDerivatives(
        problem=problem,
        parameters=tuple(parameter.path for parameter in named),
        position=twist[LINEAR] if pose else none,
        rotation=twist[ANGULAR] if pose else none,
        twist_body=body if pose else none,
        motors=rows if "motors" in wanted else none,
        efforts=efforts if "efforts" in wanted else none,
        margin=slopes["margin"],
        smallest_eigenvalue=slopes["smallest_eigenvalue"],
        _states=states,
    )


@kept_with_robot
def _named(robot: Robot, paths: tuple[str, ...]) -> tuple[Parameter, ...]:
    """Parameters of a robot by their paths.

    Raises:
        UnknownParameter: There is no such number.
        InvalidRequest: What is there is no number, or a path is given twice.
    """
    return named_parameters(robot.description, paths)


def _checked_quantities(of: str | Sequence[str]) -> tuple[str, ...]:
    """Names of quantities.

    Raises:
        InvalidRequest: Others than there are.
    """
    wanted = (of,) if isinstance(of, str) else of
    words = (
        isinstance(wanted, Sequence) and wanted and all(isinstance(name, str) for name in wanted)
    )
    if not words or not set(wanted) <= set(_KNOWN):
        raise InvalidRequest("of", f"expected some of {', '.join(_KNOWN)}, got {of!r:.200}")
    return tuple(wanted)


def _state_derivatives(
    equilibrium: Equilibrium, parameters: Sequence[Parameter], problem: ProblemName
) -> tuple[Floats, Floats]:
    """Derivatives of the state (N, P), platform rows world twists, and of the efforts (n, P).

    Raises:
        CprError: The equilibrium is singular with these held.
    """
    robot, rates = equilibrium.robot, residual_rates(equilibrium, parameters).rates
    states, efforts = np.empty_like(rates), np.zeros((len(rates), robot.motor_count))
    if not answer_rates(
        robot.prepared,
        equilibrium.load_arrays,
        PROBLEMS[problem],
        equilibrium.factors,
        equilibrium.record,
        rates,
        states,
        efforts,
    ):
        raise CprError(f"no derivatives: the equilibrium is singular with its {problem} held")
    return states.T, np.zeros_like(efforts.T) if problem == "efforts" else efforts.T

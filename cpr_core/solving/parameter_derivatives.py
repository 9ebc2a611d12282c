# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What numbers of the description do to an equilibrium, to first order.

The derivation is in docs/derivations.md, "Derivatives by parameters"; docs/parameters.md shows the use.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from ..blas_threads import on_one_blas_thread
from ..description.changed_description import named_parameters
from ..description.parameters import Parameter, checked_paths
from ..errors import CprError, InvalidRequest
from ..lie import angle_motions
from ..model.equilibrium import Equilibrium, check_equilibrium
from ..model.residual_rates import residual_rates
from ..model.robot import Robot
from .held_problem import checked_problem
from .stability_slopes import stability_slopes
from .targets import ProblemName

__all__ = ["Derivative", "ParameterDerivatives", "derivatives"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: What derivatives can be asked for.
Derivative = Literal["pose", "motors", "efforts", "margin", "smallest_eigenvalue"]
#: Smallest pivot over the largest, in natural units, of an equilibrium that is not singular.
_SINGULAR = 1e-14


@dataclass(frozen=True, eq=False)
class ParameterDerivatives:
    """Derivatives of an equilibrium by P parameters, one column each.

    The unit of every derivative is that of the quantity over that of the parameter. What was not asked
    for is empty, (0, P) or (0,).

    Attributes:
        problem: What is held: ``motors``, ``pose`` or ``efforts``.
        parameters: Paths of the parameters. One with ``[*]`` stands for the same change in all places.
        position: Of the platform origin in the world, (3, P) [m].
        rotation: Of the platform as a rotation vector in the world, (3, P) [rad].
        twist_body: Both as a twist in the axes of the platform, rotation first, (6, P) [rad, m]: as
            ``KinematoStatics.jacobian`` has them.
        motors: Of the motor positions, (n, P) [rad or m].
        efforts: Of the motor efforts, (n, P) [N m or N].
        margin: Of ``Equilibrium.margin``, (P,).
        smallest_eigenvalue: Of ``Equilibrium.spectrum_locked.smallest``, (P,) [J].
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
    named = _named(equilibrium.robot, parameters)
    states, efforts = _state_derivatives(equilibrium, named, problem)
    robot, count = equilibrium.robot, len(named)
    twist = np.zeros((6, count))
    twist[robot.platform_axes] = states[robot.platform_indices]
    turned = equilibrium.platform_rotation.T
    body = np.vstack([turned @ twist[:3], turned @ twist[3:]])
    slopes = stability_slopes(equilibrium, named, states, wanted)
    none, rows = np.zeros((0, count)), states[robot.motor_indices]
    pose = "pose" in wanted
    return ParameterDerivatives(
        problem=problem,
        parameters=tuple(parameter.path for parameter in named),
        position=twist[3:] if pose else none,
        rotation=twist[:3] if pose else none,
        twist_body=body if pose else none,
        motors=rows if "motors" in wanted else none,
        efforts=efforts if "efforts" in wanted else none,
        margin=slopes["margin"],
        smallest_eigenvalue=slopes["smallest_eigenvalue"],
        _states=states,
    )


def _named(robot: Robot, paths: str | Sequence[str]) -> tuple[Parameter, ...]:
    """Parameters of a robot by their paths, looked up once.

    Raises:
        UnknownParameter: There is no such number.
        InvalidRequest: What is there is no number, or a path is given twice.
    """
    checked = checked_paths(paths)
    known: dict[tuple[str, ...], tuple[Parameter, ...]] = robot.kept("parameters", dict)
    if checked not in known:
        known[checked] = named_parameters(robot.description, checked)
    return known[checked]


def _checked_quantities(of: str | Sequence[str]) -> tuple[str, ...]:
    """Names of quantities.

    Raises:
        InvalidRequest: Others than there are.
    """
    wanted = (of,) if isinstance(of, str) else of
    known = get_args(Derivative)
    if not isinstance(wanted, Sequence) or not wanted or any(name not in known for name in wanted):
        raise InvalidRequest("of", f"expected some of {', '.join(known)}, got {of!r:.200}")
    return tuple(wanted)


class _Cut(NamedTuple):
    """What of the tangent a problem has, found once for a robot.

    Attributes:
        equations: Rows of it.
        unknowns: Columns of it.
        block: The same where rows and columns are the first ones; None where they are not.
        scales: Factors that make it dimensionless, (M, M).
        right: Factors that make its equations dimensionless, (M, 1).
    """

    equations: Integers
    unknowns: Integers
    block: slice | None
    scales: Floats
    right: Floats


def _cut(robot: Robot, problem: ProblemName) -> _Cut:
    """What of the tangent a problem has."""
    arrays, (columns, rows) = robot.arrays, robot.problems[problem]
    legs, unit = np.arange(arrays.platform_index), robot.arrays.unit
    equations, unknowns = np.concatenate([legs, rows]), np.concatenate([legs, columns])
    first = np.arange(len(equations))
    leading = np.array_equal(equations, first) and np.array_equal(unknowns, first)
    right = (unit[equations] / arrays.energy_unit)[:, None]
    block = slice(len(first)) if leading else None
    return _Cut(equations, unknowns, block, right * unit[unknowns], right)


@on_one_blas_thread
def _state_derivatives(
    equilibrium: Equilibrium, parameters: Sequence[Parameter], problem: ProblemName
) -> tuple[Floats, Floats]:
    """Derivatives of the state (N, P), platform rows world twists, and of the efforts (n, P).

    Raises:
        CprError: The equilibrium is singular with these held.
    """
    robot, model = equilibrium.robot, residual_rates(equilibrium, parameters)
    motions, motors = model.tangent, robot.motor_indices
    cut = robot.kept(f"cut for {problem}", lambda: _cut(robot, problem))
    turns = robot.platform_indices[:3]
    angles = problem == "pose" and robot.controls_angles
    if angles:  # what is held are roll, pitch and yaw, not turns about axes of the world
        motions = motions.copy()
        motions[:, turns] = motions[:, turns] @ angle_motions(equilibrium.platform_rotation)
    if cut.block is not None:
        matrix = motions[cut.block, cut.block] * cut.scales
    else:
        matrix = motions[np.ix_(cut.equations, cut.unknowns)] * cut.scales
    states = np.zeros_like(model.rates)
    solution = _solved(matrix, -model.rates[cut.equations] * cut.right, problem)
    states[cut.unknowns] = robot.arrays.unit[cut.unknowns, None] * solution
    if angles:
        states[turns] = angle_motions(equilibrium.platform_rotation) @ states[turns]
    efforts = model.rates[motors] + model.tangent[motors] @ states
    return states, np.zeros_like(efforts) if problem == "efforts" else efforts


def _solved(matrix: Floats, right: Floats, problem: ProblemName) -> Floats:
    """Solution of a dimensionless linear problem, (M, P).

    Raises:
        CprError: The matrix has no inverse.
    """
    if not len(matrix):
        return right
    factors, order, failed = linalg.lapack.dgetrf(matrix.T, overwrite_a=True)
    pivots = np.abs(factors.diagonal())
    if not failed and pivots.min() > _SINGULAR * pivots.max():
        solution, _ = linalg.lapack.dgetrs(factors, order, right, trans=1)
        return np.asarray(solution)
    raise CprError(f"no derivatives: the equilibrium is singular with its {problem} held")

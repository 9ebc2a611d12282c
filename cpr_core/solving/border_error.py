# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far a border of stability is from that of continuous rods.

The derivation is in docs/derivations.md, "The error of a border".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..blas_threads import on_one_blas_thread
from ..description.loads import Loads
from ..errors import InvalidRequest
from ..kernels.square_problem import Configuration
from ..model.equilibrium import Equilibrium, check_equilibrium
from ..model.model_state import configuration_of, evaluate
from ..validation import checked_vector
from .assembly import moved_shape
from .discretisation_error import embedded_richer, embedding_of

__all__ = ["border_error"]

Floats = NDArray[np.float64]

#: Step of differences along the motion that loses its stiffness, dimensionless.
_STEP = 1e-4
#: Singular values below this, relative, belong to a border where branches cross.
_CROSSING = 1e-9


@on_one_blas_thread
def border_error(
    border: Equilibrium,
    *,
    motors: ArrayLike | None = None,
    pose: ArrayLike | None = None,
    loads: Loads | None = None,
) -> float:
    """Estimate how much farther on a way robots with continuous rods lose stability, motors held.

    One step of Newton's method in a richer space, for equilibrium and border at once. The first order is
    not all with three or four modes, which may miss a border by centimetres.

    Args:
        border: The equilibrium at the border: of a `PathEvent`, or of a `CriticalLoad`.
        motors: The way, if motors are moved: their change, (n,) [rad or m].
        pose: The way, if the controlled coordinates are: their change as a twist in the world, in the
            order of the description, (k,) [m or rad].
        loads: The way, if loads grow: what is added.

    Returns:
        How much farther, in units of the way; negative: the border comes earlier.

    Raises:
        InvalidRequest: No equilibrium, not one way, or one that does not fit the robot.
    """
    check_equilibrium(border)
    if sum(way is not None for way in (motors, pose, loads)) != 1:
        raise InvalidRequest("motors", "expected one way: motors, pose or loads")
    robot, start = border.robot, embedded_richer(border)
    imposed, way = start.robot.motor_indices, np.zeros(robot.motor_count)
    if motors is not None:
        way = checked_vector("motors", motors, robot.motor_count, robot.motor_list)
    if pose is not None:
        if robot.redundancy or not robot.description.controlled or robot.controls_angles:
            raise InvalidRequest(
                "pose", "expected motors or loads: no twist is the way of this robot's pose"
            )
        controlled = robot.controlled_axes
        way = checked_vector("pose", pose, len(controlled), "the controlled coordinates")
        imposed = start.robot.platform_indices[
            np.searchsorted(start.robot.platform_axes, controlled)
        ]
    found = _softening(border, start)
    size, unit = start.robot.state_size, start.robot.kernel_arrays.unit
    balance = np.s_[: start.robot.kernel_arrays.motor_index]
    held = size - len(imposed) + np.arange(len(imposed))
    matrix, rest = np.zeros((size + 1, size + 1)), np.zeros(size + 1)
    matrix[balance, :size], rest[balance] = found.tangent[balance], -found.residual[balance]
    matrix[held, imposed], matrix[held, size] = 1.0, -way / unit[imposed]
    matrix[size, :size], rest[size] = found.eigenvalue_by_state, -found.eigenvalue
    if loads is not None:
        by_load = [
            _dimensionless(start, configuration_of(start), acting)
            for acting in (loads, Loads.none())
        ]
        residual, tangent = (loaded - unloaded for loaded, unloaded in zip(*by_load, strict=True))
        matrix[balance, size] = residual[balance]
        matrix[size, size] = found.motion @ tangent @ found.motion
    return float(np.linalg.lstsq(matrix, rest, rcond=_CROSSING)[0][size])


@dataclass(frozen=True, eq=False)
class _Softening:
    """A motion that loses its stiffness, dimensionless and in state order.

    Attributes:
        residual: Of the model, (N,).
        tangent: Of the model, symmetric, (N, N).
        motion: With the multipliers that go with it, of length one; motors rest, (N,).
        eigenvalue: Its stiffness.
        eigenvalue_by_state: How that changes with the state, (N,).
    """

    residual: Floats
    tangent: Floats
    motion: Floats
    eigenvalue: float
    eigenvalue_by_state: Floats


def _softening(border: Equilibrium, start: Equilibrium) -> _Softening:
    """The motion that has no stiffness at a border, in a richer space.

    Args:
        border: The border.
        start: The same, embedded.
    """
    _, lost = _eigenvectors(
        border, _dimensionless(border, configuration_of(border), border.loads)[1]
    )
    units = border.robot.kernel_arrays.unit, start.robot.kernel_arrays.unit
    lost = embedding_of(border.robot, start.robot) @ (lost[:, 0] * units[0]) / units[1]
    place = configuration_of(start)
    residual, tangent = _dimensionless(start, place, start.loads)
    eigenvalues, motions = _eigenvectors(start, tangent)
    same = int(np.argmax(np.abs(lost @ motions)))
    motion = motions[:, same]
    everything = np.arange(len(motion))
    ends = [moved_shape(start.robot, place, everything, way * motion) for way in (_STEP, -_STEP)]
    beyond, before = (_dimensionless(start, end, start.loads)[1] for end in ends)
    # Third derivatives are symmetric: along the motion, then by the state, is the same as the other way.
    by_state = (beyond - before) @ motion / (2.0 * _STEP)
    return _Softening(residual, tangent, motion, float(eigenvalues[same]), by_state)


def _eigenvectors(equilibrium: Equilibrium, tangent: Floats) -> tuple[Floats, Floats]:
    """Eigenvalues and vectors of a tangent with the motors held, the one nearest to zero first."""
    free = equilibrium.robot.kernel_arrays.motor_index
    eigenvalues, found = np.linalg.eigh(tangent[:free, :free])
    order = np.argsort(np.abs(eigenvalues))
    vectors = np.zeros((len(tangent), free))
    vectors[:free] = found[:, order]
    return eigenvalues[order], vectors


def _dimensionless(
    equilibrium: Equilibrium, place: Configuration, loads: Loads
) -> tuple[Floats, Floats]:
    """Residual (N,) and symmetric tangent (N, N) of a place of the robot of an equilibrium."""
    robot = equilibrium.robot
    unit = robot.kernel_arrays.unit
    value = evaluate(robot, robot.load_arrays(loads), *place)
    tangent = unit[:, None] * value.tangent * unit
    return unit * value.residual, 0.5 * (tangent + tangent.T)

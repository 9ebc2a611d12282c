# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots of chains of continuous rods, solved by shooting from an equilibrium of strain modes.

Unknowns are the wrenches at the bases, the passive joints, the multipliers of the tips' orientations and
either the platform or the motors; equations are those of ``chain_balance``. Newton's method, its steps
halved where they lead nowhere.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..blas_threads import on_one_blas_thread
from ..errors import InvalidRequest
from ..model.equilibrium import Equilibrium
from ..solving.not_reached import NoForwardSolution, NoInverseSolution
from .chain_balance import ChainBalance, ChainPoint, chain_balance, variable_units
from .chain_robot import ChainRobot, chain_robot
from .chain_steps import ChainState, node_cuts
from .continuous_equilibrium import ContinuousEquilibrium
from .rough_point import rough_point
from .shooting_method import ShootingMethod

__all__ = ["solve_chains"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Newton steps, and the smallest part of one.
_ITERATIONS, _SMALLEST = 40, 1e-3


@on_one_blas_thread
def solve_chains(
    equilibrium: Equilibrium, *, motors_held: bool, method: ShootingMethod
) -> ContinuousEquilibrium:
    """Refine an equilibrium of the strain-mode model into one of continuous rods, whatever the legs are.

    Args:
        equilibrium: Where the shooting starts.
        motors_held: Whether the motors stay, or the platform.
        method: Integration and tolerance.

    Raises:
        InvalidRequest: A joint of a kind this method does not know.
        NoForwardSolution, NoInverseSolution: Newton's method does not reach the tolerance.
    """
    robot, loads = equilibrium.robot, equilibrium.loads
    point = rough_point(chain_robot(robot, loads, method), equilibrium)
    model = chain_robot(robot, loads, method, node_cuts(point.nodes))
    unknown = _unknowns(model, len(point.nodes), motors_held=motors_held)
    balance = chain_balance(model, point)
    iterations = 0
    while balance.largest >= method.tolerance and iterations < _ITERATIONS:
        before = balance.largest
        if not np.isfinite(balance.jacobian).all():  # errors have grown beyond all numbers
            break
        point, balance = _improved(model, point, balance, unknown)
        iterations += 1
        if not balance.largest < before:
            break
    if not balance.largest < method.tolerance:
        kind = NoForwardSolution if motors_held else NoInverseSolution
        raise kind(f"shooting: residual {balance.largest:.1e} after {iterations} steps", 0.0, None)
    passive = np.concatenate([leg.passive for leg in model.legs])
    return ContinuousEquilibrium(
        robot=robot,
        loads=loads,
        motors=point.values[robot.motor_indices],
        passive=point.values[passive],
        platform_rotation=point.rotation,
        platform_position=point.position,
        base_wrenches=point.wrenches,
        residual=balance.largest,
        iterations=iterations,
        method=method,
        nodes=point.nodes,
    )


def _unknowns(model: ChainRobot, nodes: int, *, motors_held: bool) -> Integers:
    """Columns of the Jacobian that are to be found."""
    robot = model.robot
    inner = [np.concatenate([leg.passive, leg.moments]) for leg in model.legs]
    moving = robot.platform_indices if motors_held else robot.motor_indices
    wrenches = robot.state_size + 6 * np.arange(len(model.legs))[:, None]
    components = np.array([2, 3, 4] if robot.planar else range(6))
    first = robot.state_size + 6 * len(model.legs)
    inside = first + 12 * np.arange(nodes)[:, None] + model.in_chain
    found = np.concatenate([*inner, moving, (wrenches + components).ravel(), inside.ravel()])
    return found.astype(np.int64)


def _improved(
    model: ChainRobot, point: ChainPoint, balance: ChainBalance, unknown: Integers
) -> tuple[ChainPoint, ChainBalance]:
    """One Newton step, halved until it improves."""
    robot, size = model.robot, model.robot.state_size
    full = np.zeros(balance.jacobian.shape[1])
    matrix = balance.jacobian[:, unknown]
    if matrix.shape[0] != matrix.shape[1]:
        raise InvalidRequest("held", "expected as many motors as platform coordinates")
    try:
        full[unknown] = np.linalg.solve(matrix, -balance.residual)
    except np.linalg.LinAlgError:
        full[unknown] = np.linalg.lstsq(matrix, -balance.residual, rcond=None)[0]
    step = full * variable_units(model, len(point.nodes))
    at_base, at_nodes = np.split(step[size:], [6 * len(model.legs)])
    share = 1.0
    while True:
        twist = np.zeros(6)
        twist[robot.platform_axes] = share * step[robot.platform_indices]
        values = point.values + share * step[:size]
        trial = ChainPoint(
            values,
            point.wrenches + share * at_base.reshape(-1, 6),
            Rotation.from_rotvec(twist[:3]).as_matrix() @ point.rotation,
            point.position + twist[3:],
            {
                place: _moved(node, share * change)
                for (place, node), change in zip(
                    point.nodes.items(), at_nodes.reshape(-1, 12), strict=True
                )
            },
        )
        ahead = chain_balance(model, trial)
        better = ahead.largest <= (1.0 - 0.25 * share) * balance.largest
        if better or ahead.largest < model.method.tolerance or share < _SMALLEST:
            return trial, ahead
        share *= 0.5


def _moved(node: ChainState, change: Floats) -> ChainState:
    place, turn, moment, force = change.reshape(4, 3)
    return ChainState(
        node.position + place,
        Rotation.from_rotvec(turn).as_matrix() @ node.frame,
        node.moment + moment,
        node.force + force,
    )

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
from ..description.chain import ChainRod, Link, Turn
from ..errors import InvalidRequest
from ..model.equilibrium import Equilibrium
from ..solving.not_reached import NoForwardSolution, NoInverseSolution
from .chain_balance import ChainBalance, ChainPoint, chain_balance, tip_joint
from .chain_robot import ChainRobot, LegModel, RodModel, chain_robot
from .continuous_equilibrium import ContinuousEquilibrium
from .shooting_method import ShootingMethod

__all__ = ["solve_chains"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Newton steps, and the smallest part of one.
_ITERATIONS, _SMALLEST = 40, 1e-3
#: Cells of a rod in the starting guess.
_CELLS = 40


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
    model = chain_robot(robot, loads, method)
    unknown = _unknowns(model, motors_held=motors_held)
    point = _guess(model, equilibrium)
    here = chain_balance(model, point)
    iterations = 0
    while here.largest >= method.tolerance and iterations < _ITERATIONS:
        before = here.largest
        point, here = _improved(model, point, here, unknown)
        iterations += 1
        if not here.largest < before:
            break
    if not here.largest < method.tolerance:
        kind = NoForwardSolution if motors_held else NoInverseSolution
        raise kind(f"shooting: residual {here.largest:.1e} after {iterations} steps", 0.0, None)
    passive = np.concatenate([leg.passive for leg in model.legs])
    return ContinuousEquilibrium(
        robot=robot,
        loads=loads,
        motors=point.values[robot.motor_indices],
        passive=point.values[passive],
        platform_rotation=point.rotation,
        platform_position=point.position,
        base_wrenches=point.wrenches,
        residual=here.largest,
        iterations=iterations,
        method=method,
    )


def _unknowns(model: ChainRobot, *, motors_held: bool) -> Integers:
    """Columns of the Jacobian that are to be found."""
    robot = model.robot
    inner = [np.concatenate([leg.passive, leg.moments]) for leg in model.legs]
    moving = robot.platform_indices if motors_held else robot.motor_indices
    wrenches = robot.state_size + 6 * np.arange(len(model.legs))[:, None]
    components = np.array([2, 3, 4] if robot.planar else range(6))
    found = np.concatenate([*inner, moving, (wrenches + components).ravel()])
    return found.astype(np.int64)


def _improved(
    model: ChainRobot, point: ChainPoint, here: ChainBalance, unknown: Integers
) -> tuple[ChainPoint, ChainBalance]:
    """One Newton step, halved until it improves."""
    robot, size = model.robot, model.robot.state_size
    units = np.repeat([robot.numbers.energy_unit, robot.numbers.energy_unit / robot.mean_length], 3)
    full = np.zeros(here.jacobian.shape[1])
    matrix = here.jacobian[:, unknown]
    if matrix.shape[0] != matrix.shape[1]:
        raise InvalidRequest("held", "expected as many motors as platform coordinates")
    try:
        full[unknown] = np.linalg.solve(matrix, -here.residual)
    except np.linalg.LinAlgError:
        full[unknown] = np.linalg.lstsq(matrix, -here.residual, rcond=None)[0]
    step = full * np.concatenate([robot.numbers.unit, np.tile(units, len(model.legs))])
    share = 1.0
    while True:
        twist = np.zeros(6)
        twist[robot.platform_axes] = share * step[robot.platform_indices]
        values = point.values + share * step[:size]
        trial = ChainPoint(
            values,
            point.wrenches + share * step[size:].reshape(-1, 6),
            Rotation.from_rotvec(twist[:3]).as_matrix() @ point.rotation,
            point.position + twist[3:],
        )
        ahead = chain_balance(model, trial)
        better = ahead.largest <= (1.0 - 0.25 * share) * here.largest
        if better or ahead.largest < model.method.tolerance or share < _SMALLEST:
            return trial, ahead
        share *= 0.5


def _guess(model: ChainRobot, equilibrium: Equilibrium) -> ChainPoint:
    """What the strain modes tell: wrenches at the bases by statics about their shape."""
    robot, values = model.robot, np.array(equilibrium.state)
    rotation = np.array(equilibrium.platform_rotation)
    held = robot.arrays.position_axes
    wrenches = np.zeros((len(model.legs), 6))
    for number, leg in enumerate(model.legs):
        tip_force = np.zeros(3)
        tip_force[held] = values[robot.numbers.legs[number].forces]
        strains = [values[rod.strain] for rod in robot.numbers.legs[number].rods]
        wrenches[number] = _base_wrench(leg, values, strains, tip_force, rotation)
    return ChainPoint(values, wrenches, rotation, np.array(equilibrium.platform_position))


def _base_wrench(
    leg: LegModel, values: Floats, strains: list[Floats], tip_force: Floats, rotation: Floats
) -> Floats:
    """From the tip's force and moment and all weights, (6,) [N m, N].

    The shape enters through lever arms only; small rotations from midpoint to midpoint are plenty.
    """
    place, frame = leg.base_position, leg.base_rotation
    places, forces, rods = [], [], iter(strains)
    for element, index in leg.elements:
        value = 0.0 if index is None else float(values[index])
        if isinstance(element, RodModel):
            length = element.length if element.fed is None else value
            if element.fed is not None:
                places.append(place[None])
                forces.append((element.fed.nominal - length) * element.fed.force[None])
            along, frame = _rod_shape(element.element, next(rods), element.length, frame)
            sigma = (np.arange(_CELLS) + 0.5) / _CELLS
            places.append(place + length * along[:-1])
            forces.append(element.properties.force(sigma) * length / _CELLS)
            for part in element.parts:
                places.append(place + length * along[[int(part.begin * _CELLS)]])
                forces.append(part.push[None])
            place = place + length * along[-1]
        elif isinstance(element, Link):
            places.append((place + frame @ element.center_of_mass)[None])
            forces.append(element.mass * leg.gravity[None])
            place, frame = place + frame @ element.offset, frame @ element.rotation
        else:
            way = (element.zero + element.ratio * value) * np.array(element.axis)
            if isinstance(element, Turn):
                frame = frame @ Rotation.from_rotvec(way).as_matrix()
            else:
                place = place + frame @ way
    mu = values[leg.moments]
    couple = -mu @ tip_joint(leg, mu, rotation, frame).axes
    arms = np.vstack([*places, place[None]]) - leg.base_position
    pushes = np.vstack([*forces, tip_force[None]])
    return np.concatenate([couple + np.cross(arms, pushes).sum(axis=0), pushes.sum(axis=0)])


def _rod_shape(
    element: ChainRod, strain: Floats, nominal: float, frame: Floats
) -> tuple[Floats, Floats]:
    """Middles of the cells and the end, over the length, (cells + 1, 3); frame at the end."""
    sigma = (np.arange(_CELLS) + 0.5) / _CELLS
    curvature = (element.modes.values(sigma) * strain) @ np.eye(3)[element.modes.directions]
    middles, end = np.empty((_CELLS + 1, 3)), np.zeros(3)
    halves = Rotation.from_rotvec(0.5 * curvature * nominal / _CELLS).as_matrix()
    for cell, half in enumerate(halves):
        middle = frame @ half
        middles[cell] = end + 0.5 / _CELLS * middle[:, 0]
        end = end + middle[:, 0] / _CELLS
        frame = middle @ half
    middles[-1] = end
    return middles, frame

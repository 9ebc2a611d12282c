# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Assembling a robot: the tips of its legs are pulled into their joints by springs.

The tip joints of free rods are closed by springs of growing stiffness, and the energy of rods and
springs is brought to a minimum for every stiffness. Minima are stable equilibria, so what is found is
stable wherever a stable equilibrium exists; Newton's method on the model ends it, with the spring
forces as first multipliers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..blas_threads import on_one_numpy_thread
from ..description.loads import Loads
from ..kernels.kernel_arrays import LoadArrays
from ..kernels.square_problem import Configuration
from ..model.displacement import displaced
from ..model.equilibrium import Equilibrium
from ..model.model_state import ModelValue, configuration_of, evaluate
from ..model.robot import Robot
from ..model.shape import tip_poses
from .refining import refine
from .softest_side import softest_side

__all__ = [
    "assemble",
    "moved_shape",
    "settle",
    "turned_over",
    "with_best_multipliers",
]

Floats = NDArray[np.float64]

#: Stiffness of the springs, dimensionless (E J / l per unit gap), one after the other.
_SPRINGS = (1.0, 10.0, 100.0, 1e3, 1e4)
#: Steps of descent per stiffness, longest step (dimensionless), and where the gradient is small.
_DESCENTS, _LONGEST_DESCENT, _FLAT = 200, 0.5, 1e-6
#: Where it is small enough in a minimum that stiffer springs will move.
_NEARLY_FLAT = 1e-3
#: What is below this is rounding: of a gradient, and of an energy, relative.
_ROUNDING, _ENERGY_ROUNDING = 1e-9, 1e-12
#: Bits of the largest number of a step of descent.
_BITS = 20
#: Kicks off unstable equilibria.
_KICKS = 6


def with_best_multipliers(robot: Robot, loads: LoadArrays, shape: Configuration) -> Floats:
    """State (N,) of a shape with the multipliers that bring it nearest to equilibrium.

    The residual is linear in the multipliers: they are a least-squares solution.
    """
    arrays, columns = robot.kernel_arrays, robot.multiplier_indices
    state = shape.state.copy()
    state[columns] = 0.0
    value = evaluate(robot, loads, *shape._replace(state=state))
    rows = robot.moving_indices
    scale = arrays.unit[rows]
    slopes = scale[:, None] * value.tangent[np.ix_(rows, columns)] * arrays.unit[columns]
    forces = np.linalg.lstsq(slopes, -scale * value.residual[rows], rcond=None)[0]
    state[columns] = arrays.unit[columns] * forces
    return state


def assemble(robot: Robot, start: Configuration, loads: Loads, platform_held: bool) -> Equilibrium:
    """Close the joints of a robot and let it come to rest.

    Args:
        robot: The robot.
        start: Where to start from, its joints open.
        loads: Loads with a potential.
        platform_held: Hold the platform until the rods are in their joints, then let it go.

    Returns:
        The equilibrium, converged or not, stable or not: the caller has to look. What has not converged
        is the robot held by the springs alone.
    """
    shape, load_arrays = start, robot.load_arrays(loads)
    if platform_held:
        for stiffness in _SPRINGS[:4]:
            shape = _descended(
                robot, load_arrays, shape, stiffness, robot.elastic_indices, _NEARLY_FLAT
            )
    return settle(robot, shape, loads, _SPRINGS[3:] if platform_held else _SPRINGS)


def settle(
    robot: Robot, shape: Configuration, loads: Loads, springs: tuple[float, ...] = _SPRINGS[3:]
) -> Equilibrium:
    """Bring a shape to rest in a stable equilibrium, its joints closed by springs at first."""
    moving = robot.moving_indices
    found, load_arrays = None, robot.load_arrays(loads)
    for kick in range(_KICKS):
        for stiffness in springs:
            flat = _FLAT if stiffness == springs[-1] else _NEARLY_FLAT
            shape = _descended(robot, load_arrays, shape, stiffness, moving, flat)
        found = _closed(robot, loads, load_arrays, shape, springs[-1])
        if not found.converged or found.index_locked == 0:
            return found
        # A saddle: along its softest motion the energy falls, to the one side or the other.
        side = 0.3 if kick % 2 == 0 else -0.3
        whole, unit = found.spectrum_locked, robot.kernel_arrays.unit[moving]
        platform, axes = _own_axes(robot, moving)
        motions = whole.motions[moving] / unit[:, None]
        motions[platform] = axes.T @ motions[platform]
        kick_off = side * softest_side(whole.eigenvalues, motions)
        kick_off[platform] = axes @ kick_off[platform]
        shape = moved_shape(robot, configuration_of(found), moving, kick_off)
        springs = _SPRINGS[3:]
    assert found is not None
    return found


def turned_over(equilibrium: Equilibrium) -> str | None:
    """Name of a leg whose tip joint holds half a turn away from how it is built, if there is one."""
    tips = tip_poses(equilibrium.robot, equilibrium.state)
    for leg, tip in zip(equilibrium.robot.description.legs, tips, strict=True):
        if leg.joint.misalignment(equilibrium.platform_rotation, tip.rotation) > 0.5 * np.pi:
            return leg.name
    return None


def _closed(
    robot: Robot, loads: Loads, load_arrays: LoadArrays, shape: Configuration, stiffness: float
) -> Equilibrium:
    """Newton's method on the model from a shape with small gaps; where it fails, the shape itself.

    Where gaps cannot be closed Newton's method ends anywhere, which rounding decides: the shape of least
    energy tells where the robot does not fit.
    """
    place = shape._replace(state=_spring_state(robot, load_arrays, shape, stiffness))
    for iterations in (100, 0):
        found = refine(robot, loads, place, iterations=iterations, contraction=1.0)
        if found.converged:
            break
    return found


def _spring_state(
    robot: Robot, load_arrays: LoadArrays, shape: Configuration, stiffness: float
) -> Floats:
    """The state with spring forces as multipliers."""
    held, unit = robot.multiplier_indices, robot.kernel_arrays.unit
    state = shape.state.copy()
    state[held] = 0.0
    gaps = evaluate(robot, load_arrays, *shape._replace(state=state)).residual[held]
    # A gap times its multiplier's unit over the unit of energy is dimensionless.
    state[held] = stiffness * gaps * unit[held] ** 2 / robot.kernel_arrays.energy_unit
    return state


def _with_springs(
    robot: Robot, load_arrays: LoadArrays, shape: Configuration, stiffness: float
) -> tuple[float, ModelValue]:
    """Dimensionless energy of rods and springs, and the model with the spring forces."""
    state = _spring_state(robot, load_arrays, shape, stiffness)
    held, arrays = robot.multiplier_indices, robot.kernel_arrays
    value = evaluate(robot, load_arrays, *shape._replace(state=state))
    gaps = value.residual[held] * arrays.unit[held] / arrays.energy_unit
    return value.energy / arrays.energy_unit + 0.5 * stiffness * float(gaps @ gaps), value


@on_one_numpy_thread
def _descended(
    robot: Robot,
    load_arrays: LoadArrays,
    shape: Configuration,
    stiffness: float,
    moving: NDArray[np.int64],
    flat: float,
) -> Configuration:
    """Minimum of the energy of rods and springs, by Newton steps turned downhill along every axis.

    Steps are rounded along axes of the robot's own: how it stands in the world does not tell where it
    ends.
    """
    arrays, held = robot.kernel_arrays, robot.multiplier_indices
    platform, axes = _own_axes(robot, moving)
    unit, units = arrays.unit[moving], np.outer(arrays.unit, arrays.unit) / arrays.energy_unit
    within, across = np.ix_(moving, moving), np.ix_(held, moving)
    energy, value = _with_springs(robot, load_arrays, shape, stiffness)
    for _ in range(_DESCENTS):
        gradient = value.residual[moving] * unit / arrays.energy_unit
        tangent = value.tangent * units
        hessian, slopes = tangent[within], tangent[across]
        hessian = 0.5 * (hessian + hessian.T) + stiffness * slopes.T @ slopes
        hessian[platform] = axes.T @ hessian[platform]
        hessian[:, platform] = hessian[:, platform] @ axes
        gradient[platform] = axes.T @ gradient[platform]
        downhill = _downhill(hessian, gradient, flat)
        if downhill is None:
            break
        step = _coarse(downhill * min(1.0, _LONGEST_DESCENT / float(np.linalg.norm(downhill))))
        expected = 1e-4 * float(gradient @ step)
        step[platform] = axes @ step[platform]
        factor = 1.0
        while factor > 1e-6:
            trial = moved_shape(robot, shape, moving, factor * step)
            trial_energy, trial_value = _with_springs(robot, load_arrays, trial, stiffness)
            if trial_energy < energy + factor * expected + _ENERGY_ROUNDING * (1.0 + abs(energy)):
                break
            factor *= 0.25
        else:
            break
        shape, energy, value = trial, trial_energy, trial_value
    return shape


def _own_axes(robot: Robot, moving: NDArray[np.int64]) -> tuple[slice, Floats]:
    """Where the platform is among coordinates, and its axes: those of the first leg's base, columns."""
    count = len(moving) - len(robot.elastic_indices)
    turn = np.asarray(np.kron(np.eye(2), robot.description.legs[0].base_rotation), np.float64)
    axes = turn[np.ix_(robot.platform_axes, robot.platform_axes)][:count, :count]
    return slice(len(moving) - count, None), axes


def _downhill(hessian: Floats, gradient: Floats, flat: float) -> Floats | None:
    """Newton's step, turned downhill along every axis; None in a minimum.

    Args:
        hessian: Dimensionless.
        gradient: Dimensionless.
        flat: Largest entry of the gradient in a minimum.
    """
    steepest = float(np.abs(gradient).max())
    try:
        np.linalg.cholesky(hessian)
        if steepest < flat:
            return None
        return -np.asarray(np.linalg.solve(hessian, gradient))  # downhill as it is, and sooner
    except np.linalg.LinAlgError:  # not definite, or singular but for rounding
        pass
    curvatures, axes = np.linalg.eigh(hessian)
    along = axes.T @ gradient
    # On a ridge rounding would tell a side: none is taken until nothing else is left to do.
    along[(curvatures < 0.0) & (np.abs(along) < _ROUNDING)] = 0.0
    step = np.asarray(axes @ (-along / np.maximum(np.abs(curvatures), 1e-6)))
    if steepest >= _FLAT:
        return step
    if curvatures[0] > -_FLAT:
        return None
    downhill = -np.sign(along[0]) * axes[:, 0] if along[0] else softest_side(curvatures, axes)
    return np.asarray(step + downhill)  # off the saddle


def _coarse(step: Floats) -> Floats:
    """A step without its last digits.

    Where a robot snaps, what differs by rounding grows from step to step until it ends in another
    equilibrium. So the same step is taken for all of it.
    """
    quantum = 2.0 ** (np.frexp(np.abs(step).max())[1] - _BITS)
    return np.asarray(quantum * np.round(step / quantum))


def moved_shape(
    robot: Robot, shape: Configuration, moving: NDArray[np.int64], change: Floats
) -> Configuration:
    """A shape after a dimensionless change of some of its coordinates."""
    whole = np.zeros(len(shape.state))
    whole[moving] = change * robot.kernel_arrays.unit[moving]
    return displaced(robot, *shape, whole)

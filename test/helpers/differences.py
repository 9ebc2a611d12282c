# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Central differences of the model, and random states to take them at."""

from __future__ import annotations

import numpy as np
import pytest

from cpr_core import Loads
from cpr_core.kernels.kernel_arrays import LoadArrays
from cpr_core.lie import rotation_exp
from cpr_core.model.model_state import ModelValue, evaluate
from cpr_core.model.robot import Robot


def random_state(robot: Robot, rng: np.random.Generator):
    """A state far from equilibrium, of realistic size: strains fall with the mode number."""
    arrays = robot.kernel_arrays
    state = rng.normal(size=len(arrays.unit)) * arrays.unit
    for rod in robot.numbers.rods:
        order = np.concatenate([np.arange(count) for count in rod.element.modes.counts])
        state[rod.strain] /= 1.0 + order**2
    for rod in robot.fed_rods.rods:
        length = robot.mean_length * rng.uniform(0.7, 1.3)
        state[rod.length_index] = (length - rod.element.zero) / rod.element.ratio
    state[robot.platform_indices] = 0.0
    twist = np.zeros(6)
    twist[robot.platform_axes] = rng.normal(size=len(robot.platform_axes))
    return state, rotation_exp(twist[:3]), twist[3:]


def moved(robot: Robot, state, rotation, position, step):
    """A state moved by a vector in state order; the platform by small world motions."""
    twist = np.zeros(6)
    twist[robot.platform_axes] = step[robot.platform_indices]
    state = state + step
    state[robot.platform_indices] = 0.0
    return state, rotation_exp(twist[:3]) @ rotation, position + twist[3:]


def derivative(function, robot: Robot, point, index: int):
    """Derivative along one state, by a central difference of order four in its natural unit."""
    step = np.zeros(len(robot.kernel_arrays.unit))
    step[index] = 2e-3 * robot.kernel_arrays.unit[index]

    def at(multiple):
        return function(*moved(robot, *point, multiple * step))

    return (8.0 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12.0 * step[index])


def model_at(robot: Robot, loads: LoadArrays):
    """The model as a function of state, rotation and position."""

    def value(state, rotation, position) -> ModelValue:
        return evaluate(robot, loads, state, rotation, position)

    return value


def check_tangent(robot: Robot, loads: Loads) -> None:
    """The tangent is the derivative of the residual."""
    value = model_at(robot, robot.load_arrays(loads))
    point = random_state(robot, np.random.default_rng(7))
    unit = robot.kernel_arrays.unit
    exact = value(*point).tangent * unit[:, None] * unit
    columns = [
        derivative(lambda *p: value(*p).residual, robot, point, index) * unit * unit[index]
        for index in range(len(unit))
    ]
    np.testing.assert_allclose(
        np.transpose(columns), exact, rtol=0, atol=1e-7 * np.abs(exact).max()
    )


def check_residual(robot: Robot, loads: Loads) -> None:
    """The residual is the derivative of the Lagrangian."""
    value = model_at(robot, robot.load_arrays(loads))
    point = random_state(robot, np.random.default_rng(11))
    constraints = robot.multiplier_indices

    def lagrangian(state, rotation, position):
        found = value(state, rotation, position)
        return found.energy + found.residual[constraints] @ state[constraints]

    unit, exact = robot.kernel_arrays.unit, value(*point).residual
    scale = np.abs(exact * unit).max()
    for index in range(len(unit)):
        slope = derivative(lagrangian, robot, point, index) * unit[index]
        assert slope == pytest.approx(exact[index] * unit[index], abs=1e-7 * scale), index

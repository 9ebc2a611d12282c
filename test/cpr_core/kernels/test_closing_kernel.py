# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Joints that are closed by the smallest motions, against the same with numpy."""

import numpy as np
import pytest

from cpr_core import load_robot, solve_home
from cpr_core.kernels.closing_kernel import close_joints
from cpr_core.kernels.square_problem import Configuration
from cpr_core.lie import rotation_exp
from cpr_core.model.model_state import evaluate
from cpr_core.model.shape import tip_poses
from cpr_core.solving.assembly import moved_shape


def closed(robot, state, rotation, position):
    """Shape with its joints closed, by pseudoinverses."""
    arrays, held, moving = robot.kernel_arrays, robot.multiplier_indices, robot.moving_indices
    shape, forces = Configuration(state, rotation, position), robot.load_arrays(robot.default_loads)
    while True:
        value = evaluate(robot, forces, *shape)
        unit = arrays.unit[held] / arrays.energy_unit
        gaps = unit * value.residual[held]
        if np.abs(gaps).max() < 1e-3:
            return shape
        slopes = unit[:, None] * value.tangent[np.ix_(held, moving)] * arrays.unit[moving]
        step = -np.linalg.pinv(slopes) @ gaps
        step /= max(1.0, np.linalg.norm(step))
        shape = moved_shape(robot, shape, moving, step)


@pytest.mark.parametrize("name", ["rfrfr", "three_rfs", "six_rfs"])
def test_a_bent_shape_is_closed(name):
    robot, random = load_robot(name), np.random.default_rng(3)
    home, moving, joints = solve_home(robot), robot.elastic_indices, robot.multiplier_indices
    state = home.state.copy()
    state[moving] += 0.3 * robot.kernel_arrays.unit[moving] * random.normal(size=len(moving))
    turn = [0.0, 0.0, 0.3] if robot.planar else [0.2, -0.1, 0.3]
    rotation, position = rotation_exp(turn) @ home.platform_rotation, np.full(3, np.nan)
    tips = np.array([tip.position for tip in tip_poses(robot, state)])
    ends = np.array([leg.joint.position for leg in robot.description.legs]) @ rotation.T
    expected = closed(robot, state, rotation, np.mean(tips - ends, axis=0))

    states, legs = np.arange(robot.state_size), robot.numbers.legs
    forces = np.array([states[leg.forces] for leg in legs])
    loads = robot.load_arrays(robot.default_loads)
    assert close_joints(robot.prepared, loads, forces, joints.copy(), state, rotation, position)
    np.testing.assert_allclose(
        state[moving] / robot.kernel_arrays.unit[moving],
        expected.state[moving] / robot.kernel_arrays.unit[moving],
        rtol=0,
        atol=1e-8,
    )
    np.testing.assert_allclose(rotation, expected.platform_rotation, rtol=0, atol=1e-8)
    np.testing.assert_allclose(position, expected.platform_position, rtol=0, atol=1e-8)
    assert np.abs(state - home.state)[moving].max() > 1e-2
    np.testing.assert_array_equal(state[robot.motor_indices], home.motors)


def test_what_is_nowhere_is_not_closed():
    robot = load_robot("rfrfr")
    home, states = solve_home(robot), np.arange(robot.state_size)
    forces = np.array([states[leg.forces] for leg in robot.numbers.legs])
    state, rotation, position = np.full(robot.state_size, np.nan), np.eye(3), np.empty(3)
    held = robot.multiplier_indices.copy()
    assert not close_joints(
        robot.prepared, home.load_arrays, forces, held, state, rotation, position
    )

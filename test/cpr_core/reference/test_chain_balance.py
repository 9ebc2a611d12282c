# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Derivatives of the shooting of chains against differences, and the symmetry of their variations."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.chain_robots import CHAINS
from helpers.reference_robots import robot_with
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from cpr_core import Robot
from cpr_core.description import joints
from cpr_core.description.loads import DistributedForce, PointForce
from cpr_core.lie import skew
from cpr_core.reference.chain_balance import ChainPoint, chain_balance, variable_units
from cpr_core.reference.chain_robot import chain_robot
from cpr_core.reference.chain_steps import ChainState, node_cuts
from cpr_core.reference.shooting_method import ShootingMethod

METHOD = ShootingMethod(steps=16)
ACROSS = tuple(np.array([0.6, 0.0, 0.8]))
TIPS = {
    "spherical": lambda place: joints.Spherical(place),
    "fixed": lambda place: joints.Fixed(place, ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))),
    "revolute": lambda place: joints.RevoluteJoint(place, ACROSS, (0.0, 0.6, 0.8)),
    "universal": lambda place: joints.Universal(place, ACROSS, (0.0, 0.6, 0.8)),
}


def anywhere(chain, tip, nodes=0):
    """A robot of two legs under all loads, and a point that is no equilibrium; nodes in some rods."""
    robot = robot_with([chain, "motor"], modes=3)
    description = replace(robot.description, stations=(0.25, 0.5))
    legs = tuple(replace(leg, joint=TIPS[tip](leg.joint.position)) for leg in description.legs)
    robot = Robot(replace(description, legs=legs))
    loads = robot.default_loads.with_(
        gravity=[0.4, -0.2, -9.81],
        rod_force=[0.1, 0.2, -0.1],
        wrench_world=[0.2, 0.1, -0.3, 0.5, 0.2, -0.1],
        wrench_body=[0.1, -0.2, 0.2, 0.3, -0.4, 0.2],
        distributed=[
            DistributedForce("leg2", [0.0, 0.5, 1.0], [[0.5, 0, 0], [0, 0.9, 0.1], [0.2, 0, 0]])
        ],
        points=[PointForce("leg2", 0.25, [0.3, -0.2, 0.4])],
    )
    random = np.random.default_rng(len(chain))
    values = robot.numbers.unit * random.normal(size=robot.state_size)
    values[robot.motor_indices] = 0.5 + 0.1 * random.normal(size=robot.motor_count)
    wrenches = np.column_stack([0.2 * random.normal(size=(2, 3)), random.normal(size=(2, 3))])
    rotation = Rotation.from_rotvec(random.normal(size=3)).as_matrix()
    nodes = {
        (rod, 0.5): ChainState(
            random.normal(size=3),
            Rotation.from_rotvec(random.normal(size=3)).as_matrix(),
            0.2 * random.normal(size=3),
            random.normal(size=3),
        )
        for rod in range(nodes)
    }
    point = ChainPoint(values, wrenches, rotation, random.normal(size=3), nodes)
    return chain_robot(robot, loads, METHOD, node_cuts(nodes)), point


def moved(model, point, column, step):
    """The point with one of its variables moved by so many natural units."""
    robot, size = model.robot, model.robot.state_size
    twist, values, wrenches = np.zeros(6), point.values.copy(), point.wrenches.copy()
    nodes = {place: list(node) for place, node in point.nodes.items()}
    if column >= size + 12:
        node = list(nodes.values())[(column - size) // 12 - 1]
        part, axis = divmod((column - size) % 12, 3)
        change = step * variable_units(model, len(nodes))[column] * np.eye(3)[axis]
        if part == 1:
            node[part] = Rotation.from_rotvec(change).as_matrix() @ node[part]
        else:
            node[part] = node[part] + change
    elif column >= size:
        energy = robot.numbers.energy_unit
        unit = np.tile(np.repeat([energy, energy / robot.mean_length], 3), 2)
        wrenches = (wrenches.ravel() + step * unit * (np.arange(12) == column - size)).reshape(2, 6)
    elif column in robot.platform_indices:
        axis = robot.platform_axes[column - robot.platform_indices[0]]
        twist[axis] = step * robot.numbers.unit[column]
    else:
        values[column] += step * robot.numbers.unit[column]
    rotation = Rotation.from_rotvec(twist[:3]).as_matrix() @ point.rotation
    nodes = {place: ChainState(*node) for place, node in nodes.items()}
    return ChainPoint(values, wrenches, rotation, point.position + twist[3:], nodes)


@pytest.mark.parametrize(
    ("chain", "tip", "nodes"),
    [
        *((chain, "fixed", 0) for chain in CHAINS),
        *(("hub", tip, 0) for tip in TIPS),
        ("two rods", "fixed", 3),
        ("fed behind a rod", "fixed", 2),
    ],
)
def test_the_jacobian_is_the_derivative_of_the_residual(chain, tip, nodes):
    model, point = anywhere(chain, tip, nodes)
    balance, step = chain_balance(model, point), 1e-5
    strain = [
        i for leg in model.robot.numbers.legs for i in range(leg.strain.start, leg.strain.stop)
    ]
    for column in np.setdiff1d(np.arange(balance.jacobian.shape[1]), strain):
        above, below = (
            chain_balance(model, moved(model, point, column, sign)).residual
            for sign in (step, -step)
        )
        expected = (above - below) / (2 * step)
        scale = max(1.0, np.abs(expected).max())
        assert_allclose(balance.jacobian[:, column], expected, rtol=0.0, atol=1e-7 * scale)


def conjugate(moment):
    """From (dp, dtheta, dm, dn) to x = (dp, dtheta) and y = (dn, dm - dtheta x m / 2)."""
    matrix = np.eye(12)[[0, 1, 2, 3, 4, 5, 9, 10, 11, 6, 7, 8]]
    matrix[9:, 3:6] = 0.5 * skew(moment)
    return matrix


@pytest.mark.parametrize("chain", CHAINS)
def test_variations_of_every_element_are_conjugate(chain):
    """Work is mutual: T keeps x . y' - x' . y, and an effort answers as its coordinate acts."""
    model, point = anywhere(chain, "fixed")
    form = np.block([[np.zeros((6, 6)), np.eye(6)], [-np.eye(6), np.zeros((6, 6))]])
    for step in chain_balance(model, point).legs[0]:
        behind, before = conjugate(step.after.moment), conjugate(step.before.moment)
        transition = behind @ step.transition @ np.linalg.inv(before)
        kept = transition.T @ form @ transition
        assert_allclose(kept, form, rtol=0.0, atol=1e-9 * np.abs(transition).max() ** 2)
        if step.index is not None:
            row, column = step.row @ np.linalg.inv(before), behind @ step.column
            expected = (form @ column) @ transition
            assert_allclose(row, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())

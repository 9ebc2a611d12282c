# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The residual against the paper taken literally: Eq. (11) by a general ODE solver, Eqs. (15)-(32).

Quaternion, J_3, W and Q are integrated together; twists and wrenches are body vectors. The paper's
wrenches enter Eq. (10) with the sign of reactions, ours are what acts on the rods.
"""

from dataclasses import replace

import numpy as np
import pytest
from helpers.differences import random_state
from scipy.integrate import solve_ivp

from cpr_core import Loads, load_robot
from cpr_core.description import joints, motors
from cpr_core.lie import quaternion_from_rotation, rotation_exp, skew
from cpr_core.model.model_state import evaluate
from cpr_core.model.robot import Robot
from cpr_core.rods.rod import StrainModes

TILTED = tuple(np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5]))
FRAME = tuple(map(tuple, rotation_exp([0.3, -0.2, 0.5])))


def adjoint(rotation, position):
    """Ad_g = [R 0; p^ R, R]."""
    return np.block([[rotation, np.zeros((3, 3))], [skew(position) @ rotation, rotation]])


def rotation_of(h):
    w, x, y, z = h
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def quaternion_rate(curvature, h):
    """A(kappa) h / 2: the product of h and the pure quaternion kappa, halved."""
    w, v = h[0], h[1:]
    return 0.5 * np.concatenate([[-v @ curvature], w * curvature + np.cross(v, curvature)])


def integrate_leg(leg, strain, rotation, position, force_per_length):
    """Eq. (11) from base to tip: g(l), J_1(l), J_2(l), W and Q."""
    count = leg.modes.total
    stacked = np.zeros((6, 3))
    stacked[:3] = np.eye(3)  # B
    base = adjoint(rotation, position)

    def shape(s):
        row = leg.modes.values(np.array([s / leg.rod.length]))[0]
        return np.eye(3)[leg.modes.directions].T * row

    def rates(s, y):
        h, p = y[:4], y[4:7]
        j3 = y[7 : 7 + 6 * count].reshape(6, count)
        turn = rotation_of(h)
        phi = shape(s)
        section_adjoint = adjoint(turn, p)
        wrench = np.concatenate([np.zeros(3), turn.T @ force_per_length])
        carried = np.linalg.solve(section_adjoint.T, wrench)
        return np.concatenate(
            [
                quaternion_rate(phi @ strain, h),
                turn[:, 0],
                (section_adjoint @ stacked @ phi).ravel(),
                base.T @ carried,
                j3.T @ carried,
            ]
        )

    start = np.zeros(7 + 7 * count + 6)
    start[:4], start[4:7] = quaternion_from_rotation(rotation), position
    end = solve_ivp(rates, (0.0, leg.rod.length), start, method="DOP853", rtol=1e-12, atol=1e-13)
    y = end.y[:, -1]
    tip_rotation, tip = rotation_of(y[:4]), y[4:7]
    inverse = np.linalg.inv(adjoint(tip_rotation, tip))
    j3 = y[7 : 7 + 6 * count].reshape(6, count)
    w_bar, q_bar = y[7 + 6 * count : 13 + 6 * count], y[13 + 6 * count :]
    return tip_rotation, tip, inverse @ base, inverse @ j3, w_bar, q_bar


def literal_residual(robot, loads, state, platform_rotation, platform_position):
    """Eq. (32) leg by leg, in the order and the frames of the library."""
    result = np.zeros(len(state))
    platform = np.zeros(6)
    for numbers, leg in zip(robot.numbers.legs, robot.description.legs, strict=True):
        strain = state[numbers.strain]
        rotation, position, motor_twist, index = leg.base_rotation, leg.base_position, None, -1
        if isinstance(leg.motor, motors.RevoluteMotor):
            index = numbers.coordinates[0]
            rotation = rotation_exp(np.array(leg.motor.axis) * state[index]) @ rotation
            motor_twist = np.concatenate([rotation.T @ leg.motor.axis, np.zeros(3)])
        elif isinstance(leg.motor, motors.Prismatic):
            index = numbers.coordinates[0]
            position = position + np.array(leg.motor.axis) * state[index]
            motor_twist = np.concatenate([np.zeros(3), rotation.T @ leg.motor.axis])
        density = leg.rod.mass_per_length * loads.gravity + loads.rod_force
        tip_rotation, tip, j1, j2, w_bar, q_bar = integrate_leg(
            leg, strain, rotation, position, density
        )

        multipliers = state[numbers.forces.start :]
        force, arm = multipliers[:3], platform_rotation @ leg.joint.position
        row = numbers.forces.start
        result[row : row + 3] = platform_position + arm - tip  # Eq. (15)
        moment = np.zeros(3)
        if isinstance(leg.joint, joints.Fixed):
            wanted = platform_rotation @ np.array(leg.joint.frame)
            relative = wanted.T @ tip_rotation
            # Eq. (16), halved and in the axes of the joint.
            result[row + 3 : row + 6] = [
                0.5 * (relative[2, 1] - relative[1, 2]),
                0.5 * (relative[0, 2] - relative[2, 0]),
                0.5 * (relative[1, 0] - relative[0, 1]),
            ]
            for axis in range(3):
                half = 0.5 * skew(np.eye(3)[axis])
                lever = sum(np.cross(tip_rotation[:, j], (wanted @ half)[:, j]) for j in range(3))
                moment -= multipliers[3 + axis] * lever
        tip_wrench = np.concatenate([tip_rotation.T @ moment, tip_rotation.T @ force])
        stiffness = leg.rod.stiffness(leg.modes, robot.grid)
        span = numbers.strain
        result[span] = stiffness @ strain - q_bar - j2.T @ tip_wrench  # Eq. (34)
        if motor_twist is not None:
            result[index] = -motor_twist @ (w_bar + j1.T @ tip_wrench)  # Eq. (33)
        platform += np.concatenate([moment + np.cross(arm, force), force])  # Eqs. (26)-(27)
    weight = robot.description.platform_mass * loads.gravity
    center = platform_rotation @ robot.description.center_of_mass
    platform[:3] -= loads.wrench_world[:3] + np.cross(center, weight)
    platform[3:] -= loads.wrench_world[3:] + weight
    result[robot.platform_indices] = platform
    return result


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(
    "motor", [motors.RevoluteMotor(TILTED), motors.Prismatic(TILTED), motors.Welded()], ids=repr
)
@pytest.mark.parametrize(
    "joint", [joints.Spherical((0.1, -0.05, 0.02)), joints.Fixed((0.1, -0.05, 0.02), FRAME)]
)
def test_residual_is_the_papers(motor, joint, seed):
    description = load_robot("six_rfs").description
    legs = tuple(
        replace(
            leg,
            motor=motor,
            joint=joint,
            drive=leg.drive if motor.actuated else motors.UNDRIVEN,
            modes=StrainModes((2, 4, 3)),
        )
        for leg in description.legs[:2]
    )
    robot = Robot(
        replace(
            description,
            legs=legs,
            platform_mass=0.2,
            center_of_mass=np.array([0.01, -0.02, 0.03]),
        )
    )
    loads = Loads.none().with_(
        gravity=[1.0, -2.0, -9.0],
        rod_force=[0.2, 0.1, -0.1],
        wrench_world=[0.1, 0.2, -0.1, 0.3, -0.4, 0.5],
    )
    point = random_state(robot, np.random.default_rng(seed))
    ours = evaluate(robot, robot.load_arrays(loads), *point).residual
    paper = literal_residual(robot, loads, *point)
    unit = robot.kernel_arrays.unit
    np.testing.assert_allclose(
        ours * unit, paper * unit, rtol=0, atol=1e-8 * np.abs(paper * unit).max()
    )

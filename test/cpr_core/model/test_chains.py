# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Legs that are chains, against differences: every element, alone and with others."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.differences import derivative, model_at, random_state

from cpr_core import Loads, load_robot
from cpr_core.description import joints
from cpr_core.description.chain import ChainRod, Link, Shift, Turn
from cpr_core.lie import rotation_exp
from cpr_core.model.robot import Robot
from cpr_core.rods.rod import StrainModes

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
TILTED = tuple(np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5]))
ACROSS = tuple(np.array([-0.4, 0.3, 1.0]) / np.linalg.norm([-0.4, 0.3, 1.0]))
BENT = rotation_exp([0.3, -0.2, 0.5])


def rod(length=0.6, counts=(1, 2, 3), stiffer=1.0, motor=None):
    of_robot = load_robot("six_rfs").description.legs[0].rod
    modulus = stiffer * of_robot.young_modulus, stiffer * of_robot.shear_modulus
    described = replace(of_robot, length=length, young_modulus=modulus[0], shear_modulus=modulus[1])
    return ChainRod(described, StrainModes(counts), motor)


MOTOR = Turn(TILTED, "motor")
#: Every element behind a motor and before a rod; then several of them, and more rods.
CHAINS = {
    "motor": [MOTOR, rod()],
    "nothing but a rod": [rod()],
    "zero and ratio": [replace(MOTOR, ratio=-2.5, zero=0.4), rod()],
    "sprung motor": [MOTOR, Turn(TILTED, None, stiffness=3.0, rest=0.2), rod()],
    "passive turn": [MOTOR, Turn(ACROSS), rod()],
    "passive shift": [MOTOR, Shift(ACROSS, None, zero=0.1), rod()],
    "sprung shift": [MOTOR, Shift(ACROSS, None, stiffness=40.0, rest=-0.1), rod()],
    "driven shift": [Shift(TILTED, "motor", zero=0.2), rod()],
    "hub": [MOTOR, Link((0.03, 0.02, -0.01)), rod()],
    "bent hub": [MOTOR, Link((0.03, 0.02, -0.01), BENT), rod()],
    "heavy hub": [MOTOR, Link((0.03, 0.02, -0.01), BENT, 0.2, (0.01, 0.03, 0.02)), rod()],
    "end piece": [MOTOR, rod(), Link((0.02, 0.0, 0.01), BENT, 0.05, (0.01, 0.0, 0.0))],
    "universal": [MOTOR, Link((0.1, 0.0, 0.0)), Turn(Y), Turn(Z), rod()],
    "two rods": [MOTOR, rod(0.3, (1, 2, 2)), rod(0.4, (0, 2, 3), 3.0)],
    "rigid middle": [MOTOR, rod(0.3), Link((0.1, 0.0, 0.0), BENT, 0.1), rod(0.4, (1, 1, 2), 2.0)],
    "joint between rods": [MOTOR, rod(0.3), Turn(ACROSS, None, stiffness=0.5), rod(0.4)],
    "joint behind the rod": [MOTOR, rod(), Turn(ACROSS), Link((0.05, 0.0, 0.0))],
    "motor at the far end": [rod(), Turn(ACROSS, "motor"), Link((0.05, 0.0, 0.02))],
    "two motors": [MOTOR, Turn(ACROSS, "second motor"), rod()],
    "one motor twice": [MOTOR, rod(0.4), Turn(ACROSS, "motor", ratio=-0.5), rod(0.3)],
    "fed behind a joint": [Turn(ACROSS), rod(0.6, (1, 2, 2), 1.0, "motor")],
    "fed and turned": [
        MOTOR,
        Link((0.05, 0, 0)),
        rod(0.6, (1, 2, 2), 1.0, "feed"),
        Link((0.03, 0, 0)),
    ],
    "fed behind a rod": [rod(0.3), Turn(ACROSS), rod(0.5, (1, 2, 2), 1.0, "motor"), Turn(TILTED)],
    "crank and universal": [
        Turn((0.0, -1.0, 0.0), "motor"),
        Link((0.1, 0.0, 0.0), np.eye(3), 0.02, (0.05, 0.0, 0.0)),
        Turn(Y, None, stiffness=0.1, rest=0.2),
        Turn(Z),
        rod(0.4),
        Link((0.02, 0.0, 0.0), np.eye(3), 0.005),
    ],
    "no rod": [MOTOR, Link((0.1, 0.0, 0.0)), Turn(Y), Turn(Z), Link((0.3, 0.0, 0.0))],
}
TIPS = {
    "spherical": joints.Spherical((0.1, -0.05, 0.02)),
    "fixed": joints.Fixed((0.1, -0.05, 0.02), tuple(map(tuple, BENT))),
}
LOADS = {
    "none": Loads.none(),
    "gravity": Loads.none().with_(gravity=[1.0, -9.0, 3.0]),
}


def beside(chain):
    """Two legs, of which one has a rod."""
    return [chain, "motor" if chain == "no rod" else chain]


def named(element, leg, shared):
    """An element whose motor is the leg's own, or that of all legs."""
    motor = getattr(element, "motor", None)
    if motor is None:
        return element
    return replace(element, motor=motor if shared else f"{motor} of {leg.name}")


def robot_of(chains, tip="spherical", shared=False):
    """The paper's robot with chains for legs, and a heavy platform."""
    description = load_robot("six_rfs").description
    legs = tuple(
        replace(
            leg,
            joint=TIPS[tip],
            elements=tuple(named(element, leg, shared) for element in CHAINS[chain]),
        )
        for leg, chain in zip(description.legs, chains, strict=False)
    )
    middle = np.array([0.02, -0.03, 0.05])
    return Robot(replace(description, legs=legs, platform_mass=0.3, center_of_mass=middle))


def check_tangent(robot, loads, seed=7):
    value = model_at(robot, robot.load_arrays(loads))
    point = random_state(robot, np.random.default_rng(seed))
    unit = robot.arrays.unit
    exact = value(*point).tangent * unit[:, None] * unit
    for index in range(len(unit)):
        column = derivative(lambda *p: value(*p).residual, robot, point, index)
        np.testing.assert_allclose(
            column * unit * unit[index],
            exact[:, index],
            rtol=0,
            atol=1e-7 * np.abs(exact).max(),
            err_msg=f"column {index}",
        )


def check_residual(robot, loads, seed=11):
    value = model_at(robot, robot.load_arrays(loads))
    point = random_state(robot, np.random.default_rng(seed))
    constraints = robot.multiplier_indices

    def lagrangian(state, rotation, position):
        found = value(state, rotation, position)
        return found.energy + found.residual[constraints] @ state[constraints]

    unit, exact = robot.arrays.unit, value(*point).residual
    scale = np.abs(exact * unit).max()
    for index in range(len(unit)):
        slope = derivative(lagrangian, robot, point, index) * unit[index]
        assert slope == pytest.approx(exact[index] * unit[index], abs=1e-7 * scale), index


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("tip", TIPS)
@pytest.mark.parametrize("chain", CHAINS)
def test_tangent_is_the_derivative_of_the_residual(chain, tip, load):
    check_tangent(robot_of(beside(chain), tip), LOADS[load])


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("chain", CHAINS)
def test_residual_is_the_derivative_of_the_lagrangian(chain, load):
    check_residual(robot_of(beside(chain), "fixed"), LOADS[load])


ALL_DIFFERENT = ["two rods", "crank and universal", "one motor twice", "end piece", "motor", "hub"]


@pytest.mark.parametrize("shared", [False, True])
def test_legs_of_different_structure_and_motors_they_share(shared):
    robot = robot_of(ALL_DIFFERENT, "fixed", shared)
    check_tangent(robot, LOADS["gravity"])
    check_residual(robot, LOADS["gravity"])

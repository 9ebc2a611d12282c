# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Residual and tangent of the model against differences, for every motor, tip joint and load."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.differences import check_residual, check_tangent

from cpr_core import Loads, load_robot, solve_forward, solve_home
from cpr_core.description import joints, motors
from cpr_core.description.loads import DistributedForce, PointForce
from cpr_core.lie import rotation_exp
from cpr_core.model.robot import Robot
from cpr_core.rods.rod import StrainModes

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
TILTED = tuple(np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5]))

SPATIAL_MOTORS = {
    "revolute": motors.RevoluteMotor(TILTED),
    "prismatic": motors.Prismatic(TILTED),
    "extensible": motors.Extensible(),
    "extensible spinning": motors.Extensible(spin=True),
    "hinge": motors.Hinge(TILTED),
    "welded": motors.Welded(),
}
SPATIAL_TIPS = {
    "spherical": joints.Spherical((0.1, -0.05, 0.02)),
    "fixed": joints.Fixed((0.1, -0.05, 0.02), tuple(map(tuple, rotation_exp([0.3, -0.2, 0.5])))),
    "revolute": joints.RevoluteJoint((0.1, -0.05, 0.02), TILTED, Y),
    "universal": joints.Universal((0.1, -0.05, 0.02), X, TILTED),
}
PLANAR_MOTORS = {
    "revolute": motors.RevoluteMotor(Z),
    "prismatic": motors.Prismatic((0.6, 0.8, 0.0)),
    "extensible": motors.Extensible(),
    "hinge": motors.Hinge(Z),
    "welded": motors.Welded(),
}
PLANAR_TIPS = {
    "revolute": joints.RevoluteJoint((0.1, -0.05, 0.0)),
    "fixed": joints.Fixed((0.1, -0.05, 0.0)),
}


def robot_of(planar, motor, tip, counts):
    """The paper's robot with another motor and tip on every leg, and a heavy platform."""
    description = load_robot("rfrfr" if planar else "six_rfs").description
    legs = tuple(
        replace(
            leg,
            motor=motor,
            joint=tip,
            drive=leg.drive if motor.actuated else motors.UNDRIVEN,
            modes=StrainModes(counts),
        )
        for leg in description.legs[:2]
    )
    return Robot(
        replace(
            description,
            legs=legs,
            point_platform=False,
            platform_mass=0.3,
            center_of_mass=np.array([0.02, -0.03, 0.0 if planar else 0.05]),
            stations=(0.35, 0.7),  # three panels
        )
    )


LOADS = {
    "none": lambda planar: Loads.none(),
    "gravity": lambda planar: Loads.none().with_(gravity=[1.0, -9.0, 0.0 if planar else 3.0]),
    "rod force": lambda planar: Loads.none().with_(rod_force=[0.3, 0.2, 0.0 if planar else -0.4]),
    "wrench in space": lambda planar: Loads.none().with_(
        wrench_world=[0, 0, 0.2, 0.3, -0.4, 0] if planar else [0.1, -0.2, 0.2, 0.3, -0.4, 0.5]
    ),
    "point forces": lambda planar: Loads.none().with_(
        points=[
            PointForce("leg1", 0.35, np.array([0.2, -0.3, 0.0 if planar else 0.4])),
            PointForce("leg2", 0.35, np.array([-0.1, 0.2, 0.0])),
        ]
    ),
    "varying force": lambda planar: Loads.none().with_(
        distributed=[
            DistributedForce(
                "leg1",
                np.array([0.0, 0.35, 1.0]),
                np.array([[0.1, 0.5, 0.0], [-0.4, 0.2, 0.0], [0.0, 0.3, 0.0 if planar else 0.6]]),
            )
        ]
    ),
    "force that adds up to nothing": lambda planar: Loads.none().with_(
        distributed=[
            DistributedForce(
                "leg1", np.array([0.0, 1.0]), np.array([[0.4, -0.3, 0.0], [-0.4, 0.3, 0.0]])
            )
        ]
    ),
    "following wrench": lambda planar: Loads.none().with_(
        wrench_body=[0, 0, 0.2, 0.3, -0.4, 0] if planar else [0.1, -0.2, 0.2, 0.3, -0.4, 0.5]
    ),
}

CASES = [
    pytest.param(False, motor, tip, (2, 3, 4), id=f"spatial-{m}-{t}")
    for m, motor in SPATIAL_MOTORS.items()
    for t, tip in SPATIAL_TIPS.items()
] + [
    pytest.param(True, motor, tip, (0, 0, 4), id=f"planar-{m}-{t}")
    for m, motor in PLANAR_MOTORS.items()
    for t, tip in PLANAR_TIPS.items()
]


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize(("planar", "motor", "tip", "counts"), CASES)
def test_tangent_is_the_derivative_of_the_residual(planar, motor, tip, counts, load):
    check_tangent(robot_of(planar, motor, tip, counts), LOADS[load](planar))


@pytest.mark.parametrize("load", ["none", "gravity", "rod force", "point forces", "varying force"])
@pytest.mark.parametrize(("planar", "motor", "tip", "counts"), CASES)
def test_residual_is_the_derivative_of_the_lagrangian(planar, motor, tip, counts, load):
    check_residual(robot_of(planar, motor, tip, counts), LOADS[load](planar))


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs"])
def test_tangent_is_symmetric_at_a_loaded_equilibrium(name):
    robot = load_robot(name)
    gravity = [0, -9.81, 0] if robot.planar else [0, 0, -9.81]
    loads = Loads.none().with_(gravity=gravity, wrench_world=[0, 0, 0, 0.05, -0.1, 0])
    unit = robot.kernel_arrays.unit
    tangent = solve_forward(robot, solve_home(robot).motors, loads=loads).tangent
    tangent = tangent * unit[:, None] * unit
    np.testing.assert_allclose(tangent, tangent.T, atol=1e-11 * np.abs(tangent).max())

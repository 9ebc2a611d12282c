# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Derivatives of equilibria by parameters against full solves of robots with other parameters."""

import numpy as np
import pytest
import yaml
from helpers.compared_derivatives import STATE, compared, equilibrium_of, problems_of
from helpers.parameter_kinds import parameter_kinds, with_loads
from helpers.shipped_steps import STEPS
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose, assert_array_equal

from cpr_core import (
    CprError,
    InvalidRequest,
    Robot,
    continued,
    derivatives,
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.description.description_file import shipped_robots
from cpr_core.kernels.condensation_kernel import DELAYED
from cpr_core.lie import angle_motions

#: A straight rod, welded to the ground and to the platform.
COLUMN = """
name: column
space: planar
rod: {length: 0.5, section: {shape: circular, radius: 0.001}, young_modulus: 210e9, shear_modulus: 82e9}
strain: {bending_3: 6}
platform: {shape: body}
legs:
- base: {position: [0, 0, 0], tangent: [1, 0, 0]}
  motor: {type: welded}
  tip: {type: fixed, position: [0, 0, 0], tangent: [1, 0, 0]}
controlled: []
home: {motors: [], platform: {position: [0.5, 0, 0]}}
"""


@pytest.mark.parametrize("name", shipped_robots())
def test_state_derivatives_are_those_of_full_solves(name):
    """Every kind of parameter, the three problems in turn; one that all robots have in all of them."""
    equilibrium, seen = equilibrium_of(name), 0
    problems = problems_of(name)
    for number, path in enumerate(parameter_kinds(equilibrium.robot)):
        asked = (
            problems
            if path in ("rod.length", "loads.platform_force[0]")
            else [problems[number % len(problems)]]
        )
        for problem in asked:
            try:
                seen += compared(equilibrium, path, problem, STATE)
            except CprError as error:
                assert "planar" in str(error), path
    assert seen > 18


def test_a_wildcard_is_the_sum_over_the_legs():
    equilibrium = equilibrium_of("six_rfs")
    single = [f"legs[{leg}].base.position[1]" for leg in range(6)]
    for problem in problems_of("six_rfs"):
        every = derivatives(equilibrium, "legs[*].base.position[1]", problem=problem)
        parts = derivatives(equilibrium, single, problem=problem)
        assert every.parameters == ("legs[*].base.position[1]",)
        for name in STATE:
            expected = getattr(parts, name).sum(axis=1, keepdims=True)
            assert_allclose(getattr(every, name), expected, rtol=1e-8, atol=1e-9)


def test_several_legs_are_the_sum_over_these():
    """The zero of a crank that moves two legs is its motor."""
    equilibrium = equilibrium_of("delta")
    single = [f"legs[{leg}].chain[0].offset" for leg in range(6)]
    cranks = [f"legs[{leg},{leg + 1}].chain[0].offset" for leg in (0, 2, 4)]
    for problem in problems_of("delta"):
        found = derivatives(equilibrium, cranks, problem=problem)
        parts = derivatives(equilibrium, single, problem=problem)
        assert found.parameters == tuple(cranks)
        for name in STATE:
            expected = getattr(parts, name).reshape(-1, 3, 2).sum(axis=2)
            assert_allclose(getattr(found, name), expected, rtol=1e-7, atol=1e-8)
    by_motor = kinemato_statics(equilibrium).jacobian
    found = derivatives(equilibrium, cranks)
    assert_allclose(found.twist_body, by_motor, rtol=1e-7, atol=1e-8)


def test_the_zero_of_a_motor_is_the_motor():
    """With the motors held; the Jacobian is in the axes of the platform, and so is ``twist_body``."""
    equilibrium = equilibrium_of("six_rfs")
    model = kinemato_statics(equilibrium)
    offsets = [f"legs[{leg}].motor.offset" for leg in range(6)]
    found = derivatives(equilibrium, offsets)
    assert_allclose(found.twist_body, model.jacobian, rtol=1e-8, atol=1e-9)
    assert_allclose(found.efforts, model.efforts_by_motors, rtol=1e-7, atol=1e-9)
    assert_array_equal(found.motors, np.zeros((6, 6)))
    assert np.abs(found.rotation - found.twist_body[:3]).max() > 0.1
    held = derivatives(equilibrium, offsets, problem="pose")
    assert_allclose(held.motors, -np.eye(6), rtol=1e-8, atol=1e-8)
    assert np.abs(held.twist_body).max() < 1e-9


def test_a_force_on_the_platform_is_a_wrench():
    equilibrium = equilibrium_of("three_rfs")
    model, turn = kinemato_statics(equilibrium), equilibrium.platform_rotation
    forces = [f"loads.platform_force[{axis}]" for axis in range(3)]
    found = derivatives(equilibrium, forces)
    assert_allclose(
        found.twist_body, model.platform_by_wrench[:, 3:] @ turn.T, rtol=1e-8, atol=1e-12
    )
    assert_allclose(found.efforts, model.efforts_by_wrench[:, 3:] @ turn.T, rtol=1e-8, atol=1e-10)


def test_what_moves_with_the_whole_robot():
    """All bases shifted: the platform shifts, motors and efforts do not notice."""
    equilibrium = equilibrium_of("gough_stewart")
    found = derivatives(equilibrium, "legs[*].base.position[2]")
    assert_allclose(found.position[:, 0], [0.0, 0.0, 1.0], rtol=0.0, atol=1e-7)
    assert np.abs(found.rotation).max() < 1e-7
    assert np.abs(found.efforts).max() < 1e-6


def test_with_a_motor_held_beside_the_pose():
    """Redundant motors: the one more than the pose needs stays where it is."""
    robot = with_loads(load_robot("four_rfr")).holding((2,))
    free = equilibrium_of("four_rfr")
    equilibrium = solve_forward(robot, free.motors)
    found = derivatives(equilibrium, "rod.length", problem="pose")
    assert found.motors[2] == 0.0
    assert np.abs(found.position).max() < 1e-9
    assert np.abs(found.motors).max() > 0.1


def test_single_angles_are_held_as_they_are_controlled():
    """Pitch and yaw, which are no turns about axes of the world once there is any yaw."""
    content = yaml.safe_load(load_robot("three_prs").description.text)
    robot = load_robot(content | {"controlled": ["z", "pitch", "yaw"]})
    equilibrium = solve_forward(robot, solve_home(robot).motors + np.array(STEPS["three_prs"]))
    found = derivatives(equilibrium, "legs[0].tip.position[1]", problem="pose")
    rates = np.linalg.solve(angle_motions(equilibrium.platform_rotation), found.rotation[:, 0])
    assert abs(rates[0]) > 1.0
    assert_allclose(rates[1:], 0.0, rtol=0.0, atol=1e-9 * abs(rates[0]))
    assert abs(found.rotation[1, 0]) > 1e-4 * abs(rates[0])
    assert abs(found.position[2, 0]) < 1e-9


def test_rods_without_a_load_notice_the_first_one():
    """Kernels leave loads on rods out where there are none."""
    equilibrium = solve_home(load_robot("six_rfs"))
    assert not equilibrium.load_arrays.on_rods[0]
    for path in ("gravity[2]", "loads.rod_force[2]"):
        for problem in problems_of("six_rfs"):
            assert compared(equilibrium, path, problem, STATE)
    assert np.abs(derivatives(equilibrium, "gravity[2]").position).max() > 1e-4


def test_where_no_factors_are_kept():
    """A straight rod under no force is not eliminated on its own: its tangent is evaluated again."""
    home = solve_home(load_robot(COLUMN))
    assert home.factors["lane"][0, 0] == DELAYED
    forces = [f"loads.platform_force[{axis}]" for axis in range(2)]
    found, model = derivatives(home, forces), kinemato_statics(home)
    assert found.position[1, 1] > 1e-3
    assert_allclose(found.twist_body[[2, 3, 4]], model.platform_by_wrench[:, 1:], atol=1e-10)


def test_strain_modes_are_those_of_the_robot():
    """Also where they are not those of the file."""
    coarse, fine = load_robot("six_rfs", modes=3), load_robot("six_rfs", modes=7)
    assert isinstance(coarse, Robot)
    found = [derivatives(solve_home(robot), "rod.length").position for robot in (coarse, fine)]
    assert_allclose(found[0], found[1], rtol=0.05)
    assert np.abs(found[0] - found[1]).max() > 1e-6


def test_where_forces_may_act_is_not_varied_and_where_they_do_is():
    """A station that moves alone moves the nodes: what differed was the error of the quadrature."""
    content = shipped_content("rfrfr")
    content["stations"] = [0.3]
    content["rod"]["profile"] = {"at": [0.0, 0.45, 1.0], "stiffness": [1.0, 1.3, 1.1]}
    content["loads"] = {
        "points": [{"leg": "leg1", "at": 0.6, "force": [2.0, 1.0, 0.0]}],
        "distributed": [
            {"leg": "leg2", "at": [0.0, 0.7, 1.0], "force": [[0, 0, 0], [3, 1, 0], [0, 0, 0]]}
        ],
    }
    robot = load_robot(content)
    home = solve_home(robot)
    for path in ("stations[0]", "stations[*]"):
        with pytest.raises(InvalidRequest, match=r"stations.* cannot be varied: the quadrature"):
            derivatives(home, [path, "rod.young_modulus"])
    for path in ("rod.profile.at[1]", "loads.points[0].at", "loads.distributed[0].at[1]"):
        at = robot.parameter_values(path)[0]
        ahead, behind = (
            continued(home, robot.with_parameters({path: at + way})).platform_position
            for way in (1e-4, -1e-4)
        )
        slope = (ahead - behind) / 2e-4
        assert np.linalg.norm(slope) > 1e-4
        found = derivatives(home, path).position[:, 0]
        assert_allclose(found, slope, rtol=0.0, atol=1e-3 * np.linalg.norm(slope))

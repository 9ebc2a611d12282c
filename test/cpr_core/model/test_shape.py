# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Leg shapes: they start at the motors, end at the platform and are as long as the rods."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.shipped_steps import CHAINS
from helpers.yaml_content import shipped_content

from cpr_core import InvalidRequest, Robot, leg_shapes, load_robot, solve_forward, solve_home
from cpr_core.description import joints


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs"])
def test_legs_join_base_and_platform(name):
    robot = load_robot(name)
    equilibrium = solve_forward(robot, solve_home(robot).motors + 0.1)
    for leg, shape in zip(robot.description.legs, leg_shapes(equilibrium, 40), strict=True):
        np.testing.assert_allclose(shape.position[0], leg.base_position)
        tip = equilibrium.platform_position + equilibrium.platform_rotation @ leg.joint.position
        np.testing.assert_allclose(shape.position[-1], tip, atol=1e-9)
        assert shape.arc_length[-1] == leg.rod.length
        steps = np.linalg.norm(np.diff(shape.position, axis=0), axis=1)
        assert np.all(steps <= np.diff(shape.arc_length) * (1 + 1e-12))
        assert steps.sum() == pytest.approx(leg.rod.length, rel=2e-3)
        for rotation in shape.rotation:
            np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-12)


def test_curvature_is_the_turning_of_the_tangent():
    equilibrium = solve_home(load_robot("rfrfr"))
    shape = leg_shapes(equilibrium, 200)[0]
    angle = np.unwrap(np.arctan2(shape.rotation[:, 1, 0], shape.rotation[:, 0, 0]))
    slope = np.gradient(angle, shape.arc_length)
    np.testing.assert_allclose(slope[20:-20], shape.curvature[20:-20, 2], rtol=1e-3, atol=1e-3)


def test_a_shape_is_told_in_a_line():
    shape = leg_shapes(solve_home(load_robot("six_rfs")), 200)[0]
    assert repr(shape) == "<LegShape: 200 points along 1 m, joints revolute spherical>"


@pytest.mark.parametrize("points", [1, 0, -1, 4.5, "many", 1001])
def test_too_few_points_and_too_many_are_refused(points):
    with pytest.raises(InvalidRequest, match="points"):
        leg_shapes(solve_home(load_robot("rfrfr")), points)


@pytest.mark.parametrize("name", ["rfrfr", "four_rfr", "gough_stewart", "six_rfs"])
def test_the_fewest_points_lead_to_the_platform_too(name):
    """Four missed it by centimetres, without a word."""
    robot = load_robot(name)
    equilibrium = solve_forward(robot, solve_home(robot).motors + 0.05 * robot.motor_units)
    for leg, shape in zip(robot.description.legs, leg_shapes(equilibrium, 2), strict=True):
        tip = equilibrium.platform_position + equilibrium.platform_rotation @ leg.joint.position
        np.testing.assert_allclose(shape.position[-1], tip, atol=1e-9)
        assert np.sum(shape.rod == 0) == 2


SPLINES = shipped_content("six_rfs") | {
    "strain": {"basis": "bsplines", "degree": 2, "knots": [0.3]}
}


@pytest.mark.parametrize("described", ["rfrfr", "six_rfs", "three_rfs", "six_rus", SPLINES])
def test_points_are_where_they_are_however_many_there_are(described):
    """Of twelve, those between the ends were off by a hundredth of a millimetre, without a word."""
    robot = load_robot(described)
    equilibrium = solve_forward(robot, solve_home(robot).motors + 0.1 * robot.motor_units)
    shapes = zip(leg_shapes(equilibrium, 4), leg_shapes(equilibrium, 400), strict=True)
    for few, many in shapes:
        for rod in range(few.rod.max() + 1):
            some, third = few.rod == rod, np.flatnonzero(many.rod == rod)[::133]
            np.testing.assert_allclose(few.position[some], many.position[third], atol=1e-12)
            np.testing.assert_allclose(few.rotation[some], many.rotation[third], atol=1e-12)
            np.testing.assert_allclose(few.arc_length[some], many.arc_length[third], atol=1e-12)


@pytest.mark.parametrize("name", CHAINS)
def test_chains_lead_to_the_platform_and_are_as_long_as_their_pieces(name):
    home = solve_home(load_robot(name))
    for leg, shape in zip(home.robot.description.legs, leg_shapes(home, 40), strict=True):
        tip = home.platform_position + home.platform_rotation @ leg.joint.position
        np.testing.assert_allclose(shape.position[0], leg.base_position)
        np.testing.assert_allclose(shape.position[-1], tip, atol=1e-9)
        np.testing.assert_allclose(shape.joints[-1].position, tip, atol=1e-9)
        assert np.all(np.diff(shape.arc_length) >= 0.0)
        whole = np.linalg.norm(np.diff(shape.position, axis=0), axis=1).sum()
        assert whole == pytest.approx(shape.arc_length[-1], rel=1e-3)
        rods = sum(element.rod.length for element in leg.rods)
        rigid = sum(
            np.linalg.norm(np.diff(piece, axis=0), axis=1).sum() for piece in shape.rigid_pieces
        )
        assert rods + rigid == pytest.approx(shape.arc_length[-1], abs=1e-12)


def test_joints_and_links_are_where_they_are():
    """The carriage of a 3-PRS: along its rail, with the hinge three centimetres above."""
    home = solve_home(load_robot("three_prs"))
    base = home.robot.description.legs[0].base_position
    shape = leg_shapes(home)[0]
    assert [(joint.kind, joint.motor) for joint in shape.joints] == [
        ("prismatic", "motor1"),
        ("revolute", None),
        ("spherical", None),
    ]
    carriage = base + [home.motors[0], 0.0, 0.0]
    hinge = carriage + [0.0, 0.0, 0.03]
    np.testing.assert_allclose(shape.joints[0].position, carriage, atol=1e-12)
    np.testing.assert_allclose(shape.joints[1].position, hinge, atol=1e-12)
    rail, end = shape.rigid_pieces
    np.testing.assert_allclose(rail, [base, carriage, hinge, hinge], atol=1e-12)
    assert np.linalg.norm(end[-1] - end[0]) == pytest.approx(0.02)


def test_legs_without_links_have_no_rigid_pieces_and_feeds_are_joints():
    shape = leg_shapes(solve_home(load_robot("gough_stewart")))[0]
    assert shape.rigid_pieces == ()
    assert [(joint.kind, joint.motor) for joint in shape.joints] == [
        ("feed", "motor1"),
        ("fixed", None),
    ]
    np.testing.assert_array_equal(shape.joints[0].position, shape.position[0])


class Ball(joints.Spherical):
    """A tip joint of one's own that is nearly another."""


@pytest.mark.parametrize("known", [True, False])
def test_a_tip_joint_of_ones_own_is_called_as_it_is(known, monkeypatch):
    """It was told as the first kind that it is one of."""
    robot = load_robot("six_rfs")
    if known:
        monkeypatch.setitem(joints.JOINTS, "ball", Ball)
        content = shipped_content("six_rfs")
        content["legs"][0]["tip"]["type"] = "ball"
        robot = load_robot(content)
    else:
        first, *others = robot.description.legs
        own = replace(first, joint=Ball(first.joint.position))
        robot = Robot(replace(robot.description, legs=(own, *others)))
    shapes = leg_shapes(solve_home(robot))
    assert [shape.joints[-1].kind for shape in shapes[:2]] == [
        "ball" if known else "Ball",
        "spherical",
    ]


def test_a_leg_that_ends_in_a_joint_ends_where_its_rod_does():
    content = shipped_content("delta")
    joint = {"joint": "revolute", "axis": [1, 0, 0], "stiffness": 1.0}
    content["legs"][0]["chain"].append(joint)
    shape = leg_shapes(solve_home(load_robot(content)))[0]
    np.testing.assert_array_equal(shape.rod[-2:], [0, -1])
    np.testing.assert_allclose(shape.position[-1], shape.position[-2], atol=1e-12)
    assert shape.arc_length[-1] == shape.arc_length[-2]
    assert np.all(np.diff(shape.arc_length) >= 0.0)

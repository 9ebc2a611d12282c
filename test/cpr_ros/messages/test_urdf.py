# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The robot as URDF: a tree that moves as the motors do."""

from xml.etree import ElementTree

import numpy as np
import pytest
from helpers.fed_robots import fed, motors_of, plain_content
from helpers.geared_robots import geared
from helpers.tracked_robots import tracked
from helpers.yaml_content import shipped_content

from cpr_core import leg_shapes, load_robot, solve_forward, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.lie import rotation_exp, rotation_from_angles
from cpr_ros.messages.urdf import robot_urdf

KINDS = {"floating", "fixed", "revolute", "continuous", "prismatic"}


class Tree:
    """What robot_state_publisher makes of a description."""

    def __init__(self, text):
        root = ElementTree.fromstring(text)
        assert root.tag == "robot"
        assert root.get("name")
        self.links = [link.get("name") for link in root.findall("link")]
        self.joints = {joint.get("name"): joint for joint in root.findall("joint")}
        assert len(set(self.links)) == len(self.links)
        assert len(self.joints) == len(root.findall("joint"))
        self.parents = {joint.find("child").get("link"): joint for joint in self.joints.values()}
        assert len(self.parents) == len(self.joints)  # a link has one parent
        assert {joint.find("parent").get("link") for joint in self.joints.values()} <= {*self.links}
        assert {joint.get("type") for joint in self.joints.values()} <= KINDS
        (self.root,) = set(self.links) - set(self.parents)

    def frame(self, link, motors):
        """Rotation and position in the root."""
        if link == self.root:
            return np.eye(3), np.zeros(3)
        joint = self.parents[link]
        rotation, position = self.frame(joint.find("parent").get("link"), motors)
        origin = joint.find("origin")
        position = position + rotation @ numbers(origin, "xyz")
        rotation = rotation @ rotation_from_angles(*numbers(origin, "rpy"))
        if joint.get("type") == "fixed":
            return rotation, position
        mimic, way = joint.find("mimic"), motors.get(joint.get("name"))
        if mimic is not None:
            way = float(mimic.get("multiplier")) * motors[mimic.get("joint")]
            way += float(mimic.get("offset"))
        axis = numbers(joint.find("axis"), "xyz")
        if joint.get("type") == "prismatic":
            return rotation, position + way * rotation @ axis
        return rotation @ rotation_exp(way * axis), position


def numbers(element, name):
    return np.array([float(word) for word in element.get(name).split()])


@pytest.mark.parametrize("name", shipped_robots())
def test_every_shipped_robot_is_a_tree_with_its_motors(name):
    robot = load_robot(name)
    tree = Tree(robot_urdf(robot, "base", "platform"))
    assert tree.root == "base"
    platform = tree.parents["platform"]
    assert (platform.get("type"), platform.find("parent").get("link")) == ("floating", "base")
    for motor in robot.description.motors:
        joint = tree.joints[motor.name]
        limit = joint.find("limit")
        assert joint.get("type") in (
            ("prismatic",) if motor.unit == "m" else ("revolute", "continuous")
        )
        if joint.get("type") != "continuous":
            assert float(limit.get("lower")) == pytest.approx(written(motor.limits.lower))
            assert float(limit.get("upper")) == pytest.approx(written(motor.limits.upper))
        assert float(limit.get("velocity")) == pytest.approx(written(motor.limits.speed))
        assert float(limit.get("effort")) == pytest.approx(written(motor.limits.effort))


def written(limit):
    """A limit as URDF has it, which knows no infinity."""
    return limit if np.isfinite(limit) else np.copysign(1e6, limit)


def test_limits_of_motors_that_count_in_small_steps_are_not_cut():
    content = shipped_content("planar_body")
    counts = 2.0**24 / (2.0 * np.pi)  # per rad
    for leg in content["legs"]:
        motor = leg["motor"]
        motor["ratio"] = 1.0 / counts
        motor["limits"]["position"] = [counts * end for end in motor["limits"]["position"]]
        motor["limits"]["speed"] *= counts
    content["home"]["motors"] = [counts * position for position in content["home"]["motors"]]
    robot = load_robot(content)
    tree = Tree(robot_urdf(robot, "base", "platform"))
    for motor in robot.description.motors:
        limit = tree.joints[motor.name].find("limit")
        assert motor.limits.upper > 1e6
        assert float(limit.get("lower")) == pytest.approx(motor.limits.lower)
        assert float(limit.get("upper")) == pytest.approx(motor.limits.upper)
        assert float(limit.get("velocity")) == pytest.approx(motor.limits.speed)


@pytest.mark.parametrize("name", ["rfrfr", "delta", "six_rus", "three_prs"])
def test_motors_are_where_the_robot_has_them_in_any_position(name):
    """The joints up to the first rod or passive joint, and the cranks between them."""
    robot = load_robot(name)
    tree = Tree(robot_urdf(robot, "base", "platform"))
    home = solve_home(robot)
    seen = 0
    for shift in (0.0, 0.05):
        equilibrium = solve_forward(robot, home.motors + shift * robot.motor_units, start=home)
        motors = dict(zip(robot.motor_names, equilibrium.motors, strict=True))
        for leg, shape in zip(robot.description.legs, leg_shapes(equilibrium), strict=True):
            first = shape.joints[0]
            assert first.motor is not None
            rotation, position = tree.frame(f"{leg.name}.1", motors)
            np.testing.assert_allclose(position, first.position, atol=1e-9)
            start = leg.chain[0].behind(leg.base_rotation, leg.base_position, motors[first.motor])
            np.testing.assert_allclose(rotation, start[0], atol=1e-9)
            seen += 1
    assert seen == 2 * len(robot.description.legs)


def test_a_motor_that_feeds_a_rod_moves_along_it():
    robot = load_robot("gough_stewart")
    tree = Tree(robot_urdf(robot, "base", "platform"))
    leg = robot.description.legs[0]
    motors = dict.fromkeys(robot.motor_names, 0.3)
    (child,) = (link for link in tree.links if link.startswith(f"{leg.name}."))
    _, position = tree.frame(child, motors)
    expected = leg.base_position + 0.3 * leg.base_rotation[:, 0]
    np.testing.assert_allclose(position, expected, atol=1e-9)


def test_a_joint_with_a_ratio_and_an_offset_follows_its_motor():
    content = shipped_content("delta")
    for leg in content["legs"][:2]:
        leg["chain"][0] |= {"ratio": -2.0, "offset": 0.1}
        del leg["chain"][0]["limits"]
    robot = load_robot(content)
    tree = Tree(robot_urdf(robot, "base", "platform"))
    motors = dict.fromkeys(robot.motor_names, 0.2)
    for leg in robot.description.legs[:2]:
        rotation, _ = tree.frame(f"{leg.name}.1", motors)
        expected = leg.base_rotation @ rotation_exp([0.0, 0.1 - 2.0 * 0.2, 0.0])
        np.testing.assert_allclose(rotation, expected, atol=1e-9)


def test_a_screw_is_a_motor_that_turns_and_a_joint_that_shifts():
    _, robot, ratios = geared("three_prs")
    tree = Tree(robot_urdf(robot, "base", "platform"))
    motors = dict(zip(robot.motor_names, 0.15 / ratios, strict=True))
    for leg in robot.description.legs:
        joint, led = tree.joints[f"motor{leg.name[-1]}"], tree.joints[f"{leg.name}.1.joint"]
        assert (joint.get("type"), led.get("type")) == ("revolute", "prismatic")
        limit, motor = joint.find("limit"), leg.joints[0]
        assert float(limit.get("upper")) == pytest.approx(motor.limits.upper)
        assert float(led.find("limit").get("upper")) == pytest.approx(0.25)
        assert float(led.find("limit").get("effort")) == pytest.approx(30.0)
        _, position = tree.frame(f"{leg.name}.1", motors)
        expected = leg.base_position + 0.15 * leg.base_rotation[:, 0]
        np.testing.assert_allclose(position, expected, atol=1e-9)


@pytest.mark.parametrize("ratio", [-2.0, 0.5])
def test_limits_of_a_joint_are_those_of_its_motor_by_the_ratio(ratio):
    """The joint goes the ratio times the motor's way, and bears as much power."""
    content = shipped_content("delta")
    limits = {"position": [-0.4, 1.2], "speed": 3.0, "effort": 5.0}
    for leg in content["legs"][:2]:  # they share a motor
        leg["chain"][0] |= {"ratio": ratio, "limits": limits}
    tree = Tree(robot_urdf(load_robot(content), "base", "platform"))
    motor, follower = tree.joints["motor1"], tree.joints["leg1.1.joint"]
    assert follower.find("mimic").get("joint") == "motor1"
    own, led = (
        {name: float(value) for name, value in joint.find("limit").attrib.items()}
        for joint in (motor, follower)
    )
    assert own == {"lower": -0.4, "upper": 1.2, "velocity": 3.0, "effort": 5.0}
    ends = [ratio * -0.4, ratio * 1.2]
    assert [led["lower"], led["upper"]] == pytest.approx([min(ends), max(ends)])
    assert led["velocity"] == pytest.approx(abs(ratio) * own["velocity"])
    assert led["effort"] * led["velocity"] == pytest.approx(own["effort"] * own["velocity"])


def test_a_motor_behind_a_passive_joint_has_no_place_in_the_tree():
    content = shipped_content("delta")
    hinge = {"joint": "revolute", "axis": [0, 0, 1], "stiffness": 5.0}
    for leg in content["legs"][:2]:
        leg["chain"].insert(0, hinge)
    robot = load_robot(content)
    tree = Tree(robot_urdf(robot, "base", "platform"))
    assert "motor1" not in tree.joints
    assert {"motor2", "motor3"} <= set(tree.joints)


def test_frames_have_the_names_that_were_asked_for():
    tree = Tree(robot_urdf(load_robot("rfrfr"), "table", "hand"))
    assert tree.root == "table"
    assert "hand" in tree.parents


def test_a_tracker_stands_on_the_base_and_its_marker_on_the_platform():
    frame, marker = [0.4, -0.6, 1.8, 3.0, 0.3, -0.4], [0.02, -0.03, 0.04, 0.3, 1.1, -0.2]
    tree = Tree(robot_urdf(tracked("six_rfs", frame, marker), "base", "platform", "camera"))
    for link, parent, numbers_of_it in (
        ("camera", "base", frame),
        ("camera_marker", "platform", marker),
    ):
        assert tree.parents[link].find("parent").get("link") == parent
        own = tree.parents[link].find("origin")
        assert numbers(own, "xyz") == pytest.approx(numbers_of_it[:3])
        turn = rotation_from_angles(*numbers(own, "rpy"))
        np.testing.assert_allclose(turn, rotation_exp(numbers_of_it[3:]), atol=1e-9)
    assert "camera" not in Tree(robot_urdf(load_robot("six_rfs"), "base", "platform")).links


def test_a_roller_is_a_motor_that_turns_and_a_rod_that_comes_out():
    """As long as the rod is at this position of the motor, where it would end if it were straight."""
    robot = load_robot(fed(plain_content()))
    tree, lengths = Tree(robot_urdf(robot, "base", "platform")), 0.37 + 0.01 * np.arange(6)
    motors = dict(zip(robot.motor_names, motors_of(lengths), strict=True))
    for number, (leg, length) in enumerate(zip(robot.description.legs, lengths, strict=True)):
        kinds = [
            tree.joints[name].get("type") for name in (f"motor{number + 1}", f"{leg.name}.1.joint")
        ]
        assert kinds == ["revolute", "prismatic"]
        _, position = tree.frame(f"{leg.name}.1", motors)
        end = leg.base_position + length * leg.base_rotation[:, 0]
        np.testing.assert_allclose(position, end, atol=1e-9)

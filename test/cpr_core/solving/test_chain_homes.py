# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Home of robots of chains: from the sides of the rods, a rough pose or rough passive joints."""

from copy import deepcopy

import numpy as np
import pytest
import yaml
from helpers.random_chains import random_chain_robot, rough_joints, rough_pose, sides
from helpers.yaml_content import shipped_content
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cpr_core import DescriptionError, NoForwardSolution, load_robot, solve_home
from cpr_core.description.joints import Fixed, Joint, RevoluteJoint, Universal
from cpr_core.lie import rotation_exp
from cpr_core.model.shape import rod_bases, tip_poses
from cpr_core.solving.rough_shape import rough_platforms, rough_state

KNOWN = {
    "pose": lambda made, seed: {"platform": rough_pose(made, seed, 0.05, 0.2)},
    "joints": lambda made, seed: {"joints": rough_joints(made, seed, 0.25)},
    "sides": lambda made, seed: {"bow": sides(made)},
}


def found_from(known, seed, planar, **made_with):
    """A random robot, and its home from what is known."""
    made = random_chain_robot(seed, planar, **made_with)
    made.content["home"] |= KNOWN[known](made, seed)
    return made, solve_home(load_robot(made.content))


@pytest.mark.parametrize("known", KNOWN)
@settings(deadline=None, max_examples=10)
@given(seed=st.integers(0, 10**6), planar=st.booleans())
def test_random_robots_come_to_rest(known, seed, planar):
    """One in a hundred has another stable equilibrium near by."""
    _, home = found_from(known, seed, planar)
    assert home.residual < 1e-10 and home.index_locked == 0


@pytest.mark.parametrize("planar", [False, True])
@pytest.mark.parametrize("known", KNOWN)
@pytest.mark.parametrize("seed", range(5))
def test_robots_come_to_rest_where_they_are_made_to(seed, known, planar):
    made, home = found_from(known, seed, planar)
    np.testing.assert_allclose(home.platform_position, made.position, atol=1e-6)
    np.testing.assert_allclose(home.platform_rotation, made.rotation, atol=1e-5)


@pytest.mark.parametrize("planar", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_joints_say_how_the_platform_is_turned(seed, planar):
    """Not at all like the world: nobody says so, but the tips do."""
    made, home = found_from("joints", seed, planar, turn=0.4, platform_turn=3.0)
    np.testing.assert_allclose(home.platform_rotation, made.rotation, atol=1e-5)


FIVE_BAR = """
name: five_bar
space: planar
rod: {length: 0.3, section: {shape: circular, radius: 0.001}, young_modulus: 210e9, shear_modulus: 82e9}
strain: {bending_3: 4}
platform: {shape: point}
controlled: [x, y]
legs:
- base: {position: [-0.2, 0, 0], tangent: [1, 0, 0]}
  chain:
  - {joint: revolute, axis: [0, 0, 1], motor: motor1}
  - {link: [0.05, 0, 0]}
  - {joint: revolute, axis: [0, 0, 1], stiffness: 0.001}
  - {rod: {}}
  tip: {type: revolute, position: [0, 0, 0]}
- base: {position: [0.2, 0, 0], tangent: [-1, 0, 0]}
  chain:
  - {joint: revolute, axis: [0, 0, 1], motor: motor2}
  - {link: [0.05, 0, 0]}
  - {joint: revolute, axis: [0, 0, 1], name: elbow, stiffness: 0.001}
  - {rod: {}}
  tip: {type: revolute, position: [0, 0, 0]}
home: {motors: [0, 0]}
"""


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_joints_choose_between_assemblies_at_the_same_motors(side):
    """The point above or below the line of the bases: elbows 0.3 m apart, rods of 0.3 m."""
    robot = yaml.safe_load(FIVE_BAR)
    robot["home"]["joints"] = {"leg1.joint2": 0.5 * side, "elbow": -0.5 * side}
    home = solve_home(load_robot(robot))
    assert home.stable
    height = side * np.sqrt(0.3**2 - 0.15**2)
    np.testing.assert_allclose(home.platform_position, [0.0, height, 0.0], atol=1e-3)


def test_rods_and_joints_begin_as_they_are_at_rest():
    changed = shipped_content("six_rus")
    changed["legs"][0]["chain"][2] |= {"stiffness": 0.1, "rest": [0.3, -0.2]}
    changed["home"]["joints"] = {"leg2.joint2": [0.1, 0.4]}
    robot = load_robot(changed)
    state = rough_state(robot, robot.description.home)
    at = {joint.name: state[index] for joint, index in robot.passive_joints}
    assert [at[f"leg1.joint2[{axis}]"] for axis in (0, 1)] == [0.3, -0.2]
    assert [at[f"leg2.joint2[{axis}]"] for axis in (0, 1)] == [0.1, 0.4]
    assert [at[f"leg3.joint2[{axis}]"] for axis in (0, 1)] == [0.0, 0.0]
    # Arcs of radius 0.3 m.
    bases, tips = leg_ends(robot, state)
    chord = 2 * 0.3 * np.sin(0.53 / 0.3 / 2)
    np.testing.assert_allclose(np.linalg.norm(tips - bases, axis=1), chord, atol=1e-9)


def leg_ends(robot, state):
    bases = np.array([poses[0].position for poses in rod_bases(robot, state)])
    return bases, np.array([pose.position for pose in tip_poses(robot, state)])


@pytest.mark.parametrize(
    ("joints", "field", "says"),
    [
        ({"leg9.joint2": 0.1}, "home.joints.leg9.joint2", "expected one of leg1.joint2[0], leg1"),
        ({"leg1.joint1": 0.1}, "home.joints.leg1.joint1", "motor1 moves it: give home.motors"),
        ({"leg1.joint2": 0.1}, "home.joints.leg1.joint2", "2 numbers, one for every axis, got 0.1"),
        (
            {"leg1.joint2": [0.1]},
            "home.joints.leg1.joint2",
            "2 numbers, one for every axis, got [0.1]",
        ),
        ({"leg1.joint2": [0.1, 0, 0]}, "home.joints.leg1.joint2", "2 numbers"),
        ({"leg2.joint2": [0.1]}, "home.joints.leg2.joint2", "expected a number, got [0.1]"),
        ({"leg2.joint2": "bent"}, "home.joints.leg2.joint2", "got 'bent'"),
    ],
)
def test_joints_that_are_not_there_or_have_other_axes_are_refused(joints, field, says):
    changed = shipped_content("six_rus")
    changed["legs"][1]["chain"][2] = {"joint": "revolute", "axis": [0, 1, 0]}
    changed["home"]["joints"] = joints
    with pytest.raises(DescriptionError) as caught:
        load_robot(changed)
    assert caught.value.field == field
    assert says in str(caught.value)


def test_a_universal_joint_with_a_motor_has_one_rough_turn():
    changed = shipped_content("six_rus")
    changed["legs"][0]["chain"][2] |= {"motor": [None, "extra"]}
    changed |= {
        "controlled": [],
        "home": {"motors": [0.0] * 7, "joints": {"leg1.joint2": [0.2, None]}},
    }
    assert load_robot(changed).description.home.joints == {"leg1.joint2[0]": 0.2}
    changed["home"]["joints"]["leg1.joint2"] = [0.2, 0.1]
    with pytest.raises(DescriptionError, match="extra moves it"):
        load_robot(changed)


def test_joints_have_the_names_they_are_given_and_each_its_own():
    changed = shipped_content("six_rus")
    changed["legs"][0]["chain"][2]["name"] = "hip"
    changed["legs"][1]["name"] = "left"
    names = [[joint.name for joint in leg.joints] for leg in load_robot(changed).description.legs]
    assert names[0] == ["leg1.joint1", "hip[0]", "hip[1]"]
    assert names[1] == ["left.joint1", "left.joint2[0]", "left.joint2[1]"]
    changed["legs"][1]["chain"][2]["name"] = "hip"
    with pytest.raises(
        DescriptionError, match=r"legs\[1\]\.chain: 'hip\[0\]' is the name of an ea"
    ):
        load_robot(changed)


def test_the_hinge_of_a_leg_in_the_short_form_has_a_name_too():
    changed = shipped_content("three_rfr_hubs")
    del changed["legs"][0]["chain"]
    changed["legs"][0]["motor"] = {"type": "hinge", "axis": [0, 0, 1]}
    changed |= {"controlled": ["x", "y"], "home": {"motors": [0, 0], "bow": "left"}}
    changed["home"]["joints"] = {"leg1.joint1": 0.4}
    robot = load_robot(changed)
    assert rough_state(robot, robot.description.home)[0] == 0.4
    assert solve_home(robot).stable


def test_sides_are_across_the_rod_where_the_joints_are():
    robot = yaml.safe_load(FIVE_BAR)
    robot["home"] |= {"joints": {"leg1.joint2": 0.5}, "bow": "left"}
    bow = load_robot(robot).description.home.bow
    np.testing.assert_allclose(bow[0], [-np.sin(0.5), np.cos(0.5), 0.0], atol=1e-12)


# What cannot be closed.

TIPS = {
    "fixed": {"tangent": [1, 0, 0], "normal": [0, 1, 0]},
    "revolute": {"axis": [0, 0, 1]},
    "universal": {"axis": [0, 1, 0]},
}


@pytest.mark.parametrize("tip", TIPS)
def test_what_cannot_be_closed_names_leg_gap_and_angle(tip):
    changed = shipped_content("six_rus")
    changed["legs"][2]["base"]["position"][0] += 3.0
    changed["legs"][2]["tip"] |= {"type": tip} | TIPS[tip]
    says = r"leg3 misses its tip joint by [12]\.\d+ m and [\d.e-]+ rad$"
    with pytest.raises(NoForwardSolution, match=says):
        solve_home(load_robot(changed))


def parallelogram(rigid_legs):
    """A planar platform on parallel rigid legs, and a rod that a motor turns."""
    hinge = {"joint": "revolute", "axis": [0, 0, 1]}
    rod = {"rod": {"length": 0.33, "rest_curvature": {"bending_3": [1.0]}}}
    crank = {"link": [0.3, 0, 0], "mass": 0.01}
    chains = [[hinge | {"motor": "m1"}, rod], *([[hinge, crank]] * rigid_legs)]
    return {
        "name": "parallelogram",
        "space": "planar",
        "rod": {"length": 0.33, "section": {"shape": "circular", "radius": 0.001}}
        | {"young_modulus": 1e11, "shear_modulus": 4e10},
        "strain": {"bending_3": 4},
        "platform": {"shape": "body", "mass": 0.1},
        "legs": [
            {
                "base": {"position": [0.2 * k, 0, 0], "tangent": [0, 1, 0]},
                "chain": chain,
                "tip": {"type": "revolute", "position": [0.2 * k - 0.1, 0, 0]},
            }
            for k, chain in enumerate(chains)
        ],
        "controlled": ["x"],
        "home": {"motors": [0.0], "platform": {"position": [-0.08, 0.24, 0]}},
    }


def test_a_motion_that_straight_legs_hold_twice_is_named():
    """Joints that are closed as written said nothing: home had a stability index of -1."""
    legs = [
        {
            "base": {"position": [*at, 0], "tangent": [0, 0, 1], "normal": [0, 1, 0]},
            "motor": {"type": "revolute", "axis": [0, 1, 0]},
            "tip": {"type": "spherical", "position": [*at, 0]},
        }
        for at in ([0.2, 0], [0, 0.2], [-0.2, 0], [0, -0.2])
    ]
    content = {
        "name": "columns",
        "space": "spatial",
        "rod": {"length": 0.5, "section": {"shape": "circular", "radius": 0.0015}}
        | {"young_modulus": 1.1e11, "shear_modulus": 4.2e10},
        "strain": {"torsion": 3, "bending_2": 6, "bending_3": 6},
        "platform": {"mass": 0.0},
        "legs": legs,
        "controlled": ["x", "y", "z", "yaw"],
        "home": {"motors": [0.0] * 4, "platform": {"position": [0, 0, 0.5]}},
    }
    with pytest.raises(NoForwardSolution, match="of the 12 constraints of its joints only 11 are"):
        solve_home(load_robot(content))


def test_a_motion_that_joints_hold_twice_is_named():
    """Two rigid legs leave the platform one motion; a third holds again what they hold."""
    assert solve_home(load_robot(parallelogram(2))).index_locked == 0
    says = (
        "of the 8 constraints of its joints only 7 are independent there: some motion is held twice"
    )
    with pytest.raises(NoForwardSolution, match=says):
        solve_home(load_robot(parallelogram(3)))


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.4, 2.0, 3.0])
def test_angles_between_tips_and_their_joints(angle):
    platform, tip_axis = rotation_exp([0.3, -0.5, 0.2]), np.array([0.6, 0.0, 0.8])
    turn = platform @ rotation_exp(angle * tip_axis)
    assert Joint((0, 0, 0)).misalignment(platform, turn) == 0.0
    assert Fixed((0, 0, 0)).misalignment(platform, turn) == pytest.approx(angle)
    across, along = (0.0, 1.0, 0.0), (0.6, 0.0, 0.8)
    hinge = RevoluteJoint((0, 0, 0), across, across)
    assert hinge.misalignment(platform, turn) == pytest.approx(angle)
    assert RevoluteJoint((0, 0, 0), along, along).misalignment(platform, turn) < 1e-7
    cross = Universal((0, 0, 0), across, (0.8, 0.0, -0.6))
    expected = abs(np.arcsin(np.sin(angle)))
    assert cross.misalignment(platform, turn) == pytest.approx(expected)


def test_a_platform_without_known_rotation_is_tried_turned_to_the_tips_to_the_bases_and_not():
    made = random_chain_robot(3, False, platform_turn=2.0)
    exact = deepcopy(made.content)
    exact["home"]["joints"] = made.joints
    robot = load_robot(exact)
    guess = robot.description.home
    first, second, last = rough_platforms(robot, guess, rough_state(robot, guess))
    np.testing.assert_array_equal(last.rotation, np.eye(3))
    np.testing.assert_allclose(first.rotation, made.rotation, atol=1e-2)
    bases, joints = (
        np.array(points) - np.mean(points, axis=0)
        for points in (
            [leg.base_position for leg in robot.description.legs],
            [leg.joint.position for leg in robot.description.legs],
        )
    )
    expected, _ = Rotation.align_vectors(bases, joints)
    np.testing.assert_allclose(second.rotation, expected.as_matrix(), atol=1e-9)
    assert np.linalg.det(first.rotation) == pytest.approx(1.0)


def test_a_flat_platform_that_is_upside_down_is_turned_and_not_mirrored():
    changed, turned = shipped_content("six_rus"), rotation_exp([np.pi, 0.0, 0.0])
    changed["home"] = {"motors": [0.0] * 6, "joints": {"leg1.joint2": [0.0, 0.0]}}
    robot = load_robot(changed)
    _, tips = leg_ends(robot, rough_state(robot, robot.description.home))
    assert np.ptp(tips[:, 2]) < 1e-9
    for leg, tip in zip(changed["legs"], tips - tips.mean(axis=0), strict=True):
        leg["tip"]["position"] = (turned.T @ tip).tolist()
    robot = load_robot(changed)
    guess = robot.description.home
    found = next(rough_platforms(robot, guess, rough_state(robot, guess))).rotation
    np.testing.assert_allclose(found, turned, atol=1e-6)


def test_a_link_that_swings_between_two_joints_about_one_axis_is_named():
    """Nothing at all resists: the energy is flat along it, to the last bit."""
    changed, hinge = shipped_content("three_prs"), {"joint": "revolute", "axis": [0, 0, 1]}
    between = [{"link": [-0.05, 0, 0], "mass": 0.1}, {"link": [0.05, 0, 0]}]
    changed["legs"][0]["chain"][2:3] = [hinge, *between, dict(hinge)]
    with pytest.raises(NoForwardSolution, match=r"nothing holds joint leg1\.joint2"):
        solve_home(load_robot(changed))


@pytest.mark.parametrize("stiffness", [1e10, 1e14])
@pytest.mark.parametrize("joint", ["revolute", "prismatic"])
@pytest.mark.parametrize("name", ["three_rfr_hubs", "three_prs"])
def test_a_spring_beside_which_rods_are_nothing_is_named(name, joint, stiffness):
    """Everything is held, by more than ever; it was said that nothing holds the platform."""
    changed = shipped_content(name)
    axis = [0, 0, 1] if joint == "revolute" else [0, 1, 0]
    spring = {"joint": joint, "axis": axis, "stiffness": stiffness}
    soft = {**spring, "stiffness": 1e3}
    for leg, at in zip(changed["legs"], (soft, spring, soft), strict=True):
        leg["chain"].insert(1, at)
    with pytest.raises(
        NoForwardSolution,
        match=r"the spring of joint leg2\.joint2 is .* times as stiff as the rods",
    ) as told:
        solve_home(load_robot(changed))
    rod = load_robot(name).description.rods[0].rod
    natural = rod.rigidities[1] / rod.length
    of_spring = stiffness * (1.0 if joint == "revolute" else rod.length**2)
    ratio = float(str(told.value).split(" times as")[0].split()[-1])
    assert ratio == pytest.approx(of_spring / natural, rel=0.3)


def test_what_nothing_holds_is_said_beside_a_stiff_spring_too():
    changed, hinge = shipped_content("three_prs"), {"joint": "revolute", "axis": [0, 0, 1]}
    between = [{"link": [-0.05, 0, 0], "mass": 0.1}, {"link": [0.05, 0, 0]}]
    changed["legs"][0]["chain"][2:3] = [hinge, *between, dict(hinge)]
    changed["legs"][1]["chain"].insert(1, {**hinge, "stiffness": 1e4})
    with pytest.raises(NoForwardSolution, match=r"nothing holds joint leg1\.joint2"):
        solve_home(load_robot(changed))

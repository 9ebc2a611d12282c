# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Requests in other units: where no robot is meant to go."""

import numpy as np
import pytest
from helpers.chain_robots import as_chains
from helpers.doubts import DEGREES, MILLIMETRES
from helpers.yaml_content import shipped_content

from cpr_core import (
    InvalidRequest,
    NotReached,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    trace,
    trace_through,
)
from cpr_core.description.description_file import read_description
from cpr_core.description.doubted_requests import (
    motors_doubt,
    position_doubt,
    quaternion_order_doubt,
)


@pytest.mark.parametrize(
    ("name", "solve", "values", "says"),
    [
        ("rfrfr", solve_forward, [148.4, 31.5], f"motor1 at 148.4 {DEGREES}"),
        ("rfrfr", solve_inverse, [0.0, 830.0], rf"platform position \(0, 830, 0\) {MILLIMETRES}"),
        (
            "gough_stewart",
            solve_inverse,
            [0, 0, 450.0, 1, 0, 0, 0],
            rf"\(0, 0, 450\) {MILLIMETRES}",
        ),
        ("rfrfr", solve_forward, [2.59, 6.5], None),
    ],
)
def test_requests_in_other_units_fail_with_what_looks_wrong(name, solve, values, says):
    content = shipped_content(name)
    for leg in content["legs"]:
        leg["motor"].pop("limits", None)
    with pytest.raises(NotReached, match=says or "not reached") as caught:
        solve(load_robot(content), values)
    assert ("looks like" in str(caught.value)) == (says is not None)


@pytest.mark.parametrize(
    ("name", "solve", "values", "says"),
    [
        ("planar_body", solve_inverse, [0.0, 0.3, 30.0], f"angle at 30 {DEGREES}"),
        ("three_rfs", solve_inverse, [0.74, 5.0, 12.0], f"pitch at 12 {DEGREES}"),
        ("three_rfs", solve_inverse, [0.74, 30.0, 0.0], f"roll at 30 {DEGREES}"),
        ("planar_body", solve_inverse, [0.0, 0.3, 6.0], None),
        (
            "three_rfs",
            solve_forward,
            [300.0, 310.0, 290.0],
            f"its limits .*motor1 at 300 {DEGREES}",
        ),
        ("three_prs", solve_forward, [20.0, 20.0, 20.0], f"its limits .*at 20 {MILLIMETRES}"),
        ("three_rfs", solve_forward, [6.3, 5.2, 5.2], None),
    ],
)
def test_angles_of_poses_and_motors_beyond_their_limits_are_doubted_too(name, solve, values, says):
    """They ended in words about folds and limits."""
    with pytest.raises((NotReached, InvalidRequest), match=says) as caught:
        solve(load_robot(name), values)
    assert ("looks like" in str(caught.value)) == (says is not None)


@pytest.mark.parametrize("turns", [7, -7, 2])
def test_an_angle_in_degrees_is_not_met_whole_turns_less(turns):
    """45 is 1.02 rad and seven turns, which was reached, and nothing said of it."""
    robot = load_robot("planar_body")
    near = solve_home(robot).pose + [0.01, 0.0, 0.02]
    assert solve_inverse(robot, near).converged
    far = near + [0.0, 0.0, 2.0 * np.pi * turns]
    for ask in (
        lambda: solve_inverse(robot, far),
        lambda: trace(robot, pose=far, points=3),
        lambda: trace_through(robot, poses=[near, far]),
    ):
        with pytest.raises(InvalidRequest, match=rf"angle at {far[2]:g} {DEGREES}"):
            ask()


@pytest.mark.parametrize("turns", [3, -1])
def test_an_angle_that_counts_turns_is_told_without_them(turns):
    """Of a controller whose angle goes on beyond a turn; what to do instead was not said."""
    robot = load_robot("planar_body")
    near = solve_home(robot).pose
    with pytest.raises(InvalidRequest, match="radians are taken without whole turns: ") as caught:
        solve_inverse(robot, near + [0.0, 0.0, 2.0 * np.pi * turns])
    near[2] = float(caught.value.problem.rpartition(" ")[2])
    np.testing.assert_allclose(solve_inverse(robot, near).pose, near, atol=1e-9)
    assert near[2] == pytest.approx(solve_home(robot).pose[2], abs=1e-5)


RAIL = {"joint": "prismatic", "axis": [1, 0, 0], "motor": "rail"}


def driven(name, **fields):
    """A shipped robot with motors that have these fields, and no limits but for them."""
    content = shipped_content(name)
    for leg in content["legs"]:
        leg["motor"].pop("limits", None)
        leg["motor"] |= fields
    content["home"]["motors"] = [
        position / fields.get("ratio", 1.0) for position in content["home"]["motors"]
    ]
    return load_robot(content)


@pytest.mark.parametrize(
    ("name", "position", "near", "says"),
    [
        ("rfrfr", 148.4, 2.59, f"motor1 at 148.4 {DEGREES}, expected radians"),
        ("rfrfr", -148.4, 2.59, f"motor1 at -148.4 {DEGREES}"),
        ("rfrfr", 8.9, 2.59, ""),  # a turn on
        ("rfrfr", 2.59, 40.0, ""),  # back from many turns
        ("rfrfr", 40.0, 39.9, ""),  # led there in small steps
        ("gough_stewart", 450.0, 0.45, f"motor1 at 450 {MILLIMETRES}"),
        ("gough_stewart", 0.5, 0.45, ""),
    ],
)
def test_motors_are_not_sent_where_no_robot_is_meant_to_go(name, position, near, says):
    robot = driven(name)
    others = solve_home(robot).motors[1:]
    motors, place = np.append(position, others), np.append(near, others)
    doubt = motors_doubt(robot.description, motors, [place])
    assert doubt.startswith(says)
    assert bool(doubt) == bool(says)


@pytest.mark.parametrize(
    ("limits", "position", "doubted"),
    [
        ([-1000.0, 1000.0], 148.4, False),  # wide open, but stated
        ([-1000.0, 1000.0], 1148.4, True),
        ([-3.0, 3.0], 148.4, True),
        ([-3.0, 3.0], 6.0, False),  # it goes as far as it can
        ([-3.0, np.inf], 148.4, True),  # there is none to this side
    ],
)
@pytest.mark.filterwarnings("ignore::cpr_core.DescriptionWarning")
def test_what_stated_limits_have_room_for_is_meant(limits, position, doubted):
    robot = driven("rfrfr", limits={"position": limits})
    home = solve_home(robot).motors
    doubt = motors_doubt(robot.description, np.array([position, home[1]]), [home])
    assert bool(doubt) == doubted


def test_turns_of_a_motor_before_its_gear_are_none_of_the_joint():
    gear = 0.01
    robot = driven("rfrfr", ratio=gear)
    home = solve_home(robot).motors
    np.testing.assert_allclose(home, [259.0, 55.0])
    for way, doubted in ((0.0, False), (6.0, False), (9.0, False), (145.8, True)):
        motors = home + [way / gear, 0.0]
        assert bool(motors_doubt(robot.description, motors, [home])) == doubted
    ahead = motors + [0.1 / gear, 0.0]
    assert not motors_doubt(robot.description, ahead, [home, motors])


@pytest.mark.parametrize(
    ("name", "position", "near", "says"),
    [
        ("rfrfr", [0.0, 830.0, 0.0], [0.0, 0.83, 0.0], f"(0, 830, 0) {MILLIMETRES}"),
        ("rfrfr", [0.0, 5.0, 0.0], [0.0, 0.83, 0.0], ""),  # out of reach, in metres
        ("rfrfr", [0.0, 830.0, 0.0], [0.0, 829.0, 0.0], ""),
        ("gough_stewart", [0.0, 0.0, 450.0], [0.0, 0.0, 0.45], f"(0, 0, 450) {MILLIMETRES}"),
    ],
)
def test_platforms_are_not_sent_where_no_robot_is(name, position, near, says):
    description = load_robot(name).description
    doubt = position_doubt(description, np.array(position), [np.array(near)])
    assert doubt.endswith(says)
    assert bool(doubt) == bool(says)


@pytest.mark.parametrize(
    ("before", "meant", "doubted"),
    [
        ({}, 0.25, 20.0),
        ({"link": [1.0, 0.0, 0.0]}, 10.0, 1000.0),
        (RAIL, 0.25, 20.0),
        (RAIL | {"limits": {"position": [-4.0, 4.0]}}, 40.0, 1000.0),
    ],
    ids=["rods alone", "arms", "rails", "rails with limits"],
)
@pytest.mark.filterwarnings("ignore::cpr_core.DescriptionWarning")
def test_arms_and_rails_longer_than_rods_lead_farther(before, meant, doubted):
    """Flexures of 2 cm behind arms of a metre, or on rails of 8 m, move a platform by metres."""
    content = as_chains("rfrfr", links=False)
    content["rod"]["length"] = 0.02
    for number, leg in enumerate(content["legs"]):
        leg["base"]["position"] = [0.02 * number, 0.0, 0.0]
        if before:
            leg["chain"].insert(0, dict(before))
    if "motor" in before:  # both on one
        content["home"]["motors"].insert(0, 0.0)
        content["controlled"] = []
        content["legs"][1]["chain"][0].pop("limits", None)  # said once
    description = read_description(content)
    home = np.zeros(3)
    assert not position_doubt(description, np.array([0.0, meant, 0.0]), [home])
    assert position_doubt(description, np.array([0.0, doubted, 0.0]), [home])


def test_quaternions_are_doubted_where_the_other_order_is_near():
    start = np.array([0.9434, -0.0406, -0.0496, 0.3255])
    w, x, y, z = start
    for sign in (1.0, -1.0):
        assert quaternion_order_doubt(sign * np.array([x, y, z, w]), start)
    assert not quaternion_order_doubt(start, start)
    assert not quaternion_order_doubt(np.array([0.0, 1.0, 0.0, 0.0]), start)
    # A third of a turn about the diagonal has four equal numbers, in any order; of either sign.
    diagonal = np.full(4, 0.5)
    assert not quaternion_order_doubt(-diagonal, diagonal)


def test_a_pitch_in_degrees_is_refused_in_radians():
    with pytest.raises(InvalidRequest, match=r"at most pi/2 rad, got -5\.0 rad"):
        solve_inverse(load_robot("three_rfs"), [0.72, 10.0, -5.0])

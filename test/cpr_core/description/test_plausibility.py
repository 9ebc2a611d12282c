# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Mistakes of newcomers: other units, other orders, words for numbers; answered in their own words."""

import re
import warnings

import numpy as np
import pytest
import yaml
from helpers.chain_robots import as_chains
from helpers.fed_robots import fed, plain_content
from helpers.shipped_steps import CHAINS
from helpers.yaml_content import shipped_content

from cpr_core import (
    DescriptionError,
    DescriptionWarning,
    InvalidRequest,
    Loads,
    NotReached,
    find_equilibria,
    kinemato_statics,
    load_robot,
    restore_equilibrium,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
    spectrum,
    trace,
    trace_through,
)
from cpr_core.description.description_file import read_description, shipped_robots
from cpr_core.description.plausibility import (
    motors_doubt,
    position_doubt,
    quaternion_order_doubt,
)
from cpr_core.workspace import map_workspace, motor_grid, pose_grid

MILLIMETRES, DEGREES = "looks like millimetres, expected metres", "looks like degrees"


def put(content, path, value):
    *parts, last = path
    for part in parts:
        content = content[part]
    content[last] = value


def soft(content):
    """Silicone: as soft as a modulus in MPa of a metal looks."""
    content["rod"] |= {"young_modulus": 1e5, "shear_modulus": 4e4, "density": 1070.0}


@pytest.mark.parametrize("name", shipped_robots())
def test_shipped_robots_are_beyond_doubt(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        _ = solve_home(load_robot(name))


@pytest.mark.parametrize(
    ("path", "value", "field", "says"),
    [
        (("rod", "length"), 800.0, "rod.length", f"got 800: {MILLIMETRES}"),
        (
            ("rod", "section", "radius"),
            1.0,
            "rod.section",
            f"radius 1.0 for a rod 0.8 m long: {MILLIMETRES}",
        ),
        (
            ("rod", "young_modulus"),
            210.0,
            "rod.young_modulus",
            "got 210: looks like GPa, expected Pa",
        ),
        (
            ("rod", "shear_modulus"),
            82.0,
            "rod.shear_modulus",
            "got 82: looks like GPa, expected Pa",
        ),
        (("rod", "young_modulus"), 210e15, "rod.young_modulus", "no material is as stiff"),
    ],
)
def test_what_cannot_be_a_rod_is_refused(path, value, field, says):
    content = shipped_content("three_rfs")
    put(content, path, value)
    with pytest.raises(DescriptionError) as caught:
        load_robot(content)
    assert caught.value.field == field
    assert says in caught.value.problem


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        (("rod", "length"), 45.0, f"rod.length: 45 m: {MILLIMETRES}"),
        (("rod", "young_modulus"), 210e3, "rod.young_modulus: 210000: looks like MPa"),
        (("rod", "density"), 7.8, r"rod.density: 7.8: looks like g/cm\^3"),
        (("rod", "yield_strain"), 2.0, "rod.yield_strain: 2: looks like per cent"),
        (("rod", "yield_strain"), 0.3, "rod.yield_strain: 0.3: .*, 0.01 for 1 %"),
        (("home", "motors"), [309.0] * 3, rf"home.motors\[0\]: 309: {DEGREES}"),
        (
            ("legs", 1, "motor", "limits", "position"),
            [-90, 90],
            rf"legs\[1\].motor.limits.position: -90: {DEGREES}",
        ),
        (
            ("legs", 1, "base", "position"),
            [-100.0, 173.0, 0.0],
            rf"base.position .*: {MILLIMETRES}",
        ),
        (("legs", 2, "tip", "position"), [-50.0, -86.0, 0.0], rf"legs\[2\].tip.*{MILLIMETRES}"),
        (
            ("platform", "center_of_mass"),
            [0.0, 0.0, 20.0],
            f"platform.center_of_mass: .*{MILLIMETRES}",
        ),
        (
            ("home", "platform"),
            {"position": [0, 0, 700.0]},
            f"home.platform.position: .*{MILLIMETRES}",
        ),
        (
            ("home", "platform"),
            {"position": [0, 0, 0.7], "quaternion_wxyz": [0.0, 0.0, 0.28, 0.96]},
            r"home.platform.quaternion_wxyz: .* turn by 180 degrees: looks like x y z w",
        ),
    ],
)
def test_what_looks_like_another_unit_is_said(path, value, says):
    content = shipped_content("three_rfs")
    put(content, path, value)
    with pytest.warns(DescriptionWarning, match=says):
        read_description(content)


@pytest.mark.parametrize("strain", [0.001, 0.006, 0.015, 0.08])
def test_strains_that_steel_carbon_and_nitinol_bear_are_beyond_doubt(strain):
    content = shipped_content("three_rfs")
    content["rod"]["yield_strain"] = strain
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        read_description(content)


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        (("chain", 0, "limits"), {"position": [-90, 90]}, rf"limits\.position: -90: {DEGREES}"),
        (("chain", 0, "limits"), {"position": [-1, 90]}, rf"limits\.position: 90: {DEGREES}"),
        (("chain", 0, "offset"), 45, rf"offset: 45: {DEGREES}"),
        (("chain", 2, "rest"), [0, 30], rf"rest: 30: {DEGREES}"),
        (
            ("chain", 0),
            {"joint": "prismatic", "axis": [0, 0, 1], "motor": "motor2", "offset": 50},
            rf"offset: 50: {MILLIMETRES}",
        ),
        (
            ("chain", 2),
            {"joint": "prismatic", "axis": [0, 0, 1], "stiffness": 100.0, "rest": -20},
            rf"rest: -20: {MILLIMETRES}",
        ),
        (("chain", 1, "link"), [23.1, 0, 0], rf"link: 23.1 m, more than .*{MILLIMETRES}"),
        (("chain", 1, "center_of_mass"), [0, 12, 0], rf"center_of_mass: 12 m.*{MILLIMETRES}"),
        (("chain", 3, "rod"), {"length": 53.0}, rf"rod\.length: 53 m: {MILLIMETRES}"),
        (("chain", 3, "rod"), {"density": 4.4}, r"rod\.density: 4.4: looks like g/cm\^3"),
    ],
)
def test_what_looks_like_another_unit_in_a_chain_is_said(path, value, says):
    content = shipped_content("six_rus")
    put(content["legs"][1], path, value)
    with pytest.warns(DescriptionWarning, match=rf"legs\[1\]\.chain\[{path[1]}\]\.{says}"):
        read_description(content)


def test_a_rod_of_a_chain_that_is_fed_millimetres_is_said():
    content = shipped_content("six_rus")
    content["legs"][0]["chain"][3] = {
        "rod": {"rest_curvature": {}},
        "motor": "feed",
        "limits": {"position": [100, 600]},
    }
    content |= {"controlled": [], "home": {"motors": [0, 0.5, 0, 0, 0, 0, 0], "bow": "outward"}}
    with pytest.warns(
        DescriptionWarning, match=rf"chain\[3\]\.limits\.position: 100: {MILLIMETRES}"
    ):
        read_description(content)


@pytest.mark.parametrize(
    ("path", "value", "field", "says"),
    [
        (
            ("chain", 1, "link"),
            [231.64, 0, 0],
            "chain[1].link",
            f"[231.64, 0.0, 0.0]: {MILLIMETRES}",
        ),
        (("chain", 1, "center_of_mass"), [0, 0, 115], "chain[1].center_of_mass", MILLIMETRES),
        (  # not hidden by a link that is only doubted
            ("chain", 1),
            {"link": [23.1, 0, 0], "mass": 0.1, "center_of_mass": [0, 0, 115]},
            "chain[1].center_of_mass",
            MILLIMETRES,
        ),
        (
            ("chain", 3, "rod"),
            {"young_modulus": 110},
            "chain[3].rod.young_modulus",
            "looks like GPa",
        ),
    ],
)
def test_what_cannot_be_in_a_chain_is_refused(path, value, field, says):
    content = shipped_content("six_rus")
    put(content["legs"][1], path, value)
    with pytest.raises(DescriptionError) as caught:
        read_description(content)
    assert caught.value.field == f"legs[1].{field}"
    assert says in caught.value.problem


@pytest.mark.parametrize("joints", [{"leg2.joint2": [0.1, 45]}, {"leg2.joint2[1]": 45}])
def test_rough_joints_in_degrees_are_said(joints):
    content = shipped_content("six_rus")
    content["home"]["joints"] = joints
    with pytest.warns(DescriptionWarning, match=rf"home\.joints\.leg2\.joint2\[1\]: 45: {DEGREES}"):
        read_description(content)


def test_the_zero_of_a_motor_in_degrees_is_said():
    content = shipped_content("three_rfs")
    content["legs"][1]["motor"]["offset"] = -270
    with pytest.warns(DescriptionWarning, match=rf"legs\[1\]\.motor\.offset: -270: {DEGREES}"):
        read_description(content)


def said_of(content):
    """What is doubted in a description, without its name."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", DescriptionWarning)
        read_description(content)
    return [str(warning.message).partition(": ")[2] for warning in caught]


def test_a_lead_in_millimetres_is_said_and_not_what_follows_from_it():
    """Its limits and home looked like degrees, and nobody named the lead."""
    content = fed(plain_content())
    assert said_of(content) == []
    content["legs"][1]["motor"]["lead"] = -20.0
    assert said_of(content) == [f"legs[1].motor.lead: -20: {MILLIMETRES}?"]
    content = shipped_content("three_prs")
    content["legs"][0]["chain"][0] |= {"lead": 4, "limits": {"position": [-30, 150]}}
    assert said_of(content) == [f"legs[0].chain[0].lead: 4: {MILLIMETRES}?"]


@pytest.mark.parametrize("gear", [{"lead": 0.002}, {"ratio": -0.0003}])
def test_limits_of_a_joint_that_stand_at_a_motor_with_a_gear_are_doubted(gear):
    """A motor in radians with a range or a speed in metres hardly moves."""
    content = shipped_content("three_prs")
    joint, name = content["legs"][0]["chain"][0], next(iter(gear))
    joint |= gear | {"limits": {"position": [-0.1, 0.1], "speed": 0.1}}
    words = (
        rf"legs\[0\]\.chain\[0\]\.limits\.{{}} is .* m{{}} behind the {name}: limits are of the "
    )
    [said] = said_of(content)
    assert re.match(words.format("position: a range of 0.2 .*", ""), said)
    joint["limits"]["position"] = [-1000, 1000]
    [said] = said_of(content)
    assert re.match(words.format("speed: 0.1 .*", "/s"), said)
    joint["limits"]["speed"] = 100.0
    assert said_of(content) == []


def test_an_inertia_in_square_millimetres_is_said():
    content = shipped_content("three_rfs")
    content["platform"] = {"mass": 0.3, "inertia": [1500, 1500, 3000, 0, 0, 0]}
    with pytest.warns(
        DescriptionWarning, match=r"platform\.inertia: 3000 with 0\.3 kg: looks like kg"
    ):
        read_description(content)


@pytest.mark.parametrize("name", CHAINS)
def test_robots_of_chains_are_beyond_doubt(name):
    content = shipped_content(name)
    if content["platform"].get("shape", "body") == "body":
        content["platform"] |= {"mass": 0.3, "inertia": [0.0015, 0.0015, 0.003, 0, 0, 0]}
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        _ = solve_home(load_robot(content))


def test_rods_of_silicone_and_of_glass_fibre_are_beyond_doubt():
    content = shipped_content("three_rfs")
    soft(content)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        read_description(content)
        content["rod"]["section"]["radius"] = 5e-6
        content["rod"]["length"] = 9.0
        read_description(content)


def test_extensible_legs_in_millimetres_are_said():
    content = shipped_content("gough_stewart")
    content["home"]["motors"] = [450.0] * 6
    with pytest.warns(DescriptionWarning, match=rf"home\.motors\[0\]: 450: {MILLIMETRES}"):
        read_description(content)


@pytest.mark.parametrize("written", ["once", "in every chain"])
def test_motors_in_millimetres_are_said_however_rods_are_written(written):
    """Rods of chains may be all there are: what a leg would have without them is much longer."""
    content = shipped_content("three_prs")
    content["home"]["motors"] = [100.0] * 3
    if written == "in every chain":
        for leg in content["legs"]:
            leg["chain"][3] = {"rod": dict(content["rod"])}
        content["rod"] |= {"length": 10.0, "rest_curvature": {}}
    with pytest.warns(DescriptionWarning, match=rf"home\.motors\[0\]: 100: {MILLIMETRES}"):
        read_description(content)


def test_a_planar_quaternion_in_another_order_is_refused_with_the_order():
    content = shipped_content("planar_body")
    content["home"]["platform"] = {"position": [0, 0.5, 0], "quaternion_wxyz": [0, 0, 0.6, 0.8]}
    with pytest.raises(DescriptionError, match="about z in a planar robot, w 0 0 z"):
        read_description(content)


# Requests.


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


# Where robots are sent.

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


PUBLIC = {
    "solve_forward": lambda robot: solve_forward(robot, [2.59, 0.55]),
    "solve_forward_by_effort": lambda robot: solve_forward_by_effort(robot, [0.0, 0.0]),
    "solve_inverse": lambda robot: solve_inverse(robot, [0.0, 0.8]),
    "trace": lambda robot: trace(robot, motors=[2.6, 0.6]),
    "trace_through": lambda robot: trace_through(robot, motors=[[2.6, 0.6]]),
    "find_equilibria": lambda robot: find_equilibria(robot, [2.6, 0.6]),
    "restore_equilibrium": lambda robot: restore_equilibrium(
        robot, Loads.none(), [], [], [], np.eye(3), [0, 0, 0]
    ),
    "pose_grid": lambda robot: pose_grid(robot, {"x": [0.0, 0.1]}),
    "motor_grid": lambda robot: motor_grid(robot, {"motor1": [0.0, 0.1]}),
    "map_workspace": lambda robot: map_workspace(
        robot, pose_grid(load_robot("rfrfr"), {"x": [0.0, 0.1], "y": [0.8, 0.9]})
    ),
}


@pytest.mark.parametrize("name", PUBLIC)
def test_a_name_in_place_of_a_robot_is_refused_with_how_to_load_one(name):
    with pytest.raises(InvalidRequest, match=r"robot: .*load_robot\('rfrfr'\) loads one"):
        PUBLIC[name]("rfrfr")
    with pytest.raises(InvalidRequest, match=r"robot: expected a Robot, got 3\.5"):
        PUBLIC[name](3.5)


# Content and texts.


@pytest.mark.parametrize("name", shipped_robots())
def test_a_description_may_be_given_as_text(name):
    text = shipped_robots()[name].read_text()
    description = read_description(text)
    assert (description.name, description.text) == (name, text)
    assert load_robot(
        yaml.safe_dump(shipped_content(name), default_flow_style=True)
    ).description.name


@pytest.mark.parametrize("text", ["name: x\nspace: [", "just\nwords", "{name: x}"])
def test_texts_that_are_no_description_are_refused_shortly(text):
    with pytest.raises(DescriptionError) as caught:
        load_robot(text + "\n" + 500 * "# more\n" if "{" not in text else text)
    assert caught.value.source == "description"
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("name", shipped_robots())
def test_shipped_files_are_numbers_in_every_yaml(name):
    content = shipped_content(name)
    assert isinstance(content["rod"]["young_modulus"], float)
    stiff = 210e9
    for word in ("210e9", "2.1e11", "2.1E11", "+21.e10"):
        content["rod"]["young_modulus"] = word
        assert read_description(content).legs[0].rod.young_modulus == pytest.approx(stiff)
    content["name"] = "1e5"
    assert read_description(content).name == "1e5"
    for word in ("210e9 Pa", "e9", "1e", "12", "inf"):
        content["rod"]["young_modulus"] = word
        with pytest.raises(DescriptionError, match=r"rod\.young_modulus: expected number"):
            read_description(content)


# Home.


def test_one_vector_is_the_side_of_all_rods():
    content = shipped_content("rfrfr")
    content["home"] = {"motors": [1.7, 1.4], "bow": [1, 0, 0]}
    robot = load_robot(content)
    content["home"]["bow"] = [[1, 0, 0], [1, 0, 0]]
    for side, same in zip(
        robot.description.home.bow, load_robot(content).description.home.bow, strict=True
    ):
        np.testing.assert_array_equal(side, same)
        assert side[0] > 0.9
    content["home"]["bow"] = [0, 0, 1]
    with pytest.raises(DescriptionError, match=r"home\.bow: expected z = 0"):
        load_robot(content)


def test_one_vector_is_the_side_of_all_rods_in_space():
    content = shipped_content("gough_stewart")
    content["home"]["bow"] = [0, 0, 1]
    with pytest.raises(DescriptionError, match=r"home\.bow: .*across the tangent of leg1"):
        load_robot(content)
    content = shipped_content("three_rfs")
    content["home"] = {"motors": [0.0] * 3, "bow": [0, 0, 1]}
    for side in load_robot(content).description.home.bow:
        np.testing.assert_allclose(side, [0, 0, 1], atol=1e-12)


@pytest.mark.parametrize("size", [1e-7, 1e-3, 3.0])
@pytest.mark.parametrize("side", ["outward", "inward", [2e-7, 0.0, 1e-7]])
def test_sides_of_rods_do_not_depend_on_the_size_of_a_robot(size, side):
    content = shipped_content("rfrfr")
    content["home"]["bow"] = side if isinstance(side, str) else [side[0], side[2], 0.0]
    same = read_description(content).home.bow
    content["rod"]["length"] *= size
    content["rod"]["section"]["radius"] *= size
    for leg in content["legs"]:
        leg["base"]["position"] = [size * number for number in leg["base"]["position"]]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DescriptionWarning)  # of micrometres, or kilometres
        bows = read_description(content).home.bow
    np.testing.assert_allclose(bows, same, atol=1e-9)


@pytest.mark.parametrize("size", [1e-7, 1.0])
def test_there_is_no_outside_in_the_middle_of_the_bases(size):
    content = shipped_content("rfrfr")
    content["rod"]["length"] *= size
    content["rod"]["section"]["radius"] *= size
    for leg, noise in zip(content["legs"], (1e-17, -1e-17), strict=True):
        leg["base"]["position"] = [size * noise, 0.0, 0.0]
    content["home"]["bow"] = "outward"
    with (
        warnings.catch_warnings(),
        pytest.raises(DescriptionError, match=r"home\.bow: expected a side across"),
    ):
        warnings.simplefilter("ignore", DescriptionWarning)
        read_description(content)


def test_a_rough_pose_far_from_home_is_said():
    content = shipped_content("rfrfr")
    content["home"]["platform"] = {"position": [0, 1.2, 0]}
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        _ = solve_home(load_robot(content))
    content["home"]["platform"] = {"position": [0, 3.0, 0]}
    robot = load_robot(content)
    with pytest.warns(
        DescriptionWarning, match=r"home\.platform\.position: .* is 2\.16 m from there"
    ):
        home = solve_home(robot)
    assert home.converged


# What people look for.


@pytest.mark.parametrize(("name", "length"), [("rfrfr", 1.0), ("delta", 0.4)])
def test_a_robot_far_from_the_origin_of_the_world_is_said(name, length):
    content = shipped_content(name)
    content["home"].pop("platform", None)
    content["home"]["bow"] = "outward"
    bases = [leg["base"]["position"] for leg in content["legs"]]
    for far, said in ((0.9e5 * length, False), (1.1e5 * length, True)):
        for leg, (x, y, z) in zip(content["legs"], bases, strict=True):
            leg["base"]["position"] = [x, y - far, z]
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            load_robot(content)
        told = [str(each.message) for each in caught]
        assert [" more than 100000 rod lengths from the origin" in text for text in told] == [
            True
        ] * said


def test_values_are_shown_in_a_line():
    robot = load_robot("six_rfs")
    found = trace(robot, motors=solve_home(robot).motors + 0.01, points=3)
    loads = robot.default_loads.with_(gravity=[0, 0, -9.81])
    for value in (
        robot,
        robot.description,
        robot.description.legs[0],
        solve_home(robot),
        found,
        loads,
    ):
        assert len(repr(value)) < 200
        assert "\n" not in repr(value)
    assert "six_rfs" in repr(robot)
    assert "3 equilibria" in repr(found)
    assert repr(loads) == "<Loads: gravity=[0.0, 0.0, -9.81]>"


@pytest.mark.parametrize("name", shipped_robots())
def test_an_equilibrium_says_whether_it_is_stable_and_where_it_is(name):
    home = solve_home(load_robot(name))
    assert home.stable
    assert home.margin == pytest.approx(spectrum(home).margin)
    assert kinemato_statics(home).jacobian.shape == (
        len(home.robot.platform_axes),
        home.robot.motor_count,
    )
    np.testing.assert_allclose(solve_inverse(home.robot, home.pose).motors, home.motors, atol=1e-9)


def test_no_stability_is_read_from_energy_where_there_is_none():
    robot = load_robot("six_rfs")
    loads = Loads.none().with_(wrench_body=[0, 0, 0, 0.01, 0, 0])
    loaded = solve_forward(robot, solve_home(robot).motors, loads=loads)
    assert loaded.index_locked == 0
    assert not loaded.stable


def test_loads_of_the_description_stay_where_others_are_added():
    robot = load_robot("three_rfs")
    wrench = [0, 0, 0, 0.1, 0, 0]
    loads = robot.default_loads.with_(wrench_world=wrench)
    np.testing.assert_array_equal(loads.gravity, [0, 0, -9.81])
    np.testing.assert_array_equal(loads.wrench_world, wrench)
    kept = solve_forward(robot, solve_home(robot).motors, loads=loads)
    lost = solve_forward(
        robot, solve_home(robot).motors, loads=Loads.none().with_(wrench_world=wrench)
    )
    assert np.linalg.norm(kept.platform_position - lost.platform_position) > 1e-3

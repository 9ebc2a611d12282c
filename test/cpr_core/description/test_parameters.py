# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers of descriptions by their paths: found, changed, refused."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
import yaml
from helpers.parameter_kinds import parameter_kinds
from numpy.testing import assert_array_equal

from cpr_core import (
    DescriptionError,
    InvalidRequest,
    MotorLimitExceeded,
    NonFiniteInput,
    Robot,
    UnknownParameter,
    continued,
    derivatives,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.description.changed_description import between, named_parameters, shifted
from cpr_core.description.description_file import shipped_robots
from cpr_core.model.varied_numbers import numbers_of
from cpr_core.solving.limits import limits_of

ROBOTS = list(shipped_robots())
SIX_RFS = shipped_robots()["six_rfs"].read_text(encoding="utf-8")
#: A rod that takes all from the robot's, and one that has a length of its own.
SHARED = """
name: shared
space: planar
rod: {length: 0.5, section: {shape: circular, radius: 0.001}, young_modulus: 210e9, shear_modulus: 82e9}
strain: {bending_3: 4}
platform: {shape: point}
legs:
- base: {position: [-0.2, 0, 0], tangent: [0, 1, 0]}
  chain:
  - {joint: revolute, axis: [0, 0, 1], motor: m1}
  - {link: [0.02, 0, 0]}
  - {rod: {}}
  tip: {type: spherical, position: [0, 0, 0]}
- base: {position: [0.2, 0, 0], tangent: [0, 1, 0]}
  chain:
  - {joint: revolute, axis: [0, 0, 1], motor: m2}
  - {link: [0.02, 0, 0]}
  - {rod: {length: 0.6}}
  tip: {type: spherical, position: [0, 0, 0]}
controlled: [x, y]
home: {motors: [0.3, -0.3], bow: outward}
"""


def same(first, second):
    """Whether two robots are the same to the kernels."""
    for name, value in first.arrays._asdict().items():
        other = getattr(second.arrays, name)
        if isinstance(value, np.ndarray):
            assert value.tobytes() == other.tobytes(), name
        else:
            assert value == other, name


def test_values_are_those_of_the_file():
    robot = load_robot("six_rfs")
    content = yaml.safe_load(SIX_RFS)
    paths = ["rod.length", "rod.density", "legs[3].base.position[1]", "legs[5].tip.position[0]"]
    legs = content["legs"]
    expected = [1.0, 7800.0, legs[3]["base"]["position"][1], legs[5]["tip"]["position"][0]]
    assert_array_equal(robot.parameter_values(paths), expected)
    assert robot.parameter_values("rod.young_modulus") == [2.1e11]


def test_defaults_count_as_written():
    robot = load_robot("six_rus")
    paths = [
        "legs[0].chain[0].offset",
        "legs[0].chain[0].ratio",
        "legs[1].chain[1].center_of_mass[0]",
    ]
    crank = robot.parameter_values("legs[1].chain[1].link[0]")[0]
    assert_array_equal(robot.parameter_values(paths), [0.0, 1.0, 0.5 * crank])
    changed = robot.with_parameters({"platform.center_of_mass[2]": 0.1, paths[1]: 2.0})
    assert_array_equal(changed.description.center_of_mass, [0.0, 0.0, 0.1])
    assert changed.description.legs[0].chain[0].ratio == 2.0


@pytest.mark.parametrize("name", ["rfrfr", "planar_body", "six_rfs", "gough_stewart"])
def test_ratios_of_the_short_form_that_are_not_written_are_one(name):
    """As those of chains; the legs stay what they are, and robots beside them have other ratios."""
    path = "legs[0].motor.ratio"
    robot = load_robot(name)
    assert robot.parameter_values(path) == [1.0]
    assert robot.description.legs[0].elements is None
    richer = load_robot(name, modes=7)
    changed = richer.with_parameters({path: 1.5})
    assert changed.description.legs[0].chain[0].ratio == 1.5
    assert changed.description.legs[0].rods[0].modes == richer.description.legs[0].modes
    same(richer, changed.with_parameters({path: 1.0}))

    home, change = solve_home(robot), 2e-5
    found = derivatives(home, path, of=("pose", "efforts"))
    above, below = (
        continued(home, robot.with_parameters({path: 1.0 + sign * change})) for sign in (1, -1)
    )
    position = (above.platform_position - below.platform_position) / (2.0 * change)
    efforts = (above.efforts - below.efforts) / (2.0 * change)
    np.testing.assert_allclose(found.position.ravel(), position, atol=1e-6)
    np.testing.assert_allclose(found.efforts.ravel(), efforts, rtol=1e-5, atol=1e-6)


def test_a_joint_that_turns_has_no_lead():
    with pytest.raises(UnknownParameter):
        load_robot("six_rfs").parameter_values("legs[0].motor.lead")


@pytest.mark.parametrize("name", ROBOTS)
def test_every_number_can_be_set(name):
    """To what it is: nothing changes, whatever is written out; and to something else and back."""
    robot = load_robot(name)
    paths = parameter_kinds(robot)
    values = dict(zip(paths, robot.parameter_values(paths), strict=True))
    same(robot, robot.with_parameters(values))
    moved = 0
    for path in paths:
        value = values[path]
        try:
            away = robot.with_parameters({path: 1.001 * value if value else 1e-3})
        except DescriptionError:
            continue  # z in the plane, a direction that alone is no more across the other
        assert away.parameter_values(path)[0] != value
        same(robot, away.with_parameters({path: value}))
        moved += 1
    assert moved > 20


@pytest.mark.parametrize("name", ROBOTS)
def test_the_text_loads_and_is_the_same_robot(name):
    robot = load_robot(name)
    force = robot.parameter_values("loads.platform_force[0]")[0] + 0.25
    changed = robot.with_parameters({"rod.length": 0.7, "loads.platform_force[0]": force})
    again = load_robot(changed.description.text)
    same(again, changed)
    assert_array_equal(again.default_loads.wrench_world, changed.default_loads.wrench_world)
    assert again.default_loads.wrench_world[3] == force
    assert load_robot(yaml.safe_load(SIX_RFS)).description.text == ""


def test_a_changed_description_keeps_the_letters_of_its_names():
    name = "\u00e9t\u00e9 \u0440\u043e\u0431\u043e\u0442"
    robot = load_robot(SIX_RFS.replace("name: six_rfs", f"name: {name}"))
    text = robot.with_parameters({"rod.length": 0.7}).description.text
    assert f"name: {name}" in text.splitlines()
    assert load_robot(text).description.name == name


def test_the_top_of_a_file_is_inherited_as_it_is_seen_there():
    robot = load_robot(SHARED)
    longer = robot.with_parameters({"rod.length": 0.55})
    assert [rod.rod.length for rod in longer.description.rods] == [0.55, 0.6]
    assert_array_equal(robot.parameter_values("legs[0].chain[2].rod.section.radius"), [0.001])
    thicker = robot.with_parameters({"legs[0].chain[2].rod.section.radius": 0.002})
    assert [rod.rod.section.radius for rod in thicker.description.rods] == [0.002, 0.001]
    both = thicker.with_parameters({"rod.section.radius": 0.003})
    assert [rod.rod.section.radius for rod in both.description.rods] == [0.002, 0.003]


def test_what_is_said_once_for_two_legs_changes_in_the_leg_that_is_named():
    link = SHARED.replace("- {link: [0.02, 0, 0]}", "- &link {link: [0.02, 0, 0]}", 1)
    robot = load_robot(link.replace("- {link: [0.02, 0, 0]}", "- *link"))
    changed = robot.with_parameters({"legs[1].chain[1].link[0]": 0.05})
    assert [leg.chain[1].offset[0] for leg in changed.description.legs] == [0.02, 0.05]
    assert [leg.chain[1].offset[0] for leg in robot.description.legs] == [0.02, 0.02]


def test_a_wildcard_is_every_leg():
    robot = load_robot(SHARED)
    changed = robot.with_parameters(
        {"legs[*].chain[1].link[0]": 0.03, "legs[*].chain[0].offset": 0.1}
    )
    assert [leg.chain[1].offset[0] for leg in changed.description.legs] == [0.03, 0.03]
    assert [leg.chain[0].zero for leg in changed.description.legs] == [0.1, 0.1]
    assert changed.parameter_values("legs[*].chain[*].link[0]") == [0.03]
    with pytest.raises(InvalidRequest, match=r"no single value: -0\.2, 0\.2; name the places"):
        robot.parameter_values("legs[*].base.position[0]")


@pytest.mark.parametrize("legs", ["0,1", "1,0"])
def test_several_legs_are_one_number(legs):
    """As of a motor that moves two legs, whose zero stands in both."""
    robot = load_robot("delta")
    changed = robot.with_parameters({f"legs[{legs}].chain[0].offset": 0.1})
    zeros = [leg.chain[0].zero for leg in changed.description.legs]
    assert zeros == [0.1, 0.1, 0.0, 0.0, 0.0, 0.0]
    assert changed.parameter_values(f"legs[{legs}].chain[0].offset") == [0.1]
    assert changed.parameter_values("legs[2,3,5].chain[*].offset") == [0.0]
    assert robot.parameter_values(f"legs[{legs}].tip.position[2]") == [0.0]
    assert robot.parameter_values("gravity[0,1]") == [0.0]
    with pytest.raises(InvalidRequest, match=r"no single value: 0\.1, 0; name the places"):
        changed.parameter_values("legs[1,2].chain[0].offset")
    with pytest.raises(InvalidRequest, match=r"legs\[1\]\.chain\[0\]\.offset is given two values"):
        robot.with_parameters(
            {f"legs[{legs}].chain[0].offset": 0.1, "legs[1].chain[0].offset": 0.2}
        )


def test_nothing_of_the_first_robot_changes():
    content = yaml.safe_load(SIX_RFS)
    before = copy.deepcopy(content)
    robot = load_robot(content)
    robot.with_parameters({"rod.length": 0.9, "legs[*].tip.position[2]": 0.01})
    assert content == before
    assert robot.parameter_values("rod.length") == [1.0]


def test_strain_modes_and_held_motors_are_kept():
    robot = Robot(load_robot("four_rfr", modes=7).description, (1,))
    changed = robot.with_parameters({"rod.length": 0.8})
    assert [rod.modes for rod in changed.description.rods] == [
        rod.modes for rod in robot.description.rods
    ]
    assert changed.held_motors == (1,)


def test_a_default_follows_what_it_is_of_where_one_of_its_entries_is_given():
    """The middle of a link that gets longer in the same call, as where one call follows the other."""
    robot = load_robot(SHARED)
    end, middle = "legs[0].chain[1].link[0]", "legs[0].chain[1].center_of_mass[1]"
    for changed in (
        robot.with_parameters({middle: 0.003, end: 0.06, "rod.length": 0.45}),
        robot.with_parameters({end: 0.06, middle: 0.003, "rod.length": 0.45}),
        robot.with_parameters({end: 0.06, "rod.length": 0.45}).with_parameters({middle: 0.003}),
    ):
        link = changed.description.legs[0].chain[1]
        assert (link.offset, link.center_of_mass) == ((0.06, 0.0, 0.0), (0.03, 0.003, 0.0))
        assert changed.description.rods[0].rod.length == 0.45
        assert load_robot(changed.description.text).description.legs[0].chain[1].offset[0] == 0.06


def half_moved():
    """A robot with a universal joint of which a motor turns the first axis; defaults and one value."""
    content = yaml.safe_load(shipped_robots()["six_rus"].read_text(encoding="utf-8"))
    content["legs"][0]["chain"][2] |= {"motor": ["m", None], "stiffness": 0.2}
    content |= {"controlled": [], "home": {"motors": [0] * 7, "bow": "outward"}}
    return load_robot(content)


@pytest.mark.parametrize(
    ("path", "value", "before", "attributes"),
    [
        ("offset", 0.1, 0.0, {"zero": (0.1, 0.0)}),
        ("offset[0]", 0.1, 0.0, {"zero": (0.1, 0.0)}),
        ("ratio", 1.5, 1.0, {"ratio": (1.5, 1.0)}),
        ("ratio[0]", 1.5, 1.0, {"ratio": (1.5, 1.0)}),
        ("stiffness", 0.3, 0.2, {"stiffness": (0.0, 0.3)}),
        ("stiffness[1]", 0.3, 0.2, {"stiffness": (0.0, 0.3)}),
        ("rest", 0.1, 0.0, {"rest": (0.0, 0.1)}),
        ("rest[1]", 0.1, 0.0, {"rest": (0.0, 0.1)}),
    ],
)
def test_numbers_of_a_universal_joint_are_named_once_or_by_axis(path, value, before, attributes):
    robot, path = half_moved(), f"legs[0].chain[2].{path}"
    assert robot.parameter_values(path) == [before]
    changed = robot.with_parameters({path: value})
    turns = changed.description.legs[0].chain[2:4]
    for name, expected in attributes.items():
        assert tuple(getattr(turn, name) for turn in turns) == expected
    assert turns[1].stiffness == (0.3 if "stiffness" in path else 0.2)
    assert changed.parameter_values(path) == [value]
    middle = between(robot.description, changed.description, 0.5)
    turns = middle.legs[0].chain[2:4]
    for name, expected in attributes.items():
        own = 0 if name in ("zero", "ratio") else 1
        assert getattr(turns[own], name) == pytest.approx(0.5 * (before + expected[own]))


def test_numbers_that_an_axis_of_a_universal_joint_cannot_have_are_unknown():
    robot, joint = half_moved(), "legs[0].chain[2]"
    for path in ("offset[1]", "ratio[1]", "stiffness[0]", "rest[0]"):
        with pytest.raises(UnknownParameter):
            robot.parameter_values(f"{joint}.{path}")
    with pytest.raises(InvalidRequest, match="two values, one of them for both"):
        robot.with_parameters({f"{joint}.ratio": 2.0, f"{joint}.ratio[0]": 3.0})


HOSTILE_PATHS = [
    ("rod.youngs_modulus", UnknownParameter, "did you mean rod.young_modulus"),
    ("legs[6].tip.position[0]", UnknownParameter, r"; legs\[0\] to legs\[5\] are leg1 to leg6$"),
    ("legs[*].tip.positio[0]", UnknownParameter, r"did you mean legs\[\*\].tip.position\[0\]"),
    ("legs[0,6].tip.position[0]", UnknownParameter, r"no number legs\[6\].tip.position\[0\]; legs"),
    ("legs[6,*].tip.position[0]", InvalidRequest, "expected a path"),
    ("legs[0,].tip.position[0]", InvalidRequest, "expected a path"),
    ("legs[0:2].tip.position[0]", InvalidRequest, "expected a path"),
    ("legs[1,3,1].tip.position[0]", InvalidRequest, r"tip.position\[0\]: entry 1 is named twice"),
    ("legs[0].tip.position[3]", UnknownParameter, "no number"),
    ("legs[0].rod.length", UnknownParameter, "did you mean rod.length"),
    ("zzzzzzzzzz", UnknownParameter, "no number zzzzzzzzzz$"),
    ("rod[0]", UnknownParameter, r"rod\[0\]"),
    ("rod.length.x", UnknownParameter, "rod.length.x"),
    ("rod", InvalidRequest, "has the fields length, section"),
    ("legs", InvalidRequest, r"legs\[0\] to legs\[5\]"),
    ("name", InvalidRequest, "no number but 'six_rfs'"),
    ("rod.section.shape", InvalidRequest, "circular"),
    ("strain.bending_3", InvalidRequest, "how many unknowns"),
    ("", InvalidRequest, "expected a path"),
    ("legs[0", InvalidRequest, "expected a path"),
    ("legs[-1].tip.position[0]", InvalidRequest, "expected a path"),
    ("legs[0]. tip", InvalidRequest, "expected a path"),
    ("rod.length\n", InvalidRequest, "expected a path"),
]


#: Robots, paths that begin with names, and what is meant by them or known of them.
NAMED_PATHS = [
    ("six_rfs", "motor1.offset", "did you mean legs[0].motor.offset?"),
    ("six_rfs", "leg1.motor.offset", "did you mean legs[0].motor.offset?"),
    ("six_rfs", "motor3.motor.offset", "did you mean legs[2].motor.offset?"),
    ("six_rfs", "leg3.tip.postion[1]", "did you mean legs[2].tip.position[1]?"),
    ("six_rfs", "leg2.rod.young_modulus", "did you mean rod.young_modulus?"),
    ("six_rfs", "motor.offset", "did you mean legs[*].motor.offset?"),
    ("six_rfs", "motor2", "motor2 is legs[1].motor"),
    ("six_rfs", "motor2.mass", "motor2 is legs[1].motor"),
    ("six_rfs", "leg2.motor3.offset", "leg2 is legs[1], motor3 is legs[2].motor"),
    ("six_rfs", "legs[1].motor1.offset", "motor1 is legs[0].motor"),
    ("six_rfs", "leg7.motor.offset", "legs[0] to legs[5] are leg1 to leg6"),
    ("six_rfs", "motor7.offset", "legs[0] to legs[5] are leg1 to leg6"),
    ("six_rfs", "legs[6].motor.offset", "legs[0] to legs[5] are leg1 to leg6"),
    ("three_rfr_hubs", "motor1.offset", "did you mean legs[0].chain[0].offset?"),
    ("three_rfr_hubs", "leg2.chain[0].offset", "did you mean legs[1].chain[0].offset?"),
    ("three_rfr_hubs", "leg1.motor.offset", "did you mean legs[0].chain[0].offset?"),
    ("three_rfr_hubs", "leg3.joint1.ofset", "did you mean legs[2].chain[0].offset?"),
    ("delta", "motor2.offset", "did you mean legs[2,3].chain[0].offset?"),
    ("delta", "motor2.ofset", "motor2 is legs[2].chain[0] and legs[3].chain[0]"),
    ("six_rus", "leg2.joint2.stiffness", "did you mean legs[1].chain[2].stiffness?"),
]


@pytest.mark.parametrize(("name", "path", "told"), NAMED_PATHS)
def test_names_in_paths_are_never_taken_for_another_leg_or_motor(name, path, told):
    with pytest.raises(UnknownParameter) as caught:
        load_robot(name).parameter_values(path)
    assert str(caught.value).endswith(f"the description has no number {path}; {told}")


def test_paths_with_names_that_count_otherwise_are_those_of_their_parts():
    content = yaml.safe_load(SHARED)
    content["legs"][0] |= {"name": "leg2"}
    content["legs"][1] |= {"name": "leg1"}
    content["legs"][1]["chain"][0] |= {"name": "crank"}
    robot = load_robot(content)
    for path, meant in (
        ("leg2.chain[0].offset", "legs[0].chain[0].offset"),
        ("leg1.base.position[0]", "legs[1].base.position[0]"),
        ("crank.offset", "legs[1].chain[0].offset"),
        ("m2.offset", "legs[1].chain[0].offset"),
        ("motor2.offset", "legs[1].chain[0].offset"),
        ("leg1.rod1.rod.length", "legs[1].chain[2].rod.length"),
        ("leg1.rod.length", "legs[1].chain[2].rod.length"),
    ):
        with pytest.raises(UnknownParameter) as caught:
            robot.parameter_values(path)
        assert caught.value.nearest == meant


def test_the_only_rod_of_its_own_is_not_meant_by_other_legs():
    content = yaml.safe_load(SIX_RFS)
    content["legs"][1]["rod"] = content["rod"] | {"length": 1.01}
    robot = load_robot(content)
    assert robot.parameter_values("legs[1].rod.length") == [1.01]
    for path in ("legs[0].rod.length", "leg1.rod.length", "leg1.length", "length"):
        with pytest.raises(UnknownParameter) as caught:
            robot.parameter_values(path)
        assert caught.value.nearest == "rod.length"


def test_motors_and_axes_of_universal_joints_mean_their_own_entries():
    robot = half_moved()
    for path, meant in (
        ("m.offset", "legs[0].chain[2].offset[0]"),
        ("leg1.joint2[1].stiffness", "legs[0].chain[2].stiffness[1]"),
        ("leg1.joint2[1].stifness", "legs[0].chain[2].stiffness[1]"),
        ("leg1.joint2.stiffness", "legs[0].chain[2].stiffness"),
    ):
        with pytest.raises(UnknownParameter) as caught:
            robot.parameter_values(path)
        assert caught.value.nearest == meant


@pytest.mark.parametrize(("path", "kind", "told"), HOSTILE_PATHS)
def test_hostile_paths_are_refused(path, kind, told):
    robot = load_robot("six_rfs")
    for question in (robot.parameter_values, lambda path: robot.with_parameters({path: 1.0})):
        with pytest.raises(kind, match=told) as caught:
            question(path)
        assert type(caught.value) is kind
        assert caught.value.argument == "parameters"


@pytest.mark.parametrize(
    "paths", [None, 3, [], [1], ["rod.length", "rod.length"], {"a": 1}, [None]]
)
def test_what_are_no_paths(paths):
    with pytest.raises(InvalidRequest, match="parameters"):
        load_robot("six_rfs").parameter_values(paths)


HOSTILE_VALUES = [
    ({"rod.section.radius": -0.001}, DescriptionError, "above 0"),
    ({"rod.section.radius": 0.0}, DescriptionError, "above 0"),
    ({"platform.mass": -1.0}, DescriptionError, "at least 0"),
    ({"rod.length": 1000.0}, DescriptionError, "rod.length"),
    ({"rod.young_modulus": 210.0}, DescriptionError, "GPa"),
    ({"legs[0].base.tangent[0]": 0.0}, DescriptionError, "direction"),
    ({"rod.length": np.nan}, NonFiniteInput, "finite"),
    ({"rod.length": np.inf}, NonFiniteInput, "finite"),
    ({"rod.length": "0.5"}, InvalidRequest, "expected a number"),
    ({"rod.length": True}, InvalidRequest, "expected a number"),
    ({"rod.length": [0.5]}, InvalidRequest, "expected a number"),
    ({"legs[*].motor.offset": 0.1, "legs[2].motor.offset": 0.2}, InvalidRequest, "two values"),
    ({}, InvalidRequest, "expected values by path"),
    (["rod.length"], InvalidRequest, "expected values by path"),
    ({3: 1.0}, InvalidRequest, "expected a path"),
]


@pytest.mark.parametrize(("values", "kind", "told"), HOSTILE_VALUES)
def test_hostile_values_are_refused(values, kind, told):
    with pytest.raises(kind, match=told) as caught:
        load_robot("six_rfs").with_parameters(values)
    assert type(caught.value) is kind


def test_a_number_that_is_no_python_float_is_one():
    robot = load_robot("six_rfs").with_parameters({"rod.length": np.float32(0.5)})
    assert robot.parameter_values("rod.length") == [0.5]


def test_a_description_that_was_changed_by_hand_is_not_read_again():
    description = replace(load_robot("six_rfs").description, written=None)
    with pytest.raises(InvalidRequest, match="was not read from a description"):
        Robot(description).parameter_values("rod.length")


def test_robots_with_other_numbers_are_pickled():
    robot = load_robot("six_rus").with_parameters({"rod.length": 0.5})
    again = pickle.loads(pickle.dumps(robot))
    assert again.parameter_values("rod.length") == [0.5]


@pytest.mark.parametrize(
    ("end", "limit", "range_"), [(0, 2.3, "[2.3, .inf]"), (1, 2.8, "[-.inf, 2.8]")]
)
def test_a_limit_to_one_side_can_be_set_and_written(end, limit, range_):
    path = f"legs[0].motor.limits.position[{end}]"
    changed = load_robot("rfrfr").with_parameters({path: limit})
    assert f"position: {range_}" in changed.description.text
    again = load_robot(changed.description.text)
    assert again.description.motors[0].limits == changed.description.motors[0].limits
    assert [bound.kind for bound in limits_of(again)] == ["motor_limit"]
    with pytest.raises(MotorLimitExceeded):
        solve_forward(again, [2.59 + 1.2 * (limit - 2.59), 0.55])


@pytest.mark.parametrize("range_", ["[.inf, -.inf]", "[.inf, .inf]", "[0.1, .nan]", "[.inf, 1.0]"])
def test_a_range_without_anything_in_it_is_refused(range_):
    text = SIX_RFS.replace("motor: {", f"motor: {{limits: {{position: {range_}}}, ", 1)
    assert text != SIX_RFS
    with pytest.raises(DescriptionError, match=r"limits.position"):
        load_robot(text)


@pytest.mark.parametrize(
    ("path", "legs"),
    [
        ("rod.length", None),
        ("legs[1].base.position[0]", 1),
        ("legs[0,1].motor.offset", 2),
        ("legs[*].motor.offset", None),
    ],
)
@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "gough_stewart"])
def test_what_is_shifted_is_what_is_written(name, path, legs):
    """Legs that a number is not of are not read again where it is shifted."""
    robot = load_robot(name)
    (parameter,) = named_parameters(robot.description, path)
    beside = Robot(shifted(robot.description, parameter, 1e-3))
    written = robot.with_parameters({path: parameter.value + 1e-3})
    numbers, expected = (
        numbers_of(each.arrays, each.load_arrays(each.default_loads)) for each in (beside, written)
    )
    assert_array_equal(numbers, expected)
    assert not np.array_equal(
        numbers, numbers_of(robot.arrays, robot.load_arrays(robot.default_loads))
    )
    read, expected = (each.description.written.read for each in (beside, written))
    assert {path: repr(value) for path, value in read.items()} == {
        path: repr(value) for path, value in expected.items()
    }
    kept = [leg in robot.description.legs for leg in beside.description.legs]
    assert sum(kept) == (0 if legs is None else len(kept) - legs)

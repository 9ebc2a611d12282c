# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is wrong with a chain is named: the field, and what was expected there."""

from copy import deepcopy

import pytest
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, load_robot

#: A joint with a motor about its first axis.
HALF_MOVED = {"joint": "universal", "axes": [[0, 1, 0], [0, 0, 1]], "motor": ["m", None]}
#: Name of the robot, path of the element changed, what it becomes, field blamed, words of the error.
WRONG = {
    "motor and chain": (
        "six_rus",
        ["legs", 0, "motor"],
        {"type": "welded"},
        "legs[0]",
        "got motor and chain",
    ),
    "nothing known": (
        "six_rus",
        ["legs", 0, "chain", 0],
        {},
        "legs[0].chain[0]",
        "missing field 'joint' (or 'link', 'rod')",
    ),
    "a kind that is none": (
        "six_rus",
        ["legs", 0, "chain", 1],
        {"hub": [0.1, 0, 0], "mass": 0.1},
        "legs[0].chain[1]",
        "missing field 'joint' (or 'link', 'rod'), got 'hub', 'mass'",
    ),
    "joint and link": (
        "six_rus",
        ["legs", 0, "chain", 1, "joint"],
        "revolute",
        "legs[0].chain[1]",
        "unknown field 'link'",
    ),
    "unknown joint": (
        "six_rus",
        ["legs", 0, "chain", 0, "joint"],
        "ball",
        "legs[0].chain[0].joint",
        "revolute, prismatic, universal",
    ),
    "misspelt": (
        "six_rus",
        ["legs", 0, "chain", 0, "axes"],
        [1, 0, 0],
        "legs[0].chain[0]",
        "unknown field 'axes'",
    ),
    "spring on a motor": (
        "six_rus",
        ["legs", 0, "chain", 0, "stiffness"],
        3.0,
        "legs[0].chain[0].stiffness",
        "a motor holds this joint",
    ),
    "ratio of nothing": (
        "six_rus",
        ["legs", 0, "chain", 0],
        {"joint": "revolute", "axis": [0, -1, 0], "ratio": 2.0},
        "legs[0].chain[0].ratio",
        "no motor",
    ),
    "ratio zero": (
        "six_rus",
        ["legs", 0, "chain", 0, "ratio"],
        0.0,
        "legs[0].chain[0].ratio",
        "other than zero",
    ),
    "limits of nothing": (
        "six_rus",
        ["legs", 0, "chain", 3, "limits"],
        {"speed": 1.0},
        "legs[0].chain[3].limits",
        "no motor feeds this rod",
    ),
    "axis of length zero": (
        "six_rus",
        ["legs", 0, "chain", 0, "axis"],
        [0, 0, 0],
        "legs[0].chain[0].axis",
        "length zero",
    ),
    "axes the same": (
        "six_rus",
        ["legs", 0, "chain", 2, "axes"],
        [[0, 1, 0], [0, -1, 0]],
        "legs[0].chain[2].axes",
        "expected two directions that are not parallel",
    ),
    "one motor for two axes": (
        "six_rus",
        ["legs", 0, "chain", 2, "motor"],
        "both",
        "legs[0].chain[2].motor",
        "expected array",
    ),
    "three springs for two axes": (
        "six_rus",
        ["legs", 0, "chain", 2, "rest"],
        [0.1, 0.2, 0.3],
        "legs[0].chain[2].rest",
        "exactly 2 entries",
    ),
    "a word for a spring": (
        "six_rus",
        ["legs", 0, "chain", 2, "stiffness"],
        "soft",
        "legs[0].chain[2].stiffness",
        "got 'soft' (of its spring",
    ),
    "spring and motor about one axis": (
        "six_rus",
        ["legs", 0, "chain", 2],
        HALF_MOVED | {"stiffness": [0.1, 0]},
        "legs[0].chain[2].stiffness",
        "a motor holds this joint",
    ),
    "offset of a passive axis": (
        "six_rus",
        ["legs", 0, "chain", 2],
        HALF_MOVED | {"offset": [0, 0.1]},
        "legs[0].chain[2].offset",
        "no motor moves this joint",
    ),
    "one spring of two axes with motors": (
        "six_rus",
        ["legs", 0, "chain", 2],
        {"joint": "universal", "axes": [[0, 1, 0], [0, 0, 1]], "motor": ["m", "n"], "rest": 0.1},
        "legs[0].chain[2].rest",
        "a motor holds this joint",
    ),
    "one ratio of two passive axes": (
        "six_rus",
        ["legs", 0, "chain", 2, "ratio"],
        2.0,
        "legs[0].chain[2].ratio",
        "no motor moves this joint",
    ),
    "negative mass": (
        "six_rus",
        ["legs", 0, "chain", 1, "mass"],
        -1.0,
        "legs[0].chain[1].mass",
        "at least 0",
    ),
    "fed and bent at rest": (
        "six_rus",
        ["legs", 0, "chain", 3],
        {"rod": {"rest_curvature": {"bending_2": [1.0, 2.0]}}, "motor": "feed"},
        "legs[0].chain[3].motor",
        "uniform",
    ),
    "turns and shifts": (
        "six_rus",
        ["legs", 0, "chain", 2],
        {"joint": "prismatic", "axis": [1, 0, 0], "motor": "motor2"},
        "legs[1].chain",
        "cannot turn, shift or feed at the same time",
    ),
    "other limits": (
        "six_rus",
        ["legs", 0, "chain", 2],
        {"joint": "revolute", "axis": [1, 0, 0], "motor": "motor1", "limits": {"effort": 1.0}},
        None,
        None,
    ),
    "universal in the plane": (
        "three_rfr_hubs",
        ["legs", 0, "chain", 1],
        {"joint": "universal", "axes": [[1, 0, 0], [0, 1, 0]]},
        "legs[0].chain[1].joint",
        "spatial",
    ),
    "out of the plane": (
        "three_rfr_hubs",
        ["legs", 0, "chain", 1, "link"],
        [0.1, 0.0, 0.1],
        "legs[0].chain[1].link",
        "z = 0",
    ),
    "about x in the plane": (
        "three_rfr_hubs",
        ["legs", 0, "chain", 0, "axis"],
        [1, 0, 0],
        "legs[0].chain[0].axis",
        "expected +-z",
    ),
    "no frame at the base": (
        "six_rus",
        ["legs", 0, "base"],
        {"position": [0, 0, 0], "tangent": [1, 0, 0]},
        "legs[0].base",
        "missing field 'normal', direction of d2",
    ),
    "strain of home for two rods": (
        "three_rfr_hubs",
        ["legs", 1, "chain", 3],
        {"rod": {}},
        "home.strain",
        "legs of one rod",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_named(case):
    name, path, value, field, words = WRONG[case]
    changed = deepcopy(shipped_content(name))
    if case == "strain of home for two rods":
        changed["home"] = {"motors": [0, 0, 0], "strain": [{}, {}, {}]}
    part = changed
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = value
    if field is None:  # the first limits count where the other joint has none
        assert load_robot(changed).description.motors[0].limits.effort == 1.0
        part[0]["limits"] = {"effort": 2.0}
        field, words = "legs[0].chain", "other limits"
    with pytest.raises(DescriptionError) as caught:
        load_robot(changed)
    assert caught.value.field == field, caught.value
    assert words in str(caught.value)


@pytest.mark.parametrize(("named", "blamed"), [(2, 2), (0, 1)])
def test_no_leg_is_called_like_a_rod_of_another(named, blamed):
    """Loads on that rod would act on one of the two, without a word."""
    changed = shipped_content("three_rfr_hubs")
    changed["legs"][1]["chain"] += [{"rod": {}}]
    changed["home"] = {"motors": [0, 0, 0], "bow": "outward"}
    assert "leg2.rod2" in load_robot(changed).rod_names
    changed["legs"][named]["name"] = "leg2.rod2"
    with pytest.raises(DescriptionError, match=r"'leg2\.rod2' is the name of a rod of") as caught:
        load_robot(changed)
    assert caught.value.field == f"legs[{blamed}].name"


def test_a_motor_named_in_two_legs_is_told_where_home_has_a_number_too_many():
    """Its name was copied with its leg: only the numbers of home were said to be wrong."""
    changed = shipped_content("three_rfr_hubs")
    joint = next(element for element in changed["legs"][1]["chain"] if "motor" in element)
    joint["motor"] = "motor1"
    del joint["limits"]
    motors = "motor1 of leg1 and leg2, motor3 of leg3"
    with pytest.raises(DescriptionError) as caught:
        load_robot(changed)
    assert caught.value.field == "home.motors"
    assert caught.value.problem == f"expected 2 numbers, one per motor ({motors}), got 3"
    changed["home"]["motors"].pop()
    changed["controlled"] = ["x", "y"]
    assert load_robot(changed).motor_names == ("motor1", "motor3")


def test_rods_are_needed():
    changed = shipped_content("three_rfr_hubs")
    for leg in changed["legs"]:
        leg["chain"] = [element for element in leg["chain"] if "rod" not in element]
    with pytest.raises(DescriptionError, match="legs: expected a rod in at least one leg"):
        load_robot(changed)

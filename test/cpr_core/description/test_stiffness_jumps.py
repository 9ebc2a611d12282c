# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A stiffness that jumps: refused where modes or splines cannot follow it, with advice."""

import numpy as np
import pytest
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, load_robot, solve_home


@pytest.mark.parametrize("place", ["robot", "leg", "chain"])
def test_a_stiffness_that_jumps_is_refused_with_advice(place):
    changed, rod = shipped_content("six_rus"), {"at": [0, 0.4, 0.45, 1], "stiffness": [1, 1, 4, 4]}
    if place == "robot":
        changed["rod"]["profile"] = rod
    elif place == "leg":
        changed["legs"][0]["rod"] = changed["rod"] | {"profile": rod}
    else:
        changed["legs"][0]["chain"][-1] = {"rod": {"profile": rod}}
    path = {"robot": "rod", "leg": "legs[0].rod", "chain": "legs[0].chain[3].rod"}[place]
    with pytest.raises(
        DescriptionError, match=r"between 0.4 and 0.45.*two rods in a chain"
    ) as caught:
        load_robot(changed)
    assert caught.value.field == f"{path}.profile.at"


def test_it_is_the_modes_of_the_robot_that_count():
    """Not those of the file where others are asked for, nor those that a tolerance has nobody write."""
    changed = shipped_content("planar_body")
    changed["rod"]["profile"] = {"at": [0, 0.3, 0.35, 1], "stiffness": [1, 1, 0.05, 0.05]}
    changed["strain"] = {"bending_3": 12}
    assert load_robot(changed).description.legs[0].modes.counts[2] == 12
    with pytest.raises(DescriptionError, match="a jump to 3 polynomial modes"):
        load_robot(changed, modes=3)
    changed["strain"] = {"bending_3": 9}
    with pytest.raises(DescriptionError, match="a jump to 9 polynomial modes"):
        load_robot(changed)
    robot = load_robot(changed, modes=12)
    with pytest.raises(DescriptionError, match="a jump to 12"):
        robot.with_parameters({"rod.profile.at[2]": 0.32})
    changed["strain"] = {"tolerance": 2e-3}
    assert load_robot(changed).description.legs[0].modes.counts[2] > 5


@pytest.mark.parametrize("falls", [False, True])
def test_a_tenth_more_is_no_jump_and_a_fifth_is(falls):
    changed = shipped_content("planar_body")
    for more, taken in ((1.09, True), (1.2, False)):
        stiffness = [more, more, 1, 1] if falls else [1, 1, more, more]
        changed["rod"]["profile"] = {"at": [0, 0.4, 0.45, 1], "stiffness": stiffness}
        if taken:
            load_robot(changed, modes=5)
            continue
        with pytest.raises(DescriptionError, match="a jump to 5 polynomial modes"):
            load_robot(changed, modes=5)


@pytest.mark.parametrize("at", [[0.1, 0.2], [0.2, 0.3], [0.3, 0.4]])
def test_rounding_makes_no_jump(at):
    changed = shipped_content("planar_body")
    changed["rod"]["profile"] = {"at": [0, *at, 1], "stiffness": [1, 1, 0.5, 0.5]}
    load_robot(changed, modes=5)


def test_a_stiffness_that_changes_slowly_or_with_knots_is_taken():
    slow, knots = shipped_content("six_rus"), shipped_content("three_rfr_hubs")
    slow["rod"]["profile"] = {"at": [0, 0.4, 0.6, 1], "stiffness": [1, 1, 4, 4]}
    load_robot(slow)
    knots["rod"]["profile"] = {"at": [0, 0.4, 0.45, 1], "stiffness": [1, 1, 4, 4]}
    knots["strain"] = {"basis": "bsplines", "knots": [0.4, 0.42, 0.45]}
    for leg in knots["legs"]:
        leg["chain"][2] = {"rod": {}}
    load_robot(knots)
    del knots["rod"]["profile"]
    knots["legs"][0]["rod"] = knots["rod"]
    assert load_robot(knots).description.legs[0].rods[0].rod.uniform


@pytest.mark.parametrize(
    ("degree", "knots", "width", "taken"),
    [
        (3, [0.5], 0.2, True),
        (3, [0.5], 0.05, False),
        (3, [0.2, 0.4, 0.6, 0.8], 0.1, True),
        (3, [0.2, 0.4, 0.6, 0.8], 1e-6, False),
        (3, [0.49, 0.51], 0.02, False),
        (3, [0.48, 0.49, 0.5, 0.51, 0.52], 0.02, True),
        (1, [0.49, 0.51], 0.02, True),
        (0, [0.5], 1e-6, True),
        (0, [0.3], 1e-6, False),
    ],
)
def test_splines_follow_what_their_knots_let_them(degree, knots, width, taken):
    """They were taken whatever the knots, and up to 20 mm wrong; here by the truth of many knots."""
    changed = shipped_content("rfrfr")
    at = [0, 0.5 - 0.5 * width, 0.5 + 0.5 * width, 1]
    changed["rod"]["profile"] = {"at": at, "stiffness": [1, 1, 0.25, 0.25]}
    changed["strain"] = {"basis": "bsplines", "degree": degree, "knots": knots}
    if not taken:
        with pytest.raises(DescriptionError, match="faster than") as caught:
            load_robot(changed)
        assert caught.value.field == "rod.profile.at"
        return
    home = solve_home(load_robot(changed))
    fine = sorted({*np.linspace(0.05, 0.95, 19), *np.linspace(at[1], at[2], 11)})
    changed["strain"] = {"basis": "bsplines", "degree": 1, "knots": [float(k) for k in fine]}
    true = solve_home(load_robot(changed))
    assert np.linalg.norm(home.platform_position - true.platform_position) < 0.01


@pytest.mark.parametrize("tip", [0.05, 0.02])
def test_splines_follow_a_rod_that_is_soft_at_its_tip(tip):
    """One moment would bend it far there, and a hinge has none."""
    changed = shipped_content("rfrfr")
    changed["rod"]["profile"] = {"at": [0, 1], "stiffness": [1, tip]}
    changed["strain"] = {"basis": "bsplines", "knots": [0.5]}
    home = solve_home(load_robot(changed))
    changed["strain"]["knots"] = [0.5, 0.8, 0.9, 0.95, 0.98]
    true = solve_home(load_robot(changed))
    assert np.linalg.norm(home.platform_position - true.platform_position) < 2e-3

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Home from little: motors and the side of the rods, or a rough pose of the platform."""

import re
import warnings

import numpy as np
import pytest
from helpers.ring_robots import three_columns, two_columns
from helpers.yaml_content import shipped_content
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.robustness import distance, residual
from cpr_core import (
    CprError,
    DescriptionError,
    DescriptionWarning,
    NoForwardSolution,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.description.description_file import shipped_robots
from cpr_core.solving.assembly import turned_over


@pytest.mark.parametrize("modes", [3, 5, 8, 12])
@pytest.mark.parametrize("name", shipped_robots())
def test_every_shipped_robot_comes_to_rest_in_a_stable_equilibrium(name, modes):
    home = solve_home(load_robot(name, modes=modes))
    assert residual(home) < 1e-10
    assert home.index_locked == 0
    assert turned_over(home) is None


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "three_rfs", "planar_body"])
def test_a_rough_pose_leads_to_the_same_home_as_the_sides(name):
    home = solve_home(load_robot(name))
    content = shipped_content(name)
    w, x, y, z = home.platform_quaternion
    place = home.platform_position + [0.03, -0.02, 0.0 if home.robot.planar else 0.02]
    content["home"] = {
        "motors": home.motors.tolist(),
        "platform": {"position": place.tolist()},
    }
    if name == "six_rfs":
        content["home"]["platform"]["quaternion_wxyz"] = [0.9434, -0.0406, -0.0496, 0.3255]
    if name == "planar_body":
        content["home"]["platform"]["quaternion_wxyz"] = [float(w), float(x), float(y), float(z)]
    assert distance(solve_home(load_robot(content)), home) < 1e-8


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "three_rfs"])
def test_sides_may_be_vectors_one_per_leg(name):
    content = shipped_content(name)
    middle = np.mean([leg["base"]["position"] for leg in content["legs"]], axis=0)
    content["home"]["bow"] = [
        [*(np.array(leg["base"]["position"]) - middle).tolist()] for leg in content["legs"]
    ]
    assert distance(solve_home(load_robot(content)), solve_home(load_robot(name))) < 1e-12


@pytest.mark.parametrize("kept", [[0], [0, 1], [0, 2], [0, 1, 2]])
def test_a_platform_that_nothing_holds_is_said_to_be(kept):
    """Ball joints leave the platform a turn about every axis through all of them."""
    content = shipped_content("six_rfs")
    sides = [
        [np.cos(angle), np.sin(angle), 0.3] for angle in np.repeat([0, 1, 2], 2) * 2 * np.pi / 3
    ]
    content["legs"] = [content["legs"][leg] for leg in kept]
    content["controlled"] = ["x", "y", "z"][: len(kept)]
    content["home"] = {
        "motors": [content["home"]["motors"][leg] for leg in kept],
        "bow": [[float(part) for part in sides[leg]] for leg in kept],
    }
    with pytest.raises(
        NoForwardSolution, match=r"nothing holds the platform: it can turn about \("
    ):
        _ = solve_home(load_robot(content))


def test_left_and_right_are_the_mirror_images_of_each_other():
    content = shipped_content("planar_body")
    content["home"] = {"motors": [-0.5] * 3, "bow": "right"}
    left, right = solve_home(load_robot("planar_body")), solve_home(load_robot(content))
    assert right.energy == pytest.approx(left.energy, abs=1e-9)
    np.testing.assert_allclose(right.platform_rotation, left.platform_rotation.T, atol=1e-8)


@pytest.mark.parametrize("side", ["outward", "inward"])
def test_rods_bow_away_from_the_middle_of_the_bases_or_to_it(side):
    content = shipped_content("rfrfr")
    content["home"] = {"motors": [0.9, 2.2], "bow": side}
    description = load_robot(content).description
    middle = np.mean([leg.base_position for leg in description.legs], axis=0)
    for leg, bow in zip(description.legs, description.home.bow, strict=True):
        assert np.sign(bow @ (leg.base_position - middle)) == (1.0 if side == "outward" else -1.0)
        assert np.linalg.norm(bow) == pytest.approx(1.0)


def test_the_other_side_is_another_equilibrium():
    content = shipped_content("rfrfr")
    content["home"] = {"motors": [0.9, 2.2], "bow": ["left", "right"]}
    inward = solve_home(load_robot(content))
    content["home"]["bow"] = ["right", "left"]
    outward = solve_home(load_robot(content))
    assert inward.index_locked == outward.index_locked == 0
    assert residual(inward) < 1e-10


@settings(deadline=None, max_examples=25)
@given(
    st.integers(2, 6),
    st.floats(0.1, 0.4),
    st.floats(0.03, 0.2),
    st.floats(0.6, 1.5),
    st.floats(0.3, 1.4),
    st.booleans(),
)
def test_rings_of_legs_are_assembled(legs, base, platform, length, lean, heavy):
    """Legs around a circle that lean outward and bow outward, any number and size."""
    angles = 2.0 * np.pi * np.arange(legs + 1) / (legs + 1)
    content = {
        "name": "ring",
        "space": "spatial",
        "rod": {
            "length": length,
            "section": {"shape": "circular", "radius": 0.001},
            "young_modulus": 210e9,
            "shear_modulus": 82e9,
            "density": 7800,
        },
        "gravity": [0, 0, -9.81 if heavy else 0],
        "legs": [
            {
                "base": {
                    "position": [base * np.cos(a), base * np.sin(a), 0.0],
                    "tangent": [np.cos(a), np.sin(a), 0.0],
                },
                "motor": {"type": "revolute", "axis": [-np.sin(a), np.cos(a), 0.0]},
                "tip": {
                    "type": "spherical",
                    "position": [platform * np.cos(a), platform * np.sin(a), 0.0],
                },
            }
            for a in angles
        ],
        "controlled": [],
        "home": {"motors": [-lean] * (legs + 1), "bow": "outward"},
    }
    for leg in content["legs"]:
        leg["base"]["position"] = [float(value) for value in leg["base"]["position"]]
        leg["base"]["tangent"] = [float(value) for value in leg["base"]["tangent"]]
        leg["motor"]["axis"] = [float(value) for value in leg["motor"]["axis"]]
        leg["tip"]["position"] = [float(value) for value in leg["tip"]["position"]]
    count = legs + 1
    if count <= 6:
        content["controlled"] = ["z", "roll", "pitch", "x", "y", "yaw"][:count]
    home = solve_home(load_robot(content))
    assert residual(home) < 1e-10
    assert home.index_locked == 0


@pytest.mark.parametrize("build", [two_columns, three_columns, lambda: three_columns(mass=2.0)])
def test_a_symmetric_robot_that_buckles_under_its_loads_comes_to_rest(build):
    """It was left standing, unstable, without a word: where it buckles no fold ended the way."""
    home = solve_home(build())
    assert home.stable
    assert residual(home) < 1e-10


@pytest.mark.parametrize("build", [two_columns, three_columns])
def test_where_a_robot_comes_to_rest_is_no_matter_of_rounding(build):
    """From the last bit of a number on, steps of its fall grew apart and led elsewhere."""
    home = solve_home(build())
    for wider in (2e-16, 4e-16, 1e-15, 1e-14, 1e-13):
        assert distance(home, solve_home(build(wider))) < 1e-9


def test_a_robot_that_snaps_under_its_loads_comes_to_rest_below():
    content = shipped_content("rfrfr")
    content["platform"]["mass"] = 0.6
    content["gravity"] = [0, -9.81, 0]
    home = solve_home(load_robot(content))
    assert residual(home) < 1e-10
    assert home.index_locked == 0
    assert home.platform_position[1] < 0.4
    with pytest.raises(CprError, match="turns back"):
        solve_forward(
            load_robot("rfrfr"),
            [2.59, 0.55],
            loads=home.loads.with_(wrench_world=[0, 0, 0, 0, -0.6 * 9.81, 0]),
        )


@pytest.mark.parametrize(
    ("home", "field", "text"),
    [
        ({}, "home", "expected bow"),
        ({"bow": "up"}, "home.bow", "up"),
        ({"bow": ["outward"]}, "home.bow", "expected 2 sides, got 1"),
        ({"bow": [[0, 0, 1], "outward"]}, "home.bow[0]", "z"),
        ({"bow": [[0, 0, 0], "outward"]}, "home.bow[0]", "across the tangent"),
    ],
)
def test_bad_sides_are_refused(home, field, text):
    content = shipped_content("rfrfr")
    content["home"] = {"motors": [2.59, 0.55]} | home
    with pytest.raises(DescriptionError) as caught:
        load_robot(content)
    assert caught.value.field.startswith(field)
    assert text in str(caught.value)


def test_left_and_right_are_for_the_plane():
    content = shipped_content("six_rfs")
    content["home"]["bow"] = "left"
    with pytest.raises(DescriptionError, match="expected outward, inward or a vector, got 'left'"):
        load_robot(content)


@pytest.mark.parametrize(
    ("position", "limits", "text"),
    [
        (1e155, [-1.5, 1.5], "motor1: position 1e+155 rad is outside its limits [-1.5, 1.5]"),
        (1.6, [-1.5, 1.5], "motor1: position 1.6 rad is outside its limits [-1.5, 1.5]"),
        (1e155, None, "motor1: expected a position of at most 1e+09 rad, got 1e+155 rad"),
        (1e9 + 0.5, None, "motor1: expected a position of at most 1e+09 rad, got 1000000000.5 rad"),
        (-1e300, None, "motor1: expected a position of at most 1e+09 rad, got -1e+300 rad"),
    ],
)
@pytest.mark.filterwarnings("ignore::cpr_core.DescriptionWarning")
def test_motors_are_within_their_limits_before_rods_are_bent(position, limits, text):
    """Rods that were bent by numbers beyond all others ended in an assertion."""
    content = shipped_content("rfrfr")
    content["home"]["motors"] = [position, 0.55]
    content["legs"][0]["motor"] |= {"limits": {"position": limits} if limits else {}}
    with pytest.raises(DescriptionError) as caught:
        solve_home(load_robot(content))
    assert caught.value.field == "home"
    assert text in str(caught.value)


@pytest.mark.parametrize("name", ["rfrfr", "three_prs", "six_rus"])
@pytest.mark.parametrize("offset", [1e300, -1e17, 1.1e9])
def test_a_joint_beyond_all_numbers_is_refused(name, offset):
    """It ended in an assertion without words, or in a home that rounding had chosen."""
    content = shipped_content(name)
    leg = content["legs"][0]
    (leg["motor"] if "motor" in leg else leg["chain"][0])["offset"] = offset
    with pytest.raises(DescriptionError, match=r"offset: expected a number of at (least -|most )1"):
        load_robot(content)


@pytest.mark.parametrize("far", [1e12, 1e155, 1e200])
def test_a_tip_beyond_all_numbers_is_refused(far):
    """It was an error of the linear algebra."""
    content = shipped_content("four_rfr")
    content["legs"][2]["tip"]["position"] = [0.05, far, 0.0]
    with pytest.raises(
        DescriptionError, match=r"1e\+09 rod lengths away: looks like milli"
    ) as caught:
        load_robot(content)
    assert caught.value.field == "legs[2].tip.position"


def turned_bases(angles, **platform):
    """Rods clamped at both ends, their bases turned [rad]; beside a pose they are stiff in torsion."""
    content = shipped_content("gough_stewart")
    for leg, angle in zip(content["legs"], angles, strict=True):
        leg["base"]["normal"] = [np.cos(angle), np.sin(angle), 0.0]
    if platform:
        content["strain"] = {"torsion": 0, "bending_2": 5, "bending_3": 5}
        content["home"] = {"motors": content["home"]["motors"], "platform": platform}
    return load_robot(content)


def test_a_platform_that_is_turned_from_where_it_was_said_to_be_is_told():
    """An orientation that was given was compared with nothing: it may be off by a quarter turn."""
    place = solve_home(load_robot("gough_stewart")).platform_position.tolist()
    robot = turned_bases([1.2] * 6, position=place, quaternion_wxyz=[1.0, 0.0, 0.0, 0.0])
    words = r"quaternion_wxyz: .* turned by 1\.\d* rad from there, to \(0\.\d.*check .*axis_in_rod"
    with pytest.warns(DescriptionWarning, match=words):
        home = solve_home(robot)
    w, x, y, z = (float(value) for value in home.platform_quaternion)
    near = turned_bases([1.2] * 6, position=place, quaternion_wxyz=[w, x, y, z])
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        assert distance(solve_home(near), home) < 1e-8
        solve_home(turned_bases([1.2] * 6, position=place))  # nobody said that it is not turned


@pytest.mark.parametrize(("angle", "wound"), [(1.2, True), (0.6, False)])
def test_rods_that_are_wound_at_home_are_told(angle, wound):
    """Half of them turned to the one side, half to the other: the platform can follow neither."""
    robot = turned_bases([angle, -angle] * 3)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        solve_home(robot)
    said = [str(warning.message) for warning in caught]
    assert len(said) == wound
    words = r"home: leg\d \(and 5 more\) is wound by 1\.2\d* rad there, before .*: check tangent, normal"
    assert all(re.search(words, text) for text in said)


def test_a_rod_that_is_twisted_at_rest_is_not_wound():
    content = shipped_content("gough_stewart")
    content["rod"]["rest_curvature"] = {"torsion": [1.2 / content["rod"]["length"]]}
    for leg, angle in zip(content["legs"], [-1.2] * 6, strict=True):
        leg["base"]["normal"] = [np.cos(angle), np.sin(angle), 0.0]
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        solve_home(load_robot(content))


@pytest.mark.parametrize(
    ("name", "bow", "told"),
    [
        ("rfrfr", "inward", r"leg1 \(and 1 more\) bow"),
        ("rfrfr", "left", "leg2 bows"),
        ("planar_body", ["left", "left", "right"], "leg3 bows"),
        ("planar_body", "outward", ""),
        ("six_rfs", "inward", r"leg1 \(and 5 more\) bow"),
        ("six_rfs", None, ""),
    ],
)
def test_a_rod_that_bows_to_the_other_side_is_told(name, bow, told):
    """With these motors there is one rest, to one side; which one was asked for made no difference."""
    content = shipped_content(name)
    content["home"]["bow"] = bow
    if bow is None:
        del content["home"]["bow"]
        place = solve_home(load_robot(name)).platform_position.tolist()
        content["home"]["platform"] = {"position": place}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        home = solve_home(load_robot(content))
    said = [str(warning.message) for warning in caught]
    assert len(said) == bool(told)
    assert all(re.search(f"home.bow: {told} to the other side in the home", text) for text in said)
    assert distance(solve_home(load_robot(name)), home) < 1e-7


def test_a_tip_that_misses_by_half_a_turn_is_asked_for_its_directions():
    content = shipped_content("gough_stewart")
    tip = content["legs"][2]["tip"]
    tip["tangent"] = [-part for part in tip["tangent"]]
    words = r"leg3 misses its tip joint by [\d.e-]+ m and 3\.14 rad \(does its .* the other way\?\)"
    with pytest.raises(NoForwardSolution, match=words):
        solve_home(load_robot(content))


@pytest.mark.parametrize("name", ["three_prs", "three_rfs"])
def test_angles_that_are_none_at_home_are_told(name):
    """Twists about an axis across both were lost, and the closed loop froze."""
    content = shipped_content(name)
    for leg in content["legs"]:
        x, y, z = leg["tip"]["position"]
        leg["tip"]["position"] = [z, y, -x]  # x of the platform's frame is its normal
    content["home"] = {
        key: content["home"][key] for key in ("motors", "bow") if key in content["home"]
    }
    if "bow" not in content["home"]:
        place = solve_home(load_robot(name)).platform_position.tolist()
        content["home"]["platform"] = {"position": place}
    with pytest.warns(DescriptionWarning, match=r"controlled: at home .* pitch of -?1\.57 rad"):
        home = solve_home(load_robot(content))
    np.testing.assert_allclose(
        home.platform_position, solve_home(load_robot(name)).platform_position, atol=1e-9
    )


@pytest.mark.filterwarnings("error::cpr_core.DescriptionWarning")
@pytest.mark.parametrize("name", shipped_robots())
def test_no_shipped_robot_is_warned_of_at_home(name):
    solve_home(load_robot(name))

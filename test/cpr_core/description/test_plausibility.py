# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Descriptions in other units or orders: doubted or refused in the words of whoever wrote them."""

import warnings

import pytest
from helpers.doubts import DEGREES, MILLIMETRES
from helpers.spoilt_descriptions import put
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, DescriptionWarning, load_robot, solve_home
from cpr_core.description.description_file import read_description


def soft(content):
    """Silicone: as soft as a modulus in MPa of a metal looks."""
    content["rod"] |= {"young_modulus": 1e5, "shear_modulus": 4e4, "density": 1070.0}


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
        (
            ("rod", "shear_modulus"),
            5.4e11,
            r"rod.shear_modulus: the shear modulus 5.4e\+11 is 2.6 of .* other way round\?",
        ),
        (
            ("rod", "rest_curvature"),
            {"bending_2": [86.0]},
            "rod.rest_curvature: 86 1/m coil a rod of 0.8 m by 10.9 turns: looks like degrees per metre",
        ),
        (
            ("strain",),
            {"tolerance": 0.01},
            rf"strain.tolerance: 0.01 m of rods of 0.8 m: {MILLIMETRES}",
        ),
        (
            ("rod", "section", "radius"),
            0.3,
            rf"legs\[0\]: a rod 0.6 m thick, where legs have 0.8 m of rods: {MILLIMETRES}",
        ),
        (("rod", "section", "radius"), 0.08, rf"legs\[0\]: a rod 0.16 m thick, .*: {MILLIMETRES}"),
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
            rf"legs\[1\].base.position: more than .*: {MILLIMETRES}",
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


@pytest.mark.parametrize(
    ("young", "shear"), [(210e9, 82e6), (2.1e9, 820e9), (2.1e6, 820e6), (210e9, 42e6)]
)
def test_one_modulus_in_another_unit_than_the_other_is_said_once(young, shear):
    """Where ball joints let rods untwisted, no answer shows it."""
    content = shipped_content("three_rfs")
    content["rod"] |= {"young_modulus": young, "shear_modulus": shear}
    with pytest.warns(DescriptionWarning, match=r"rod\.shear_modulus: the shear modulus") as told:
        read_description(content)
    assert len(told) == 1


@pytest.mark.parametrize(("young", "shear"), [(140e9, 4e9), (150e9, 2.5e9), (15e9, 35e9)])
def test_fibres_along_a_rod_and_across_it_are_beyond_doubt(young, shear):
    content = shipped_content("three_rfs")
    content["rod"] |= {"young_modulus": young, "shear_modulus": shear}
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        read_description(content)


def test_a_rod_that_changes_one_modulus_alone_is_where_it_is_said():
    content = shipped_content("three_prs")
    content["legs"][1]["chain"][3]["rod"] = {"young_modulus": 2.1e7}
    says = r"legs\[1\]\.chain\[3\]\.rod\.young_modulus: the shear modulus 8\.2e\+10 is 3\.9e\+03 of"
    with pytest.warns(DescriptionWarning, match=says) as told:
        read_description(content)
    assert len(told) == 1


@pytest.mark.parametrize("strain", [0.001, 0.006, 0.015, 0.08])
def test_strains_that_steel_carbon_and_nitinol_bear_are_beyond_doubt(strain):
    content = shipped_content("three_rfs")
    content["rod"]["yield_strain"] = strain
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        read_description(content)


def test_the_zero_of_a_motor_in_degrees_is_said():
    content = shipped_content("three_rfs")
    content["legs"][1]["motor"]["offset"] = -270
    with pytest.warns(DescriptionWarning, match=rf"legs\[1\]\.motor\.offset: -270: {DEGREES}"):
        read_description(content)


def test_one_base_in_millimetres_is_named_alone():
    """It moves the mean of all bases so far that every one of them, and home, seemed far away."""
    content = shipped_content("six_rfs")
    put(content, ("legs", 2, "base", "position"), [80.0, 0.0, 0.0])
    with pytest.warns(DescriptionWarning, match="far|away") as warned:
        read_description(content)
    (text,) = [str(warning.message) for warning in warned if "away" in str(warning.message)]
    assert f"legs[2].base.position: more than 10 rod lengths away: {MILLIMETRES}" in text


def test_gravity_in_millimetres_is_said():
    content = shipped_content("six_rfs")
    put(content, ("gravity",), [0.0, 0.0, -9810.0])
    with pytest.warns(
        DescriptionWarning, match=r"gravity: 9810: looks like mm/s\^2, expected m/s\^2"
    ):
        read_description(content)
    put(content, ("gravity",), [0.0, 0.0, -981.0])  # in a centrifuge
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_description(content)


def test_an_inertia_in_square_millimetres_is_said():
    content = shipped_content("three_rfs")
    content["platform"] = {"mass": 0.3, "inertia": [1500, 1500, 3000, 0, 0, 0]}
    with pytest.warns(
        DescriptionWarning, match=r"platform\.inertia: 3000 with 0\.3 kg: looks like kg"
    ):
        read_description(content)


@pytest.mark.parametrize("rest", [{"torsion": [100.0]}, {"bending_2": [5.0, 5.0, 5.0]}])
def test_rods_that_are_twisted_or_bent_at_rest_are_beyond_doubt(rest):
    content = shipped_content("three_rfs")
    content["rod"]["rest_curvature"] = rest
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        read_description(content)


def test_a_modulus_in_mpa_is_doubted_in_one_way():
    content = shipped_content("three_rfs")
    content["rod"]["young_modulus"] = 210e3
    with pytest.warns(DescriptionWarning) as told:
        read_description(content)
    assert [str(warning.message) for warning in told] == [
        "three_rfs: rod.young_modulus: 210000: looks like MPa, expected Pa"
    ]


def test_rods_of_silicone_and_of_glass_fibre_are_beyond_doubt():
    content = shipped_content("three_rfs")
    soft(content)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        read_description(content)
        content["rod"]["section"]["radius"] = 5e-6
        content["rod"]["length"] = 9.0
        read_description(content)


def test_a_wide_strip_and_a_short_thick_fitting_are_not_doubted():
    content = shipped_content("rfrfr")
    content["rod"]["section"] = {"shape": "rectangular", "width": 5e-4, "height": 0.2}
    fitting = {"length": 0.03, "section": {"shape": "circular", "radius": 0.01}}
    for number, leg in enumerate(content["legs"]):
        joint = {"joint": "revolute", "axis": [0, 0, 1], "motor": f"motor{number + 1}"}
        del leg["motor"]
        leg["chain"] = [joint, {"rod": fitting, "strain": {"bending_3": 1}}, {"rod": {}}]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_description(content)


def test_extensible_legs_in_millimetres_are_said():
    content = shipped_content("gough_stewart")
    content["home"]["motors"] = [450.0] * 6
    with pytest.warns(DescriptionWarning, match=rf"home\.motors\[0\]: 450: {MILLIMETRES}"):
        read_description(content)


def test_a_planar_quaternion_in_another_order_is_refused_with_the_order():
    content = shipped_content("planar_body")
    content["home"]["platform"] = {"position": [0, 0.5, 0], "quaternion_wxyz": [0, 0, 0.6, 0.8]}
    with pytest.raises(DescriptionError, match="about z in a planar robot, w 0 0 z"):
        read_description(content)


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


def test_a_point_with_tips_apart_looks_like_a_body():
    """It would never turn, and the answers would be those of another robot."""
    content = shipped_content("planar_body")
    content["controlled"] = ["x", "y"]
    del content["legs"][2]
    content["home"] = {"motors": [0.5, 0.5], "bow": "left"}
    content["platform"]["shape"] = "point"
    says = r"platform\.shape: a point never turns, and tips on it are 0\.173205 m apart: expected body\?"
    with pytest.warns(DescriptionWarning, match=says):
        load_robot(content)
    content["legs"][1]["tip"]["position"] = content["legs"][0]["tip"]["position"]
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        load_robot(content)


def test_loads_that_home_does_not_bear_are_what_is_named():
    content = shipped_content("two_rods")
    content["platform"]["mass"] = 80
    content["rod"]["yield_strain"] = 0.01
    says = (
        "home: the loads of the description, which grow from none there, are not borne: .* strain"
    )
    with pytest.raises(DescriptionError, match=says):
        solve_home(load_robot(content))
    content["platform"]["mass"], content["gravity"] = 0, [0, 0, 0]
    content["rod"]["yield_strain"] = 0.001
    with pytest.raises(DescriptionError, match=r"home: leg1\.rod1: bending strain"):
        solve_home(load_robot(content))


def test_a_ratio_the_wrong_way_round_is_what_is_doubted():
    content = shipped_content("planar_body")
    content["legs"][0]["motor"]["ratio"] = 100
    says = (
        r"legs\[0\]\.motor\.ratio: -1\.5 rad of the motor are -150 rad behind it: expected the way of "
        r"the joint per way of the motor, 0\.01\?"
    )
    with pytest.warns(DescriptionWarning, match=says):
        read_description(content)
    content["legs"][0]["motor"]["limits"]["position"] = [-150, 150]
    with pytest.warns(DescriptionWarning, match=rf"limits\.position: -150: {DEGREES}"):
        read_description(content)

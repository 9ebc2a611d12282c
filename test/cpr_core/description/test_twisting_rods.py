# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rods that would twist under load, where a description says nothing of torsion."""

import re
import warnings

import numpy as np
import pytest
from helpers.yaml_content import shipped_content

from cpr_core import error_of, load_robot, solve_forward, solve_home
from cpr_core.lie import rotation_log

HINGE = {"type": "revolute", "axis": [0, 0, 1]}
TIPS = {
    "spherical": ({"type": "spherical"}, ""),
    "fixed": ({"type": "fixed", "tangent": [0, 0, 1], "normal": [1, 0, 0]}, "tip joint holds"),
    "universal": ({"type": "universal", "axis": [1, 0, 0]}, "tip joint holds"),
    "universal about the tangent": (
        {"type": "universal", "axis": [1, 0, 0], "axis_in_rod": [1, 0, 0]},
        "",
    ),
    "hinge across": (HINGE, "tip joint holds"),
    "hinge about the tangent": (HINGE | {"axis_in_rod": [1, 0, 0]}, ""),
}


def content(tip=None, **rod):
    """A Stewart-Gough of the tips and rods, whose strain is not written."""
    found = shipped_content("gough_stewart")
    del found["strain"]
    for leg in found["legs"]:
        leg["tip"] = {"position": leg["tip"]["position"]} | (tip or {"type": "spherical"})
    found["rod"] |= rod
    return found


def said(description):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        load_robot(description)
    return [str(warning.message) for warning in caught]


@pytest.mark.parametrize(("tip", "why"), TIPS.values(), ids=list(TIPS))
def test_tips_that_hold_a_rod_about_its_tangent_twist_it(tip, why):
    told = said(content(tip))
    assert len(told) == bool(why)
    words = rf"strain: no torsion is written.* leg1 \(and 5 more\) would twist under load: .*{why}"
    assert all(re.search(words, text) for text in told)


STRIP = {"shape": "rectangular", "width": 0.004, "height": 0.001}


@pytest.mark.parametrize(
    ("rod", "why"),
    [
        ({"rest_curvature": {"bending_3": [1.0]}}, "bent at rest"),
        ({"section": STRIP}, "stiffer to one side"),
        ({"section": STRIP | {"height": 0.004}}, ""),
    ],
)
def test_so_do_rods_that_are_bent_at_rest_or_strips(rod, why):
    told = said(content(**rod))
    assert len(told) == bool(why)
    assert all(why in text for text in told)


@pytest.mark.parametrize(
    "change",
    [
        {"strain": {"torsion": 0}},
        {"strain": {"torsion": 2, "bending_2": 3}},
        {"strain": {"tolerance": 1e-5}},
    ],
)
def test_nothing_is_said_where_torsion_is_spoken_of(change):
    assert said(content(TIPS["fixed"][0]) | change) == []


def test_a_leg_may_speak_of_its_own():
    description = content(TIPS["fixed"][0])
    for leg in description["legs"][:4]:
        leg["strain"] = {"torsion": 0}
    (told,) = said(description)
    assert "but leg5 (and 1 more) would twist" in told
    for leg in description["legs"][4:]:
        leg["strain"] = {"torsion": 3}
    assert said(description) == []


def test_rods_in_the_plane_do_not_twist():
    description = shipped_content("planar_body")
    del description["strain"]
    assert said(description) == []


@pytest.mark.filterwarnings("ignore:.*no torsion is written")
def test_the_estimated_error_tells_what_is_left_out():
    """It compared within the directions that have modes: 1e-4 rad in place of 0.012."""
    description = shipped_content("gough_stewart")
    del description["strain"]
    robot = load_robot(description)
    exact = load_robot(description | {"strain": {"torsion": 10, "bending_2": 10, "bending_3": 10}})
    way = 0.001 * np.random.default_rng(0).uniform(-1.0, 1.0, robot.motor_count)
    found = solve_forward(robot, solve_home(robot).motors + way)
    true = solve_forward(exact, found.motors)
    turn = np.linalg.norm(rotation_log(true.platform_rotation @ found.platform_rotation.T))
    assert turn > 0.01
    assert 0.5 < error_of(found).angle / turn < 2.0

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Paths and values that are refused, and in which words."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.yaml_content import shipped_content

from cpr_core import (
    DescriptionError,
    InvalidRequest,
    NonFiniteInput,
    Robot,
    UnknownParameter,
    load_robot,
)

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


@pytest.mark.parametrize(("path", "kind", "told"), HOSTILE_PATHS)
def test_hostile_paths_are_refused(path, kind, told):
    robot = load_robot("six_rfs")
    for question in (robot.parameter_values, lambda path: robot.with_parameters({path: 1.0})):
        with pytest.raises(kind, match=told) as caught:
            question(path)
        assert type(caught.value) is kind
        assert caught.value.argument == "parameters"


@pytest.mark.parametrize("name", ["young_modulus", "shear_modulus", "density"])
def test_a_material_that_a_given_section_does_not_have_is_no_parameter(name):
    content = shipped_content("six_rfs")
    given = {"shape": "given", "torsion": 0.13, "bending_2": 0.16, "bending_3": 0.16}
    content["rod"] = {"length": 1.0, "section": given}
    robot = load_robot(content)
    for question in (robot.parameter_values, lambda path: robot.with_parameters({path: 1e9})):
        with pytest.raises(UnknownParameter, match=f"no number rod.{name}"):
            question(f"rod.{name}")


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


def test_a_description_that_was_changed_by_hand_is_not_read_again():
    description = replace(load_robot("six_rfs").description, written=None)
    with pytest.raises(InvalidRequest, match="was not read from a description"):
        Robot(description).parameter_values("rod.length")

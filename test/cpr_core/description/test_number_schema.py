# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A number that is checked alone is refused where the whole description is, in the same words."""

import pytest
from helpers.parameter_kinds import parameter_kinds

from cpr_core import DescriptionError, load_robot
from cpr_core.description import description_file
from cpr_core.description.description_file import check_numbers, check_schema, shipped_robots
from cpr_core.description.parameters import changed_content, parameter_changes

NUMBERS = (-1.0, 0.0, 0.5, 1e9)
BOTH_MOTORS = """
name: universal
space: spatial
rod: {length: 0.5, section: {shape: annular, radius: 0.002, inner_radius: 0.001},
      young_modulus: 210e9, shear_modulus: 82e9, density: 7800}
platform: {mass: 0.1}
legs:
- base: {position: [0, 0, 0], tangent: [0, 0, 1], normal: [1, 0, 0]}
  chain:
  - {joint: universal, axes: [[1, 0, 0], [0, 1, 0]], motor: [a, b], offset: [0.1, 0.2]}
  - {joint: universal, axes: [[1, 0, 0], [0, 1, 0]], stiffness: [1.0, 2.0]}
  - {rod: {}}
  tip: {type: fixed, position: [0, 0, 0], tangent: [0, 0, 1], normal: [1, 0, 0]}
controlled: [x, y]
home: {motors: [0, 0], platform: {position: [0, 0, 0.5]}}
"""
BOTH_PATHS = ("legs[0].chain[0].offset[1]", "legs[0].chain[1].stiffness[0]", "rod.section.radius")


def refusal(check, *arguments):
    try:
        check("source", *arguments)
    except DescriptionError as error:
        return str(error)
    return None


def numbers(written, path):
    for number in NUMBERS:
        changes = parameter_changes(written, {path: number})
        yield changed_content(written, changes), changes


@pytest.mark.parametrize("robot", [*shipped_robots(), BOTH_MOTORS])
def test_a_number_alone_is_refused_as_the_whole_is(robot):
    found = load_robot(robot)
    refused = 0
    paths = BOTH_PATHS if robot == BOTH_MOTORS else parameter_kinds(found)
    for path in paths:
        for content, changes in numbers(found.description.written, path):
            expected = refusal(check_schema, content)
            assert refusal(check_numbers, content, changes) == expected, (path, changes)
            refused += expected is not None
    assert refused > 2


@pytest.mark.parametrize("robot", shipped_robots())
def test_what_is_allowed_is_told_without_the_whole(robot, monkeypatch):
    found = load_robot(robot)
    monkeypatch.setattr(description_file, "check_schema", lambda *all: pytest.fail("not needed"))
    for path in parameter_kinds(found):
        changes = parameter_changes(found.description.written, {path: 0.5})
        check_numbers("source", changed_content(found.description.written, changes), changes)

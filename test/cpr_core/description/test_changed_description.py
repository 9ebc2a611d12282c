# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A description with other numbers: what is inherited follows, what is kept stays, all is written."""

import numpy as np
import pytest
from helpers.parameter_robots import SHARED, SIX_RFS
from numpy.testing import assert_array_equal

from cpr_core import DescriptionError, MotorLimitExceeded, Robot, load_robot, solve_forward
from cpr_core.description.changed_description import named_parameters, shifted, shifted_together
from cpr_core.model.varied_numbers import numbers_of
from cpr_core.solving.limits import limits_of


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


@pytest.mark.parametrize(
    ("end", "limit", "range_"), [(0, 2.3, "[2.3, .inf]"), (1, 2.8, "[-.inf, 2.8]")]
)
def test_a_limit_to_one_side_can_be_set_and_written(end, limit, range_):
    path = f"legs[0].motor.limits.position[{end}]"
    changed = load_robot("rfrfr").with_parameters({path: limit})
    assert f"position: {range_}" in changed.description.text
    again = load_robot(changed.description.text)
    assert again.description.motors[0].limits == changed.description.motors[0].limits
    assert [(bound.kind, bound.end) for bound in limits_of(again)] == [
        ("motor_limit", ("lower", "upper")[end])
    ]
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
        numbers_of(each.kernel_arrays, each.load_arrays(each.default_loads))
        for each in (beside, written)
    )
    assert_array_equal(numbers, expected)
    assert not np.array_equal(
        numbers, numbers_of(robot.kernel_arrays, robot.load_arrays(robot.default_loads))
    )
    read, expected = (each.description.written.read for each in (beside, written))
    assert {path: repr(value) for path, value in read.items()} == {
        path: repr(value) for path, value in expected.items()
    }
    kept = [leg in robot.description.legs for leg in beside.description.legs]
    assert sum(kept) == (0 if legs is None else len(kept) - legs)


def test_what_is_changed_by_two_paths_is_changed_by_both():
    description = load_robot("rfrfr").description
    one, all_of_them = named_parameters(
        description, ["legs[0].base.position[1]", "legs[*].base.position[1]"]
    )
    changed = shifted_together(description, ((one, 0.01), (all_of_them, 0.002)))
    moved = [
        after.base_position[1] - before.base_position[1]
        for after, before in zip(changed.legs, description.legs, strict=True)
    ]
    assert moved == pytest.approx([0.012, 0.002])

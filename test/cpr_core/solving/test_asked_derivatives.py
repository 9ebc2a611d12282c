# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Questions after derivatives: answered the same whenever asked, at zero and at ends, or refused."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.compared_derivatives import STATE, equilibrium_of, natural_units
from helpers.parameter_kinds import parameter_kinds, with_loads
from helpers.shipped_steps import STEPS
from helpers.solved_beside import polished
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose, assert_array_equal

from cpr_core import (
    CprError,
    DescriptionError,
    InvalidRequest,
    UnknownParameter,
    derivatives,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.description.changed_description import named_parameters
from cpr_core.description.description_file import shipped_robots
from cpr_core.model.residual_rates import parameter_scales

OUTPUTS, STABILITY = ("pose", "motors", "efforts"), ("margin", "smallest_eigenvalue")


def test_what_is_asked_for_is_there_and_nothing_else():
    equilibrium = equilibrium_of("rfrfr")
    found = derivatives(equilibrium, ["rod.length", "rod.density"], of="margin")
    assert found.margin.shape == (2,)
    assert found.position.shape == found.motors.shape == found.efforts.shape == (0, 2)
    assert found.smallest_eigenvalue.shape == (0,)
    whole = derivatives(equilibrium, ["rod.length", "rod.density"])
    assert whole.twist_body.shape == (6, 2)
    assert whole.motors.shape == whole.efforts.shape == (2, 2)
    assert whole.margin.shape == (0,)
    assert derivatives(equilibrium, "rod.length", problem="efforts").problem == "efforts"


@pytest.mark.parametrize("name", shipped_robots())
def test_it_does_not_matter_where_was_asked_first(name):
    """At home motors at zero or a level platform may hide what a parameter does elsewhere."""
    answers = []
    for first in (False, True):
        robot = with_loads(load_robot(name))
        home = solve_home(robot)
        away = polished(solve_forward(robot, home.motors + 2.0 * np.array(STEPS[name])), "motors")
        paths = parameter_kinds(robot)
        for path in paths if first else ():
            refusal(home, path)
        answers.append([refusal(away, path) for path in paths])
    units = natural_units(robot)
    for path, mine, other in zip(paths, *answers, strict=True):
        if isinstance(mine, CprError):
            assert str(mine) == str(other)
            continue
        (scale,) = parameter_scales(away, named_parameters(robot.description, path))
        for name in STATE:
            values = [scale * getattr(found, name)[:, 0] / units[name] for found in (other, mine)]
            size = max(np.abs(values[1]).max(), 1.0)  # as of full solves
            assert_allclose(*values, rtol=0.0, atol=1e-6 * size, err_msg=path)


@pytest.mark.parametrize("tiny", [1e-9, 3e-11, 1e-13, -1e-20, 1e-300])
def test_a_number_next_to_zero_is_varied_as_zero_is(tiny):
    """Steps that were parts of it were lost beside a motor at 5 rad: it did nothing at all."""
    path, answers = "legs[3].motor.offset", []
    for value in (0.0, tiny):
        robot = load_robot("six_rfs").with_parameters({path: value})
        answers.append(derivatives(solve_home(robot), path, of=(*OUTPUTS, *STABILITY)))
    for name in STABILITY:
        both = [getattr(found, name)[0] for found in answers]
        assert both[1] == pytest.approx(both[0], rel=1e-6)
    for name in STATE:
        both = [getattr(found, name) for found in answers]
        assert_allclose(*both, rtol=0.0, atol=1e-6 * max(1.0, np.abs(both[0]).max()))
    assert np.abs(answers[1].position).max() > 0.1


def refusal(equilibrium, path):
    """Derivatives, or why there are none."""
    try:
        return derivatives(equilibrium, path)
    except CprError as error:
        return error


def test_the_second_question_is_answered_by_the_same_numbers():
    equilibrium = equilibrium_of("six_rfs")
    paths = ["rod.length", "legs[0].motor.offset"]
    first, again = derivatives(equilibrium, paths), derivatives(equilibrium, paths)
    alone = derivatives(equilibrium, paths[1])
    for name in STATE:
        assert_array_equal(getattr(first, name), getattr(again, name))
        assert_allclose(getattr(first, name)[:, 1:], getattr(alone, name), rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(
    ("arguments", "kind", "told"),
    [
        (("rod.lenght",), UnknownParameter, "did you mean rod.length"),
        (("rod.length", "wrench"), InvalidRequest, "expected some of pose, motors"),
        (("rod.length", ()), InvalidRequest, "expected some of pose, motors"),
        (("rod.length", "pose", "wrench"), InvalidRequest, "expected motors, efforts or pose"),
        (([],), InvalidRequest, "at least one path"),
        (("rod.yield_strain",), InvalidRequest, "not given"),
        (("legs[0].base.position[2]",), CprError, "planar"),
    ],
)
def test_bad_questions_are_refused(arguments, kind, told):
    with pytest.raises(kind, match=told):
        derivatives(solve_home(load_robot("rfrfr")), *arguments)


def test_no_equilibrium_and_no_single_solution():
    with pytest.raises(InvalidRequest, match="expected an Equilibrium"):
        derivatives("home", "rod.length")
    home = solve_home(load_robot("four_rfr"))
    with pytest.raises(InvalidRequest, match="no single solution"):
        derivatives(home, "rod.length", problem="pose")


def test_a_singular_equilibrium_has_none():
    equilibrium = equilibrium_of("rfrfr")
    nothing = equilibrium.factors.copy()
    nothing["lane"][1:] = 0.0  # before that is how it was factored
    singular = replace(equilibrium, known_factors=nothing)
    assert derivatives(equilibrium, "rod.length").position.any()
    with pytest.raises(CprError, match="singular with its motors held"):
        derivatives(singular, "rod.length")


def with_a_force(at):
    content = shipped_content("rfrfr")
    content["loads"] = {"points": [{"leg": "leg1", "at": at, "force": [0.05, -0.1, 0.0]}]}
    return load_robot(content)


@pytest.mark.parametrize("others", [(), ("legs[1].motor.offset", "legs[0].motor.offset")])
def test_a_number_that_can_only_get_smaller(others):
    """It was refused: there is no robot on the other side."""
    path, largest, way = "loads.points[0].at", 1.0 - 4e-6, 1e-3

    def at(value):
        return solve_forward(with_a_force(value), [2.7, 0.4])

    middle = at(largest)
    found = derivatives(middle, [path, *others], of=("pose", "efforts", "margin"))
    near = [middle, *(at(largest - number * way) for number in (1, 2, 3))]
    weights = np.array([11.0, -18.0, 9.0, -2.0]) / (6.0 * way)
    for own, values in (
        (found.position[:, 0], [equilibrium.platform_position for equilibrium in near]),
        (found.efforts[:, 0], [equilibrium.efforts for equilibrium in near]),
        (found.margin[:1], [[equilibrium.margin] for equilibrium in near]),
    ):
        expected = weights @ np.array(values)
        assert_allclose(own, expected, rtol=0.0, atol=1e-4 * np.abs(expected).max() + 1e-9)
    single = derivatives(middle, path)
    assert_allclose(found.position[:, 0], single.position[:, 0], rtol=1e-9)


def test_a_number_that_can_go_neither_way_is_refused_with_the_reason():
    home = solve_home(load_robot("rfrfr"))
    with pytest.raises(DescriptionError, match=r"expected z = 0 in a planar robot, got .* 1e-05"):
        derivatives(home, "gravity[2]")

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far limits are, and what is said where one does not hold: of either sign, at either end."""

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from helpers.yaml_content import shipped_content

from cpr_core import (
    MotorLimitExceeded,
    PathEvent,
    StrainLimitExceeded,
    bending_strains,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    trace,
    trace_through,
)
from cpr_core.kernels.limit_kernel import ROUNDING
from cpr_core.solving.limits import (
    Limit,
    check_limits,
    first_of,
    grazes,
    limits_along,
    limits_of,
    margins,
    may_be_kept_again,
    undisturbed,
)


def limited(motor, **limits):
    content = shipped_content("rfrfr")
    content["legs"][motor]["motor"]["limits"] = limits
    return load_robot(content)


def free_effort(motor):
    robot = load_robot("rfrfr")
    return float(solve_home(robot).efforts[motor])


@pytest.mark.parametrize("kind", ["motor_limit", "strain_limit"])
def test_an_error_of_a_longer_way_is_another_one(kind):
    """Who still had the first one read another fraction in it."""
    last = solve_home(load_robot("rfrfr"))
    event = PathEvent(kind, 0.5, last, 0, 0, "")
    if kind == "motor_limit":
        first = MotorLimitExceeded("m", "effort", 3.1, (-3, 3), "N m", 0.5, last, event, "doubt")
        of_its_own = ("motor", "quantity", "value", "limits", "last")
    else:
        first, of_its_own = (
            StrainLimitExceeded("leg1", 0.2, 0.1, 0.5, last, event),
            ("rod", "value"),
        )
    said = str(first)
    first.add_note("noted before")
    longer = first.on_longer_way(0.25, "at a force of 3 N")
    first.add_note("of the first one only")
    assert longer is not first and type(longer) is type(first)
    assert longer.__notes__ == ["noted before"]
    assert (str(first), first.fraction, first.event) == (said, 0.5, event)
    assert str(longer) == said.replace("after 50.00 % of the way", "at a force of 3 N")
    assert (longer.fraction, longer.event.fraction, longer.event.kind) == (0.25, 0.25, kind)
    for name in of_its_own:
        assert getattr(longer, name) is getattr(first, name)


@pytest.mark.parametrize("motor", [0, 1])
def test_an_effort_counts_whatever_its_sign(motor):
    effort = free_effort(motor)
    assert np.sign(effort) == (1 if motor == 0 else -1)
    found = solve_home(limited(motor, effort=1.25 * abs(effort)))
    np.testing.assert_allclose(np.sort(margins(found)), [0.2, 1.8])
    check_limits(found)


@pytest.mark.parametrize("motor", [0, 1])
def test_an_effort_beyond_its_limit_is_refused_by_name(motor):
    """At (0, 0.8) the motors hold +-0.70 N m, at home +-0.62 N m."""
    robot = limited(motor, effort=0.66)
    with pytest.raises(MotorLimitExceeded, match=f"motor{motor + 1}: effort") as caught:
        solve_inverse(robot, [0.0, 0.8])
    assert abs(caught.value.value) > 0.66
    assert np.sign(caught.value.value) == np.sign(free_effort(motor))
    assert caught.value.limits == (-0.66, 0.66)


@pytest.mark.parametrize("by", [0.5, 2.0])
def test_a_position_beyond_its_range_is_told_as_it_was_asked_for(by):
    """Not as it was where the way ended, just beyond the range."""
    home = solve_home(load_robot("rfrfr")).motors
    robot = limited(0, position=[home[0] - 0.1, home[0] + 0.1])
    with pytest.raises(MotorLimitExceeded, match=rf"motor1: position {home[0] + by:.6g}") as caught:
        solve_forward(robot, home + [by, 0.0])
    assert caught.value.value == home[0] + by
    np.testing.assert_allclose(caught.value.last.motors[0], home[0] + 0.1, atol=1e-6)


@pytest.mark.parametrize("interval", [[2.5, 4.0], [1.0, 2.7]])
def test_both_ends_of_a_range_count(interval):
    found = solve_home(limited(0, position=interval))
    sides = [found.motors[0] - interval[0], interval[1] - found.motors[0]]
    np.testing.assert_allclose(margins(found), sides)
    ends = [Limit("motor_limit", 0, "lower"), Limit("motor_limit", 0, "upper")]
    assert limits_of(found.robot) == tuple(ends)


def test_limits_are_in_the_order_of_motors_then_of_rods():
    content = shipped_content("rfrfr")
    content["legs"][0]["motor"]["limits"] = {"position": [-5.0, 5.0], "effort": 3.0}
    content["legs"][1]["motor"]["limits"] = {"effort": 2.0}
    content["rod"]["yield_strain"] = 0.01
    found = solve_home(load_robot(content))
    motors, efforts, strains = found.motors, found.efforts, bending_strains(found)
    of_first = [motors[0] + 5.0, 5.0 - motors[0], 1.0 + efforts[0] / 3.0, 1.0 - efforts[0] / 3.0]
    of_second = [1.0 + efforts[1] / 2.0, 1.0 - efforts[1] / 2.0]
    expected = [*of_first, *of_second, *(1.0 - strains / 0.01)]
    np.testing.assert_allclose(margins(found), expected, rtol=1e-12)
    assert [(limit.kind[:6], limit.number, limit.end) for limit in limits_of(found.robot)] == [
        ("motor_", 0, "lower"),
        ("motor_", 0, "upper"),
        *(("effort", motor, end) for motor in (0, 1) for end in ("lower", "upper")),
        ("strain", 0, "upper"),
        ("strain", 1, "upper"),
    ]


@pytest.mark.parametrize("given", ["pose", "poses"])
def test_who_is_beyond_one_end_of_a_range_is_not_let_beyond_the_other(given):
    """Both ends were one limit, which did not hold all along: it went through and back into it."""
    free = load_robot("rfrfr")
    begin, end = [0.09660815, 0.68635971], [0.25771835, 0.51336455]
    start = solve_inverse(free, begin)
    turned = trace(free, pose=end, start=start).motors[:, 0]
    assert turned[-1] > turned[0] + 0.03 and turned.max() > turned[-1] + 0.03
    interval = [0.5 * (turned[0] + turned[-1]), 0.5 * (turned.max() + turned[-1])]
    content = shipped_content("rfrfr")
    content["legs"][0]["motor"]["limits"] = {"position": interval}
    content["home"]["motors"] = [float(np.mean(interval)), 0.55]
    robot = load_robot(content)
    beyond = replace(start, robot=robot)
    if given == "pose":
        with pytest.raises(MotorLimitExceeded, match="motor1: position") as caught:
            solve_inverse(robot, end, start=beyond)
        last = caught.value.last
    else:
        last = trace_through(robot, poses=[end], start=beyond).stopped.equilibrium
    assert last.motors[0] == pytest.approx(interval[1], abs=1e-6)


@pytest.mark.parametrize(
    ("before", "after", "asked"),
    [
        ([0.3], [0.01], True),  # it goes on as fast: beyond the limit and back in one more step
        ([0.01], [0.3], True),
        ([0.3], [0.25], False),
        ([0.3, 0.3], [0.25, 0.01], True),
        ([0.003], [0.001], True),
        ([1e-5], [1e-6], False),  # the step is short enough
        ([], [], False),
    ],
)
def test_a_limit_may_be_passed_within_a_step_that_changes_its_margin_by_as_much(
    before, after, asked
):
    assert grazes(np.array(before), np.array(after)) == asked


@pytest.mark.parametrize(
    ("value", "limits", "words"),
    [
        (1.5000001, (-1.5, 1.5), "position 1.5000001 rad is outside its limits [-1.5, 1.5]"),
        (0.25, (-785.398, -0.0), "position 0.25 rad is outside its limits [-785.398, 0]"),
    ],
)
def test_a_value_beyond_a_limit_is_told_from_it(value, limits, words):
    """In as many digits as it takes; and zero has no sign."""
    error = MotorLimitExceeded("motor1", "position", value, limits, "rad")
    assert f"motor1: {words}" in str(error)


def strain_limited():
    content = shipped_content("rfrfr")
    content["rod"]["yield_strain"] = 0.01
    for leg in content["legs"]:
        leg["motor"]["limits"] = {"effort": 3.0}
    return load_robot(content)


@pytest.mark.parametrize(
    "made", [partial(load_robot, "rfrfr"), partial(load_robot, "delta"), strain_limited]
)
def test_margins_along_a_way_are_those_of_every_equilibrium(made):
    robot = made()
    home = solve_home(robot)
    ways = np.linspace(0.0, 0.05, 7)[:, None] * np.ones(robot.motor_count)
    along = [home, *trace_through(robot, motors=home.motors + ways).equilibria]
    records = np.array([each.record for each in along])
    np.testing.assert_array_equal(limits_along(robot, records), [margins(each) for each in along])


@pytest.mark.parametrize("seed", range(20))
def test_a_way_is_undisturbed_until_a_limit_does_not_hold_or_is_grazed(seed):
    random = np.random.default_rng(seed)
    along = 0.05 + np.cumsum(0.02 * random.standard_normal((30, 3)), axis=0) + 0.03 * (seed % 5)
    steps = [after.min() < -ROUNDING or grazes(before, after) for before, after in pairwise(along)]
    assert undisturbed(along) == next((k for k, step in enumerate(steps) if step), len(steps))


def test_a_way_without_limits_or_steps_is_undisturbed():
    assert undisturbed(np.zeros((5, 0))) == 4
    assert undisturbed(np.ones((1, 3))) == 0


def test_a_limit_that_is_passed_by_little_disturbs_too():
    assert undisturbed(np.array([[2e-4], [1e-4], [-1e-4], [-2e-4]])) == 1


def test_rounding_at_a_limit_disturbs_nothing():
    """Who stands at the end of a range would be walked at every tick."""
    assert undisturbed(np.array([[1e-4], [-0.9 * ROUNDING], [0.0]])) == 2
    assert undisturbed(np.array([[1e-4], [-1.1 * ROUNDING], [0.0]])) == 0


@pytest.mark.parametrize(
    ("limits", "by_motors", "by_pose"),
    [
        ({"position": [-10, 10]}, False, True),  # motors that are imposed move evenly
        ({"effort": 3.0}, True, True),
        ({}, False, False),
    ],
)
def test_limits_that_may_be_passed_and_kept_again(limits, by_motors, by_pose):
    robot = limited(0, **limits)
    assert may_be_kept_again(robot, "motors") == by_motors
    assert may_be_kept_again(robot, "pose") == by_pose


def test_so_may_limits_of_strain():
    content = shipped_content("rfrfr")
    content["rod"]["yield_strain"] = 0.01
    assert may_be_kept_again(load_robot(content), "motors")


def test_the_limit_of_the_first_motor_or_rod_is_told():
    both = {Limit("effort_limit", 1, "lower"), Limit("motor_limit", 0, "upper")}
    assert first_of(frozenset(both)) == Limit("motor_limit", 0, "upper")
    assert first_of(frozenset()) is None


def test_a_limit_that_is_passed_by_what_rounding_hides_ends_the_way():
    """On which side of it a point is was another answer each time, and the walk went on by nothing."""
    robot = load_robot("three_prs")
    at_end = solve_forward(robot, [0.25, 0.2, 0.2])
    start = solve_inverse(robot, at_end.pose + [0.0, 1.6625e-4, 0.0], start=at_end)
    assert 0.0 < start.motors[0] - 0.25 < 4e-10
    with pytest.raises(MotorLimitExceeded, match="motor1: position"):
        solve_inverse(robot, start.pose + [0.0, 1e-4, 0.0], start=start, time_limit=20.0)

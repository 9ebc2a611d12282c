# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What happens within a step and is undone in it is found, as if steps had been small."""

import numpy as np
import pytest
from helpers.ring_robots import three_swinging
from helpers.yaml_content import shipped_content
from hypothesis import given
from hypothesis import strategies as st

from cpr_core import (
    MotorLimitExceeded,
    NoInverseSolution,
    UnstableEquilibrium,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    trace,
    trace_through,
)
from cpr_core.kernels.natural_units import LONGEST_STEP
from cpr_core.solving.hidden_changes import (
    Hidden,
    Watched,
    hidden_between,
    may_hide,
    may_hide_in_one_step,
)
from cpr_core.solving.near_request import ALONE
from cpr_core.solving.requests import target_of

#: A way of rfrfr in its plane on which it is unstable from 0.89 to 0.998, and stable at both ends.
UNSTABLE_BETWEEN = (
    [0.26248885530230015, -0.2484422279951375],
    [0.2073511413318955, -0.024830572845052398],
)
#: One on which the effort of its first motor is 5 % larger than at both ends, and that effort [N m].
EFFORT_BETWEEN = (
    [0.042805794789804064, 0.595335439469961],
    [-0.02236594942739742, 0.3395800475086446],
)
EFFORT_AT_ENDS = 1.0365745360148084
#: A way of motors of four_rfr, of which the third pulls after it has pushed, most of all between [rad].
SIGN_CHANGES = np.array([[0.4136, 0.9715, -0.103, 0.5288], [1.6202, 0.903, -0.3115, 1.3956]])

places = st.floats(-1.0, 1.0)
lengths = st.floats(0.01, 1.0)


@given(
    middle=st.floats(0.1, 0.9),
    depth=st.floats(1e-6, 1.0),
    bend=st.floats(0.1, 100.0),
    aside=lengths,
)
def test_what_falls_below_zero_and_rises_again_may_hide(middle, depth, bend, aside):
    """Parabolas with a third value before or behind the step; straight lines that meet below zero."""

    def parabola(place):
        return bend * (place - middle) ** 2 - depth

    def lines(place):
        return bend * abs(place - middle) - depth

    for value in (parabola, lines):
        if value(0.0) <= 0.0 or value(1.0) <= 0.0:
            continue
        for other in (-aside, 1.0 + aside):
            for sign in (1.0, -1.0):
                values = tuple([sign * value(place)] for place in (other, 0.0, 1.0))
                assert may_hide((other, 0.0, 1.0), values)


@given(slope=st.floats(-5.0, 5.0), start=st.floats(0.0, 2.0), aside=lengths)
def test_nothing_hides_where_values_are_far_from_zero_beside_their_change(slope, start, aside):
    values = tuple([abs(slope) * (2.0 + aside) + start + slope * x] for x in (-aside, 0.0, 1.0))
    assert not may_hide((-aside, 0.0, 1.0), values)


@pytest.mark.parametrize(("more", "hides"), [(1.0, True), (1.9, True), (2.1, False)])
def test_what_is_bent_twice_as_much_as_it_seems_may_hide(more, hides):
    """A third value nearby tells the bend; so much more and it would touch zero within the step."""
    other, rise, bend = -0.1, 0.55, more  # the bend within, where three values tell one of 1
    first = (bend - rise) ** 2 / (4.0 * bend) - 1e-6
    values = [first + (rise - 1.0) * place + place**2 for place in (other, 0.0, 1.0)]
    assert may_hide((other, 0.0, 1.0), tuple([value] for value in values)) == hides


@pytest.mark.parametrize(("more", "hides"), [(1.0, True), (1.2, True), (1.3, False)])
def test_what_is_a_quarter_steeper_than_it_seems_may_hide(more, hides):
    """Lines from both ends, one of which is as steep as beside the step, meet so far below."""
    height = 0.5 * more - 1e-6
    values = ([height + 1.0], [height], [height])
    assert may_hide((-1.0, 0.0, 1.0), values) == hides


def test_what_shows_does_not_hide():
    assert not may_hide((-1.0, 0.0, 1.0), ([2.0, -1.0], [0.1, -0.1], [-0.2, 0.3]))


def test_nor_does_what_stays_at_zero():
    """A motor at the end of its range while others move."""
    assert not may_hide((-1.0, 0.0, 1.0), ([0.0], [0.0], [0.0]))


@pytest.mark.parametrize("other", [-1.0, 2.0])
def test_nor_does_what_leaves_zero_evenly(other):
    """The way from a limit, or from the border of stability."""
    line = (
        ([0.3 * place + 0.3] for place in (other, 0.0, 1.0))
        if other < 0.0
        else ([0.3 * place] for place in (other, 0.0, 1.0))
    )
    assert not may_hide((other, 0.0, 1.0), tuple(line))


@pytest.mark.parametrize(
    ("margin", "singularity", "expected"),
    [
        (0.01, [0.01], Hidden.MARGIN | Hidden.SINGULARITY),
        (0.01, [9.0], Hidden.MARGIN),
        (9.0, [0.01], Hidden.SINGULARITY),
        (0.01, [], Hidden.MARGIN),
        (9.0, [], Hidden.NOTHING),
    ],
)
def test_what_hides_is_told_apart(margin, singularity, expected):
    """Values that fall by one in the step before, and are as near to zero at both ends of the next."""
    now = Watched((margin,), tuple(singularity))
    before = Watched((margin + 1.0,), tuple(value + 1.0 for value in singularity))
    assert hidden_between((-1.0, 0.0, 1.0), (before, now, now)) == expected


def test_one_step_is_long_where_it_ends_near_zero():
    assert may_hide_in_one_step(0.01, 0.01, 0.1)
    assert not may_hide_in_one_step(0.5, 0.5, 0.1)
    assert not may_hide_in_one_step(0.01, 0.01, 0.01)


def test_a_stretch_without_stability_is_not_stepped_over():
    """It was accepted: both ends of the only step were stable."""
    first, last = UNSTABLE_BETWEEN
    start = solve_inverse(load_robot("rfrfr"), first, stable_only=True)
    with pytest.raises(UnstableEquilibrium) as refused:
        solve_inverse(start.robot, last, start=start, stable_only=True)
    assert refused.value.fraction == pytest.approx(0.89395868, abs=1e-8)
    assert solve_inverse(start.robot, last, start=start).index_locked == 0  # nobody asked


def test_nor_is_one_in_a_lone_step():
    first, last = np.array(UNSTABLE_BETWEEN)
    start = solve_inverse(load_robot("rfrfr"), first, stable_only=True)
    near = solve_inverse(start.robot, first + 0.86 * (last - first), start=start, stable_only=True)
    assert target_of(near, "pose", last).distance(near) < ALONE * LONGEST_STEP
    with pytest.raises(UnstableEquilibrium):
        solve_inverse(start.robot, last, start=near, stable_only=True)


@pytest.mark.parametrize("points", [2, 5, 51, 201])
def test_events_do_not_depend_on_how_many_points_are_kept(points):
    first, last = UNSTABLE_BETWEEN
    start = solve_inverse(load_robot("rfrfr"), first)
    way = trace(start.robot, pose=last, start=start, points=points)
    assert [event.kind for event in way.events] == ["stability", "stability"]
    assert [event.index_after for event in way.events] == [1, 0]
    fractions = [event.fraction for event in way.events]
    np.testing.assert_allclose(fractions, [0.893958682, 0.997738997], atol=1e-8)


def pushed_along(robot, force):
    """At home under a force [E J / l^2] that turns with the platform."""
    unit = robot.kernel_arrays.energy_unit / robot.mean_length
    loads = robot.default_loads.with_(wrench_body=[0.0, 0.0, 0.0, *(unit * np.array(force))])
    return solve_forward(robot, solve_home(robot).motors, loads=loads)


@pytest.mark.parametrize("points", [2, 5, 51])
@pytest.mark.parametrize(
    ("name", "motors", "fractions"),
    [
        ("planar_body", [0.2254, -0.8642, -0.8537], [0.544125, 0.700302]),
        ("rfrfr", [0.5539, 2.7269], [0.562094, 0.600365, 0.939471]),
        ("rfrfr", [0.598, 2.3202], [0.614984, 0.694214]),
        ("two_rods", [0.7442, 2.3877], [0.652940, 0.657377]),
    ],
)
def test_inverse_singularities_come_in_pairs(name, motors, fractions, points):
    """Pairs within a step were missed, the last one with 51 points too."""
    way = trace(load_robot(name), motors=motors, points=points)
    assert {event.kind for event in way.events} == {"singularity"}
    np.testing.assert_allclose([event.fraction for event in way.events], fractions, atol=1e-6)


@pytest.mark.parametrize("points", [2, 5, 51])
@pytest.mark.parametrize(
    ("name", "motors", "fractions"),
    [
        ("rfrfr", [0.5539, 2.7269], [0.562093, 0.600365, 0.939490]),
        ("two_rods", [0.7442, 2.3877], [0.652940, 0.657377]),
    ],
)
def test_so_they_do_under_loads_without_a_potential(name, motors, fractions, points):
    """Nearness to one was not watched there: of a pair within a step nothing told."""
    start = pushed_along(load_robot(name), [1e-3, 5e-4, 0.0])
    way = trace(start.robot, motors=motors, start=start, points=points)
    assert {event.kind for event in way.events} == {"singularity"}
    np.testing.assert_allclose([event.fraction for event in way.events], fractions, atol=1e-6)


def test_a_limit_is_kept_all_along():
    """An effort was 5 % too large on the way, and accepted."""
    content = shipped_content("rfrfr")
    content["legs"][0]["motor"]["limits"] = {"effort": EFFORT_AT_ENDS}
    robot = load_robot(content)
    first, last = EFFORT_BETWEEN
    start = solve_inverse(robot, first)
    with pytest.raises(MotorLimitExceeded) as refused:
        solve_inverse(robot, last, start=start)
    assert refused.value.fraction == pytest.approx(0.0936, abs=1e-3)
    for points in (2, 51):
        way = trace(robot, pose=last, start=start, points=points)
        assert [event.kind for event in way.events] == ["effort_limit"]


@pytest.mark.parametrize("part", [0.5, 0.9, 0.98])
def test_a_limit_of_effort_is_kept_where_the_effort_has_changed_its_sign(part):
    """What is left of a limit has a kink there: beyond it the effort seemed to be far from its limit."""
    content = shipped_content("four_rfr")
    joints = [leg["chain"][0] for leg in content["legs"]]
    for joint in joints:
        joint.pop("limits")
    first, last = SIGN_CHANGES
    content["home"]["motors"] = first.tolist()
    way = trace(load_robot(content), motors=last, points=201)
    largest, ends = np.abs(way.efforts).max(axis=0), np.abs(way.efforts[[0, -1]]).max(axis=0)
    assert largest[2] > 1.5 * ends[2]
    assert way.efforts[0, 2] * way.efforts[-1, 2] < 0.0
    joints[2]["limits"] = {"effort": float(ends[2] + part * (largest - ends)[2])}
    with pytest.raises(MotorLimitExceeded):
        solve_forward(load_robot(content), last)


@pytest.mark.parametrize("rows", [1, 2, 3, 4, 5, 9, 10, 20])
def test_waypoints_miss_no_more_than_requests_one_by_one(rows):
    first, last = UNSTABLE_BETWEEN
    robot = load_robot("rfrfr")
    start = solve_inverse(robot, first)
    poses = np.linspace(first, last, rows + 1)[1:]
    assert not trace_through(robot, poses=poses, start=start, stable_only=True).reached


@pytest.mark.parametrize("rows", [1, 2, 3, 10])
def test_waypoints_that_are_far_apart_have_the_events_of_a_trace(rows):
    first, last = UNSTABLE_BETWEEN
    robot = load_robot("rfrfr")
    start = solve_inverse(robot, first)
    way = trace_through(robot, poses=np.linspace(first, last, rows + 1)[1:], start=start)
    assert [event.kind for event in way.events] == ["stability", "stability"]
    np.testing.assert_allclose(
        [event.fraction for event in way.events], [0.893958682, 0.997738997], atol=1e-7
    )


def test_waypoints_tell_pairs_of_singularities():
    way = trace_through(load_robot("rfrfr"), motors=np.linspace([2.59, 0.55], [0.598, 2.3202], 11))
    assert [event.kind for event in way.events] == ["singularity", "singularity"]


@pytest.mark.parametrize("points", [2, 51, 101])
def test_symmetric_ways_end_where_several_branches_cross(points):
    """The determinant keeps its sign where two singular values pass zero: it was walked through."""
    robot = three_swinging()
    home = solve_home(robot)
    below = [home.platform_position[2] - 0.02, 0.0, 0.0]
    way = trace(robot, pose=below, points=points)
    assert not way.reached
    assert [event.kind for event in way.events] == ["bifurcation"]
    assert "several branches cross" in way.events[0].message
    with pytest.raises(NoInverseSolution, match="several branches cross"):
        solve_inverse(robot, below)


@pytest.mark.parametrize("points", [2, 3, 11, 51])
@pytest.mark.parametrize(
    ("name", "axis", "way", "index", "fraction"),
    [
        ("gough_stewart", 0, 0.8, 1, 0.1975039496),  # where stability changes once more
        ("six_rus", 2, -0.8, 3, 0.4064011617),  # where the branch itself turns back
    ],
)
def test_they_end_there_whatever_else_happens_and_wherever_points_lie(
    name, axis, way, index, fraction, points
):
    """Whether they ended, and whether in a fold, was decided by how many points were asked for."""
    robot = load_robot(name)
    target = solve_home(robot).pose
    target[axis] += way * robot.mean_length
    last = trace(robot, pose=target, points=points).events[-1]
    assert (last.kind, last.index_before, last.index_after) == ("bifurcation", index, index)
    assert last.fraction == pytest.approx(fraction, abs=2e-9)


@pytest.mark.parametrize("points", [2, 51])
def test_so_they_do_under_a_force_that_turns_with_the_platform(points):
    """The branch was walked through where several cross, and a request ended on another one."""
    start = pushed_along(three_swinging(), [0.0, 0.0, 0.005])
    below = start.pose - [0.02, 0.0, 0.0]
    way = trace(start.robot, pose=below, start=start, points=points)
    assert not way.reached
    assert [event.kind for event in way.events] == ["bifurcation"]
    with pytest.raises(NoInverseSolution, match="several branches cross"):
        solve_inverse(start.robot, below, start=start)

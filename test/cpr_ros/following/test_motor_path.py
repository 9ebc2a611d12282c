# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors as a function of time: points are met exactly, nothing jumps, speeds are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cpr_ros.following.motor_path import MotorPath

MOTORS = 3
#: Half an acceleration is a coefficient: the smallest numbers of all have no half.
numbers = st.floats(-3.0, 3.0, allow_subnormal=False).filter(
    lambda number: 2.0 * (0.5 * number) == number
)
#: Orders of a path by what its points carry.
KINDS = (1, 2, 3)


@st.composite
def paths(draw, kinds=KINDS):
    """A path and the points it goes through: times, and for every order (P, n)."""
    count = draw(st.integers(2, 6))
    times = np.cumsum(draw(arrays(float, count, elements=st.floats(0.05, 2.0))))
    carried = [
        draw(arrays(float, (count, MOTORS), elements=numbers))
        for _ in range(draw(st.sampled_from(kinds)))
    ]
    return MotorPath.through(times, *carried), times, carried


@settings(max_examples=60, deadline=None)
@given(paths())
def test_points_are_met_in_all_they_carry(given_path):
    path, times, carried = given_path
    for number, time in enumerate(times[:-1]):
        for order, values in enumerate(carried):
            np.testing.assert_array_equal(path.at(time)[order], values[number])
    arrived = path.at_end()
    for order, values in enumerate(carried):
        size = 1.0 + np.abs(path.pieces[-1]).max()
        np.testing.assert_allclose(arrived[order], values[-1], atol=1e-10 * size)
    np.testing.assert_array_equal(path.at(path.end).positions, carried[0][-1])
    np.testing.assert_array_equal(path.positions([path.end + 1.0])[0], carried[0][-1])


@settings(max_examples=60, deadline=None)
@given(paths())
def test_what_points_carry_is_continuous(given_path):
    path, times, carried = given_path
    size = 1.0 + np.abs(path.pieces).max()
    for time in times[1:-1]:
        before, after = path.at(time - 1e-9), path.at(time)
        for order in range(len(carried)):
            np.testing.assert_allclose(before[order], after[order], atol=1e-6 * size)


@settings(max_examples=50, deadline=None)
@given(paths(), st.floats(0.0, 1.0))
def test_derivatives_are_those_of_the_positions(given_path, part):
    path, _, _ = given_path
    piece = int(part * (len(path.breaks) - 2))
    time, step = 0.5 * (path.breaks[piece] + path.breaks[piece + 1]), 1e-5
    _, velocity, acceleration = path.at(time)
    first, middle, last = path.positions([time - step, time, time + step])
    size = 1.0 + np.abs(path.pieces).max()
    np.testing.assert_allclose((last - first) / (2.0 * step), velocity, atol=1e-6 * size)
    np.testing.assert_allclose(
        (path.at(time + step).velocities - path.at(time - step).velocities) / (2.0 * step),
        acceleration,
        atol=1e-4 * size,
    )
    np.testing.assert_allclose(middle, path.at(time).positions, atol=1e-12 * size)


@settings(max_examples=60, deadline=None)
@given(paths())
def test_no_speed_is_above_the_largest_and_one_has_it(given_path):
    path, _, _ = given_path
    found = path.largest_speeds()
    for piece, (first, last) in enumerate(zip(path.breaks[:-1], path.breaks[1:], strict=True)):
        inside = np.linspace(first, last, 41)[:-1]
        speeds = np.abs([path.at(time).velocities for time in inside]).max(axis=0)
        assert np.all(speeds <= found[piece] * (1.0 + 1e-9) + 1e-9)
        # The turn is found, not only bounded: between samples a speed changes this little.
        bend = np.abs([path.at(time).accelerations for time in inside]).max(axis=0)
        assert np.all(found[piece] <= speeds + bend * (last - first) / 40 * 1.1 + 1e-9)


@settings(max_examples=60, deadline=None)
@given(paths())
def test_bounds_of_speeds_are_above_them_and_near_them_in_short_pieces(given_path):
    path, _, _ = given_path
    speeds, bounds = path.largest_speeds(), path.speed_bounds()
    slack = 1e-9 * (1.0 + speeds.max())
    assert np.all(bounds >= speeds - slack)
    some = np.arange(len(speeds))[::2]
    np.testing.assert_array_equal(path.largest_speeds(some), speeds[some])
    length = path.end - path.begin
    short = path.part(path.begin, path.begin + 1e-4 * length, 0.0)
    largest = speeds.max(axis=0) + 1e-3 * slack
    assert np.all(short.speed_bounds()[0] <= short.largest_speeds()[0] + 0.01 * largest)


@pytest.mark.parametrize("rest", [1, 2])
def test_the_speed_from_rest_to_rest_is_known_exactly(rest):
    """Of a cubic 3/2 of the mean, of a quintic 15/8."""
    zeros = [np.zeros((2, 1))] * rest
    path = MotorPath.through([1.0, 3.0], [[0.5], [2.5]], *zeros)
    assert path.largest_speeds()[0, 0] == pytest.approx([1.5, 1.875][rest - 1], rel=1e-9)


@settings(max_examples=50, deadline=None)
@given(paths(), st.floats(-0.2, 1.2), st.floats(0.01, 1.0), numbers)
def test_a_part_moved_in_time_is_the_same_motion(given_path, begin, length, moved):
    path, _, _ = given_path
    first = path.begin + begin * (path.end - path.begin)
    part = path.part(first, first + length, moved)
    assert (part.begin, part.end) == pytest.approx((moved, moved + length))
    size = 1.0 + np.abs(path.pieces).max()
    for time in np.linspace(0.0, length, 7)[:-1]:
        for mine, its in zip(part.at(moved + time), path.at(first + time), strict=True):
            if np.min(np.abs(first + time - path.breaks)) > 1e-9:
                np.testing.assert_allclose(mine, its, atol=1e-9 * size)


def test_one_path_behind_another():
    rest = MotorPath.rest(-1.0, 0.0, np.array([2.0]))
    path = rest.then(MotorPath.through([0.0, 1.0], [[2.0], [3.0]]))
    np.testing.assert_allclose(path.positions([-2.0, -0.5, 0.5, 1.0, 4.0])[:, 0], [2, 2, 2.5, 3, 3])
    assert path.at(-0.5).velocities == 0.0

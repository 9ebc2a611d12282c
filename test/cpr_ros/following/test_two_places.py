# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that are measured in two places in turn, and what is none of it."""

import itertools

import numpy as np
import pytest
from helpers.drive import robot
from hypothesis import given
from hypothesis import strategies as st

from cpr_ros.following.moved_by_others import MovedByOthers
from cpr_ros.following.two_places import TwoPlaces

HOME, OTHER = np.array([2.6, 0.5]), np.array([2.6, 1.0])


def said(rate, other_rate, seconds, own=lambda now: HOME):
    """What comes of two publishers, one of them elsewhere: times and motors."""
    times = [(k / rate, own(k / rate)) for k in range(int(rate * seconds))]
    times += [((k + 0.5) / other_rate, OTHER) for k in range(int(other_rate * seconds))]
    return sorted(times, key=lambda each: each[0])


@pytest.mark.parametrize(("rate", "other"), [(50, 50), (100, 15), (15, 100), (200, 3), (5, 7)])
def test_two_publishers_are_found_out_soon_and_as_long_as_there_are_two(rate, other):
    places, found = TwoPlaces(robot("rfrfr")), []
    for now, motors in said(rate, other, 6.0):
        found.append((now, places.take(motors, HOME, 0.1, now)))
    first = next(now for now, apart in found if apart)
    assert first <= 4.5 / min(rate, other)
    assert all(apart == 0.5 for now, apart in found if now >= first)
    later = [places.take(HOME, HOME, 0.1, 6.0 + 0.1 * k) for k in range(1, 40)]
    assert later[-1] == 0.0 and later == sorted(later, reverse=True)


def test_they_are_found_out_in_motion_too():
    places = TwoPlaces(robot("rfrfr"))
    own = lambda now: HOME + [0.5 * now, -0.2 * now]  # noqa: E731
    apart = [places.take(motors, own(now), 0.1, now) for now, motors in said(50, 50, 1.0, own)]
    assert apart[20] > 0.4 and all(apart[20:])


def test_they_are_found_out_where_the_motors_were_sent_from_the_other_place_a_while_ago():
    places = TwoPlaces(robot("rfrfr"))
    places.take(OTHER, OTHER, 0.1, 0.0)
    apart = [places.take(motors, HOME, 0.1, 0.1 + now) for now, motors in said(50, 50, 1.0)]
    assert not any(apart[:40])  # for half a second motors that are late may be there
    assert all(apart[60:])


@pytest.mark.parametrize("repeated", [2, 3, 10])
def test_publishers_that_say_everything_again_are_found_out_too(repeated):
    places, found = TwoPlaces(robot("rfrfr")), []
    for k in range(120):
        motors = OTHER if (k // repeated) % 2 else HOME
        found.append(places.take(motors, HOME, 0.1, 0.02 * k))
    assert all(apart == 0.5 for apart in found[5 * repeated :])


@pytest.mark.parametrize(
    ("size", "speed", "rate", "delay", "tolerance"),
    [
        (0.2, 3.0, 10, 0.25, 0.1),
        (0.1, 2.0, 20, 0.12, 0.05),
        (0.02, 1.0, 100, 0.03, 0.01),
        (0.2, 2.0, 5, 0.1, 0.1),
        (0.05, 2.0, 20, 0.03, 0.02),
        (0.02, 1.0, 25, 0.06, 0.01),
    ],
)
@pytest.mark.parametrize("phase", [0.0, 0.3, 0.6])
def test_motors_that_are_sent_out_and_back_and_measured_late_are_in_one_place(
    size, speed, rate, delay, tolerance, phase
):
    """Out and back between two measurements, of which the next one tells of it."""

    def way(now):
        since = max(0.0, now) % 0.9
        return max(0.0, min(since * speed, 2.0 * size - since * speed))

    others, measured = MovedByOthers(robot("rfrfr"), tolerance), phase / rate
    for tick in range(2000):
        now = tick * 0.005
        others.commanded(10.0 + now, HOME + [way(now), 0.0])
        if now >= measured:
            others.take(HOME + [way(now - delay), 0.0], HOME + [way(now), 0.0], 10.0 + now)
            assert "two places" not in others.in_question
            measured += 1.0 / rate


@pytest.mark.parametrize("wrong", [1, 2])
def test_single_wrong_numbers_are_none_of_it(wrong):
    places = TwoPlaces(robot("rfrfr"))
    for k in range(300):
        motors = OTHER if k in (100, 150)[:wrong] else HOME
        assert places.take(motors, HOME, 0.1, 0.01 * k) == 0.0


@given(
    size=st.floats(0.05, 2.0),
    speed=st.floats(0.1, 20.0),
    rate=st.sampled_from([5.0, 20.0, 100.0]),
    lag=st.floats(0.0, 0.03),
)
def test_no_way_that_motors_are_sent_is_one(size, speed, rate, lag):
    """There and back, however fast and however seldom that is measured."""
    places = TwoPlaces(robot("rfrfr"))
    way = lambda now: HOME + [size * np.sin(speed * now), 0.0]  # noqa: E731
    for k in range(100):
        now = k / rate
        if size * speed * lag < 0.2 * size:  # a motor that hardly follows is not where it is sent
            assert places.take(way(now - lag), way(now), 0.1, now) == 0.0


def test_hands_that_move_motors_slowly_are_none_of_it():
    places, way = TwoPlaces(robot("rfrfr")), np.concatenate([np.linspace(0, 1, 40)] * 3)
    for k, part in enumerate(itertools.chain(way, way[::-1])):
        if part in (0.0, 1.0):
            continue  # put back at once, it would be
        assert places.take(HOME + [part, 0.0], HOME, 0.1, 0.05 * k) == 0.0


def test_motors_that_swing_out_are_in_one_place():
    """Let go by whoever moved them: what comes back by a part goes on from there."""
    places, at, swing = TwoPlaces(robot("rfrfr")), 0.0, 2.0
    for k in range(10):
        assert places.take(HOME + [at, 0.0], HOME, 0.02, 0.2 * k) == 0.0
        at, swing = at + swing, -0.6 * swing
    assert abs(swing) > 0.01  # the last ones count too


@pytest.mark.parametrize(
    ("tolerance", "several"), [(0.1, True), (0.1, False), (0.6, True), (0.0, True)]
)
def test_nothing_is_believed_of_motors_that_are_measured_in_two_places(tolerance, several):
    others, words = MovedByOthers(robot("rfrfr"), tolerance), set()
    for now, motors in said(100, 15, 3.0):
        assert not others.take(motors, HOME, 10.0 + now, several=several)
        words.add(others.away)
    if tolerance == 0.1 and several:
        assert any(
            "in two places in turn, 0.5 (rad or rod lengths) apart" in each for each in words
        )
        assert "in two places" in others.away and others.in_question
    else:
        assert words == {""}


@given(
    seed=st.integers(0, 1000), part=st.floats(0.1, 0.99), rate=st.sampled_from([5.0, 50.0, 200.0])
)
def test_noise_within_the_tolerance_of_the_commands_is_one_place(seed, part, rate):
    """Of coarse encoders, and of a motor that trembles: it was told to be another robot."""
    others, random = MovedByOthers(robot("rfrfr"), 0.1), np.random.default_rng(seed)
    for k in range(200):
        others.take(HOME + random.uniform(-0.1 * part, 0.1 * part, 2), HOME, 10.0 + k / rate)
        assert others.in_question == ""


def test_parameters_that_are_set_again_do_not_end_it():
    """Half of the time the newest measurement agrees with the commands."""
    others = MovedByOthers(robot("rfrfr"), 0.1)
    for now, motors in said(50, 50, 1.0):
        others.take(motors, HOME, 10.0 + now)
        if now > 0.5:
            others.tolerance = 0.1
            assert "in two places" in others.away
    others.tolerance = 0.3
    assert "in two places" in others.away
    others.tolerance = 0.6
    assert others.away == ""

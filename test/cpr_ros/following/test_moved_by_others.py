# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that are measured elsewhere than they were sent."""

import math

import numpy as np
import pytest
from helpers.drive import robot

from cpr_ros.following.moved_by_others import FOLLOWING, SETTLING, MovedByOthers
from cpr_ros.following.standstill import GONE_ON, RESTING

SENT = np.array([2.6, 0.5])
ELSEWHERE = SENT + [0.0, 0.2]


@pytest.fixture
def others():
    found = MovedByOthers(robot("rfrfr"), 0.1)
    found.commanded(0.0, SENT)
    return found


def test_motors_that_arrive_late_are_not_moved_by_others(others):
    for now, motors in ((0.1, ELSEWHERE), (0.4, ELSEWHERE), (0.6, SENT + 0.09), (5.0, SENT)):
        assert not others.take(motors, SENT, now)
        assert others.away == ""


def take_for_long(others, motors, now):
    """Often enough to be believed."""
    for age in (0.1, 0.05, 0.0):
        others.take(motors, SENT, now - age)


def test_motors_elsewhere_are_told_soon_and_begun_with_when_they_rest(others):
    assert not others.take(SENT, SENT, 10.0)
    for number in range(20):  # a hand that moves them
        moving = SENT + [0.0, 0.02 * number]
        assert not others.take(moving, SENT, 10.0 + 0.1 * number)
        # The first one elsewhere may be wrong.
        assert (others.doubt != "") == (number == 6), number
        assert (others.away != "") == (number > 6), number
    assert "one was measured 0.38 (rad or rod lengths) from its last command" in others.away
    assert "moved_tolerance 0.1" in others.away
    last = 10.0 + 0.1 * 19
    assert not others.take(moving + 0.5 * RESTING, SENT, last + 0.9 * SETTLING)
    assert others.take(moving, SENT, last + SETTLING)


def test_a_hand_may_move_a_motor_to_near_its_negative():
    others, sent = MovedByOthers(robot("rfrfr"), 0.1), np.array([2.6, 0.1])
    for number in range(20):
        begun = others.take(np.array([2.6, -0.08]), sent, 10.0 + 0.1 * number)
    assert begun and "somebody else has moved" in others.away


def test_motors_that_come_back_are_where_they_were_sent(others):
    take_for_long(others, ELSEWHERE, 10.0)
    assert others.away
    assert not others.take(SENT, SENT, 10.1)
    assert others.away == ""


@pytest.mark.parametrize(("rate", "wrong"), [(10.0, 1), (100.0, 1), (100.0, 5), (1000.0, 40)])
def test_measurements_that_are_wrong_for_a_moment_are_a_doubt(others, rate, wrong):
    """One of them ended what waited, and told a supervisor to halt."""
    for number in range(round(rate)):
        others.take(SENT, SENT, 10.0 + number / rate)
    for number in range(wrong):
        others.take(ELSEWHERE, SENT, 11.0 + number / rate)
        others.look(11.0 + number / rate)
        assert others.away == ""
        assert "measured 0.2 (rad or rod lengths) from its last command" in others.in_question
    others.take(SENT, SENT, 11.0 + wrong / rate)
    assert others.in_question == ""


def test_a_doubt_that_nothing_settles_is_taken_for_true(others):
    others.take(SENT, SENT, 10.0)
    others.take(ELSEWHERE, SENT, 11.0)
    others.look(11.0 + 0.9 * SETTLING)
    assert others.doubt and not others.away
    others.look(11.0 + SETTLING)
    assert "somebody else has moved the motors: one was measured 0.2" in others.away
    assert not others.doubt


def test_motors_that_rest_where_they_were_before_a_command_are_no_doubt(others):
    """Of those that are measured seldom."""
    others.take(SENT, SENT, 10.0)
    others.commanded(10.1, ELSEWHERE)
    assert others.take(SENT, ELSEWHERE, 10.11 + SETTLING)
    assert "somebody else has moved the motors: one was measured 0.2" in others.away


def test_wrong_measurements_in_a_motion_are_no_doubt(others):
    others.take(SENT, SENT, 10.0)
    others.commanded(10.0, SENT)
    others.take(ELSEWHERE, SENT, 10.1)
    assert others.in_question == ""


def test_a_new_command_gives_them_time(others):
    take_for_long(others, ELSEWHERE, 10.0)
    others.commanded(10.0, SENT)
    assert others.away == ""
    assert not others.take(ELSEWHERE, SENT, 10.0 + 0.9 * SETTLING)
    assert others.away == ""
    assert others.take(ELSEWHERE, SENT, 10.0 + SETTLING)


def drive(others, speed, follows, begin=20.0, seconds=2.0, delay=0.0):
    """Command a motor on and on, and measure it; when it is told, how far ahead it is sent then."""
    for number in range(round(200.0 * seconds)):
        now = begin + 0.005 * number
        sent = SENT + [0.0, speed * (now - begin)]
        if not others.away:
            others.commanded(now, sent)
        measured = SENT + [0.0, speed * max(0.0, follows * (now - begin - delay))]
        if number % 4 == 0:
            assert not others.take(measured, sent, now)
            if others.away:
                return now - begin, sent[1] - measured[1]
    return None


def test_motors_that_stand_still_while_commands_go_on_are_told(others):
    others.take(SENT, SENT, 19.0)  # at rest for long when they are sent off
    after, ahead = drive(others, 1.0, 0.0)
    told = SETTLING + GONE_ON / 1.0
    assert told <= after <= told + 0.03
    assert ahead < 1.0 * (told + 0.03)
    assert "the motors do not follow: one was measured 0.5" in others.away
    assert "more than moved_tolerance 0.1" in others.away
    sent, told = SENT + [0.0, ahead], 20.0 + after
    assert not others.take(SENT, sent, told + 0.9 * SETTLING)
    assert others.away
    assert others.take(SENT, sent, told + SETTLING)
    others.begin()  # the node has begun where they are
    assert others.away == ""
    assert drive(others, 1.0, 0.0, begin=30.0)[0] >= SETTLING


def test_motors_that_jam_on_their_way_are_told(others):
    assert drive(others, 1.0, 1.0, seconds=1.0) is None
    jammed, now = SENT + [0.0, 1.0], 21.0
    while not others.away:
        sent = jammed + [0.0, 1.0 * (now - 21.0)]
        others.commanded(now, sent)
        others.take(jammed, sent, now)
        now += 0.005
    late = now - 0.005 - 21.0 - SETTLING - GONE_ON / 1.0
    assert -1e-9 < late < 0.01 + 1e-9  # rounding may cost a tick of either


@pytest.mark.parametrize("speed", [0.05, 0.5, 5.0])
@pytest.mark.parametrize(("follows", "delay"), [(1.0, 0.0), (1.0, 0.3), (0.8, 0.1)])
def test_motors_that_lag_follow(others, speed, follows, delay):
    others.take(SENT, SENT, 19.0)
    assert drive(others, speed, follows, delay=delay) is None
    assert others.away == ""


def test_commands_between_measurements_count(others):
    others.take(SENT, SENT, 10.0)
    for way in np.arange(0.0, SETTLING + 2.0 * GONE_ON, 0.01):
        others.commanded(11.0 + way, SENT + way)
    others.take(SENT, SENT + way, 11.0 + way)
    assert "the motors do not follow" in others.away


@pytest.mark.parametrize(("way", "waited_for"), [(0.2, False), (0.01, True)])
def test_a_pause_in_which_motors_did_not_come_tells_no_arrival(others, way, waited_for):
    """Sent now and then, and measured soon after only: it was never told that they do not follow."""
    others.take(SENT, SENT, 10.0)
    for now in (11.0, 11.6):
        assert not others.away
        others.commanded(now, SENT + way)
        others.take(SENT, SENT + way, now + 0.3, waited_for=waited_for)
    assert "the motors do not follow" in others.away


def test_motors_near_their_slow_commands_may_rest(others):
    others.take(SENT, SENT, 19.0)
    assert drive(others, 0.04, 0.0) is None


def test_another_tolerance_ends_it_and_begins_nothing(others):
    """It was for ever, where nobody measured any more."""
    for tolerance, told in ((0.15, True), (0.25, False)):
        others.take(SENT, SENT, 9.8)
        others.take(ELSEWHERE, SENT, 9.85)
        others.tolerance = tolerance
        words = f"more than moved_tolerance {tolerance}"
        assert (words in others.doubt) == told == bool(others.doubt)
        others.tolerance = 0.1
    take_for_long(others, ELSEWHERE, 10.0)
    others.tolerance = 0.15
    assert "more than moved_tolerance 0.15" in others.away
    for tolerance in (0.0, 0.25):
        take_for_long(others, ELSEWHERE, 10.0)
        others.tolerance = tolerance
        assert others.away == ""
        others.tolerance = 0.1
        assert others.away == ""


def test_nothing_is_compared_without_commands_or_without_a_tolerance(others):
    assert not others.take(ELSEWHERE, None, 20.0)
    assert others.away == ""
    others.tolerance = 0.0
    assert not others.take(ELSEWHERE, SENT, 30.0)
    assert others.away == ""


def test_ways_count_in_the_units_of_motors():
    sliding = robot("gough_stewart")
    others = MovedByOthers(sliding, 0.1)
    sent = np.full(sliding.motor_count, 0.4)
    for way, away in ((0.09, False), (0.11, True)):
        measured = sent.copy()
        measured[0] += way * sliding.motor_units[0]
        others.take(measured, sent, 1.0)
        assert bool(others.in_question) == away


@pytest.mark.parametrize("tolerance", [0.1, 0.0])
def test_motors_that_commands_wait_for_do_not_follow_and_are_not_begun_with(others, tolerance):
    """As long as they wait; how far ahead these are, and what noise they have, is not asked."""
    near, others.tolerance = SENT + 0.01, tolerance
    for number in range(40):
        now = 10.0 + 0.05 * number
        noise = 0.1 * RESTING * (number % 2)
        assert not others.take(near + noise, SENT, now, waited_for=True)
        assert bool(others.away) == (now - 10.0 >= SETTLING - 1e-9), now
    assert "as far as max_lead allows" in others.away
    assert not others.take(near, SENT, now + 0.05)
    assert others.away == ""
    now += 1.0
    others.commanded(now, SENT)
    for number in range(40):  # a hand that holds them, or little power: they move
        now += 0.05
        assert not others.take(near + 0.02 * number, SENT + 0.02 * number, now, waited_for=True)
        assert others.away == ""


@pytest.mark.parametrize(
    ("name", "max_speed", "slow"), [("rfrfr", 0.015, 0.002), ("gough_stewart", 0.1, 0.012)]
)
def test_motors_of_slow_robots_follow_at_a_part_of_their_speed(name, max_speed, slow):
    """They moved at half the speed that was asked for, and were said not to follow."""
    found = robot(name)
    begin = np.full(found.motor_count, 0.5)
    patience = RESTING / (FOLLOWING * max_speed)
    for speed in (slow, 0.0):
        others = MovedByOthers(found, 0.1)
        others.commanded(0.0, begin + 0.1)
        for number in range(round(200 * 3.0 * patience)):
            now = 10.0 + 0.005 * number
            flicker = 0.2 * RESTING * (number % 2)  # as much as an encoder of 12 bits, and more
            measured = begin + (speed * (now - 10.0) + flicker) * found.motor_units
            options = {"max_speed": max_speed, "waited_for": True}
            assert not others.take(measured, begin + 0.1, now, **options)
            assert bool(others.away) == (not speed and now - 10.0 >= patience - 1e-9), now
    assert f"all at rest for {patience:.3g} s" in others.away
    # Half a second is enough where commands would have gone far.
    assert not others.take(measured, begin + 0.1, now, max_speed=1.0, waited_for=True)
    assert "all at rest for 0.5 s" in others.away


def test_where_they_were_just_measured_nothing_is_sent_for_a_while(others):
    """Several may say so, and not agree."""
    others.begin(SENT)
    assert (others.in_question, others.due) == ("", math.inf)
    others.prove(10.0)
    others.take(SENT, SENT, 10.5)
    others.look(10.99)
    assert "where the motors are was just measured" in others.in_question and not others.away
    others.take(ELSEWHERE, SENT, 10.995)
    assert others.due == 11.0
    others.look(11.0)
    assert others.in_question == others.doubt != ""
    assert others.due == 10.995 + SETTLING


@pytest.mark.parametrize(("proved", "measured"), [(0.0, 6), (10.0, 4)])
def test_who_contradicts_another_in_that_while_is_found_sooner(others, proved, measured):
    others.prove(proved)
    for number, motors in enumerate([SENT, ELSEWHERE] * 3):
        now = 10.0 + 0.45 * number
        others.look(now)
        assert not others.take(motors, SENT, now)
        assert ("in two places" in others.away) == (number + 1 >= measured) == bool(others.away)
    for number in range(10):  # nor are they begun with where one of them goes on
        assert not others.take(ELSEWHERE, SENT, now + 0.1 * number)
        assert "in two places" in others.away


@pytest.mark.parametrize("begun", [True, False])
def test_what_was_measured_before_the_node_has_begun_there_counts_no_more(others, begun):
    for number, motors in enumerate([SENT, ELSEWHERE] * 3):
        if begun and number == 5:
            others.begin(SENT)
        others.take(motors, SENT, 10.0 + 0.45 * number)
    assert ("in two places" in others.away) == (not begun)


def test_motors_that_are_held_where_the_node_has_begun_are_begun_with_every_time(others):
    """However far the first command leads."""
    for now in (10.0, 20.0, 30.0):
        take_for_long(others, ELSEWHERE, now)
        assert others.take(ELSEWHERE, SENT, now + SETTLING)
        others.begin(ELSEWHERE)
        others.commanded(now + 5.0, SENT)

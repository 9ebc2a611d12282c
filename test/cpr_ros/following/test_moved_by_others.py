# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that are measured elsewhere than they were sent."""

import numpy as np
import pytest
from helpers.drive import robot

from cpr_ros.following.moved_by_others import RESTING, SETTLING, MovedByOthers

SENT = np.array([2.6, 0.5])
ELSEWHERE = SENT + [0.0, 0.2]


@pytest.fixture
def others():
    found = MovedByOthers(robot("rfrfr"), 0.1)
    found.commanded(0.0)
    return found


def test_motors_that_arrive_late_are_not_moved_by_others(others):
    for now, motors in ((0.1, ELSEWHERE), (0.4, ELSEWHERE), (0.6, SENT + 0.09), (5.0, SENT)):
        assert not others.take(motors, SENT, now)
        assert others.away == ""


def test_motors_elsewhere_are_told_at_once_and_begun_with_when_they_rest(others):
    assert not others.take(SENT, SENT, 10.0)
    for number in range(20):  # a hand that moves them
        moving = SENT + [0.0, 0.02 * number]
        assert not others.take(moving, SENT, 10.0 + 0.1 * number)
        assert (others.away != "") == (0.02 * number > 0.1), number
    assert "one was measured 0.38 (rad or rod lengths) from its last command" in others.away
    assert "moved_tolerance 0.1" in others.away
    last = 10.0 + 0.1 * 19
    assert not others.take(moving + 0.5 * RESTING, SENT, last + 0.9 * SETTLING)
    assert others.take(moving, SENT, last + SETTLING)


def test_motors_that_come_back_are_where_they_were_sent(others):
    others.take(ELSEWHERE, SENT, 10.0)
    assert others.away
    assert not others.take(SENT, SENT, 10.1)
    assert others.away == ""


def test_a_new_command_gives_them_time(others):
    others.take(ELSEWHERE, SENT, 10.0)
    others.commanded(10.0)
    assert others.away == ""
    assert not others.take(ELSEWHERE, SENT, 10.0 + 0.9 * SETTLING)
    assert others.away == ""
    assert others.take(ELSEWHERE, SENT, 10.0 + SETTLING)


def test_another_tolerance_ends_it_and_begins_nothing(others):
    """It was for ever, where nobody measured any more."""
    others.take(ELSEWHERE, SENT, 10.0)
    others.tolerance = 0.15
    assert "more than moved_tolerance 0.15" in others.away
    for tolerance in (0.0, 0.25):
        others.take(ELSEWHERE, SENT, 10.0)
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
        assert bool(others.away) == away

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that are as far off their commands as before they were begun with; those that are not."""

import numpy as np
import pytest
from helpers.drive import robot

from cpr_ros.following.constant_offset import ConstantOffset

PLACE, OFF = np.array([2.6, 0.6]), np.array([0.0, 0.3])


@pytest.fixture(params=[True, False], ids=["known", "unknown"])
def offset(request):
    """Of motors that were off, and sent a little farther from where they are begun with."""
    found = ConstantOffset(robot("rfrfr"))
    found.begun_with(OFF)
    found.begin(PLACE if request.param else None)
    assert found.take(PLACE, PLACE, 0.1, 0.0) == ""
    if not request.param:
        found.sent(PLACE, 0.5)
    return found


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("before", "off", "said"),
    [
        (0.3, 0.3, True),
        (0.3, 0.22, True),
        (0.3, 0.38, True),
        (0.3, -0.3, False),
        (0.3, 0.6, False),
        (0.08, 0.15, False),  # of what is tolerated nothing is said, of before or of now
        (0.15, 0.08, False),
    ],
)
def test_a_motor_is_off_by_about_the_same(offset, before, off, said, sign):
    offset.begun_with(sign * np.array([0.0, before]))
    offset.sent(PLACE + 0.01, 1.0)
    told = offset.take(PLACE + [0.01, sign * off], PLACE + 0.01, 0.1, 1.1)
    words = f"motor2 was measured {sign * off - 0.01:+.3g} rad off its command"
    assert told.startswith(words) == said == bool(told)


def test_ways_count_in_the_units_of_motors():
    sliding = robot("gough_stewart")
    place, way = np.full(sliding.motor_count, 0.4), sliding.motor_units * np.eye(6)[0]
    for part, said in ((0.09, False), (0.11, True)):
        found = ConstantOffset(sliding)
        found.begun_with(part * way)
        found.begin(place)
        found.sent(place, 1.0)
        assert bool(found.take(place + part * way, place, 0.1, 1.1)) == said


def test_a_motor_that_stays_is_not_off_however_far_the_first_command_leads(offset):
    """At a low rate of ticks."""
    command = PLACE - OFF
    offset.sent(command, 1.0)
    for now, noise in ((1.1, 0.0), (5.0, 0.04)):
        assert offset.take(PLACE + noise, command, 0.1, now) == ""


def test_motors_that_followed_are_not_off_as_before(offset):
    offset.sent(PLACE + 0.01, 1.0)
    offset.take(PLACE, PLACE + 0.01, 0.1, 1.5)
    offset.take(PLACE, PLACE + 0.01, 0.1, 2.1)
    assert offset.take(PLACE + OFF, PLACE + 0.01, 0.1, 2.2) == ""


def test_a_motor_that_overshoots_and_later_jams_is_not_off_as_before(offset):
    """It is as far behind as commands go ahead, on their way, however far beside it was before."""
    offset.sent(PLACE + 0.01, 1.0)
    assert offset.take(PLACE - [0.0, 0.06], PLACE + 0.01, 0.1, 1.1) == ""
    command = PLACE - OFF
    offset.sent(command, 1.3)
    for now in (1.4, 5.0):
        assert offset.take(PLACE, command, 0.1, now) == ""

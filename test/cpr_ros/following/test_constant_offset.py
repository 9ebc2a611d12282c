# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that are as far off their commands as before they were begun with; those that are not."""

import numpy as np
import pytest
from helpers.drive import robot

from cpr_ros.following.constant_offset import ConstantOffset

PLACE, OFF = np.array([2.6, 0.6]), np.array([0.0, 0.3])


@pytest.fixture
def offset():
    """Of motors that were off, and sent a little farther from where they are begun with."""
    found = ConstantOffset(robot("rfrfr"))
    found.begun_with(OFF)
    found.begin(PLACE)
    assert found.take(PLACE, PLACE, 0.1, 0.0) == ""
    return found


@pytest.mark.parametrize(
    ("off", "said"), [(0.3, True), (0.22, True), (0.38, True), (-0.3, False), (0.6, False)]
)
def test_a_motor_is_off_by_about_the_same(offset, off, said):
    offset.sent(PLACE + 0.01, 1.0)
    told = offset.take(PLACE + [0.01, off], PLACE + 0.01, 0.1, 1.1)
    assert told.startswith("motor2 was measured +0.") == said == bool(told)


def test_a_motor_that_stays_is_not_off_however_far_the_first_command_leads(offset):
    """At a low rate of ticks."""
    command = PLACE - OFF
    offset.sent(command, 1.0)
    for now in (1.1, 5.0):
        assert offset.take(PLACE, command, 0.1, now) == ""


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

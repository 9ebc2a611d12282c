# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that come nearer to their command, rest, and leave it again."""

import math

import pytest

from cpr_ros.following.approach import Approach
from cpr_ros.following.standstill import RESTING


@pytest.fixture
def approach():
    return Approach()


def test_it_lasts_as_long_as_they_come_nearer(approach):
    assert approach.since == math.inf
    for number in range(10):
        approach.take(0.5 - 1.1 * RESTING * number, float(number))
        assert approach.since == float(number)
        assert not approach.leaving
    for number in range(10, 20):  # at rest, but for noise
        approach.take(0.5 - 1.1 * RESTING * 9 - 0.4 * RESTING * (-1) ** number, float(number))
        assert approach.since == 9.0
        assert not approach.leaving


def test_it_ends_when_they_are_farther_than_they_were(approach):
    for way, leaving in (
        (0.5, False),
        (0.3, False),
        (0.3 + 0.9 * RESTING, False),
        (0.3 + 1.1 * RESTING, True),
        (0.3, False),
        (0.4, True),
    ):
        approach.take(way, 1.0)
        assert approach.leaving == leaving, way


def test_what_was_before_it_begins_tells_nothing(approach):
    approach.take(0.1, 1.0)
    approach.take(0.2, 2.0)
    assert approach.leaving
    approach.begin()
    assert not approach.leaving
    approach.take(0.5, 3.0)
    assert (approach.since, approach.leaving) == (3.0, False)
    approach.begin(4.0)
    approach.take(0.9, 5.0)
    assert (approach.since, approach.leaving) == (4.0, False)


def test_a_way_that_nobody_knows_is_no_nearer_and_no_farther(approach):
    approach.take(0.3, 1.0)
    approach.take(math.nan, 2.0)
    assert (approach.since, approach.leaving) == (1.0, False)

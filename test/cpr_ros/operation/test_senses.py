# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

import pytest

from cpr_ros.operation.senses import SETTLED, Sight


def test_nothing_is_missing_before_anything_was():
    assert Sight().missing("", 0.0) == ""


def test_what_is_missing_is_told_until_it_has_come_again_for_a_while():
    sight = Sight()
    assert sight.missing("too old", 10.0) == "too old"
    assert sight.missing("", 10.5) == "too old; it came again less than 1 s ago"
    assert sight.missing("", 10.0 + SETTLED) == ""


@pytest.mark.parametrize("gap", [0.05, 0.5, 0.95])
def test_what_comes_now_and_then_is_missing_all_along(gap):
    sight, now = Sight(), 0.0
    for _ in range(10):
        assert sight.missing("a NaN", now)
        assert sight.missing("", now + 0.5 * gap)
        now += gap


def test_what_is_missing_now_is_told_not_what_was():
    sight = Sight()
    sight.missing("a NaN", 0.0)
    assert sight.missing("too old", 0.5) == "too old"


def test_forgetting_is_as_if_nothing_had_been_missing():
    sight = Sight()
    sight.missing("too old", 0.0)
    sight.forget()
    assert sight.missing("", 0.1) == ""

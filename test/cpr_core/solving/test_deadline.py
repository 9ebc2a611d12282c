# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The time that is left of a request."""

import math

from cpr_core.solving.deadline import Deadline


def test_what_is_left_becomes_less_and_never_less_than_none():
    readings = iter([5.0, 5.0, 7.5, 8.0, 9.0])
    deadline = Deadline(3.0, lambda: next(readings))
    assert [deadline.left for _ in range(4)] == [3.0, 0.5, 0.0, 0.0]


def test_it_is_over_where_nothing_is_left_and_never_without_a_limit():
    readings = iter([5.0, 7.9, 8.0, 9.0])
    deadline = Deadline(3.0, lambda: next(readings))
    assert [deadline.over for _ in range(3)] == [False, True, True]
    endless = Deadline(None)
    assert not endless.over and endless.left == math.inf

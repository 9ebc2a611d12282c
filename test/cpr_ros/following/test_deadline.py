# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The time that is left of a request."""

from cpr_ros.following.deadline import Deadline


def test_what_is_left_becomes_less_and_never_less_than_none():
    readings = iter([5.0, 5.0, 7.5, 8.0, 9.0])
    deadline = Deadline(3.0, lambda: next(readings))
    assert [deadline.left for _ in range(4)] == [3.0, 0.5, 0.0, 0.0]

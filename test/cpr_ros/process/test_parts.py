# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What one thread looks after."""

import math
import sys

from cpr_ros.process.parts import Parts


class Part:
    """Due at a time, and fails if it is to."""

    def __init__(self, due=math.inf, fails=False):
        self.due, self.fails, self.looked = due, fails, []

    def look(self, now):
        self.looked.append(now)
        if self.fails:
            raise ValueError("singular")


def test_the_first_that_is_due_counts():
    assert Parts((Part(3.0), Part(), Part(2.0)), print).due == 2.0
    assert Parts((Part(),), print).due == math.inf


def test_one_that_fails_takes_no_turn_from_the_others_and_is_told():
    first, failing, last = parts = Part(), Part(fails=True), Part()
    told, now = [], iter(range(1, 7))
    looked_after = Parts(parts, lambda: told.append(sys.exception()), lambda: next(now))
    for _ in range(2):
        looked_after.look()
    assert [first.looked, failing.looked, last.looked] == [[1, 4], [2, 5], [3, 6]]
    assert [str(error) for error in told] == ["singular", "singular"]

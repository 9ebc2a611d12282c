# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""When streams come, on a clock of the test."""

import math
from contextlib import suppress

import numpy as np
import pytest

from cpr_ros.process.periodic import LOOK, Periodic


class Clockwork:
    """Whoever spins; how often it woke up, and what was said when."""

    def __init__(self, begin=1000.0):
        self.now = self.begin = begin
        self.periodic, self.woke = Periodic(), 0
        self.periodic.begin(begin)

    def add(self, rate, wanted=lambda now: True):
        said = []
        self.periodic.add(rate, lambda: said.append(self.now - self.begin), wanted)
        return said

    def until(self, end, lateness=1e-5):
        while self.periodic.due + lateness < self.begin + end:
            self.now = self.periodic.due + lateness
            self.woke += 1
            self.periodic.look(self.now)
        self.now = self.begin + end


def test_everything_comes_at_its_rate():
    clock = Clockwork()
    streams = {rate: clock.add(rate) for rate in (50.0, 20.0, 10.0, 1.0, 0.5)}
    clock.until(10.005)
    for rate, said in streams.items():
        np.testing.assert_allclose(said, np.arange(1, 10 * rate + 1) / rate, atol=2e-5)


def test_what_is_due_together_wakes_the_node_once():
    clock = Clockwork()
    for rate in (50.0, 10.0, 1.0):
        clock.add(rate)
    clock.until(10.005)
    assert clock.woke == 500


@pytest.mark.parametrize("what", ["saying it", "asking who wants it"])
def test_what_fails_keeps_nothing_else_from_its_turns(what):
    clock, failed = Clockwork(), []
    others = [clock.add(10.0), clock.add(20.0)]

    def fail(now=0.0):
        failed.append(clock.now - clock.begin)
        raise ValueError("singular")

    if what == "saying it":
        clock.periodic.add(10.0, fail)
    else:
        clock.periodic.add(10.0, lambda: None, fail)
    others.append(clock.add(10.0))
    while clock.now < clock.begin + 1.05:
        with suppress(ValueError):
            clock.until(1.05)
    np.testing.assert_allclose(failed, np.arange(1, 11) / 10.0, atol=1e-4)
    for said, rate in zip(others, (10.0, 20.0, 10.0), strict=True):
        expected = np.arange(1, 1.05 * rate) / rate
        np.testing.assert_allclose(said, expected, atol=1e-4)


def test_what_comes_late_is_not_made_up_for_and_moves_nothing():
    clock = Clockwork()
    said = clock.add(10.0)
    clock.until(1.05)
    clock.now = clock.begin + 1.57
    clock.periodic.look(clock.now)
    clock.until(2.05)
    np.testing.assert_allclose(said[10:], [1.57, 1.6, 1.7, 1.8, 1.9, 2.0], atol=2e-5)


def test_what_nobody_wants_is_looked_at_together_and_seldom():
    clock = Clockwork()
    heard = [clock.add(rate, lambda now: False) for rate in (200.0, 50.0, 20.0, 10.0)]
    clock.until(10.0)
    assert heard == [[]] * 4
    # Once for the first call of each, then together.
    assert clock.woke <= 4 + 10.0 / LOOK


@pytest.mark.parametrize("rate", [200.0, 50.0, 20.0, 10.0, 7.0, 0.5])
def test_who_comes_is_heard_soon_and_at_the_rate(rate):
    clock = Clockwork()
    came = 3.03
    said = clock.add(rate, lambda now: now - clock.begin >= came)
    clock.until(20.0)
    assert came <= said[0] <= came + LOOK + 1.0 / rate
    np.testing.assert_allclose(np.diff(said), 1.0 / rate, atol=2e-5)
    np.testing.assert_allclose(np.round(np.array(said) * rate) / rate, said, atol=2e-5)


def test_nothing_comes_after_a_new_beginning():
    clock = Clockwork()
    said = clock.add(10.0)
    clock.periodic.begin(0.0)
    assert clock.periodic.due == math.inf
    clock.periodic.look(clock.now + 100.0)
    assert said == []

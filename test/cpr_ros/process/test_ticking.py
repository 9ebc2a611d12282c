# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""When ticks come, on a clock of the test."""

import math
from itertools import pairwise

import numpy as np
import pytest

from cpr_ros.process.ticking import JITTER, Ticking

PERIOD = 0.005
NEAREST = (1.0 - JITTER) * PERIOD


class Clockwork:
    """Whoever spins, and what ticks."""

    def __init__(self, duration=0.0):
        self.now, self.ticks, self.work, self.duration = 0.0, [], 0, duration
        self.ticking = Ticking(PERIOD, self._tick, lambda: self.work == 0, lambda: self.now)
        self.ticking.start(self.now)

    def _tick(self, now):
        assert now == self.now
        self.ticks.append(now)
        self.work = max(0, self.work - 1)
        self.now += self.duration

    def fail(self, now):
        self._tick(now)
        raise ValueError("singular")

    def come(self, work):
        """Something to do comes, for so many ticks."""
        self.work += work
        self.ticking.look(self.now)

    def until(self, end, lateness=lambda: 0.0):
        """Let time go by; ticks that are due are served late."""
        while self.ticking.due <= end:
            self.now = max(self.now, self.ticking.due + lateness())
            self.ticking.look(self.now)
        self.now = max(self.now, end)


def test_what_comes_at_rest_is_acted_on_at_once_and_ticks_follow_a_period_apart():
    clock = Clockwork()
    clock.until(1.0012)
    assert clock.ticks == []
    clock.come(3)
    clock.until(1.1)
    np.testing.assert_allclose(clock.ticks, 1.0012 + PERIOD * np.arange(3), atol=1e-12)
    assert clock.ticking.due == math.inf


def test_what_comes_between_ticks_waits_for_the_next():
    clock = Clockwork()
    clock.until(1.0)
    for arrival in (1.0, 1.001, 1.0049):
        clock.until(arrival)
        clock.come(1)
    clock.until(1.1)
    np.testing.assert_allclose(clock.ticks, [1.0, 1.005, 1.010], atol=1e-12)


def test_no_two_ticks_are_closer_than_a_period_whatever_comes_when():
    random, clock = np.random.default_rng(1), Clockwork()
    for late in (0.0, 0.02, 0.5, 3.0):
        for _ in range(500):
            clock.until(clock.now + random.exponential(2.0 * PERIOD), lambda: 0.0)
            clock.come(int(random.integers(0, 4)))
            clock.until(
                clock.now + random.exponential(PERIOD),
                lambda late=late: late * PERIOD * random.random(),
            )
    gaps = np.diff(clock.ticks)
    assert len(gaps) > 2000
    assert gaps.min() >= NEAREST - 1e-9
    # The times they are planned for are whole periods apart: what is early is not early again.
    times = np.array(clock.ticks)
    for first in range(0, len(times) - 200, 100):
        many = times[first : first + 200] - times[first]
        assert (many >= PERIOD * (np.arange(200) - JITTER) - 1e-9).all()


def test_small_lateness_does_not_add_up():
    random, clock = np.random.default_rng(2), Clockwork()
    clock.until(1.0)
    clock.come(1000)
    clock.until(20.0, lambda: JITTER * PERIOD * random.random())
    assert clock.ticks[-1] - clock.ticks[0] < (999 + JITTER) * PERIOD
    assert clock.ticking.late == 0


def test_a_tick_that_was_late_is_counted_and_not_made_up_for():
    clock = Clockwork()
    clock.until(1.0)
    clock.come(4)
    delays = iter([0.9 * PERIOD, 1.2 * PERIOD, 0.0, 0.0])
    clock.until(2.0, lambda: next(delays))
    gaps = [last - first for first, last in pairwise(clock.ticks)]
    np.testing.assert_allclose(gaps, [1.9 * PERIOD, 2.2 * PERIOD, PERIOD])
    assert clock.ticking.late == 1


def test_nothing_ticks_after_the_end():
    clock = Clockwork()
    clock.ticking.stop()
    clock.come(5)
    clock.ticking.look(10.0)
    assert clock.ticks == []


@pytest.mark.parametrize("part", [0.98, 1.0, 20.0])
def test_a_tick_that_takes_long_leaves_time_to_all_else_before_the_next(part):
    """Pauses and resets came behind the wrenches that a tick could not bear, and were never heard."""
    clock = Clockwork(part * PERIOD)
    clock.come(5)
    free = []
    while clock.work:
        clock.now = clock.ticking.due
        clock.ticking.look(clock.now)
        free.append(clock.ticking.due - clock.now)
    assert len(free) == 5
    assert min(free) >= 0.09 * clock.duration


def test_so_does_one_that_fails():
    """Its error ended the round, and the next tick was due in the next one: nothing else had a turn."""
    clock = Clockwork(2.0 * PERIOD)
    failing = Ticking(PERIOD, clock.fail, lambda: False, lambda: clock.now)
    failing.start(0.0)
    clock.now = PERIOD
    with pytest.raises(ValueError, match="singular"):
        failing.look(clock.now)
    assert failing.due - clock.now >= 0.09 * clock.duration


def test_ticks_that_leave_enough_time_come_every_period():
    clock = Clockwork(0.9 * PERIOD)
    clock.come(20)
    clock.until(1.0)
    np.testing.assert_allclose(np.diff(clock.ticks), PERIOD, rtol=1e-9)

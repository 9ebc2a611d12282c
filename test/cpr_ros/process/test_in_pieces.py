# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Work between ticks, on a clock of the test."""

import itertools
import math

import pytest

from cpr_ros.process.in_pieces import InPieces
from cpr_ros.process.ticking import Ticking

PERIOD, TICK = 0.005, 0.001


class Clockwork:
    """Whoever spins: ticks that take a while, and work in between."""

    def __init__(self, *durations):
        self.now, self.ticks, self.pieces = 0.0, [], []
        self.durations = itertools.cycle(durations or [TICK])
        self.ticking = Ticking(PERIOD, self._tick, lambda: False, lambda: self.now)
        self.in_pieces = InPieces(self.ticking, lambda: self.now)
        self.ticking.start(self.now)

    def _tick(self, now):
        self.ticks.append(now)
        self.now += next(self.durations)

    def work(self, name, *durations):
        """Pieces that take so long."""
        for number, duration in enumerate(durations):
            self.now += duration
            self.pieces.append((name, number))
            if number + 1 < len(durations):
                yield

    def begin(self, name, *durations):
        self.in_pieces.begin(name, self.work(name, *durations))

    def until(self, end):
        """Spin."""
        while self.now < end:
            self.ticking.look(self.now)
            self.in_pieces.look(self.now)
            self.now = max(self.now, min(self.in_pieces.due, self.ticking.due))

    def lateness(self):
        """The largest of ticks since this was asked for last [s]."""
        gaps = [later - earlier for earlier, later in itertools.pairwise(self.ticks)]
        self.ticks = self.ticks[-1:]
        return max(gaps) - PERIOD


def test_ticks_wait_for_no_work_once_it_is_known_how_long_its_pieces_take():
    clock = Clockwork()
    durations = 0.002, 0.0035, 0.001, 0.003
    clock.begin("metrics", *durations)
    clock.until(0.1)
    assert clock.lateness() < max(durations)  # the first time nobody knows
    for turn in range(1, 5):
        clock.begin("metrics", *durations)
        clock.until(0.1 + 0.1 * turn)
        assert clock.lateness() < 1e-9
    assert clock.pieces == 5 * [("metrics", number) for number in range(4)]


def test_a_piece_waits_for_a_tick_that_leaves_time_for_it():
    clock = Clockwork(0.003, 0.001)
    for turn in range(1, 6):
        clock.begin("metrics", 0.0035)
        clock.until(0.1 * turn + 0.005 * (turn % 2))
        late = clock.lateness()
        assert turn == 1 or late < 1e-9
    assert len(clock.pieces) == 5


def test_a_piece_that_took_long_lately_may_do_so_again():
    clock = Clockwork()
    for turn in range(6):
        clock.begin("metrics", 0.0015, 0.001 if turn % 2 else 0.0035)
        clock.until(0.1 * (turn + 1))
        late = clock.lateness()
        assert turn == 0 or late < 1e-9


def test_a_piece_that_never_fits_is_done_after_the_second_tick():
    clock = Clockwork()
    for turn in range(1, 4):
        clock.begin("long", *3 * [0.006])
        clock.until(0.1 * turn)
        assert len(clock.pieces) == 3 * turn
        assert clock.lateness() < 0.003  # of 0.006 all but what is left after the tick


def test_at_rest_one_piece_is_done_at_a_look():
    """What comes meanwhile is heard in between."""
    clock = Clockwork()
    clock.ticking.stop()
    clock.begin("metrics", *3 * [0.01])
    for count in range(1, 4):
        assert clock.in_pieces.due < clock.now
        clock.in_pieces.look(clock.now)
        assert len(clock.pieces) == count
    assert clock.in_pieces.due == math.inf
    clock.in_pieces.look(clock.now)
    assert len(clock.pieces) == 3


def test_what_takes_long_once_is_trusted_again_before_long():
    clock = Clockwork()
    clock.begin("metrics", 0.02)
    clock.until(0.1)
    clock.lateness()
    for turn in range(20):
        clock.begin("metrics", 0.001)
        clock.until(0.2 + 0.1 * turn)
    clock.begin("metrics", 0.001)
    clock.ticking.due = clock.now + 0.0045
    assert clock.in_pieces.due < clock.now


def test_kinds_are_done_in_order_and_one_of_a_kind_at_a_time():
    clock = Clockwork()
    clock.begin("metrics", 0.001, 0.001)
    clock.begin("markers", 0.001, 0.001)
    clock.begin("metrics", *9 * [0.001])
    clock.until(0.1)
    expected = [(name, number) for name in ("metrics", "markers") for number in range(2)]
    assert clock.pieces == expected
    clock.begin("metrics", 0.001)
    clock.until(0.2)
    assert clock.pieces[4:] == [("metrics", 0)]


def test_an_error_ends_its_own_work_only():
    clock = Clockwork()

    def failing():
        yield
        raise ValueError("singular")

    clock.ticking.stop()
    clock.in_pieces.begin("failing", failing())
    clock.begin("metrics", 0.001)
    clock.in_pieces.look(clock.now)
    with pytest.raises(ValueError, match="singular"):
        clock.in_pieces.look(clock.now)
    clock.in_pieces.look(clock.now)
    assert clock.pieces == [("metrics", 0)]
    clock.in_pieces.begin("failing", failing())  # the next one is begun
    assert clock.in_pieces.due < clock.now


def test_nothing_is_done_after_a_stop():
    clock = Clockwork()
    clock.begin("metrics", 0.001, 0.001)
    clock.in_pieces.look(clock.now)
    clock.in_pieces.stop()
    assert clock.in_pieces.due == math.inf
    clock.until(0.1)
    assert clock.pieces == [("metrics", 0)]

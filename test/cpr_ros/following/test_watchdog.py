# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

from cpr_ros.following.watchdog import Watchdog


def test_age_counts_from_the_newest_input():
    watchdog = Watchdog(0.5)
    assert watchdog.age(10.0) == -1.0
    assert not watchdog.stale(10.0)
    watchdog.feed(10.0)
    watchdog.feed(11.0)
    assert watchdog.age(11.25) == 0.25
    assert not watchdog.stale(11.5)
    assert watchdog.stale(11.51)


def test_what_came_after_the_tick_had_begun_is_new():
    """A negative age would say that nothing ever came."""
    watchdog = Watchdog(0.5)
    watchdog.feed(10.1)
    assert watchdog.age(10.0) == 0.0


def test_a_timeout_below_a_second_is_not_cut_off():
    watchdog = Watchdog(0.25)
    watchdog.feed(0.0)
    assert not watchdog.stale(0.2)
    assert watchdog.stale(0.3)


def test_a_timeout_of_zero_means_never():
    watchdog = Watchdog(0.0)
    watchdog.feed(0.0)
    assert not watchdog.stale(1e9)


def test_forgetting_is_as_if_nothing_had_come():
    watchdog = Watchdog(0.1)
    watchdog.feed(0.0)
    watchdog.forget()
    assert watchdog.age(5.0) == -1.0
    assert not watchdog.stale(5.0)

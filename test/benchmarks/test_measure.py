# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How cases are measured: turns, repeats, spread."""

import gc
import time

import pytest

from benchmarks.measure import Case, measure, summary_of


def test_cases_take_turns_and_slow_ones_are_repeated_less():
    calls = []
    cases = [
        Case("one", lambda: calls.append("one"), slow=True),
        Case("two", lambda: calls.append("two"), count=4),
    ]
    sampled = []
    found = measure(cases, 6, 2, sampled.append)
    assert sampled[:2] == ["one", "two"]  # warm-up
    rounds = [set(sampled[start : start + 2]) for start in (2, 4)]
    assert rounds == [{"one", "two"}] * 2
    assert sampled[6:] == ["two"] * 4
    assert {key: figure.samples for key, figure in found.items()} == {"one": 2, "two": 6}
    assert calls.count("one") >= 3
    assert calls.count("two") >= 7
    assert found["one"].clock == "processor"
    assert found["two"].median > 0.0


def test_figures_are_those_of_one_operation():
    def work():
        end = time.thread_time() + 1e-3
        while time.thread_time() < end:
            pass

    found = measure([Case("one", work), Case("many", work, count=4)], 5, 1)
    # Never less than it takes; what else there is to do takes far less.
    assert 1e-3 <= found["one"].smallest < 1.2e-3
    assert 0.25e-3 <= found["many"].smallest < 0.3e-3


def test_the_garbage_collector_rests_only_during_samples():
    states = []
    measure([Case("one", lambda: states.append(gc.isenabled()))], 2, 2)
    assert states and not any(states)
    assert gc.isenabled()


def test_a_case_that_fails_leaves_the_garbage_collector_on():
    with pytest.raises(ZeroDivisionError):
        measure([Case("one", lambda: 1 // 0)], 2, 2)
    assert gc.isenabled()


def test_keys_given_twice_are_refused():
    with pytest.raises(ValueError, match="same"):
        measure([Case("same", int), Case("same", int)], 1, 1)


def test_summaries_are_quartiles():
    found = summary_of([5.0, 1.0, 2.0, 4.0, 3.0], "MB")
    assert (found.smallest, found.first_quartile, found.median, found.third_quartile) == (
        1,
        2,
        3,
        4,
    )
    assert (found.samples, found.unit) == (5, "MB")

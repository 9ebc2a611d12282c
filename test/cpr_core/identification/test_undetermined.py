# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What measurements do not tell is found, and said with as few parameters as possible."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpr_core.identification.undetermined import (
    hidden_parameters,
    knowledge,
    parameter_sizes,
    unseen_directions,
    unseen_in_words,
)

NAMES = ("a", "b", "c", "d")
ALL = np.ones(4, np.bool_)


@given(st.integers(0, 2**32 - 1), st.integers(0, 3))
def test_directions_change_nothing_and_all_others_something(seed, hidden):
    generator = np.random.default_rng(seed)
    known = np.linalg.qr(generator.normal(size=(4, 4)))[0]
    rates = generator.normal(size=(9, 4 - hidden)) @ known[: 4 - hidden]
    found = unseen_directions(rates)
    assert found.shape == (hidden, 4)
    assert np.abs(rates @ found.T).max(initial=0.0) < 1e-10
    assert found @ found.T == pytest.approx(np.eye(hidden))


@given(st.integers(0, 2**32 - 1), st.integers(0, 4), st.floats(0.1, 10.0))
def test_what_is_told_has_the_covariance_of_least_squares(seed, apart, variance):
    """Of two parameters that are known as a sum only, of others or none, and of others."""
    generator = np.random.default_rng(seed)
    rates = generator.normal(size=(9, 4))
    if apart < 4:
        rates[:, apart] = rates[:, (apart + 1) % 4]
    known = knowledge(rates, np.ones(4))
    wanted = variance * np.linalg.pinv(rates.T @ rates, rcond=1e-10)
    together = [apart, (apart + 1) % 4] if apart < 4 else []
    wanted[together] = wanted[:, together] = 0.0
    wanted[together, together] = np.inf
    assert len(known.unseen) == (apart < 4)
    np.testing.assert_allclose(known.covariance(variance), wanted, rtol=1e-6, atol=1e-9)


def test_nothing_is_told_by_measurements_that_nothing_moves():
    known = knowledge(np.zeros((3, 2)), np.ones(2))
    np.testing.assert_array_equal(known.covariance(), np.diag([np.inf, np.inf]))


def test_rounding_alone_shows_nothing():
    rounding = 4e-9 * np.random.default_rng(0).normal(size=(9, 2))
    assert unseen_directions(rounding).shape == (2, 2)
    weak = np.diag([1e3, 0.01])
    assert unseen_directions(weak).shape == (0, 2)


def test_what_shows_only_changes_far_beyond_the_value_is_not_seen():
    rates = np.diag([5.0, 1e-4])
    assert np.abs(unseen_directions(rates)) == pytest.approx(np.array([[0.0, 1.0]]))
    # Uncertain by ten thousand natural units, which are half a percent of such a value.
    sizes = parameter_sizes(np.array([1.0, -2e6]), np.array([1.0, 1.0]))
    assert unseen_directions(rates, sizes).shape == (0, 2)


@pytest.mark.parametrize(
    ("part", "deviation", "hidden"),
    [(0.1, 1.0, True), (5e-4, 1e-4, True), (5e-4, 1e-2, False), (1e-7, 1e-9, False)],
)
def test_a_small_part_counts_where_the_parameter_is_known_better_than_that(part, deviation, hidden):
    row = np.array([[1.0, part]])
    found = hidden_parameters(row, np.ones(2), np.array([0.0, deviation]))
    assert found.tolist() == [True, hidden]
    words = unseen_in_words(row, found, np.ones(2), NAMES[:2], np.array([1.0, part]))
    told = "a and b are determined only as their ratio" if hidden else "a is not determined"
    assert words == (told,)


@pytest.mark.parametrize(
    ("rows", "values", "words"),
    [
        ([[0, 1, 0, 0]], [1, 2, 3, 4], ("b is not determined",)),
        ([[0, 1, 0, 1]], [1, 2, 3, 2], ("b and d are determined only as their ratio",)),
        ([[0, 4, 0, -2]], [1, 2, 3, 1], ("b and d are determined only as their product",)),
        ([[3, 0, 1, 0]], [0, 2, 0, 1], ("a by +1, c by +0.333",)),
        ([[1, 1, 1, 0]], [1, 1, 1, 1], ("a by +1, b by +1, c by +1",)),
    ],
)
def test_words(rows, values, words):
    rows = np.array(rows, float)
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    found = unseen_in_words(rows, ALL, np.ones(4), NAMES, np.array(values, float))
    assert len(found) == len(words)
    for line, text in zip(found, words, strict=True):
        assert line.endswith(text)


@pytest.mark.parametrize("entry", ["[0]", "[0,1]", "[*]"])
def test_places_are_no_ratio_whatever_entries_are_named(entry):
    row = np.array([[0.6, 0.8]])
    names = (f"legs[0].base.position{entry}", "rod.length")
    found = unseen_in_words(row, np.ones(2), np.ones(2), names, np.array([6.0, 8.0]))
    assert found[0].endswith(f"{names[0]} by +0.75, {names[1]} by +1")


def test_directions_are_taken_apart():
    mixed = np.linalg.qr(np.random.default_rng(0).normal(size=(2, 2)))[0]
    rows = mixed @ [[1, 0, 0, 0], [0, 0.6, 0.8, 0]]
    found = unseen_in_words(rows, ALL, np.ones(4), NAMES, np.array([1.0, 3.0, 4.0, 1.0]))
    assert set(found) == {
        "a is not determined",
        "b and c are determined only as their ratio",
    }


def test_natural_units_do_not_matter_for_words():
    row = np.array([[0.6, 0.8, 0.0, 0.0]])
    [line] = unseen_in_words(
        row, ALL, np.array([1e9, 1.0, 1.0, 1.0]), NAMES, np.array([6e9, 8, 1, 1])
    )
    assert line == "a and b are determined only as their ratio"

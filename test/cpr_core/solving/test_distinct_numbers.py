# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers that are compared in a sentence."""

import math

import pytest

from cpr_core.solving.distinct_numbers import distinct, rounded_seconds


@pytest.mark.parametrize(
    ("numbers", "texts"),
    [
        ((0.05, 0.1), ["0.05", "0.1"]),
        ((0.0499999, 0.05), ["0.0499999", "0.05"]),
        ((0.05, math.nextafter(0.05, 1.0)), ["0.05", "0.05000000000000001"]),
        ((2.8, 2.8), ["2.8", "2.8"]),
        ((2.8000001, -math.inf, 2.8), ["2.8000001", "-inf", "2.8"]),
        ((math.nan, 1.0), ["nan", "1"]),
        ((-785.398, -0.0), ["-785.4", "0"]),
    ],
)
def test_different_numbers_look_different(numbers, texts):
    assert distinct(*numbers) == texts


def test_more_digits_may_be_wanted_anyway():
    assert distinct(math.pi, 1.5, fewest=6) == ["3.14159", "1.5"]


@pytest.mark.parametrize(
    ("time", "text"),
    [(-6.9e-18, "0"), (-0.0, "0"), (-1.5, "-1.5"), (2.1e-9, "2e-09"), (0.1, "0.1")],
)
def test_times_are_zero_where_only_rounding_says_otherwise(time, text):
    assert rounded_seconds(time) == text

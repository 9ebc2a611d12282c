# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers that are compared in a sentence."""

import math

import pytest

from cpr_ros.distinct_numbers import distinct


@pytest.mark.parametrize(
    ("numbers", "texts"),
    [
        ((0.05, 0.1), ["0.05", "0.1"]),
        ((0.0499999, 0.05), ["0.0499999", "0.05"]),
        ((0.05, math.nextafter(0.05, 1.0)), ["0.05", "0.05000000000000001"]),
        ((2.8, 2.8), ["2.8", "2.8"]),
        ((2.8000001, -math.inf, 2.8), ["2.8000001", "-inf", "2.8"]),
        ((math.nan, 1.0), ["nan", "1"]),
    ],
)
def test_different_numbers_look_different(numbers, texts):
    assert distinct(*numbers) == texts

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Texts of the command line as numbers."""

import argparse
import math

import pytest

from cpr_core.command_line.argument_types import count, length, not_negative, number


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("pi", math.pi),
        ("+pi", math.pi),
        ("-pi", -math.pi),
        ("2pi", 2.0 * math.pi),
        ("-2*pi/3", -2.0 * math.pi / 3.0),
        (".5pi", 0.5 * math.pi),
        ("pi/1.5", math.pi / 1.5),
        ("-1e-3", -1e-3),
    ],
)
def test_multiples_of_pi_are_numbers(text, value):
    assert number(text) == pytest.approx(value)


@pytest.mark.parametrize(
    ("read", "least", "refused"),
    [
        (not_negative, "0", ("-1e-9", "nan", "inf")),
        (length, "1e-300", ("0", "-1", "nan", "inf")),
        (count, "0", ("-1", "0.5", "9" * 41, "9" * 5000)),
    ],
)
def test_numbers_have_their_limits(read, least, refused):
    assert read(least) == float(least)
    for text in refused:
        with pytest.raises(argparse.ArgumentTypeError, match="expected a"):
            read(text)

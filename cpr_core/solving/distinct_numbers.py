# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers in sentences that compare them."""

from __future__ import annotations

__all__ = ["distinct", "rounded_seconds"]

#: Digits that are enough for a person, and those that tell any two numbers apart.
_FEWEST, _ALL = 4, 17


def distinct(*numbers: float, fewest: int = _FEWEST) -> list[str]:
    """Numbers with few digits, or as many as it takes that different ones look different.

    Args:
        numbers: The numbers; zero has no sign.
        fewest: Digits that are enough where they tell them apart.
    """
    for digits in range(fewest, _ALL + 1):
        texts = [f"{number + 0.0:.{digits}g}" for number in numbers]
        if len(set(texts)) == len(set(numbers)):
            break
    return texts


def rounded_seconds(time: float) -> str:
    """A time to a nanosecond, as messages have it: sums of times are often not quite 0."""
    return f"{round(time, 9) + 0.0:g}"

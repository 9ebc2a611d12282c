# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers in sentences that compare them."""

from __future__ import annotations

__all__ = ["distinct"]

#: Digits that are enough for a person, and those that tell any two numbers apart.
_FEWEST, _ALL = 4, 17


def distinct(*numbers: float) -> list[str]:
    """Numbers with few digits, or as many as it takes that different ones look different."""
    for digits in range(_FEWEST, _ALL + 1):
        texts = [f"{number:.{digits}g}" for number in numbers]
        if len(set(texts)) == len(set(numbers)):
            break
    return texts

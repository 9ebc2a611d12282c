# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers that somebody types into a field."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidRequest
from ..validation import checked_vector

__all__ = ["numbers_as_text", "typed_numbers"]

Floats = NDArray[np.float64]

#: A point between thousands, and a decimal comma: 1.234,5.
_THOUSANDS = re.compile(r"(?<![\d.])\d{1,3}(\.\d{3})+,\d+(?![\d.])")


def typed_numbers(name: str, text: str, meaning: tuple[str, ...]) -> Floats:
    """Numbers between spaces, commas or semicolons, in brackets or not.

    Of whole numbers a comma between digits may be a decimal one, unless all of three or more, or those
    in brackets, are separated so.

    Args:
        name: What they are, for the error.
        text: What was typed.
        meaning: What each of them is.

    Raises:
        InvalidRequest: Not so many numbers, or commas that may be decimal ones.
        NonFiniteInput: A NaN or an infinity.
    """
    words = [word for word in re.split(r"[\s,;\[\]()]+", text) if word]
    expected = " ".join(meaning)
    decimal = bool(re.search(r"\d,\d", text)) and not re.search(r"[\[(]", text)
    if "." in text:
        decimal = decimal and ";" in text
    elif len(meaning) > 2:
        decimal = decimal and not re.fullmatch(r"\s*[-+\d]+(,[-+\d]+)*\s*", text)
    if decimal or _THOUSANDS.search(text):
        raise InvalidRequest(
            name,
            f"expected decimal points, and spaces between numbers ({expected}), got {text[:80]!r}",
        )
    try:
        values = [_number(word) for word in words]
    except ValueError:
        raise InvalidRequest(
            name, f"expected {len(meaning)} numbers ({expected}), got {text[:80]!r}"
        ) from None
    return checked_vector(name, np.array(values), len(meaning), expected)


def _number(word: str) -> float:
    """A number as people write it: Python reads ``2_7`` as 27 too, and digits of other scripts.

    Raises:
        ValueError: It is none.
    """
    if not word.isascii() or "_" in word:
        raise ValueError(word)
    return float(word)


def numbers_as_text(values: Floats) -> str:
    """The same numbers as text, short; typed again they are these to ten digits."""
    return " ".join(f"{value + 0.0:.10g}" for value in values.tolist())

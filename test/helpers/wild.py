# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Random values that nobody expects: numbers of any size, words of any letters.

Hypothesis draws such values too, but takes several milliseconds for a message to remember how it was
drawn; where ten thousand are drawn and none is made smaller that is most of the time.
"""

from __future__ import annotations

import math
import struct
import sys
from random import Random

#: Where numbers end, begin and are easily mistaken.
EDGES = (
    *(0.0, 0.5, 1.0, 1.0 + 1e-15, 1.0 / 3.0, 1e6, 1e16, 1e300),
    *(sys.float_info.max, sys.float_info.min, sys.float_info.epsilon, 5e-324),
    *(math.inf, math.nan),
)
NO_NUMBERS = (math.nan, math.inf, -math.inf)


def any_number(chance: Random) -> float:
    """Any number there is, NaN and infinity among them."""
    kind = chance.randrange(3)
    if kind == 0:
        return chance.choice((-1.0, 1.0)) * chance.choice(EDGES)
    if kind == 1:
        return chance.uniform(-10.0, 10.0)
    return struct.unpack("d", chance.randbytes(8))[0]


def any_numbers(chance: Random, most: int) -> list[float]:
    """So many of them at most."""
    return [any_number(chance) for _ in range(chance.randint(0, most))]


def word(chance: Random, longest: int = 12, *, empty: bool = True) -> str:
    """Letters of any language, or none at all; ROS ends a string at a zero, so none is in it."""
    return "".join(_letter(chance) for _ in range(chance.randint(0 if empty else 1, longest)))


def _letter(chance: Random) -> str:
    """A surrogate is half a letter: it cannot be sent."""
    last = chance.choice((0x7F, 0xFF, 0xFFFF, sys.maxunicode))
    number = chance.randint(1, last)
    return chr(number) if not 0xD800 <= number <= 0xDFFF else "\ufffd"

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a sequence of answers leads: in the length of elements, and in the stiffness against stretch."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

__all__ = ["limit_of_powers", "richardson"]

Floats = NDArray[np.float64]


def richardson(values: Sequence[Floats], order: int, step: int = 2) -> tuple[Floats, Floats]:
    """The limit of answers with the length of the elements, or a compliance, halved every time.

    Args:
        values: The answers, coarse to fine, two or more of them, of one shape.
        order: Power of what is halved in the greatest part of the error.
        step: By how much the power of the next part is greater.

    Raises:
        ValueError: Fewer than two answers.

    Returns:
        The limit, and how much the last halving changed it.
    """
    row = [np.asarray(value, np.float64) for value in values]
    if len(row) < 2:
        raise ValueError(f"expected two answers or more, got {len(row)}")
    before = row[-1]
    for level in range(1, len(values)):
        factor = 2.0 ** (order + (level - 1) * step)
        before = row[-1]
        row = [fine + (fine - coarse) / (factor - 1.0) for coarse, fine in pairwise(row)]
    return row[-1], row[-1] - before


def limit_of_powers(
    values: Sequence[Floats], sizes: Sequence[float], powers: Sequence[int]
) -> Floats:
    """The limit of answers whose error has given powers of the length of the elements, of any lengths.

    Args:
        values: The answers, of one shape.
        sizes: Lengths of their elements [m].
        powers: One fewer than answers.

    Raises:
        ValueError: Not as many answers and lengths as unknowns.

    Returns:
        The answer at length zero.
    """
    if not len(values) == len(sizes) == len(powers) + 1:
        raise ValueError(f"expected {len(powers) + 1} answers, got {len(values)}")
    relative = np.asarray(sizes, np.float64) / max(sizes)
    terms = relative[:, None] ** np.array([0, *powers])
    limit: Floats = np.linalg.solve(terms, np.asarray(values, np.float64))[0]
    return limit

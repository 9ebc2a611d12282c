# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rows that are there twice: they tell nothing new, and count as if they did."""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import first_and_others
from .compared import ComparedRow
from .measurements import Measurement

__all__ = ["repeated_doubts"]

#: So many numbers that are compared are not the same twice by chance, even rounded as instruments do it.
_FEWEST = 3


def repeated_doubts(rows: Sequence[ComparedRow]) -> tuple[str, ...]:
    """Which rows are another one to the last digit, in a line; none where noise tells all apart."""
    firsts: dict[tuple[object, ...], Measurement] = {}
    repeated: list[tuple[Measurement, Measurement]] = []
    for row in rows:
        if len(row.places) >= _FEWEST:
            first = firsts.setdefault(_content(row.measurement), row.measurement)
            if first is not row.measurement:
                repeated.append((first, row.measurement))
    if not repeated:
        return ()
    labels = first_and_others([row.label for _, row in repeated])
    return (
        f"{labels}: the same to the last digit as {repeated[0][0].label}: noise would tell what is "
        "measured twice apart; a row that is there twice counts twice, and intervals are too narrow",
    )


def _content(row: Measurement) -> tuple[object, ...]:
    """All that was measured and what acted, to compare."""
    arrays = (row.motors, row.position, row.quaternion_wxyz, row.efforts)
    numbers = tuple(None if values is None else values.tobytes() for values in arrays)
    acting = None if row.loads is None else tuple(row.loads.parts.items())
    return (*numbers, acting, row.frame)

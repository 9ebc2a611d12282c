# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Borders of a map: points where something changes, and in two dimensions the lines through them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..validation import ReadOnlyArrays

__all__ = ["Border", "BorderKind"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: What changes at a border:
#:
#: - ``stability``: the stability index with the motors held; ``stability_free``: at constant effort;
#: - ``singularity``: the branch ends (inverse singularity; of motors: it folds, or its index changes);
#: - ``limits``: a limit of a motor or a rod.
BorderKind = Literal["stability", "stability_free", "singularity", "limits"]


@dataclass(frozen=True, eq=False)
class Border(ReadOnlyArrays):
    """All points of one kind where lines between neighbouring cells cross a border.

    Attributes:
        kind: What changes.
        points: Where, in numbers along the axes, (P, D).
        cells: The neighbours on both sides, (P, 2): the second may be a cell that was not reached.
        before: Index, or number of limits that do not hold, or 1, on the side of the first cell, (P,).
        after: The same on the other side of the point, (P,); -1 where the branch ends.
        segments: Pairs of points, (S, 2), that a line of the border joins; in two dimensions only.
    """

    kind: BorderKind
    points: Floats
    cells: Integers
    before: Integers
    after: Integers
    segments: Integers

    def polylines(self) -> tuple[Floats, ...]:
        """The segments joined to lines, each (Q, 2); closed ones end where they begin."""
        beside: dict[int, list[int]] = {}
        for first, second in self.segments.tolist():
            beside.setdefault(first, []).append(second)
            beside.setdefault(second, []).append(first)
        lines = []
        for ends_first in (True, False):  # open lines from their ends, then what is closed
            for begin in sorted(beside):
                while beside[begin] and (not ends_first or len(beside[begin]) != 2):
                    line = [begin]
                    while beside[line[-1]]:
                        ahead = beside[line[-1]].pop(0)
                        beside[ahead].remove(line[-1])
                        line.append(ahead)
                        if len(beside[ahead]) != 1:
                            break
                    lines.append(self.points[line])
        return tuple(lines)

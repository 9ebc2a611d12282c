# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The rods of a robot that motors feed, and how long they are: looked at in every request."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..validation import read_only
from .state_numbers import RodNumbers

__all__ = ["FedRods", "fed_rods"]

Floats = NDArray[np.float64]

#: Part of the length of a description below which a fed rod is as good as not there.
_NO_LENGTH = 1e-4


class FedRods(NamedTuple):
    """Rods that motors feed, F of them.

    Attributes:
        rods: Which ones.
        motors: Numbers of their motors, (F,).
        zeros: Their lengths with these at zero, (F,) [m].
        ratios: How fast they grow with these, (F,) [m/rad or 1].
    """

    rods: tuple[RodNumbers, ...]
    motors: NDArray[np.int64]
    zeros: Floats
    ratios: Floats

    def lengths(self, motors: Floats) -> Floats:
        """Their lengths, (..., F) [m], at motor positions (..., n)."""
        found: Floats = self.zeros + self.ratios * motors[..., self.motors]
        return found

    def exist(self, motors: Floats) -> bool:
        """Whether all of them have a length at motor positions, (n,)."""
        return not self.rods or bool((self.lengths(motors) > 0.0).all())

    def drawn_in(self, motors: Floats) -> str:
        """That a motor at its position, out of (n,), has drawn in its whole rod; empty: none has."""
        lengths = self.lengths(motors).tolist() if self.rods else ()
        for rod, length in zip(self.rods, lengths, strict=True):
            if length < _NO_LENGTH * rod.element.rod.length:
                return f"{rod.element.motor} has drawn in its rod: no length is left"
        return ""


def fed_rods(rods: Iterable[RodNumbers], first_motor: int) -> FedRods:
    """Those among the rods of a robot that are fed; its motors begin at that state index."""
    fed = tuple(rod for rod in rods if rod.length_index is not None)
    motors = np.array([rod.length_index for rod in fed], np.int64) - first_motor
    feeds = [(rod.element.zero, rod.element.ratio) for rod in fed]
    zeros, ratios = np.array(feeds).reshape(-1, 2).T
    return FedRods(fed, read_only(motors), read_only(zeros), read_only(ratios))

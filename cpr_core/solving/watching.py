# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is looked at along a way: limits, and what must not change its sign unseen within a step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model.equilibrium import Equilibrium, firm_margin
from ..model.smallest_singular_value import smallest_singular_value
from ..validation import kept_with_value
from .hidden_changes import Watched

__all__ = ["Watching"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Watching:
    """What is watched along a way of a robot.

    Attributes:
        limits: Whether limits may be passed and kept again.
        stability: Whether the margin of stability is, beside the stability index.
        singularity: Whether the distance from an inverse singularity is. Symmetric robots pass these
            with two singular values at once: the determinant keeps its sign, and Newton's method may not
            see it.
    """

    limits: bool
    stability: bool
    singularity: bool

    def at(self, equilibrium: Equilibrium, limits: Floats, inverse_sign: int) -> Watched:
        """What must not change its sign unseen.

        Args:
            equilibrium: Where.
            limits: ``margins`` there, (K,).
            inverse_sign: Sign of the determinant of the inverse problem there; read where it is watched.
        """
        values, distance = list[float](), list[float]()
        if self.limits:
            values += limits.tolist()
        if self.stability:
            values.append(firm_margin(equilibrium))
        if self.singularity:
            distance.append(inverse_sign * _inverse_nearness(equilibrium))
        return Watched(tuple(values), tuple(distance))


@kept_with_value
def _inverse_nearness(equilibrium: Equilibrium) -> float:
    """Distance from an inverse singularity: the end of a step is the start of the next."""
    return smallest_singular_value(equilibrium, True, None)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Anderson's mixing: what the last steps of an iteration have changed says where it leads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["MixedSteps"]

Floats = NDArray[np.float64]

#: Changes below this times the largest are those of rounding.
_ROUNDING = 1e-6


class MixedSteps:
    """Steps towards where an iteration has none to make.

    By themselves they go around it where the iteration turns too far; mixed with those before they
    converge as secants do. See Walker and Ni, Anderson acceleration for fixed-point iterations, SIAM J.
    Numer. Anal. 49 (2011), doi 10.1137/10078356X.
    """

    def __init__(self, memory: int) -> None:
        """Know of no steps yet; as many are kept as there are directions in which they may go around."""
        self._memory, self._before = memory, list[tuple[Floats, Floats, Floats]]()

    def mixed(self, place: Floats, step: Floats, taken: Floats) -> Floats:
        """The step from a place, (n,).

        Args:
            place: Where the iteration is.
            step: Its own step.
            taken: What of it would be taken without those before.
        """
        steps, ways = [], []
        for earlier, own, part in self._before:
            steps.append(step - own)
            ways.append(place - earlier + taken - part)
        self._before = [*self._before, (place, step, taken)][-self._memory :]
        if not steps:
            return taken
        weights = np.linalg.lstsq(np.array(steps).T, step, rcond=_ROUNDING)[0]
        return np.asarray(taken - np.array(ways).T @ weights)

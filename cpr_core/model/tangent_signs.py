# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Stability indices of an equilibrium from one symmetric elimination (Sylvester's law)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.record_layout import INDEX_FREE, INDEX_LOCKED, INVERSE_SIGN

__all__ = ["TangentSigns", "tangent_signs_of"]


class TangentSigns(NamedTuple):
    """Signs of the tangent at an equilibrium. Two neighbours of a branch differ where one vanishes.

    Attributes:
        index_locked: Negative eigenvalues of H_r with the motors held.
        index_free: With the motors at constant effort.
        inverse_sign: Sign of the determinant of the inverse problem; 0 where there is none.
    """

    index_locked: int
    index_free: int
    inverse_sign: int


def tangent_signs_of(signs: NDArray[np.float64]) -> TangentSigns:
    """The signs as a record keeps them, (3,)."""
    values = signs.astype(int).tolist()
    return TangentSigns(values[INDEX_LOCKED], values[INDEX_FREE], values[INVERSE_SIGN])

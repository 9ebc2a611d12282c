# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Stability indices of an equilibrium from one symmetric elimination (Sylvester's law)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from .record_layout import INDEX_FREE, INDEX_LOCKED, INVERSE_SIGN, SIGNS

if TYPE_CHECKING:
    from .equilibrium import Equilibrium

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


def tangent_signs_of(equilibrium: Equilibrium) -> TangentSigns:
    """The signs the kernels found."""
    first = equilibrium.robot.state_size + SIGNS
    values = equilibrium.record[first : first + 3].astype(int).tolist()
    return TangentSigns(values[INDEX_LOCKED], values[INDEX_FREE], values[INVERSE_SIGN])

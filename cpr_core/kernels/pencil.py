# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Memory of the kernels that find smallest eigenvalues, and what they know of a robot beforehand."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .kernel_arrays import RobotArrays
from .lanes import empty_lanes, zeros_lanes
from .pencil_layout import PencilLayout, pencil_layout

__all__ = ["Pencil", "pencil_of"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Lanes = NDArray[np.void]

#: Steps of Lanczos' method before it begins again.
_STEPS = 24


class Pencil(NamedTuple):
    """K and M of ``pencil_kernel`` for G groups of legs, their factors, and vectors.

    A leg has r rows and c columns, b of them of the platform. Delayed may be all C multipliers at most,
    up to E of a leg. All numbers are dimensionless.
    """

    layout: PencilLayout
    gram: Lanes  # (G, S, S) int Phi^T Phi dsigma by slots: M of unit motions
    weights: Lanes  # (G, r) M of unit motions on other slots: 1 where something moves
    springs: Lanes  # (G, r) stiffness of springs on other slots
    start: Lanes  # (G, r) where iterations begin
    elastic: Lanes  # (G, S, S) elastic stiffness
    blocks: Lanes  # (G, r, c) upper triangles of K
    corner: Floats  # (b, b) platform part of K
    condensed: Floats  # (b + C + n_a, b + C + n_a) H of platform, delayed slots and motors
    upper: Lanes  # (G, r, c) rows of L^T, and of D^-1 L^-1 B
    inverse: Lanes  # (G, r) D^-1
    rows: Lanes  # (r, c) rows of D L^T, or by the columns of `slots`
    left: Floats  # (b, b) pivot rows of what is left of the platform
    delayed_count: Integers  # (1,) D, see `delayed_pencil_kernel`
    rounds: Integers  # (G,) most of them of one leg
    places: Integers  # (G, E, lanes) their numbers, round by round; -1: none
    beside: Lanes  # (G, E, r) their couplings to the rows of their legs
    beside_platform: Lanes  # (G, E, b)
    beyond: Lanes  # (G, E, r) rows of D L^T
    found: Lanes  # (G, E) their part of a solution
    whole: Floats  # (b + C, b + C) what is left of platform and delayed slots
    factored: Floats  # (b + C, b + C) its LU factors
    part: Floats  # (b + C,)
    vector: Lanes  # (G, r)
    border: Floats  # (b,)
    loaded: Lanes  # (G, r) M times the vector
    border_loaded: Floats  # (b,)
    basis: Lanes  # (T, G, r) of Lanczos' method
    border_basis: Floats  # (T, b)
    along_diagonal: Floats  # (T,) of its tridiagonal matrix
    beside_diagonal: Floats  # (T,)
    ritz_vector: Floats  # (T,)
    ritz_pivots: Floats  # (T,)
    stiffness: Floats  # (b + C, b + C) LU factors of platform and delayed slots
    compliance: Floats  # (b + C, b + C) its inverse, transposed
    turn: Floats  # (b, b) world twists of body twists
    turned_compliance: Floats  # (b, b + C) the turn of the compliance
    by_leg: Lanes  # (1,) written by lanes and read leg by leg
    pivots: Integers  # (b + C,)


def pencil_of(arrays: RobotArrays, grams: Floats) -> Pencil:
    """Memory for one thread; long, for every field has its line.

    Args:
        arrays: The robot.
        grams: ``int Phi^T Phi dsigma`` by strain coordinates, in the order of the state, (N, N).
    """
    slots, groups, width = arrays.slots, len(arrays.groups), arrays.slot_index.shape[2]
    strains, platform = slots.strain_count, slots.platform_count
    layout = pencil_layout(slots, arrays.constraint_count)
    rows, columns = layout.row_count, layout.column_count
    border, constraints = len(arrays.border_indices), arrays.constraint_count
    most = slots.first_passive - slots.first_multiplier

    def empty(*shape: int) -> Any:
        return empty_lanes(width, *shape)

    return Pencil(
        layout=layout,
        gram=_grams_of_slots(arrays, grams),
        weights=_weights_of_slots(arrays, rows),
        springs=_springs_of_slots(arrays, rows),
        start=_start_of_search(width, groups, rows),
        elastic=empty(groups, strains, strains),
        blocks=zeros_lanes(width, groups, rows, columns),
        corner=np.empty((platform, platform)),
        condensed=np.empty((border + constraints, border + constraints)),
        upper=zeros_lanes(width, groups, rows, columns),
        inverse=zeros_lanes(width, groups, rows),
        rows=zeros_lanes(width, rows, max(columns, slots.total)),
        left=np.empty((platform, platform)),
        delayed_count=np.zeros(1, np.int64),
        rounds=np.zeros(groups, np.int64),
        places=np.full((groups, most, width), -1, np.int64),
        beside=zeros_lanes(width, groups, most, rows),
        beside_platform=zeros_lanes(width, groups, most, platform),
        beyond=zeros_lanes(width, groups, most, rows),
        found=zeros_lanes(width, groups, most),
        whole=np.empty((platform + constraints, platform + constraints)),
        factored=np.empty((platform + constraints, platform + constraints)),
        part=np.empty(platform + constraints),
        vector=zeros_lanes(width, groups, rows),
        border=np.empty(platform),
        loaded=zeros_lanes(width, groups, rows),
        border_loaded=np.empty(platform),
        basis=empty(_STEPS, groups, rows),
        border_basis=np.empty((_STEPS, platform)),
        along_diagonal=np.empty(_STEPS),
        beside_diagonal=np.empty(_STEPS),
        ritz_vector=np.empty(_STEPS),
        ritz_pivots=np.empty(_STEPS),
        stiffness=np.empty((platform + constraints, platform + constraints)),
        compliance=np.empty((platform + constraints, platform + constraints)),
        turn=np.empty((platform, platform)),
        turned_compliance=np.empty((platform, platform + constraints)),
        by_leg=zeros_lanes(width, 1),
        pivots=np.empty(platform + constraints, np.int64),
    )


def _grams_of_slots(arrays: RobotArrays, grams: Floats) -> Any:
    """``int Phi^T Phi dsigma`` by slots of the legs, (groups, strains, strains) of lanes."""
    width, strains = arrays.slot_index.shape[2], arrays.slots.strain_count
    found = zeros_lanes(width, len(arrays.groups), strains, strains)
    for group, lane in np.argwhere(arrays.lane_leg >= 0):
        modes = np.flatnonzero(arrays.slot_index[group, :strains, lane] >= 0)
        own = arrays.slot_index[group, modes, lane]
        found["lane"][group, modes[:, None], modes, lane] = grams[np.ix_(own, own)]
    return found


def _weights_of_slots(arrays: RobotArrays, rows: int) -> Any:
    """One for every passive slot that there is, and where there are motors, (groups, rows) of lanes."""
    slots = arrays.slots
    found = zeros_lanes(arrays.slot_index.shape[2], len(arrays.groups), rows)
    passive = slice(slots.first_passive, slots.inner_count)
    found["lane"][:, passive] = arrays.slot_index[:, passive] >= 0
    found["lane"][:, slots.inner_count] = (arrays.motor_slot_index >= 0).any(axis=1)
    return found


def _springs_of_slots(arrays: RobotArrays, rows: int) -> Any:
    """Stiffness of passive joints, dimensionless, (groups, rows) of lanes."""
    found = zeros_lanes(arrays.slot_index.shape[2], len(arrays.groups), rows)
    for group, position in np.argwhere(arrays.elements["slot"] >= 0):
        element = arrays.elements[group, position]
        slot = element["slot"]
        if slot < arrays.slots.inner_count:  # not a motor's
            unit = arrays.units["lane"][group, slot]
            found["lane"][group, slot] = element["stiffness"] * unit**2 / arrays.energy_unit
    return found


def _start_of_search(width: int, groups: int, rows: int) -> Any:
    """Where searches for eigenvalues begin: no eigenvector is at right angles to it by symmetry."""
    found = empty_lanes(width, groups, rows)
    legs = width * np.arange(groups)[:, None, None] + np.arange(width)
    found["lane"][:] = 1.0 + 0.5 * np.sin(1.3 * np.arange(rows)[:, None] + 2.1 * legs)
    return found

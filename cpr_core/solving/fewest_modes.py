# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Giving up strain modes one by one, the one that moves the platform least first.

The derivation is in docs/derivations.md, "Modes that are chosen".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..blas_threads import on_one_blas_thread
from ..description.robot_description import ModeCounts
from ..kernels.twist_layout import FIRST_LINEAR
from ..model.equilibrium import Equilibrium
from ..validation import cached_property

__all__ = ["fewest_modes"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Modes of torsion are given up only where that changes nothing, so much, of how far any wrench moves
#: the platform: what no motor twists shows nothing of it before there are loads. The last one of a rod
#: also of the budget, as the estimated error does not see a direction without modes.
_NOTHING = 1e-3
#: Compliance of a coordinate, dimensionless, that others hold where it is: rounding.
_HELD = 1e-14
#: Compliance of a platform, of the largest there is, that is rounding: straight legs hold it rigidly.
_RIGID = 1e-12


@on_one_blas_thread
def fewest_modes(
    exact: Sequence[Equilibrium], budget: float, bending: Sequence[int]
) -> list[ModeCounts]:
    """The numbers of modes per rod with which no platform moves farther than a budget, to first order.

    Args:
        exact: Equilibria of one robot that has more modes than it needs.
        budget: How far platforms may move [m].
        bending: Fewest modes of every rod in every direction in which it bends, (rods,); one or more.
    """
    rods = list(exact[0].robot.numbers.rods)
    left = [list(rod.element.modes.counts) for rod in rods]
    first = [rod.strain.start + np.cumsum([0, *rod.element.modes.counts[:2]]) for rod in rods]
    truncated = _Truncated.none(exact)
    while True:
        candidates = sorted(
            (_farthest(truncated.moved_without(first[rod][direction] + count - 1)), rod, direction)
            for rod, counts in enumerate(left)
            for direction, count in enumerate(counts)
            if count > (bending[rod] if direction else int(rods[rod].element.uncoils[direction]))
        )
        for farthest, rod, direction in candidates:
            last = first[rod][direction] + left[rod][direction] - 1
            most = _NOTHING * budget if left[rod][direction] == 1 else np.inf
            if farthest <= budget and (direction > 0 or truncated.is_idle(last, most)):
                left[rod][direction] -= 1
                truncated = truncated.without(last)
                break
        else:
            return [(torsion, bending_2, bending_3) for torsion, bending_2, bending_3 in left]


def _farthest(moved: Floats) -> float:
    return float(np.linalg.norm(moved, axis=1).max())


@dataclass(frozen=True, eq=False)
class _Truncated:
    """Equilibria after some strain coordinates have been given up, held as at rest; dimensionless.

    Attributes:
        compliance: How the state answers to generalised forces, motors held, (P, N, N).
        state: The state, less that at rest, (P, N).
        moved: How far the platforms have moved, (P, axes) [m].
        axes: State indices of the platform's translations.
        length: Their unit [m].
        platform: State indices of the platform.
    """

    compliance: Floats
    state: Floats
    moved: Floats
    axes: Integers
    length: float
    platform: Integers

    @classmethod
    def none(cls, exact: Sequence[Equilibrium]) -> _Truncated:
        """Nothing given up yet."""
        robot = exact[0].robot
        axes = robot.platform_indices[robot.platform_axes >= FIRST_LINEAR]
        return cls(
            np.array([_compliance(at) for at in exact]),
            np.array([(at.state - robot.rest_state) / robot.kernel_arrays.unit for at in exact]),
            np.zeros((len(exact), len(axes))),
            axes,
            robot.mean_length,
            robot.platform_indices,
        )

    def moved_without(self, index: int) -> Floats:
        """How far the platforms will have moved without one more coordinate, (P, axes) [m]."""
        lever = self.length * self.compliance[:, self.axes, index]
        return self.moved - lever * self._force(index)[:, None]

    def is_idle(self, index: int, most: float) -> bool:
        """Whether giving up a coordinate makes no platform stiffer, nor moves one as far as that [m]."""
        idle = self.stiffer_without(index) < _NOTHING
        return idle and _farthest(self.moved_without(index) - self.moved) < most

    def stiffer_without(self, index: int) -> float:
        """Largest part of its compliance that the platform loses in any direction without a coordinate.

        1 where a motion is wholly lost, as a turn of the platform about rods that cannot twist.
        """
        own = np.maximum(self.compliance[:, index, index], _HELD)
        column = self.compliance[:, self.platform, index]
        parts = np.einsum("pi,pij,pj->p", column, self._platform_stiffness, column)
        return float(np.abs(parts / own).max())

    @cached_property
    def _platform_stiffness(self) -> Floats:
        """Of the platforms, dimensionless, (P, platform, platform)."""
        platform = self.compliance[:, self.platform[:, None], self.platform]
        rounding = _RIGID * self.compliance.max(axis=(1, 2))
        found: Floats = np.linalg.inv(
            platform + rounding[:, None, None] * np.eye(len(self.platform))
        )
        return found

    def without(self, index: int) -> _Truncated:
        """One more coordinate held as at rest."""
        column, row = self.compliance[:, :, index, None], self.compliance[:, None, index, :]
        own, force = self.compliance[:, index, index], self._force(index)
        compliance = self.compliance - column * (row / np.maximum(own, _HELD)[:, None, None])
        state = self.state - column[:, :, 0] * force[:, None]
        return replace(self, compliance=compliance, state=state, moved=self.moved_without(index))

    def _force(self, index: int) -> Floats:
        """What brings a coordinate to rest, (P,); immense where others hold it elsewhere."""
        return self.state[:, index] / np.maximum(self.compliance[:, index, index], _HELD)


def _compliance(equilibrium: Equilibrium) -> Floats:
    """Inverse of the tangent with the motors held, dimensionless, zero for the motors, (N, N)."""
    tangent, arrays = equilibrium.tangent, equilibrium.robot.kernel_arrays
    free = np.s_[: arrays.motor_index]
    found = np.zeros_like(tangent)
    found[free, free] = np.linalg.inv((tangent * arrays.unit * arrays.unit[:, None])[free, free])
    return found

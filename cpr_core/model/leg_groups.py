# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Legs of equal structure, which the kernels go through side by side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..description.chain_element import ChainElement
from ..description.leg_description import LegDescription
from ..kernels.kernel_arrays import Element
from ..kernels.lanes import WIDTH
from ..kernels.slots import COMPONENTS

__all__ = ["LegGroup", "leg_groups"]

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class LegGroup:
    """Up to W legs whose chains are the same kinds of elements.

    Attributes:
        numbers: The legs.
        kinds: Kind of every element.
        moved: Whether a motor moves it.
        passive_count: Passive joints.
        component_start: For every rod the first strain slot of torsion and both bendings, and the last.
        function: Which shape function every strain slot uses.
    """

    numbers: tuple[int, ...]
    kinds: tuple[Element, ...]
    moved: tuple[bool, ...]
    passive_count: int
    component_start: tuple[Integers, ...]
    function: tuple[int, ...]

    @property
    def strain_count(self) -> int:
        """Strain slots."""
        return int(self.component_start[-1][COMPONENTS]) if self.component_start else 0

    @property
    def function_count(self) -> int:
        """Shape functions."""
        return max(self.function, default=0) + 1

    @property
    def motor_count(self) -> int:
        """Joints and rods moved by motors."""
        return sum(self.moved)


def leg_groups(legs: tuple[LegDescription, ...]) -> list[LegGroup]:
    """Groups in the order of their first legs."""
    alike: dict[tuple[tuple[Element, bool], ...], list[int]] = {}
    for number, leg in enumerate(legs):
        alike.setdefault(tuple(map(_structure, leg.chain)), []).append(number)
    groups = []
    for structure, numbers in alike.items():
        kinds = tuple(kind for kind, _ in structure)
        moved = tuple(is_moved for _, is_moved in structure)
        passive = sum(element.passive for element in legs[numbers[0]].chain)
        for first in range(0, len(numbers), WIDTH):
            members = tuple(numbers[first : first + WIDTH])
            starts, function = _strain_slots([legs[number] for number in members])
            groups.append(LegGroup(members, kinds, moved, passive, starts, function))
    return groups


def _structure(element: ChainElement) -> tuple[Element, bool]:
    return Element[element.kind.upper()], element.motor is not None


def _strain_slots(legs: list[LegDescription]) -> tuple[tuple[Integers, ...], tuple[int, ...]]:
    """Strain slots of the rods of a group, one rod after the other, and their shape functions.

    Components of a rod share functions where all legs agree. The n-th function of a basis may depend on
    how many there are, so they are alike only where every leg has as many modes in one as in the other.
    """
    rods = [leg.rods for leg in legs]
    starts: list[Integers] = []
    names: dict[tuple[int, int, int], int] = {}
    function, end = [], 0
    for number in range(len(rods[0])):
        counts = np.array([of_leg[number].modes.counts for of_leg in rods])
        start = end + np.concatenate([[0], np.cumsum(counts.max(axis=0))])
        for component in range(3):
            same = [
                c for c in range(component) if np.array_equal(counts[:, c], counts[:, component])
            ]
            for n in range(start[component + 1] - start[component]):
                name = (number, same[0] if same else component, n)
                function.append(names.setdefault(name, len(names)))
        starts.append(start)
        end = int(start[COMPONENTS])
    return tuple(starts), tuple(function)

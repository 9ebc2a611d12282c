# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From a robot to the arrays the kernels see: the order of the state, and the slots of the legs."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.chain import ChainRod
from ..kernels.kept_factors import kept_count
from ..kernels.kernel_arrays import (
    Element,
    Lanes,
    RobotArrays,
    element_dtype,
    group_dtype,
    rod_dtype,
)
from ..kernels.lanes import WIDTH, zeros_lanes
from ..kernels.slots import COMPONENTS, SlotLayout, slot_layout
from ..rods.quadrature import MAGNUS_WEIGHTS, RodGrid
from ..rods.rod import Rod, StrainModes
from .discretised_robot import DiscretisedRobot
from .leg_groups import LegGroup, leg_groups
from .state_numbers import LegNumbers

__all__ = ["robot_arrays"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Types of the records of all robots: numpy takes as long to make them as to fill some.
_GROUP, _ELEMENT, _ROD = group_dtype(WIDTH), element_dtype(WIDTH), rod_dtype(WIDTH)
#: What an element has for every lane.
_OF_LANES = tuple(name for name in _ELEMENT.names or () if _ELEMENT[name].shape)


def robot_arrays(robot: DiscretisedRobot) -> RobotArrays:
    """A robot as the kernels see it."""
    return _Builder(robot).build()


@dataclass(frozen=True, eq=False)
class _SlotArrays:
    """Arrays by slots and lanes, filled leg by leg; as ``RobotArrays`` has them."""

    slots: SlotLayout
    groups: NDArray[np.void]
    elements: NDArray[np.void]
    rods: NDArray[np.void]
    function: Integers
    slot_index: Integers
    motor_slot_index: Integers
    motor_ratio: Lanes
    units: Lanes
    functions: Lanes
    step_functions: Lanes
    elastic: Lanes
    rest_moment: Lanes
    rest_steps: Lanes


class _RodValues(NamedTuple):
    """What the kernels read of a rod with m strain modes.

    Attributes:
        functions: Shape functions at the nodes, (m, K).
        step_functions: Their moments over the rotation steps, (m, H, 3).
        stiffness: K_e, (m, m).
        rest_moment: Forces of the coordinates at rest, K_e q_rest, (m,).
        rest_energy: q_rest^T K_e q_rest [J].
        rest_steps: Moments over the rotation steps of the curvature at rest beyond the modes, by
            component, (H, 3, 3); None: they hold it.
    """

    functions: Floats
    step_functions: Floats
    stiffness: Floats
    rest_moment: Floats
    rest_energy: float
    rest_steps: Floats | None


def _found_values(rod: Rod, modes: StrainModes, grid: RodGrid) -> _RodValues:
    """Those of a rod."""
    hashable = modes.identity is modes
    functions, step_functions = (
        _kept_functions(modes, grid) if hashable else _functions(modes, grid)
    )
    stiffness, rest = rod.stiffness(modes, grid), rod.rest_strain(modes)
    rest_moment, steps = stiffness @ rest, None
    if not modes.hold(rod.rest_curvature):
        steps = np.swapaxes(rod.rest_beyond_steps(modes, grid.step_points), 1, 2)
    return _RodValues(
        functions, step_functions, stiffness, rest_moment, float(rest @ rest_moment), steps
    )


def _functions(modes: StrainModes, grid: RodGrid) -> tuple[Floats, Floats]:
    """Shape functions at the nodes, (m, K), and their moments over the rotation steps, (m, H, 3)."""
    step_values = modes.values(grid.step_points.ravel())
    moments = MAGNUS_WEIGHTS @ step_values.reshape(*grid.step_points.shape, -1)
    return modes.values(grid.nodes).T, np.moveaxis(moments, 2, 0)


#: Robots that differ in their numbers have the same modes and share a grid.
_kept_functions = lru_cache(maxsize=128)(_functions)


class _Builder:
    """Fills the slots of the lanes, leg by leg."""

    def __init__(self, robot: DiscretisedRobot) -> None:
        self.planar, self.grid, self.coordinates = (
            robot.planar,
            robot.grid,
            robot.platform_coordinates,
        )
        self.described, self.numbers = robot.description.legs, robot.numbers
        self.position_axes = np.array([0, 1] if self.planar else [0, 1, 2])
        self.groups = leg_groups(self.described)
        self.values: dict[tuple[int, Hashable], _RodValues] = {}
        self.mode_slots: dict[tuple[int, int, tuple[int, ...]], Integers] = {}

    def build(self) -> RobotArrays:
        """All arrays."""
        numbers = self.numbers
        held = [self._held_orientations(leg) + len(self.position_axes) for leg in numbers.legs]
        return RobotArrays(
            **self._slots(),
            weights=self.grid.weights,
            integration=np.ascontiguousarray(self.grid.integration.T),
            panel_nodes=self.grid.panel_nodes,
            steps=self.grid.steps,
            step_node=self.grid.step_node,
            position_axes=self.position_axes,
            platform_axes=self.coordinates.axes.copy(),  # read-only is another type to numba
            unit=numbers.unit,
            energy_unit=numbers.energy_unit,
            platform_index=numbers.platform_index,
            motor_index=numbers.motor_index,
            border_indices=np.arange(numbers.platform_index, len(numbers.unit)),
            inverse_unknowns=self._inverse_unknowns(),
            controls_angles=int(self.coordinates.controls_angles),
            constraint_count=sum(held),
        )

    def _held_orientations(self, leg: LegNumbers) -> int:
        return leg.moments.stop - leg.moments.start

    def _inverse_unknowns(self) -> Integers:
        if not len(self.coordinates.controlled):
            return np.zeros(0, np.int64)
        free = ~np.isin(self.coordinates.axes, self.coordinates.controlled)
        motors = np.arange(self.numbers.motor_index, len(self.numbers.unit))
        return np.concatenate([self.numbers.platform_index + np.flatnonzero(free), motors])

    def _slots(self) -> dict[str, Any]:
        """What the kernels read by slots and lanes."""
        arrays = self._empty_slots()
        slots, count = arrays.slots, len(self.groups)
        for group, legs in enumerate(self.groups):
            self._fill_structure(arrays, group, legs)
            for lane, number in enumerate(legs.numbers):
                self._fill_chain(arrays, number, group, lane)
                self._fill_leg(arrays, number, group, lane)
                self._fill_coordinates(arrays, number, group, lane)
            self._repeat_last(arrays, group, len(legs.numbers))
        unit, motor_index = self.numbers.unit, self.numbers.motor_index
        used = arrays.slot_index >= 0
        arrays.units["lane"][:, : slots.inner_count] = np.where(used, unit[arrays.slot_index], 0.0)
        columns = np.arange(slots.platform_count)
        platform = unit[motor_index - slots.platform_count + columns]
        arrays.units["lane"][:, slots.first_platform + columns] = platform[:, None]
        missing = zeros_lanes(WIDTH, count, slots.inner_count)
        missing["lane"][:] = ~used
        border = len(unit) - motor_index + slots.platform_count
        moved = arrays.motor_slot_index[arrays.motor_slot_index >= 0]
        alone = slots.motor_count == 1 and len(np.unique(moved)) == len(moved)
        lane_leg = np.full((count, WIDTH), -1)
        for group, legs in enumerate(self.groups):
            lane_leg[group, : len(legs.numbers)] = legs.numbers
        return vars(arrays) | {
            "kept_count": kept_count(count, slots, border, WIDTH),
            "missing": missing,
            "lane_leg": lane_leg,
            "one_slot_a_motor": int(alone),
            "extensible": int(any(rod.length_index is not None for rod in self.numbers.rods)),
        }

    def _empty_slots(self) -> _SlotArrays:
        """How many slots there are, and room for what is in them."""
        groups, nodes, steps = self.groups, len(self.grid.nodes), len(self.grid.steps)
        count = len(groups)
        slots = slot_layout(
            strain_count=max(group.strain_count for group in groups),
            position_count=len(self.position_axes),
            orientation_count=max(map(self._held_orientations, self.numbers.legs)),
            passive_count=max(group.passive_count for group in groups),
            platform_count=len(self.coordinates.axes),
            motor_count=max(group.motor_count for group in groups),
        )
        functions = max(group.function_count for group in groups)
        every_rod = [element for leg in self.described for element in leg.rods]
        curved = not all(rod.modes.hold(rod.rod.rest_curvature) for rod in every_rod)
        rods = np.zeros((count, max(1, *(len(group.component_start) for group in groups))), _ROD)
        rods["length_slot"], rods["length_index"], rods["loads"] = -1, -1, -1
        elements = np.zeros((count, max(len(group.kinds) for group in groups)), _ELEMENT)
        elements["slot"], elements["rod"] = -1, -1
        return _SlotArrays(
            slots=slots,
            groups=np.zeros(count, _GROUP),
            elements=elements,
            rods=rods,
            function=np.zeros((count, slots.strain_count), np.int64),
            slot_index=np.full((count, slots.inner_count, WIDTH), -1),
            motor_slot_index=np.full((count, slots.motor_count, WIDTH), -1),
            motor_ratio=zeros_lanes(WIDTH, count, slots.motor_count),
            units=zeros_lanes(WIDTH, count, slots.total),
            functions=zeros_lanes(WIDTH, count, functions, nodes),
            step_functions=zeros_lanes(WIDTH, count, steps, functions, 3),
            elastic=zeros_lanes(WIDTH, count, slots.strain_count, slots.strain_count),
            rest_moment=zeros_lanes(WIDTH, count, slots.strain_count),
            rest_steps=zeros_lanes(WIDTH, count, rods.shape[1], steps if curved else 1, 3, 3),
        )

    def _fill_structure(self, arrays: _SlotArrays, group: int, legs: LegGroup) -> None:
        """What is the same for all legs of a group."""
        slots, elements, rods = arrays.slots, arrays.elements[group], arrays.rods[group]
        arrays.function[group, : len(legs.function)] = legs.function
        passive, motors, rod = slots.first_passive, slots.first_motor, 0
        turned = False
        for position, (kind, moved) in enumerate(zip(legs.kinds, legs.moved, strict=True)):
            elements["kind"][position] = kind
            if kind == Element.ROD:
                elements["rod"][position] = rod
                rods["component_start"][rod] = legs.component_start[rod]
                rods["turned"][rod], rods["followed"][rod] = turned, position + 1 < len(legs.kinds)
                if moved:
                    rods["length_slot"][rod], motors = motors, motors + 1
                rod += 1
            elif kind != Element.LINK:
                if moved:
                    elements["slot"][position], motors = motors, motors + 1
                else:
                    elements["slot"][position], passive = passive, passive + 1
            turned = turned or kind in (Element.TURN, Element.ROD)

    def _fill_chain(self, arrays: _SlotArrays, number: int, group: int, lane: int) -> None:
        """Base, joints, links and rods of a leg: what every lane has, see ``_repeat_last``."""
        leg, fields = self.described[number], arrays.groups[group]
        fields["base_rotation"][..., lane] = leg.base_rotation
        fields["base_position"][..., lane] = leg.base_position
        for position, element in enumerate(leg.chain):
            row = arrays.elements[group, position]
            for name, value in element.constants().items():
                row[name][..., lane] = value
            row["heavy"] |= row["mass"][lane] > 0.0
        for rod, element in enumerate(leg.rods):
            self._fill_rod(arrays, element, group, rod, lane)

    def _repeat_last(self, arrays: _SlotArrays, group: int, used: int) -> None:
        """A lane without leg repeats the last one, without tip, force or motor."""
        for lanes in (
            *(arrays.groups[name][group] for name in ("base_rotation", "base_position")),
            *(arrays.elements[name][group] for name in _OF_LANES),
            arrays.rods["length"][group],
            arrays.functions["lane"][group],
            arrays.step_functions["lane"][group],
            arrays.rest_steps["lane"][group],
        ):
            lanes[..., used:] = lanes[..., used - 1 : used]

    def _fill_rod(
        self, arrays: _SlotArrays, element: ChainRod, group: int, rod: int, lane: int
    ) -> None:
        """Length, and shape functions at nodes and steps."""
        arrays.rods[group, rod]["length"][lane] = element.rod.length
        own, functions = (
            self._rod_values(element),
            arrays.function[group, self._mode_slots(arrays, element, group, rod)],
        )
        arrays.functions["lane"][group, functions, :, lane] = own.functions
        arrays.step_functions["lane"][group, :, functions, :, lane] = own.step_functions
        if own.rest_steps is not None:
            arrays.rods[group, rod]["curved"] = 1
            arrays.rest_steps["lane"][group, rod, ..., lane] = own.rest_steps

    def _fill_leg(self, arrays: _SlotArrays, number: int, group: int, lane: int) -> None:
        """Elasticity of the rods, tip and multipliers of a leg."""
        leg, numbers, fields = (
            self.described[number],
            self.numbers.legs[number],
            arrays.groups[group],
        )
        fields["exists"][lane] = 1.0
        fields["tip_position"][..., lane] = leg.joint.position
        conditions = leg.joint.orientation(self.planar)
        for row, condition in enumerate(conditions):
            fields["orientation"][row, ..., lane] = leg.joint.rotation() @ condition
        multipliers = np.arange(arrays.slots.position_count + len(conditions))
        first = arrays.slots.first_multiplier
        index = numbers.forces.start + multipliers
        arrays.slot_index[group, first + multipliers, lane] = index
        before = sum(len(other.rods) for other in self.described[:number])
        for rod, (element, own) in enumerate(zip(leg.rods, numbers.rods, strict=True)):
            slots, row = self._mode_slots(arrays, element, group, rod), arrays.rods[group, rod]
            row["loads"][lane] = before + rod
            values = self._rod_values(element)
            row["rest_energy"][lane] = values.rest_energy
            row["extensible"][lane] = element.motor is not None
            row["fed_zero"][lane] = element.zero
            arrays.slot_index[group, slots, lane] = own.strain.start + np.arange(len(slots))
            arrays.elastic["lane"][group, slots[:, None], slots, lane] = values.stiffness
            arrays.rest_moment["lane"][group, slots, lane] = values.rest_moment

    def _rod_values(self, element: ChainRod) -> _RodValues:
        """Those of a rod and its modes, found once for all legs that have them."""
        key = id(element.rod), element.modes.identity
        if key not in self.values:
            self.values[key] = _found_values(element.rod, element.modes, self.grid)
        return self.values[key]

    def _fill_coordinates(self, arrays: _SlotArrays, number: int, group: int, lane: int) -> None:
        """Which states the joints of a leg are moved by."""
        elements, slots = arrays.elements[group], arrays.slots
        for position, element in enumerate(self.described[number].chain):
            index = self.numbers.legs[number].coordinates[position]
            if index is None:
                continue
            slot = int(elements["slot"][position])
            rod = int(elements["rod"][position])
            if rod >= 0:
                row = arrays.rods[group, rod]
                slot = int(row["length_slot"])
                row["length_index"][lane] = index
            if slot < slots.inner_count:
                arrays.slot_index[group, slot, lane] = index
                continue
            arrays.motor_slot_index[group, slot - slots.first_motor, lane] = index
            arrays.motor_ratio["lane"][group, slot - slots.first_motor, lane] = element.ratio
            arrays.units["lane"][group, slot, lane] = element.ratio * self.numbers.unit[index]

    def _mode_slots(self, arrays: _SlotArrays, element: ChainRod, group: int, rod: int) -> Integers:
        """Slots of the strain modes of a rod, found once for all legs of a group."""
        key = group, rod, tuple(element.modes.counts)
        if key not in self.mode_slots:
            starts = arrays.rods[group, rod]["component_start"][:COMPONENTS]
            pairs = zip(starts, element.modes.counts, strict=True)
            self.mode_slots[key] = np.concatenate([start + np.arange(n) for start, n in pairs])
        return self.mode_slots[key]

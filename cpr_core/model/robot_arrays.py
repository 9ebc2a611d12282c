# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From a robot to the arrays the kernels see: the order of the state, and the slots of the legs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..description.robot_description import LegDescription, RobotDescription
from ..kernels.kept_factors import kept_count
from ..kernels.kernel_arrays import LEG, Lanes, RobotArrays, group_dtype
from ..kernels.lanes import WIDTH, zeros_lanes
from ..kernels.slots import SlotLayout, slot_layout
from ..rods.quadrature import MAGNUS_WEIGHTS, RodGrid
from .platform_coordinates import PlatformCoordinates

__all__ = ["robot_arrays"]

Floats = NDArray[np.float64]


def robot_arrays(
    description: RobotDescription, grid: RodGrid, coordinates: PlatformCoordinates
) -> RobotArrays:
    """A robot as the kernels see it.

    Args:
        description: The robot.
        grid: Quadrature of every rod.
        coordinates: Motions of its platform.
    """
    return _Builder(description, grid, coordinates).build()


@dataclass(frozen=True, eq=False)
class _SlotArrays:
    """Arrays by slots and lanes, filled leg by leg; as ``RobotArrays`` has them."""

    slots: SlotLayout
    component_start: NDArray[np.int64]
    function: NDArray[np.int64]
    groups: NDArray[np.void]
    index: NDArray[np.int64]
    units: Lanes
    functions: Lanes
    step_functions: Lanes
    elastic: Lanes
    rest_moment: Lanes

    def mode_slots(self, leg: LegDescription) -> NDArray[np.int64]:
        """Slots of the strain modes of a leg."""
        starts = self.component_start[:3]
        return np.concatenate(
            [start + np.arange(n) for start, n in zip(starts, leg.modes.counts, strict=True)]
        )


class _Builder:
    """Numbers the states leg by leg, then fills the slots of the lanes."""

    def __init__(
        self, description: RobotDescription, grid: RodGrid, coordinates: PlatformCoordinates
    ) -> None:
        self.planar, self.grid, self.coordinates = description.planar, grid, coordinates
        self.described = description.legs
        self.length_unit = description.mean_length
        rigidities = [leg.rod.rigidities.max() for leg in self.described]
        self.energy_unit = float(np.mean(rigidities)) / self.length_unit
        self.position_axes = np.array([0, 1] if self.planar else [0, 1, 2])
        self.legs = np.zeros(len(self.described), LEG)
        self.unit: list[float] = []
        # Leg, the name of its coordinate, and the natural unit.
        self.motors: list[tuple[int, str, float]] = []

    def build(self) -> RobotArrays:
        """All arrays."""
        for number, leg in enumerate(self.described):
            self._number_states(number, leg)
        platform_index = len(self.unit)
        axes = self.coordinates.axes
        self.unit += [1.0 if axis < 3 else self.length_unit for axis in axes]
        motor_index = len(self.unit)
        for number, name, natural in self.motors:
            self.legs[number][f"{name}_index"] = len(self.unit)
            self.unit.append(natural)
        constraints = (
            len(self.position_axes) * len(self.legs) + self.legs["orientation_count"].sum()
        )
        return RobotArrays(
            legs=self.legs,
            stiffness=self._stiffness(),
            **self._slots(motor_index),
            weights=self.grid.weights,
            integration=np.ascontiguousarray(self.grid.integration.T),
            panel_nodes=self.grid.panel_nodes,
            steps=self.grid.steps,
            step_node=self.grid.step_node,
            position_axes=self.position_axes,
            platform_axes=axes,
            unit=np.array(self.unit),
            energy_unit=self.energy_unit,
            platform_index=platform_index,
            motor_index=motor_index,
            border_indices=np.arange(platform_index, len(self.unit)),
            inverse_unknowns=self._inverse_unknowns(platform_index, motor_index),
            controls_angles=int(self.coordinates.controls_angles),
            constraint_count=int(constraints),
        )

    def _number_states(self, number: int, leg: LegDescription) -> None:
        numbers = self.legs[number]
        numbers["length"] = leg.rod.length
        for kind, axis, coordinate, natural in (
            ("turn", leg.motor.turn_axis(leg.base_rotation), "rotation", 1.0),
            ("shift", leg.motor.shift_axis, "translation", self.length_unit),
        ):
            numbers[f"{coordinate}_index"] = -1
            if axis is None:
                continue
            numbers[f"{coordinate}_axis"] = axis
            if leg.motor.actuated == kind:
                self.motors.append((number, coordinate, natural))
            else:
                numbers[f"{coordinate}_index"] = len(self.unit)
                self.unit.append(natural)
        numbers["extensible"] = leg.motor.extensible
        numbers["strain_index"] = len(self.unit)
        numbers["strain_count"] = leg.modes.total
        self.unit += [1.0 / self.length_unit] * leg.modes.total
        numbers["orientation_count"] = len(leg.joint.orientation(self.planar))
        numbers["multiplier_index"] = len(self.unit)
        self.unit += [self.energy_unit / self.length_unit] * len(self.position_axes)
        self.unit += [self.energy_unit] * numbers["orientation_count"]

    def _inverse_unknowns(self, platform_index: int, motor_index: int) -> NDArray[np.int64]:
        if not len(self.coordinates.controlled):
            return np.zeros(0, np.int64)
        free = ~np.isin(self.coordinates.axes, self.coordinates.controlled)
        motors = np.arange(motor_index, len(self.unit))
        return np.concatenate([platform_index + np.flatnonzero(free), motors])

    def _stiffness(self) -> Floats:
        widest = max(leg.modes.total for leg in self.described)
        stiffness = np.zeros((len(self.legs), widest, widest))
        for number, leg in enumerate(self.described):
            total = leg.modes.total
            stiffness[number, :total, :total] = leg.rod.stiffness(leg.modes, self.grid)
        return stiffness

    def _slots(self, motor_index: int) -> dict[str, Any]:
        """What the kernels read by slots and lanes."""
        arrays = self._empty_slots(motor_index)
        slots, count = arrays.slots, len(arrays.groups)
        for lane_number in range(count * WIDTH):
            group, lane = divmod(lane_number, WIDTH)
            # A lane without leg repeats the last one, without tip, force or motor.
            number = min(lane_number, len(self.legs) - 1)
            self._fill_rod(arrays, number, group, lane)
            if lane_number < len(self.legs):
                self._fill_leg(arrays, number, group, lane)
                self._fill_base(arrays, number, group, lane, motor_index)
        unit = np.array(self.unit)
        used = arrays.index >= 0
        arrays.units["lane"][:, : slots.inner_count] = np.where(used, unit[arrays.index], 0.0)
        columns = np.arange(slots.platform_count)
        platform = unit[motor_index - slots.platform_count + columns]
        arrays.units["lane"][:, slots.first_platform + columns] = platform[:, None]
        missing = zeros_lanes(WIDTH, count, slots.inner_count)
        missing["lane"][:] = ~used
        border = len(self.unit) - motor_index + slots.platform_count
        return {
            "slots": slots,
            "kept_count": kept_count(count, slots, border, WIDTH),
            "groups": arrays.groups,
            "slot_index": arrays.index,
            "units": arrays.units,
            "missing": missing,
            "component_start": arrays.component_start,
            "function": arrays.function,
            "functions": arrays.functions,
            "step_functions": arrays.step_functions,
            "elastic": arrays.elastic,
            "rest_moment": arrays.rest_moment,
            "shifted": int(any(leg.motor.shift_axis is not None for leg in self.described)),
            "extensible": int(self.legs["extensible"].any()),
        }

    def _empty_slots(self, motor_index: int) -> _SlotArrays:
        """How many slots there are, and room for what is in them."""
        legs, nodes, steps = self.legs, len(self.grid.nodes), len(self.grid.steps)
        count = -(-len(legs) // WIDTH)
        most_modes = np.array([leg.modes.counts for leg in self.described]).max(axis=0)
        start = np.concatenate([[0], np.cumsum(most_modes)])
        free = np.stack([legs["rotation_index"], legs["translation_index"]])
        slots = slot_layout(
            strain_count=int(start[-1]),
            position_count=len(self.position_axes),
            orientation_count=int(legs["orientation_count"].max()),
            passive=bool(((free >= 0) & (free < motor_index)).any()),
            platform_count=len(self.coordinates.axes),
        )
        groups = np.zeros(count, group_dtype(WIDTH))
        for name in ("turn_index", "shift_index", "motor_index"):
            groups[name] = -1
        function, names = _functions(self.described, start)
        return _SlotArrays(
            slots=slots,
            component_start=start,
            function=function,
            groups=groups,
            index=np.full((count, slots.inner_count, WIDTH), -1),
            units=zeros_lanes(WIDTH, count, slots.total),
            functions=zeros_lanes(WIDTH, count, len(names), nodes),
            step_functions=zeros_lanes(WIDTH, count, steps, len(names), 3),
            elastic=zeros_lanes(WIDTH, count, slots.strain_count, slots.strain_count),
            rest_moment=zeros_lanes(WIDTH, count, slots.strain_count),
        )

    def _fill_rod(self, arrays: _SlotArrays, number: int, group: int, lane: int) -> None:
        """Length, base and strain modes of a leg: what every lane has."""
        leg, fields, grid = self.described[number], arrays.groups[group], self.grid
        fields["length"][lane] = leg.rod.length
        fields["base_rotation"][..., lane] = leg.base_rotation
        fields["base_position"][..., lane] = leg.base_position
        values = leg.modes.values(grid.nodes)
        step_values = leg.modes.values(grid.step_points.ravel())
        moments = MAGNUS_WEIGHTS @ step_values.reshape(*grid.step_points.shape, -1)
        for mode, slot in enumerate(arrays.mode_slots(leg)):
            function = arrays.function[slot]
            arrays.functions["lane"][group, function, :, lane] = values[:, mode]
            arrays.step_functions["lane"][group, :, function, :, lane] = moments[..., mode]

    def _fill_leg(self, arrays: _SlotArrays, number: int, group: int, lane: int) -> None:
        """Elasticity, tip and multipliers of a leg."""
        leg, numbers, fields = self.described[number], self.legs[number], arrays.groups[group]
        fields["exists"][lane] = 1.0
        fields["rest_energy"][lane] = leg.rod.rest_energy(self.grid)
        fields["extensible"][lane] = leg.motor.extensible
        fields["tip_position"][..., lane] = leg.joint.position
        conditions = leg.joint.orientation(self.planar)
        for row, condition in enumerate(conditions):
            fields["orientation"][row, ..., lane] = leg.joint.rotation() @ condition
        modes = arrays.mode_slots(leg)
        arrays.index[group, modes, lane] = numbers["strain_index"] + np.arange(len(modes))
        multipliers = np.arange(arrays.slots.position_count + len(conditions))
        first = arrays.slots.first_multiplier
        arrays.index[group, first + multipliers, lane] = numbers["multiplier_index"] + multipliers
        stiffness = leg.rod.stiffness(leg.modes, self.grid)
        arrays.elastic["lane"][group, modes[:, None], modes, lane] = stiffness
        arrays.rest_moment["lane"][group, modes, lane] = leg.rod.rest_moment(leg.modes, self.grid)

    def _fill_base(
        self, arrays: _SlotArrays, number: int, group: int, lane: int, motor_index: int
    ) -> None:
        """Coordinates of the base of a leg, moved by a motor or passive."""
        leg, numbers, fields = self.described[number], self.legs[number], arrays.groups[group]
        for axis, name, coordinate in (
            (leg.motor.turn_axis(leg.base_rotation), "turn", "rotation"),
            (leg.motor.shift_axis, "shift", "translation"),
        ):
            if axis is None:
                continue
            index = numbers[f"{coordinate}_index"]
            fields[f"{coordinate}_axis"][..., lane] = axis
            fields[f"{name}_index"][lane] = index
            fields[f"{name}_motor"][lane] = index >= motor_index
            fields[f"{name}_passive"][lane] = index < motor_index
            if index >= motor_index:
                fields["motor_index"][lane] = index
                arrays.units["lane"][group, arrays.slots.motor, lane] = self.unit[index]
            else:
                arrays.index[group, arrays.slots.passive, lane] = index


def _functions(
    legs: tuple[LegDescription, ...], start: NDArray[np.int64]
) -> tuple[NDArray[np.int64], list[tuple[int, int]]]:
    """Which shape function every strain slot uses; components share them where all legs agree.

    The n-th function of a basis may depend on how many there are, so components are alike only where
    every leg has as many modes in one as in the other.
    """
    counts = np.array([leg.modes.counts for leg in legs])
    names: list[tuple[int, int]] = []
    function = []
    for component in range(3):
        alike = [c for c in range(component) if np.array_equal(counts[:, c], counts[:, component])]
        for n in range(start[component + 1] - start[component]):
            name = (alike[0] if alike else component, n)
            if name not in names:
                names.append(name)
            function.append(names.index(name))
    return np.array(function, dtype=np.int64), names

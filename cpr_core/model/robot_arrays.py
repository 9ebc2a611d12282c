# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From a robot to the arrays the kernels see: the order of the state, and the slots of the legs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..description.robot_description import LegDescription, RobotDescription
from ..kernels.kept_factors import kept_count
from ..kernels.kernel_arrays import LEG, RobotArrays, group_dtype
from ..kernels.lanes import WIDTH, zeros_lanes
from ..kernels.slots import slot_layout
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
            orientation_count=int(self.legs["orientation_count"].max()),
        )

    def _number_states(self, number: int, leg: LegDescription) -> None:
        here = self.legs[number]
        here["length"] = leg.rod.length
        for kind, axis, name, natural in (
            ("turn", leg.motor.turn_axis(leg.base_rotation), "rotation", 1.0),
            ("shift", leg.motor.shift_axis, "translation", self.length_unit),
        ):
            here[f"{name}_index"] = -1
            if axis is None:
                continue
            here[f"{name}_axis"] = axis
            if leg.motor.actuated == kind:
                self.motors.append((number, name, natural))
            else:
                here[f"{name}_index"] = len(self.unit)
                self.unit.append(natural)
        here["extensible"] = leg.motor.extensible
        here["strain_index"] = len(self.unit)
        here["strain_count"] = leg.modes.total
        self.unit += [1.0 / self.length_unit] * leg.modes.total
        here["orientation_count"] = len(leg.joint.orientation(self.planar))
        here["multiplier_index"] = len(self.unit)
        self.unit += [self.energy_unit / self.length_unit] * len(self.position_axes)
        self.unit += [self.energy_unit] * here["orientation_count"]

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
        grid, legs = self.grid, self.legs
        width, count = WIDTH, -(-len(legs) // WIDTH)
        counts = np.array([leg.modes.counts for leg in self.described])
        start = np.concatenate([[0], np.cumsum(counts.max(axis=0))])
        free = np.stack([legs["rotation_index"], legs["translation_index"]])
        is_passive = (free >= 0) & (free < motor_index)
        slots = slot_layout(
            strain_count=int(start[-1]),
            position_count=len(self.position_axes),
            orientation_count=int(legs["orientation_count"].max()),
            passive=bool(is_passive.any()),
            platform_count=len(self.coordinates.axes),
        )
        strains, inner = slots.strain_count, slots.inner_count

        index = np.full((count, inner, width), -1)
        units = zeros_lanes(width, count, slots.total)
        missing = zeros_lanes(width, count, inner)
        groups = np.zeros(count, group_dtype(width))
        function, names = _functions(self.described, start)
        functions = zeros_lanes(width, count, len(names), len(grid.nodes))
        step_functions = zeros_lanes(width, count, len(grid.steps), len(names), 3)
        elastic = zeros_lanes(width, count, strains, strains)
        rest_moment = zeros_lanes(width, count, strains)
        for name in ("turn_index", "shift_index", "motor_index"):
            groups[name] = -1

        for lane_number in range(count * width):
            group, lane = divmod(lane_number, width)
            exists = lane_number < len(legs)
            # A lane without leg repeats the last one, without tip, force or motor.
            number = min(lane_number, len(legs) - 1)
            leg, here, fields = self.described[number], legs[number], groups[group]
            fields["length"][lane] = leg.rod.length
            fields["base_rotation"][..., lane] = leg.base_rotation
            fields["base_position"][..., lane] = leg.base_position
            values = leg.modes.values(grid.nodes)
            step_values = leg.modes.values(grid.step_points.ravel())
            moments = MAGNUS_WEIGHTS @ step_values.reshape(*grid.step_points.shape, -1)
            modes = np.concatenate([start[c] + np.arange(counts[number, c]) for c in range(3)])
            for mode, slot in enumerate(modes):
                at = function[slot]
                functions["lane"][group, at, :, lane] = values[:, mode]
                step_functions["lane"][group, :, at, :, lane] = moments[..., mode]
            if not exists:
                continue
            fields["exists"][lane] = 1.0
            fields["rest_energy"][lane] = leg.rod.rest_energy(grid)
            fields["extensible"][lane] = leg.motor.extensible
            fields["tip_position"][..., lane] = leg.joint.position
            conditions = leg.joint.orientation(self.planar)
            for row, condition in enumerate(conditions):
                fields["orientation"][row, ..., lane] = leg.joint.rotation() @ condition
            for axis, name, own in (
                (leg.motor.turn_axis(leg.base_rotation), "turn", "rotation"),
                (leg.motor.shift_axis, "shift", "translation"),
            ):
                if axis is None:
                    continue
                at = here[f"{own}_index"]
                fields[f"{own}_axis"][..., lane] = axis
                fields[f"{name}_index"][lane] = at
                fields[f"{name}_motor"][lane] = at >= motor_index
                fields[f"{name}_passive"][lane] = at < motor_index
                if at >= motor_index:
                    fields["motor_index"][lane] = at
                    units["lane"][group, slots.motor, lane] = self.unit[at]
                else:
                    index[group, slots.passive, lane] = at
            index[group, modes, lane] = here["strain_index"] + np.arange(len(modes))
            multipliers = np.arange(slots.position_count + len(conditions))
            first = slots.first_multiplier
            index[group, first + multipliers, lane] = here["multiplier_index"] + multipliers
            elastic["lane"][group, modes[:, None], modes, lane] = leg.rod.stiffness(leg.modes, grid)
            rest_moment["lane"][group, modes, lane] = leg.rod.rest_moment(leg.modes, grid)
        unit = np.array(self.unit)
        there = index >= 0
        units["lane"][:, :inner] = np.where(there, unit[index], 0.0)
        columns = np.arange(slots.platform_count)
        own = unit[motor_index - slots.platform_count + columns]
        units["lane"][:, slots.first_platform + columns] = own[:, None]
        missing["lane"][:] = ~there
        return {
            "slots": slots,
            "kept_count": kept_count(
                count, slots, len(self.unit) - motor_index + slots.platform_count, width
            ),
            "groups": groups,
            "slot_index": index,
            "units": units,
            "missing": missing,
            "component_start": start,
            "function": function,
            "functions": functions,
            "step_functions": step_functions,
            "elastic": elastic,
            "rest_moment": rest_moment,
            "passive": int(slots.passive >= 0),
            "shifted": int(any(leg.motor.shift_axis is not None for leg in self.described)),
            "extensible": int(legs["extensible"].any()),
        }


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

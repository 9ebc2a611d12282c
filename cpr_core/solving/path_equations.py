# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The equations F(x, t) = 0 of a path, dimensionless: unknowns x, fraction of the way t."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..kernels.kernel_arrays import PLATFORM_LOADS, LoadArrays, interpolated_loads
from ..kernels.natural_units import EFFORT_UNIT
from ..kernels.square_problem import Configuration
from ..kernels.twist_layout import ANGULAR
from ..lie import angle_motions, rotation_log
from ..model.displacement import displaced
from ..model.equilibrium import Equilibrium
from ..model.model_state import ModelValue, configuration_of, evaluate
from ..validation import cached_property
from .targets import Imposed, Target

__all__ = ["PathEquations"]

Floats = NDArray[np.float64]

#: Step of the fraction by which the rate of the residual is found, central differences.
_RATE_STEP = 1e-5
#: The same for what changes evenly along the whole way: less than a quarter turn.
_EVEN_STEP = 0.25


class PathEquations:
    """Residual, matrix and rate along the way from an equilibrium to a target; unknowns legs first.

    Attributes:
        conservative: Whether all loads on the way have a potential.
        loads_change: Whether they change on the way.
    """

    def __init__(self, start: Equilibrium, target: Target, loads: Loads) -> None:
        """Take the ends of the way; nothing is evaluated yet."""
        robot = start.robot
        self._start, self._target, self._loads, self._robot = start, target, loads, robot
        self.loads_change = loads is not start.loads
        self._last_loads = robot.load_arrays(loads) if self.loads_change else start.load_arrays
        self.conservative = robot.has_potential(loads) and (
            not self.loads_change or robot.has_potential(start.loads)
        )
        self._columns, self._rows = robot.problems[target.problem]
        self._angles = target.problem == "pose" and robot.controls_angles
        self._even_rates: tuple[Floats, Floats] | None = None

    @cached_property
    def _equations(self) -> NDArray[np.int64]:
        """State indices of the equations, legs first."""
        return np.concatenate([np.arange(self._robot.kernel_arrays.platform_index), self._rows])

    @cached_property
    def _scales(self) -> Floats:
        """What makes the matrix of the problem dimensionless, entry by entry."""
        arrays = self._robot.kernel_arrays
        unknowns = np.concatenate([np.arange(arrays.platform_index), self._columns])
        scales: Floats = np.outer(arrays.unit[self._equations], arrays.unit[unknowns])
        return scales / arrays.energy_unit

    @cached_property
    def load_distance(self) -> float:
        """How far the loads change, comparable to a motor in radians."""
        if not self.loads_change:
            return 0.0
        arrays, length = self._robot.kernel_arrays, self._robot.mean_length
        first, last = self._start.load_arrays, self._last_loads
        platform = {
            name: np.abs(last.platform[name] - first.platform[name]).max()
            for name in PLATFORM_LOADS.names or ()
        }
        rods = np.abs(last.distributed - first.distributed).max(initial=0.0) * length
        points = np.abs(last.point - first.point).max(initial=0.0)
        forces = max(
            platform["weight"], platform["force_world"], platform["force_body"], rods, points
        )
        moments = max(platform["moment_world"], platform["moment_body"])
        return float(max(forces * length, moments)) / (EFFORT_UNIT * arrays.energy_unit)

    def loads_at(self, fraction: float) -> LoadArrays:
        """Loads part of the way; all entries are linear in what is given."""
        if not self.loads_change or fraction == 1.0:
            return self._last_loads
        return interpolated_loads(self._start.load_arrays, self._last_loads, fraction)

    def loads_between(self, fraction: float) -> Loads:
        """The same as they are given."""
        return self._start.loads.toward(self._loads, fraction) if self.loads_change else self._loads

    def imposed(self, place: Configuration, fraction: float) -> tuple[Configuration, Floats]:
        """A configuration with what is imposed at a fraction, and the imposed efforts, (n,)."""
        state, rotation, position = place
        first, efforts = self._robot.kernel_arrays.motor_index, np.zeros(self._robot.motor_count)
        free = Imposed(state[first:], efforts, rotation, position)
        found = self._target.imposed(self._start, fraction, free)
        imposed = np.concatenate((state[:first], found.motors))
        return Configuration(imposed, found.rotation, found.position), found.efforts

    def moved(self, place: Configuration, change: Floats) -> Configuration:
        """A configuration after a dimensionless change of the unknowns."""
        robot, inner = self._robot, self._robot.kernel_arrays.platform_index
        whole = np.zeros(len(place.state))
        whole[:inner] = change[:inner]
        whole[self._columns] = change[inner:]
        whole *= robot.kernel_arrays.unit
        if self._angles:
            turning = robot.platform_indices[ANGULAR]
            whole[turning] = angle_motions(place.platform_rotation) @ whole[turning]
        return displaced(robot, *place, whole)

    def residual(self, value: ModelValue, efforts: Floats) -> Floats:
        """F where the model has been evaluated with what is imposed, (M,)."""
        return self._scaled(value.residual, efforts)

    def _scaled(self, residual: Floats, efforts: Floats) -> Floats:
        """A residual less the efforts, in natural units, of the equations of the problem."""
        arrays, residual = self._robot.kernel_arrays, residual.copy()
        residual[arrays.motor_index :] -= efforts
        residual *= arrays.unit / arrays.energy_unit
        return residual[self._equations]

    def matrix(self, value: ModelValue, rotation: Floats) -> Floats:
        """Derivative of F by the unknowns where the model has been evaluated, (M, M).

        Args:
            value: The model there.
            rotation: Of the platform there, (3, 3).
        """
        tangent, inner = value.tangent, self._robot.kernel_arrays.platform_index
        if self._angles:
            turns = self._robot.platform_indices[ANGULAR]
            tangent = tangent.copy()
            tangent[:, turns] = tangent[:, turns] @ angle_motions(rotation)
        # The legs, most of it, are copied as they are: picking entry by entry takes five times longer.
        scaled = np.empty_like(self._scales)
        scaled[:inner, :inner] = tangent[:inner, :inner]
        scaled[:inner, inner:] = tangent[:inner, self._columns]
        scaled[inner:, :inner] = tangent[self._rows, :inner]
        scaled[inner:, inner:] = tangent[self._rows[:, None], self._columns]
        scaled *= self._scales
        return scaled

    def sign(self, equilibrium: Equilibrium) -> int:
        """Sign of the determinant of the problem at an equilibrium under any loads."""
        place = configuration_of(equilibrium)
        value = evaluate(self._robot, equilibrium.load_arrays, *place)
        return int(np.linalg.slogdet(self.matrix(value, place.platform_rotation))[0])

    def linearised(self, equilibrium: Equilibrium, fraction: float) -> tuple[Floats, Floats]:
        """Derivatives of F by the unknowns and by the fraction at a solution, (M, M) and (M,)."""
        place, _ = self.imposed(configuration_of(equilibrium), fraction)
        value = evaluate(self._robot, equilibrium.load_arrays, *place)
        return self.matrix(value, place.platform_rotation), self.rate(value, place, fraction)

    def rate(self, value: ModelValue, place: Configuration, fraction: float) -> Floats:
        """Derivative of F by the fraction, the unknowns held, (M,).

        What is imposed moves along the tangent. Where loads change too, central differences: exact where
        it is linear in the residual (loads, efforts), good to 1e-9 elsewhere; only predictions and
        directions depend on it.

        Args:
            value: The model there.
            place: A configuration with what is imposed.
            fraction: Fraction of the way.
        """
        if not self.loads_change:
            whole, efforts = self._imposed_rates(place, fraction)
            return self._scaled(value.tangent @ whole, efforts)
        sides = []
        for beside in (fraction + _RATE_STEP, fraction - _RATE_STEP):
            other, imposed = self.imposed(place, beside)
            value_beside = evaluate(self._robot, self.loads_at(beside), *other)
            sides.append(self.residual(value_beside, imposed))
        return (sides[0] - sides[1]) / (2.0 * _RATE_STEP)

    def _imposed_rates(self, place: Configuration, fraction: float) -> tuple[Floats, Floats]:
        """Rates of state and efforts with the fraction; only single angles do not change evenly."""
        if self._even_rates is not None:
            return self._even_rates
        step = _RATE_STEP if self._angles else _EVEN_STEP
        after, efforts = self.imposed(place, fraction + step)
        before, efforts_before = self.imposed(place, fraction - step)
        turn = rotation_log(after.platform_rotation @ before.platform_rotation.T)
        twist = np.concatenate([turn, after.platform_position - before.platform_position])
        whole = after.state - before.state
        whole[self._robot.platform_indices] += twist[self._robot.platform_axes]
        rates = whole / (2.0 * step), (efforts - efforts_before) / (2.0 * step)
        if not self._angles:
            self._even_rates = rates
        return rates

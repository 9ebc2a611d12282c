# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A described robot in numbers: its state and units, the nodes along its rods, its limits."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..description.chain import ChainJoint
from ..description.leg_description import DescribedMotor
from ..description.loads import Loads
from ..description.motors import MotorLimits
from ..description.robot_description import RobotDescription
from ..errors import DescriptionError
from ..kernels.record_layout import EFFORT
from ..rods.quadrature import RodGrid, distinct_stations, rod_grid
from ..validation import cached_array, cached_property
from .fed_rods import FedRods, fed_rods
from .motor_limits import MotorLimitArrays, motor_limit_arrays
from .platform_coordinates import PlatformCoordinates, platform_coordinates
from .state_numbers import StateNumbers, state_numbers
from .strain_matrices import curvature_stations, strain_grams, strain_stiffness, unit_motions

__all__ = ["DiscretisedRobot"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False, repr=False)
class DiscretisedRobot:
    """What follows from a description alone, each looked up or found once.

    Attributes:
        description: What the user described.
    """

    description: RobotDescription

    @property
    def planar(self) -> bool:
        """Whether the robot lives in the plane z = 0."""
        return self.description.planar

    def has_potential(self, loads: Loads) -> bool:
        """Whether all of some loads have a potential here, see :meth:`Loads.conservative`."""
        return loads.conservative(self.planar, self.description.point_platform)

    @cached_property
    def motor_names(self) -> tuple[str, ...]:
        """Motor names in motor order."""
        return self.description.motor_names

    @cached_property
    def motor_list(self) -> str:
        """The same in words."""
        return " ".join(self.motor_names)

    @cached_property
    def motor_count(self) -> int:
        """Number of motors n."""
        return len(self.motor_names)

    @cached_property
    def rod_names(self) -> tuple[str, ...]:
        """Names of the rods, (R,): of their legs, numbered where a leg has several."""
        return self.description.rod_names

    @cached_property
    def mean_length(self) -> float:
        """Mean (nominal) rod length, the natural unit of length [m]."""
        return self.description.mean_length

    @cached_property
    def platform_coordinates(self) -> PlatformCoordinates:
        """Motions of the platform, and which of them are controlled."""
        return platform_coordinates(self.description)

    @cached_property
    def platform_axes(self) -> Integers:
        """Components of the world twist [omega; v] the platform has."""
        return self.platform_coordinates.axes

    @cached_property
    def controlled_axes(self) -> Integers:
        """World twist components that move the controlled coordinates.

        With ``controls_angles`` the first three stand for roll, pitch and yaw.
        """
        return self.platform_coordinates.controlled

    @cached_property
    def controls_angles(self) -> bool:
        """Whether single angles of Rz(yaw) Ry(pitch) Rx(roll) are controlled."""
        return self.platform_coordinates.controls_angles

    @cached_property
    def numbers(self) -> StateNumbers:
        """Where everything is in a state."""
        return state_numbers(self.description, self.platform_coordinates)

    @cached_property
    def state_size(self) -> int:
        """Numbers N of a state: of legs, platform and motors."""
        return len(self.numbers.unit)

    @cached_array
    def motor_indices(self) -> Integers:
        """State indices of the motors."""
        return self.numbers.motor_index + np.arange(self.motor_count)

    @cached_array
    def platform_indices(self) -> Integers:
        """State indices of the platform twist."""
        return self.numbers.platform_index + np.arange(len(self.platform_axes))

    @cached_array
    def multiplier_indices(self) -> Integers:
        """State indices of the multipliers, leg by leg."""
        indices = np.arange(self.state_size)
        return np.concatenate(
            [indices[part] for leg in self.numbers.legs for part in (leg.forces, leg.moments)]
        )

    @cached_array
    def elastic_indices(self) -> Integers:
        """State indices of the leg coordinates: passive joints and strain, leg by leg."""
        elastic = np.ones(self.numbers.platform_index, np.bool_)
        elastic[self.multiplier_indices] = False
        return np.flatnonzero(elastic)

    @cached_array
    def moving_indices(self) -> Integers:
        """State indices of what moves while the motors are held: leg coordinates, then the platform."""
        return np.concatenate([self.elastic_indices, self.platform_indices])

    @cached_property
    def passive_joints(self) -> tuple[tuple[ChainJoint, int], ...]:
        """The passive joints of all legs, and where they are in the state."""
        return tuple(
            (element, index)
            for leg, numbers in zip(self.description.legs, self.numbers.legs, strict=True)
            for element, index in zip(leg.chain, numbers.coordinates, strict=True)
            if isinstance(element, ChainJoint) and element.passive and index is not None
        )

    @cached_array
    def motor_units(self) -> Floats:
        """Natural units of the motors, (n,): what moves their joints by a radian or a rod length."""
        return self.numbers.unit[self.motor_indices]

    @cached_array
    def wrench_units(self) -> Floats:
        """Natural units of a whole wrench, moments E J / l and forces E J / l^2, (6,) [N m, N]."""
        energy = self.numbers.energy_unit
        return np.repeat([energy, energy / self.mean_length], 3)

    @cached_property
    def breakpoints(self) -> tuple[float, ...]:
        """Interior s/l where loads, stiffness or shape functions of some leg are not smooth."""
        description = self.description
        points = set(description.stations)
        for element in self.description.rods:
            points |= {*element.modes.basis.breakpoints}
            if not element.rod.profile.uniform:
                points |= {*element.rod.profile.at.tolist()}
        for distributed in description.loads.distributed:
            points |= {*distributed.at.tolist()}
        points |= {point.at for point in description.loads.points}
        return distinct_stations(points)

    @cached_property
    def grid(self) -> RodGrid:
        """Quadrature of every rod: positions are good to 1e-9 m, also where rods are bent far.

        The integrands are products of shape functions and of the tangent field, whose spectrum decays
        a few orders beyond the highest mode. Rods that twist too are bent in three dimensions, where
        rotations have errors of their own. test/cpr_core/rods/test_quadrature.py measures both.
        """
        modes, twisted = 0, False
        for element in self.description.rods:
            counts, rest = element.modes.counts, list(map(len, element.rod.rest_curvature))
            modes, twisted = max(modes, *counts), twisted or counts[0] + rest[0] > 0
            if not element.modes.hold(element.rod.rest_curvature):
                modes = max(modes, *rest)
        more = 12 if twisted else 9 if modes < 8 else 8
        nodes = 4 * math.ceil((modes + more) / 4)  # kernels take four at a time
        return rod_grid(nodes, self.breakpoints, substeps=2 if twisted else 1)

    @cached_array
    def curvature_sigma(self) -> Floats:
        """Where curvatures of rods are looked at: s/l of both ends and the nodes, (P,)."""
        return np.concatenate([[0.0], self.grid.nodes, [1.0]])

    @cached_property
    def curvature_stations(self) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
        """Per rod, at both ends and the nodes (P,): curvature by strain coordinate (P, 3, m); at rest.

        That at rest is (P, 3) [1/m], as far as the modes take it up.
        """
        return curvature_stations(self.numbers, self.curvature_sigma)

    @cached_array
    def rest_state(self) -> Floats:
        """State whose rods have no elastic strain, (N,): all else is zero."""
        found = np.zeros(self.state_size)
        for rod in self.numbers.rods:
            found[rod.strain] = rod.element.rod.rest_strain(rod.element.modes)
        return found

    @cached_array
    def strain_grams(self) -> Floats:
        """Integrals of products of the strain modes of every rod, in state order, (N, N)."""
        return strain_grams(self.numbers, self.grid)

    @cached_array
    def strain_stiffness(self) -> Floats:
        """Elastic stiffness K_e of every rod at its nominal length, in state order, (N, N)."""
        return strain_stiffness(self.numbers, self.grid)

    @cached_array
    def unit_motions(self) -> Floats:
        """Dimensionless unit motions as columns, in state order, (N, N).

        Rotations count in radians, translations in mean rod lengths and strains by their L2 norm along
        the rod, ``(l int kappa^2 ds)^(1/2)``; so a norm of motions does not depend on units or on the
        strain basis.

        Raises:
            DescriptionError: The modes of a rod are not independent, as many monomials are not.
        """
        try:
            return unit_motions(self.numbers, self.strain_grams)
        except np.linalg.LinAlgError:
            source, problem = self.description.source, "expected modes that are independent"
            hint = "monomials are not from about a dozen on, legendre are"
            raise DescriptionError(source, "strain", f"{problem}: {hint}") from None

    @cached_property
    def fed_rods(self) -> FedRods:
        """The rods that motors feed."""
        return fed_rods(self.numbers.rods, self.numbers.motor_index)

    def rods_exist(self, state: Floats) -> bool:
        """Whether all rods have a length in a state (N,)."""
        return self.fed_rods.exist(state[self.numbers.motor_index :])

    @cached_property
    def limited_motors(self) -> tuple[tuple[int, DescribedMotor], ...]:
        """Motors that have limits of position or effort, by number."""
        return tuple(
            (number, motor)
            for number, motor in enumerate(self.description.motors)
            if replace(motor.limits, speed=math.inf) != MotorLimits()
        )

    @cached_property
    def motor_limits(self) -> MotorLimitArrays:
        """Limits of the motors as arrays."""
        return motor_limit_arrays(self.description, self.motor_units)

    @cached_array
    def limited_numbers(self) -> Integers:
        """Where the positions and efforts that ``motor_limits`` are about are in a record, (K,)."""
        limits, positions = self.motor_limits, self.numbers.motor_index
        return limits.motors + np.where(limits.of_effort, self.state_size + EFFORT, positions)

    @cached_array
    def yield_strains(self) -> Floats:
        """Bending strain every rod bears (its yield strain), infinite where not given, (R,)."""
        return np.array([rod.element.rod.yield_strain for rod in self.numbers.rods])

    @cached_property
    def limits_strain(self) -> bool:
        """Whether any rod has a yield strain."""
        return bool(np.isfinite(self.yield_strains).any())

    @cached_property
    def limits_effort(self) -> bool:
        """Whether the effort of any motor is limited."""
        return bool(self.motor_limits.of_effort.any())

    @cached_property
    def limited(self) -> bool:
        """Whether there are any limits of motors' positions and efforts or of strain."""
        return bool(self.limited_motors) or self.limits_strain

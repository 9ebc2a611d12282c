# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot ready to be solved: its description and the arrays of the kernels."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, NamedTuple, ParamSpec, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from ..description.chain import ChainJoint
from ..description.changed_description import parameter_values, with_parameters
from ..description.described_rods import lacking_modes
from ..description.leg_description import DescribedMotor
from ..description.loads import Loads
from ..description.motors import MotorLimits
from ..description.robot_description import RobotDescription
from ..errors import DescriptionError, InvalidRequest
from ..kernels.kernel_arrays import LoadArrays, RobotArrays, workspace
from ..kernels.pencil import pencil_of
from ..kernels.prepared_robot import PreparedRobot
from ..kernels.record_layout import EFFORT
from ..rods.quadrature import RodGrid, distinct_stations, rod_grid
from ..validation import cached_array, cached_property, checked_count, read_only
from .fed_rods import FedRods, fed_rods
from .load_arrays import load_arrays
from .motor_limits import MotorLimitArrays, motor_limit_arrays
from .platform_coordinates import PlatformCoordinates, platform_coordinates
from .robot_arrays import robot_arrays
from .state_numbers import StateNumbers, state_numbers
from .strain_matrices import curvature_stations, strain_grams, strain_stiffness, unit_motions

__all__ = ["Robot", "checked_robot", "kept_with_robot"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Found = TypeVar("Found")
Arguments = ParamSpec("Arguments")


def checked_robot(value: object) -> Robot:
    """What a question about a robot takes.

    Raises:
        InvalidRequest: No robot.
    """
    if isinstance(value, Robot):
        return value
    loads = f": load_robot({value!r:.80}) loads one" if isinstance(value, str | Path) else ""
    raise InvalidRequest("robot", f"expected a Robot, got {value!r:.80}{loads}")


def kept_with_robot(
    find: Callable[Concatenate[Robot, Arguments], Found],
    *,
    most: int | None = None,
    by: Callable[Arguments, Hashable] | None = None,
) -> Callable[Concatenate[Robot, Arguments], Found]:
    """Makes of a function of a robot one that finds once, and keeps what it found with the robot.

    What else the function takes is handed in by place, and there is an answer for each of it. Threads
    that ask at once may all search, without waiting for each other; they all get what was found first.
    With options: ``@partial(kept_with_robot, most=100)``.

    Args:
        find: The function.
        most: So many answers are kept, the oldest ones go first; None: all.
        by: What tells arguments apart that are not hashable, or that are not to be kept.
    """

    @wraps(find)
    def kept(robot: Robot, *arguments: Any) -> Found:
        key = arguments if by is None else by(*arguments)  # type: ignore[call-arg]
        known = robot._kept.get(kept)
        if known is None:
            known = robot._kept.setdefault(kept, {})
        try:
            found: Found = known[key]
        except KeyError:
            found = known.setdefault(key, find(robot, *arguments))  # type: ignore[call-arg]
            if most is not None:
                for oldest in list(known)[:-most]:
                    known.pop(oldest, None)
        return found

    return cast("Callable[Concatenate[Robot, Arguments], Found]", kept)


class SquareSystem(NamedTuple):
    """What is solved for, beside the legs, and which equations are.

    Attributes:
        unknowns: State indices.
        equations: State indices, as many.
    """

    unknowns: Integers
    equations: Integers


@dataclass(frozen=True, eq=False, repr=False)
class Robot:
    """A robot with its discretisation. Immutable; everything else is a function of it.

    Attributes:
        description: What the user described.
        held_motors: Numbers of the motors that stay where they are put in the inverse problem, see
            ``holding``.
    """

    description: RobotDescription
    held_motors: tuple[int, ...] = ()
    _kept: dict[Callable[..., Any], dict[Hashable, Any]] = field(default_factory=dict, init=False)
    _last_loads: list[tuple[Loads, LoadArrays]] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        """Look at the motors that are held.

        Raises:
            InvalidRequest: No motors, or not as many as the inverse problem can do without.
        """
        if self.held_motors:
            self._checked_held(self.held_motors)

    def __repr__(self) -> str:
        described = self.description
        return (
            f"<Robot {described.name}: {'planar' if self.planar else 'spatial'}, "
            f"{len(described.legs)} legs, {self.motor_count} motors, "
            f"{sum(rod.modes.total for rod in described.rods)} strain coordinates>"
        )

    def __reduce__(self) -> tuple[type[Robot], tuple[RobotDescription, tuple[int, ...]]]:
        return Robot, (self.description, self.held_motors)

    def holding(self, motors: Sequence[int]) -> Robot:
        """The same robot, with an inverse problem in which some motors are imposed beside the pose.

        The problem has a single solution then.

        Args:
            motors: Numbers of as many motors as the ``redundancy`` says, from 0.

        Raises:
            InvalidRequest: No motors, or not as many as the inverse problem can do without.
        """
        held = self._checked_held(motors)
        return _holding(self, held)

    def _checked_held(self, motors: Sequence[int]) -> tuple[int, ...]:
        """Numbers of motors to hold.

        Raises:
            InvalidRequest: No motors, or not as many as the inverse problem can do without.
        """
        expected = f"numbers of different motors, from 0 to {self.motor_count - 1}"
        if not np.iterable(motors) or isinstance(motors, str):
            raise InvalidRequest("motors", f"expected {expected}, got {motors!r:.200}")
        held = tuple(checked_count("motors", motor, 0, self.motor_count - 1) for motor in motors)
        if len(set(held)) < len(held):
            raise InvalidRequest("motors", f"expected {expected}, got {motors!r:.200}")
        if len(held) != self._spare_motors:
            raise InvalidRequest(
                "motors",
                f"expected {self._spare_motors} to hold, as {self.motor_count} motors move "
                f"{len(self.controlled_axes)} controlled coordinates, got {motors!r:.200}",
            )
        return held

    def parameter_values(self, paths: str | Sequence[str]) -> Floats:
        """Numbers of the description, (P,), in SI units.

        Args:
            paths: Where they are in the description, such as ``rod.young_modulus``,
                ``legs[2].base.position[1]`` or, for the same in two legs or in all,
                ``legs[0,1].motor.offset``, ``legs[*].motor.offset``.

        Raises:
            UnknownParameter: There is no such number.
            InvalidRequest: What is there is no number, or not the same in all of its legs.
        """
        return parameter_values(self.description, paths)

    def with_parameters(self, values: Mapping[str, float]) -> Robot:
        """The same robot with other numbers in its description.

        An equilibrium of this one goes on as one of that one by ``continued``.

        Args:
            values: New numbers by their paths, as ``parameter_values`` takes them.

        Raises:
            UnknownParameter: There is no such number.
            InvalidRequest: What is there or what is given is no number.
            NonFiniteInput: A NaN or an infinity.
            DescriptionError: No robot has such a number.
        """
        return Robot(with_parameters(self.description, values), self.held_motors)

    @property
    def planar(self) -> bool:
        """Whether the robot lives in the plane z = 0."""
        return self.description.planar

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
    def mean_length(self) -> float:
        """Mean (nominal) rod length, the natural unit of length [m]."""
        return self.description.mean_length

    @cached_property
    def platform_axes(self) -> Integers:
        """Components of the world twist [omega; v] the platform has."""
        return self.platform_coordinates.axes

    @cached_property
    def platform_coordinates(self) -> PlatformCoordinates:
        """Motions of the platform, and which of them are controlled."""
        return platform_coordinates(self.description)

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
    def arrays(self) -> RobotArrays:
        """The robot as the kernels see it.

        Raises:
            DescriptionError: A fed rod has no modes in a direction in which it is curved at rest.
        """
        for element in self.description.rods:
            if problem := lacking_modes(element):
                raise DescriptionError(self.description.source, "strain", problem)
        arrays = robot_arrays(self.description, self.grid, self.platform_coordinates, self.numbers)
        if not self.held_motors:
            return arrays
        held = arrays.motor_index + np.array(self.held_motors, np.int64)
        unknowns = np.setdiff1d(arrays.inverse_unknowns, held)
        return arrays._replace(inverse_unknowns=unknowns)

    @cached_property
    def numbers(self) -> StateNumbers:
        """Where everything is in a state."""
        return state_numbers(self.description, self.platform_coordinates)

    @cached_property
    def state_size(self) -> int:
        """Numbers N of a state: of legs, platform and motors."""
        return len(self.numbers.unit)

    @cached_array
    def rest_state(self) -> Floats:
        """State whose rods have no elastic strain, (N,): all else is zero."""
        found = np.zeros(self.state_size)
        for rod in self.numbers.rods:
            found[rod.strain] = rod.element.rod.rest_strain(rod.element.modes)
        return found

    @property
    def prepared(self) -> PreparedRobot:
        """The arrays with the memory of this thread, as entries of the kernels take them."""
        memory = self._memory
        try:
            return memory.prepared
        except AttributeError:
            memory.prepared = PreparedRobot(
                self.arrays, workspace(self.arrays), pencil_of(self.arrays, self.strain_grams)
            )
            return memory.prepared

    @cached_property
    def _memory(self) -> threading.local:
        return threading.local()

    @cached_array
    def motor_indices(self) -> Integers:
        """State indices of the motors."""
        return self.arrays.motor_index + np.arange(self.motor_count)

    @cached_array
    def wrench_units(self) -> Floats:
        """Natural units of a whole wrench, moments E J / l and forces E J / l^2, (6,) [N m, N]."""
        energy = self.arrays.energy_unit
        return np.repeat([energy, energy / self.mean_length], 3)

    @cached_array
    def motor_units(self) -> Floats:
        """Natural units of the motors, (n,): what moves their joints by a radian or a rod length."""
        return self.arrays.unit[self.motor_indices]

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
        limits, positions = self.motor_limits, self.arrays.motor_index
        return limits.motors + np.where(limits.of_effort, self.state_size + EFFORT, positions)

    @cached_array
    def strain_limits(self) -> Floats:
        """Bending strain every rod bears (its yield strain), infinite where not given, (R,)."""
        return np.array([rod.element.rod.yield_strain for rod in self.numbers.rods])

    @cached_property
    def rod_names(self) -> tuple[str, ...]:
        """Names of the rods, (R,): of their legs, numbered where a leg has several."""
        return self.description.rod_names

    @cached_property
    def passive_joints(self) -> tuple[tuple[ChainJoint, int], ...]:
        """The passive joints of all legs, and where they are in the state."""
        return tuple(
            (element, index)
            for leg, numbers in zip(self.description.legs, self.numbers.legs, strict=True)
            for element, index in zip(leg.chain, numbers.coordinates, strict=True)
            if isinstance(element, ChainJoint) and element.passive and index is not None
        )

    @cached_property
    def limits_strain(self) -> bool:
        """Whether any rod has a yield strain."""
        return bool(np.isfinite(self.strain_limits).any())

    @cached_property
    def limits_effort(self) -> bool:
        """Whether the effort of any motor is limited."""
        return bool(self.motor_limits.of_effort.any())

    @cached_property
    def limited(self) -> bool:
        """Whether there are any limits of motors' positions and efforts or of strain."""
        return bool(self.limited_motors) or self.limits_strain

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

    @cached_property
    def fed_rods(self) -> FedRods:
        """The rods that motors feed."""
        return fed_rods(self.numbers.rods, self.arrays.motor_index)

    def rods_exist(self, state: Floats) -> bool:
        """Whether all rods have a length in a state (N,)."""
        return self.fed_rods.exist(state[self.arrays.motor_index :])

    @cached_array
    def platform_indices(self) -> Integers:
        """State indices of the platform twist."""
        return self.arrays.platform_index + np.arange(len(self.platform_axes))

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
        elastic = np.ones(self.arrays.platform_index, np.bool_)
        elastic[self.multiplier_indices] = False
        return np.flatnonzero(elastic)

    @cached_array
    def moving_indices(self) -> Integers:
        """State indices of what moves while the motors are held: leg coordinates, then the platform."""
        return np.concatenate([self.elastic_indices, self.platform_indices])

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
    def redundancy(self) -> int:
        """How many motors there are beyond those the controlled coordinates need; 0 without any."""
        return self._spare_motors - len(self.held_motors)

    @property
    def _spare_motors(self) -> int:
        """The same if none were held."""
        controlled = len(self.controlled_axes)
        return self.motor_count - controlled if controlled else 0

    @cached_property
    def problems(self) -> dict[str, SquareSystem]:
        """Unknowns and equations beside those of the legs, by what is imposed (Section IV-B)."""
        platform, motors = self.platform_indices, self.motor_indices
        both = read_only(np.concatenate([platform, motors]))
        return {
            "motors": SquareSystem(platform, platform),
            "efforts": SquareSystem(both, both),
            "pose": SquareSystem(read_only(self.arrays.inverse_unknowns.copy()), platform),
        }

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

    @cached_array
    def strain_grams(self) -> Floats:
        """Integrals of products of the strain modes of every rod, in state order, (N, N)."""
        return strain_grams(self.numbers, self.grid)

    @cached_array
    def strain_stiffness(self) -> Floats:
        """Elastic stiffness K_e of every rod at its nominal length, in state order, (N, N)."""
        return strain_stiffness(self.numbers, self.grid)

    @cached_property
    def default_loads(self) -> Loads:
        """Loads of the description: gravity, and all that always acts.

        ``robot.default_loads.with_(wrench_world=...)`` keeps all but the wrench;
        ``Loads.none().with_(...)`` is without gravity.
        """
        return self.description.loads

    def load_arrays(self, loads: Loads) -> LoadArrays:
        """Loads as the kernels see them; the last ones are kept.

        Raises:
            InvalidRequest: No loads, or loads that do not fit the robot.
        """
        for last, arrays in self._last_loads:
            if last is loads:
                return arrays
        found = load_arrays(self.description, self.grid, self.breakpoints, self.rod_names, loads)
        self._last_loads[:] = [(loads, found)]
        return found


@kept_with_robot
def _holding(robot: Robot, motors: tuple[int, ...]) -> Robot:
    return Robot(robot.description, motors)

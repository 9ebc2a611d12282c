# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot ready to be solved: the arrays of the kernels, their memory, and motors that are held."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import wraps
from pathlib import Path
from typing import Any, ClassVar, Concatenate, NamedTuple, ParamSpec, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from ..description.changed_description import parameter_values, with_parameters
from ..description.described_rods import lacking_modes
from ..description.loads import Loads
from ..description.robot_description import RobotDescription
from ..errors import DescriptionError, InvalidRequest
from ..kernels.kernel_arrays import LoadArrays, RobotArrays
from ..kernels.pencil import pencil_of
from ..kernels.prepared_robot import PreparedRobot
from ..kernels.record_layout import EFFORT
from ..kernels.workspace_arrays import workspace
from ..validation import cached_property, checked_count, read_only
from .discretised_robot import DiscretisedRobot
from .load_arrays import load_arrays
from .other_names import OF_ROBOTS, OtherNames
from .robot_arrays import robot_arrays

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
        answers = robot._kept.get(kept)
        if answers is None:
            answers = robot._kept.setdefault(kept, {})
        try:
            answer: Found = answers[key]
        except KeyError:
            answer = answers.setdefault(key, find(robot, *arguments))  # type: ignore[call-arg]
            if most is not None:
                for oldest in list(answers)[:-most]:
                    answers.pop(oldest, None)
        return answer

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
class Robot(DiscretisedRobot, OtherNames):
    """A robot with its discretisation. Immutable; everything else is a function of it.

    Attributes:
        description: What the user described.
        held_motors: Numbers of the motors that stay where they are put in the inverse problem, see
            ``holding``.
    """

    held_motors: tuple[int, ...] = ()
    _other_names: ClassVar[Mapping[str, str]] = OF_ROBOTS
    _kept: dict[Callable[..., Any], dict[Hashable, Any]] = field(default_factory=dict, init=False)
    _last_loads: list[tuple[Loads, LoadArrays]] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        """Look at the description, and at the motors that are held.

        Raises:
            InvalidRequest: No description, no motors, or not as many as the inverse problem can do
                without.
        """
        if not isinstance(self.description, RobotDescription):
            got = f"{type(self.description).__name__} {self.description!r:.100}"
            raise InvalidRequest(
                "robot", f"expected a description, got {got}: load_robot makes a robot"
            )
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
        return self.with_description(with_parameters(self.description, values))

    def with_description(self, description: RobotDescription) -> Robot:
        """The robot of another description with as many motors, the same of them held."""
        return Robot(description, self.held_motors)

    @cached_property
    def kernel_arrays(self) -> RobotArrays:
        """The robot as the kernels see it.

        Raises:
            DescriptionError: A fed rod has no modes in a direction in which it is curved at rest.
        """
        for element in self.description.rods:
            if problem := lacking_modes(element):
                raise DescriptionError(self.description.source, "strain", problem)
        arrays = robot_arrays(self)
        if not self.held_motors:
            return arrays
        held = arrays.motor_index + np.array(self.held_motors, np.int64)
        unknowns = np.setdiff1d(arrays.inverse_unknowns, held)
        return arrays._replace(inverse_unknowns=unknowns)

    @cached_property
    def record_size(self) -> int:
        """How many numbers the record of an equilibrium has, see `record_layout`."""
        return self.state_size + EFFORT + self.motor_count

    @property
    def prepared(self) -> PreparedRobot:
        """The arrays with the memory of this thread, as entries of the kernels take them."""
        memory = self._memory
        try:
            return memory.prepared
        except AttributeError:
            memory.prepared = PreparedRobot(
                self.kernel_arrays,
                workspace(self.kernel_arrays),
                pencil_of(self.kernel_arrays, self.strain_grams),
            )
            return memory.prepared

    @cached_property
    def _memory(self) -> threading.local:
        return threading.local()

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
            "pose": SquareSystem(read_only(self.kernel_arrays.inverse_unknowns.copy()), platform),
        }

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
        found = load_arrays(self, loads)
        self._last_loads[:] = [(loads, found)]
        return found


@kept_with_robot
def _holding(robot: Robot, motors: tuple[int, ...]) -> Robot:
    return Robot(robot.description, motors)

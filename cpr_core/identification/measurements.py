# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What was measured of a robot, row by row; what is not there was not measured."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from ..description.controlled_coordinates import pose_of
from ..description.loads import Loads
from ..errors import InvalidRequest, NonFiniteInput
from ..kernels.problems import ProblemName
from ..lie import rotation_from_quaternion
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..validation import cached_property, checked_number, checked_word, read_only

__all__ = [
    "LARGEST_DEVIATION",
    "SMALLEST_DEVIATION",
    "DrivenBy",
    "Frame",
    "Measurement",
    "StandardDeviations",
    "changed_measurement",
    "checked_deviations",
    "checked_measurements",
    "driven_by",
]

Floats = NDArray[np.float64]
#: In which frame a pose was measured.
Frame = Literal["world", "tracker"]

#: Standard deviations, far below the rounding of any number and far beyond any measurement: squares
#: over them are finite, and more than nothing.
SMALLEST_DEVIATION, LARGEST_DEVIATION = 1e-30, 1e30


@dataclass(frozen=True, eq=False)
class Measurement:
    """What was measured at one equilibrium; None is what was not, also in place of single numbers.

    Motors drive the equilibrium where all of them are given. Without them the controlled coordinates of
    the pose drive it, without these the efforts of all motors. All else is compared with what follows.

    A pose is that of the platform in the world, or as the tracker of the description tells it: that of
    the marker in the tracker's frame. One in the tracker's frame drives nothing.

    Attributes:
        motors: Motor positions in motor order, (n,) [rad or m].
        position: Of the platform origin, or of the marker, (3,) [m].
        quaternion_wxyz: Orientation of the platform, or of the marker, (4,), all or nothing.
        efforts: Motor efforts on the rods in motor order, (n,) [N m or N].
        loads: Loads in force; None: those of the description.
        label: What errors call it, such as ``line 7``; empty: its number.
        frame: ``world``, or ``tracker`` for the marker in the tracker's frame.
    """

    motors: Floats | None = None
    position: Floats | None = None
    quaternion_wxyz: Floats | None = None
    efforts: Floats | None = None
    loads: Loads | None = None
    label: str = ""
    frame: Frame = "world"

    def __post_init__(self) -> None:
        """Make arrays of numbers, with NaN where there is none.

        Raises:
            InvalidRequest: No numbers, or too few of them.
            NonFiniteInput: A NaN or an infinity was given.
            InvalidQuaternion: A quaternion far from unit length.
        """
        for name, size in (("motors", 0), ("position", 3), ("quaternion_wxyz", 4), ("efforts", 0)):
            value = _numbers(self.named(name), getattr(self, name), size)
            object.__setattr__(self, name, value)
        if self.loads is not None and not isinstance(self.loads, Loads):
            raise InvalidRequest(self.named("loads"), f"expected Loads, got {self.loads!r:.80}")
        checked_word(self.named("frame"), self.frame, get_args(Frame))
        _ = self.rotation

    def named(self, field: str) -> str:
        """What errors call one of its fields."""
        return f"{self.label}: {field}" if self.label else field

    def predicted_pose(self, equilibrium: Equilibrium) -> tuple[Floats, Floats]:
        """Position, (3,) [m], and rotation, (3, 3), of an equilibrium as this measurement has them."""
        pose = equilibrium.platform_position, equilibrium.platform_rotation
        tracker = equilibrium.robot.description.tracker
        if self.frame == "world" or tracker is None:
            return pose
        return tracker.marker_in_tracker(*pose)

    @cached_property
    def rotation(self) -> Floats | None:
        """The orientation as a matrix, (3, 3); None where it was not measured.

        Raises:
            InvalidQuaternion: A quaternion far from unit length.
        """
        if self.quaternion_wxyz is None:
            return None
        try:
            return read_only(rotation_from_quaternion(self.quaternion_wxyz))
        except InvalidRequest as error:
            raise type(error)(self.named("quaternion_wxyz"), error.problem) from None


def _numbers(name: str, value: Any, size: int) -> Floats | None:
    """Numbers of a field, NaN for None; None where none of them is given.

    Raises:
        InvalidRequest: Something else, another count, or part of a quaternion.
        NonFiniteInput: A NaN or an infinity.
    """
    if value is None:
        return None
    try:
        entries = list(value)
        given = [entry for entry in entries if entry is not None]
        if any(isinstance(entry, str | bytes | bool) for entry in given):
            raise TypeError
        found = np.array([math.nan if entry is None else float(entry) for entry in entries])
    except (TypeError, ValueError):
        raise InvalidRequest(name, f"expected numbers or None, got {value!r:.200}") from None
    if size and len(found) != size:
        raise InvalidRequest(name, f"expected {size} numbers, got {len(found)}")
    if not np.isfinite(np.array(given, float)).all():
        problem = f"expected finite numbers, None where nothing was measured, got {found.tolist()}"
        raise NonFiniteInput(name, problem)
    if not given:
        return None
    if size == 4 and len(given) < size:
        raise InvalidRequest(name, f"expected all of w x y z or none, got {entries}")
    return read_only(found)


@dataclass(frozen=True)
class StandardDeviations:
    """How exact measurements are; None: exact where it drives, an error where it would be compared.

    Noise of what drives a row is carried to what is compared, to first order.

    Attributes:
        position: Of every coordinate of the platform [m].
        rotation: Of the orientation about every axis [rad].
        motors: Of motor positions [rad or m].
        efforts: Of motor efforts [N m or N].
    """

    position: float | None = None
    rotation: float | None = None
    motors: float | None = None
    efforts: float | None = None

    def __post_init__(self) -> None:
        """Check them.

        Raises:
            InvalidRequest: One that is not a positive number, or too small or too large for its square.
        """
        for field in fields(self):
            value = getattr(self, field.name)
            if value is None:
                continue
            number = checked_number(f"deviations.{field.name}", value)
            if not SMALLEST_DEVIATION <= number <= LARGEST_DEVIATION:
                limits = f"from {SMALLEST_DEVIATION:g} to {LARGEST_DEVIATION:g}"
                problem = f"expected a positive standard deviation {limits}, got {value}"
                raise InvalidRequest(f"deviations.{field.name}", problem)

    def of(self, kind: str) -> float:
        """The one of a kind of measurement.

        Raises:
            InvalidRequest: It is not given.
        """
        value: float | None = getattr(self, kind)
        if value is None:
            known = f"expected the standard deviation of {kind}, of which there are measurements"
            raise InvalidRequest(f"deviations.{kind}", known)
        return value


def checked_deviations(deviations: StandardDeviations) -> StandardDeviations:
    """Standard deviations.

    Raises:
        InvalidRequest: They are something else.
    """
    if not isinstance(deviations, StandardDeviations):
        problem = f"expected StandardDeviations(position=..., ...), got {deviations!r:.80}"
        raise InvalidRequest("deviations", problem)
    return deviations


def checked_measurements(robot: Robot, rows: Sequence[Measurement]) -> tuple[Measurement, ...]:
    """Measurements that fit a robot, with labels.

    Raises:
        InvalidRequest: None, numbers of other robots, or a row in which nothing drives the equilibrium.
    """
    if not isinstance(rows, Sequence) or not rows:
        raise InvalidRequest("measurements", f"expected at least one Measurement, got {rows!r:.80}")
    found = []
    for number, row in enumerate(rows):
        if not isinstance(row, Measurement):
            problem = f"expected a Measurement, got {row!r:.80}"
            raise InvalidRequest(f"measurements[{number}]", problem)
        named = row if row.label else changed_measurement(row, label=f"measurements[{number}]")
        for name in ("motors", "efforts"):
            value = getattr(row, name)
            if value is not None and len(value) != robot.motor_count:
                problem = f"expected {robot.motor_count} numbers ({robot.motor_list})"
                raise InvalidRequest(named.named(name), f"{problem}, got {len(value)}")
        if named.frame == "tracker" and robot.description.tracker is None:
            problem = f"expected world, the description of {robot.description.name} has no tracker"
            raise InvalidRequest(named.named("frame"), problem)
        driven_by(robot, named)
        found.append(named)
    return _with_shared_loads(tuple(found))


def _with_shared_loads(rows: tuple[Measurement, ...]) -> tuple[Measurement, ...]:
    """The same, equal loads being one object: what is found for loads is kept with them."""
    known: list[Loads] = []
    found = []
    for row in rows:
        if row.loads is None:
            found.append(row)
            continue
        same = next((loads for loads in known if not loads.differences(row.loads)), None)
        known += [row.loads] if same is None else []
        found.append(row if same is None else changed_measurement(row, loads=same))
    return tuple(found)


def changed_measurement(row: Measurement, **fields: Any) -> Measurement:
    """The same with other fields that need no check: what was not measured is NaN in them."""
    copied = object.__new__(Measurement)
    copied.__dict__.update(row.__dict__ | fields)
    return copied


class DrivenBy(NamedTuple):
    """What an equilibrium follows from.

    Attributes:
        problem: ``motors``, ``pose`` or ``efforts``.
        values: As a request has them.
    """

    problem: ProblemName
    values: Floats


def driven_by(robot: Robot, row: Measurement) -> DrivenBy:
    """What of a row its equilibrium follows from.

    Raises:
        InvalidRequest: Nothing does.
    """
    if row.motors is not None and np.isfinite(row.motors).all():
        return DrivenBy("motors", row.motors)
    if robot.description.controlled and not robot.redundancy and row.frame == "world":
        pose = _pose(robot, row)
        if np.isfinite(pose).all():
            return DrivenBy("pose", pose)
    if row.efforts is not None and np.isfinite(row.efforts).all():
        return DrivenBy("efforts", row.efforts)
    problem = "expected all motors, else all controlled coordinates, else all efforts"
    if row.frame == "tracker":
        problem = "expected all motors, else all efforts: a pose in the tracker's frame drives none"
    raise InvalidRequest(row.label, f"nothing drives this row: {problem}")


def _pose(robot: Robot, row: Measurement) -> Floats:
    """The controlled coordinates of a row as the inverse problem takes them, NaN where not measured."""
    parts = (row.position, (3,)), (row.rotation, (3, 3)), (row.quaternion_wxyz, (4,))
    position, rotation, quaternion = (
        np.full(shape, math.nan) if part is None else part for part, shape in parts
    )
    return pose_of(robot.description.controlled, position, rotation, lambda: quaternion)

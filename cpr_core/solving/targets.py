# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a problem imposes, and the straight path to it from an equilibrium."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidRequest
from ..kernels.natural_units import EFFORT_UNIT
from ..kernels.problems import ProblemName
from ..kernels.record_layout import IMPOSED_MOTORS, POSITION, ROTATION
from ..kernels.twist_layout import FIRST_LINEAR
from ..lie import roll_pitch_yaw, rotation_exp, rotation_from_angles, rotation_log
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot

__all__ = [
    "EffortTarget",
    "Imposed",
    "MotorTarget",
    "PoseTarget",
    "Target",
    "apart",
    "check_rod_lengths",
    "pose_between",
]

Floats = NDArray[np.float64]


class Imposed(NamedTuple):
    """Values a problem is solved for.

    Attributes:
        motors: Motor positions, (n,).
        efforts: Motor efforts, (n,); used where they are imposed.
        rotation: Platform rotation, (3, 3).
        position: Platform position, (3,) [m].
    """

    motors: Floats
    efforts: Floats
    rotation: Floats
    position: Floats


class Target(Protocol):
    """What a problem imposes, and the straight path there."""

    #: Key of ``Robot.problems``.
    problem: ClassVar[ProblemName]

    def distance(self, start: Equilibrium) -> float:
        """How far it is from the start to here, in radians and rod lengths: see ``apart``."""
        ...

    def imposed(self, start: Equilibrium, fraction: float, free: Imposed) -> Imposed:
        """What holds at a fraction of the way from the start; what is not imposed as it is given."""
        ...

    def given(
        self, start: Equilibrium, fraction: float = 1.0, near: Equilibrium | None = None
    ) -> Floats:
        """What holds at a fraction of the way, as the kernels take it: a row of ``continue_equilibria``.

        Args:
            start: Where the way begins.
            fraction: Fraction of the way; default here, at its end.
            near: What is not imposed is as there; default as at the start.
        """
        ...


def check_rod_lengths(robot: Robot, motors: Floats) -> None:
    """Whether motors that set rod lengths leave rods: the shorter, the stiffer without bound.

    Args:
        robot: The robot.
        motors: Motor positions, (..., n) [rad or m].

    Raises:
        InvalidRequest: A rod length of zero or less.
    """
    fed = robot.fed_rods
    if not fed.rods or (lengths := fed.lengths(motors)).min() > 0.0:
        return
    number = int(np.flatnonzero(~(lengths.reshape(-1, len(fed.rods)) > 0.0).all(axis=0))[0])
    motor, length = fed.rods[number].element.motor, lengths[..., number].min()
    raise InvalidRequest("motors", f"{motor}: expected a rod length above 0 m, got {length:g} m")


def apart(robot: Robot, problem: ProblemName, first: Floats, last: Floats) -> Floats:
    """How far it is from imposed values to others, in radians and rod lengths, (...).

    Largest change of a motor; of an effort, with EFFORT_UNIT E J / l (torques) or E J / l^2 as a radian;
    of a pose that of a coordinate of the position or the angle between the orientations; motors held
    beside it do not count.

    Args:
        robot: The robot.
        problem: What is imposed.
        first: Values as ``Target.given`` has them, (..., n), or of a pose (..., 12) or more.
        last: As many.
    """
    largest: Floats
    if problem == "motors":
        largest = np.abs((last - first) / robot.motor_units).max(axis=-1, initial=0.0)
    elif problem == "efforts":
        largest = (np.abs(last - first) * robot.motor_units).max(axis=-1, initial=0.0)
        largest = largest / (EFFORT_UNIT * robot.kernel_arrays.energy_unit)
    else:
        turns, places = slice(ROTATION, POSITION), slice(POSITION, IMPOSED_MOTORS)
        cosines = 0.5 * ((first[..., turns] * last[..., turns]).sum(axis=-1) - 1.0)
        moved = np.abs(last[..., places] - first[..., places]).max(axis=-1) / robot.mean_length
        largest = np.maximum(moved, np.arccos(cosines.clip(-1.0, 1.0)))
    return largest


def _between(first: Floats, last: Floats, fraction: float) -> Floats:
    """Straight from one to the other, to the last bit where they are the same."""
    return last if fraction == 1.0 else first + fraction * (last - first)


@dataclass(frozen=True, eq=False)
class MotorTarget:
    """Motor positions: the forward problem.

    Attributes:
        motors: (n,) [rad or m].
    """

    motors: Floats
    problem: ClassVar[ProblemName] = "motors"

    def distance(self, start: Equilibrium) -> float:
        """Largest change of a motor."""
        return float(apart(start.robot, "motors", start.motors, self.motors))

    def imposed(self, start: Equilibrium, fraction: float, free: Imposed) -> Imposed:
        """Straight in the motor positions."""
        return free._replace(motors=_between(start.motors, self.motors, fraction))

    def given(
        self, start: Equilibrium, fraction: float = 1.0, near: Equilibrium | None = None
    ) -> Floats:
        """The motors, (1, n)."""
        return _between(start.motors, self.motors, fraction)[None].copy()


@dataclass(frozen=True, eq=False)
class EffortTarget:
    """Motor efforts: the forward problem by effort.

    Attributes:
        efforts: (n,) [N m or N].
    """

    efforts: Floats
    problem: ClassVar[ProblemName] = "efforts"

    def distance(self, start: Equilibrium) -> float:
        """Largest change of an effort."""
        return float(apart(start.robot, "efforts", start.efforts, self.efforts))

    def imposed(self, start: Equilibrium, fraction: float, free: Imposed) -> Imposed:
        """Straight in the efforts."""
        return free._replace(efforts=_between(start.efforts, self.efforts, fraction))

    def given(
        self, start: Equilibrium, fraction: float = 1.0, near: Equilibrium | None = None
    ) -> Floats:
        """The efforts, (1, n)."""
        return _between(start.efforts, self.efforts, fraction)[None].copy()


@dataclass(frozen=True, eq=False)
class PoseTarget:
    """Controlled platform coordinates: the inverse problem.

    Attributes:
        rotation: Platform rotation, (3, 3); read where the orientation is controlled.
        position: Platform position, (3,) [m]; read where it is controlled.
        motors: Motor positions, (n,) [rad or m]; read for motors that the robot holds (``holding``);
            None: these stay where they are.
    """

    rotation: Floats
    position: Floats
    motors: Floats | None = None
    problem: ClassVar[ProblemName] = "pose"

    def distance(self, start: Equilibrium) -> float:
        """Distance of the positions, angle between the orientations, or way of a motor that is held.

        As `apart` has it, in a third of its time: control loops ask for one pose after the other.
        """
        robot, way = start.robot, 0.0
        if self.motors is not None and robot.held_motors:
            ways = np.abs(self.motors - start.motors) / robot.motor_units
            way = float(ways[list(robot.held_motors)].max())
        moved = max(map(abs, (self.position - start.platform_position).tolist()))
        turned = 0.0
        if self.rotation is not start.platform_rotation:  # as it is, where no turn is controlled
            cosine = 0.5 * (float(np.vdot(self.rotation, start.platform_rotation)) - 1.0)
            turned = math.acos(min(max(cosine, -1.0), 1.0))
        return max(moved / robot.mean_length, turned, way)

    def imposed(self, start: Equilibrium, fraction: float, free: Imposed) -> Imposed:
        """Straight in the position, single angles and held motors, about one axis in the orientation."""
        motors = self._held(start, fraction, free.motors)
        place = self._placed(start, fraction, free.rotation, free.position)
        return Imposed(motors, free.efforts, *place)

    def given(
        self, start: Equilibrium, fraction: float = 1.0, near: Equilibrium | None = None
    ) -> Floats:
        """Rotation, position and motors, (1, 12 + n)."""
        free = start if near is None else near
        motors = self._held(start, fraction, free.motors)
        row = np.empty(IMPOSED_MOTORS + len(motors))
        rotation, position = self._placed(
            start, fraction, free.platform_rotation, free.platform_position
        )
        row[ROTATION:POSITION] = rotation.ravel()
        row[POSITION:IMPOSED_MOTORS], row[IMPOSED_MOTORS:] = position, motors
        return row[None, :]

    def _held(self, start: Equilibrium, fraction: float, motors: Floats) -> Floats:
        """Motors, those that are held on the straight way."""
        if self.motors is None:
            return motors
        holding, held = list(start.robot.held_motors), motors.copy()
        held[holding] = _between(start.motors, self.motors, fraction)[holding]
        return held

    def _placed(
        self, start: Equilibrium, fraction: float, rotation: Floats, position: Floats
    ) -> tuple[Floats, Floats]:
        """Rotation and position of the platform, what is controlled of them on the way."""
        coordinates, position = start.robot.platform_coordinates, position.copy()
        held = coordinates.controlled_positions
        position[held] = _between(start.platform_position[held], self.position[held], fraction)
        if coordinates.controls_angles:
            rotation = self._angles_between(start, fraction, rotation)
        elif coordinates.controls_turns:
            rotation = self._turned(start, fraction)
        return rotation, position

    def _turned(self, start: Equilibrium, fraction: float) -> Floats:
        """The orientation on the short way, (3, 3)."""
        if fraction == 1.0:
            return self.rotation
        turn = rotation_log(self.rotation @ start.platform_rotation.T)
        return rotation_exp(fraction * turn) @ start.platform_rotation

    def _angles_between(self, start: Equilibrium, fraction: float, rotation: Floats) -> Floats:
        """The controlled angles on the short way, the others as they are."""
        turned = roll_pitch_yaw(self.rotation)
        if fraction != 1.0:  # beyond the end as well: walks by arc length step over it
            first = roll_pitch_yaw(start.platform_rotation)
            turn = turned - first
            turn -= 2.0 * np.pi * np.round(turn / (2.0 * np.pi))
            turned = first + fraction * turn
        axes = start.robot.controlled_axes
        held = axes[axes < FIRST_LINEAR]
        angles = roll_pitch_yaw(rotation)
        angles[held] = turned[held]
        return rotation_from_angles(*angles)


def pose_between(start: Equilibrium, target: PoseTarget, fraction: float) -> PoseTarget:
    """The pose at a fraction of the way to another, what is not controlled as at the start."""
    free = Imposed(start.motors, start.efforts, start.platform_rotation, start.platform_position)
    imposed = target.imposed(start, fraction, free)
    return PoseTarget(imposed.rotation, imposed.position)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the freedom of more motors than controlled coordinates is used for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Literal, Protocol, get_args

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidRequest
from ..model.configurations import SAME_EQUILIBRIUM
from ..model.equilibrium import Equilibrium, firm_margin
from ..model.kinemato_statics import kinemato_statics
from ..validation import checked_word
from .held_walks import self_motions

__all__ = [
    "OBJECTIVES",
    "GreatestMargin",
    "LeastEffort",
    "LeastMotion",
    "Objective",
    "ObjectiveName",
    "Probe",
    "objective_of",
]

Floats = NDArray[np.float64]
ObjectiveName = Literal["least_motion", "least_effort", "greatest_margin"]
OBJECTIVES: tuple[ObjectiveName, ...] = get_args(ObjectiveName)

#: An equilibrium at the same pose, its motors moved along the null space by about so much
#: (dimensionless, (n,)); None where there is none near by.
Probe = Callable[[Floats], Equilibrium | None]


class Objective(Protocol):
    """What is made least at a pose. Motors count in radians and rod lengths."""

    #: Its name in requests and answers.
    name: ClassVar[ObjectiveName]
    #: A change of the motors below this is none.
    tolerance: ClassVar[float]
    #: Equilibria nearer than this, dimensionless, are one that was reached by two ways.
    same: ClassVar[float]

    def value(self, equilibrium: Equilibrium) -> float:
        """What is made least, dimensionless."""
        ...

    def slope(self, equilibrium: Equilibrium, directions: Floats, probe: Probe) -> Floats:
        """Derivatives along self-motions.

        Args:
            equilibrium: Where.
            directions: Self-motions, orthonormal columns, (n, r).
            probe: Finds equilibria beside it.

        Returns:
            (r,)
        """
        ...

    def curvature(self, equilibrium: Equilibrium, directions: Floats) -> Floats:
        """A first guess of the second derivatives along self-motions, positive definite, (r, r)."""
        ...


@dataclass(frozen=True, eq=False)
class LeastMotion:
    """The motors move as little as possible, by the sum of squares.

    Attributes:
        motors: Where they move from, (n,) [rad or m].
    """

    motors: Floats
    name: ClassVar[ObjectiveName] = "least_motion"
    tolerance: ClassVar[float] = 1e-7
    same: ClassVar[float] = SAME_EQUILIBRIUM

    def value(self, equilibrium: Equilibrium) -> float:
        """Half the square of the way."""
        return 0.5 * float(np.sum(_way(equilibrium, self.motors) ** 2))

    def slope(self, equilibrium: Equilibrium, directions: Floats, probe: Probe) -> Floats:
        """The way, along the directions."""
        return _way(equilibrium, self.motors) @ directions

    def curvature(self, equilibrium: Equilibrium, directions: Floats) -> Floats:
        """Of straight ways."""
        return np.eye(directions.shape[1])

    def __str__(self) -> str:
        motors = ", ".join(f"{motor!r}" for motor in self.motors.tolist())
        return f"{self.name} from motors ({motors})"


@dataclass(frozen=True, eq=False)
class LeastEffort:
    """The sum of squares of the efforts is least, torques in E J / l and forces in E J / l^2.

    Along self-motions that change no effort, as of a coarse and a fine motor about one axis, all is
    equally little: what rounding leaves there is no slope, and the motors move as little as possible.

    Attributes:
        motors: Where they move from, (n,) [rad or m].
    """

    motors: Floats
    name: ClassVar[ObjectiveName] = "least_effort"
    tolerance: ClassVar[float] = 1e-9
    same: ClassVar[float] = SAME_EQUILIBRIUM

    #: Changes of the efforts by less of what the motors' motions change them by are rounding.
    _ROUNDING: ClassVar[float] = 1e-9

    def value(self, equilibrium: Equilibrium) -> float:
        """Half the sum of squares, and that of the way along what changes no effort."""
        efforts = equilibrium.efforts * _per_effort(equilibrium)
        directions = self_motions(kinemato_statics(equilibrium))
        idle = self._sensitivity(equilibrium, directions)[1]
        way = _way(equilibrium, self.motors) @ directions @ idle.T
        return 0.5 * float(np.sum(efforts**2) + np.sum(way**2))

    def slope(self, equilibrium: Equilibrium, directions: Floats, probe: Probe) -> Floats:
        """By the effort sensitivity; the way along what changes no effort."""
        efforts = equilibrium.efforts * _per_effort(equilibrium)
        sensitivity, idle = self._sensitivity(equilibrium, directions)
        way = _way(equilibrium, self.motors) @ directions
        return np.asarray(efforts @ sensitivity + way @ idle.T @ idle)

    def curvature(self, equilibrium: Equilibrium, directions: Floats) -> Floats:
        """As if the sensitivity stayed (Gauss-Newton); of straight ways along what changes no effort."""
        sensitivity, idle = self._sensitivity(equilibrium, directions)
        found = sensitivity.T @ sensitivity
        return np.asarray(found + 1e-9 * np.trace(found) * np.eye(len(found)) + idle.T @ idle)

    def __str__(self) -> str:
        return self.name

    def _sensitivity(self, equilibrium: Equilibrium, directions: Floats) -> tuple[Floats, Floats]:
        """Change of the efforts along self-motions, (n, r), and those that change none, rows of r."""
        by_motors = kinemato_statics(equilibrium).efforts_by_motors * equilibrium.robot.motor_units
        by_motors = _per_effort(equilibrium)[:, None] * by_motors
        found = by_motors @ directions
        _, changes, motions = np.linalg.svd(found)
        idle = motions[changes < self._ROUNDING * max(1.0, float(np.linalg.norm(by_motors)))]
        return np.asarray(found - found @ idle.T @ idle), np.asarray(idle)


@dataclass(frozen=True, eq=False)
class GreatestMargin:
    """The margin of stability with the motors held is greatest."""

    name: ClassVar[ObjectiveName] = "greatest_margin"
    tolerance: ClassVar[float] = 1e-6
    #: The margin is flat at its greatest: where a search ends, motors are 1e-4 from there, forces 1e-3.
    same: ClassVar[float] = 1e-2

    #: Way of the differences: their error and that of the margins are then alike.
    _WAY: ClassVar[float] = 1e-3

    def value(self, equilibrium: Equilibrium) -> float:
        """The margin, or that of what costs elastic energy, negative."""
        return -firm_margin(equilibrium)

    def slope(self, equilibrium: Equilibrium, directions: Floats, probe: Probe) -> Floats:
        """By central differences, on one side where there is no equilibrium on the other."""
        found, centre = [], self.value(equilibrium)
        for direction in directions.T:
            ways, values = [0.0], [centre]
            for way in (-self._WAY, self._WAY):
                beside = probe(way * direction)
                if beside is not None:
                    ways.append(way)
                    values.append(self.value(beside))
            found.append((values[-1] - values[-2]) / (ways[-1] - ways[-2]) if ways[1:] else 0.0)
        return np.array(found)

    def __str__(self) -> str:
        return self.name

    def curvature(self, equilibrium: Equilibrium, directions: Floats) -> Floats:
        """A radian for a margin of 1: what is right is learnt on the way."""
        return np.eye(directions.shape[1])


def objective_of(start: Equilibrium, problem: str, name: str | None) -> Objective | None:
    """The objective of a request; None where it leaves no freedom.

    Args:
        start: Where motions begin.
        problem: What is imposed: ``motors``, ``pose`` or ``efforts``.
        name: One of ``OBJECTIVES``; None: least motion.

    Raises:
        InvalidRequest: Another name, or one where there is no freedom.
    """
    if name is not None:
        checked_word("objective", name, OBJECTIVES)
    if problem == "pose" and start.robot.redundancy > 0:
        if name == "least_effort":
            return LeastEffort(start.motors)
        return GreatestMargin() if name == "greatest_margin" else LeastMotion(start.motors)
    if name is not None:
        robot = start.robot.description.name
        reason = (
            f"{robot} has no more motors than controlled coordinates"
            if problem == "pose"
            else f"{problem} are imposed"
        )
        raise InvalidRequest("objective", f"expected none: {reason}, got {name!r}")
    return None


def _way(equilibrium: Equilibrium, motors: Floats) -> Floats:
    """Of the motors from where they were, dimensionless, (n,)."""
    return np.asarray((equilibrium.motors - motors) / equilibrium.robot.motor_units)


def _per_effort(equilibrium: Equilibrium) -> Floats:
    """One over the natural units of the efforts, (n,)."""
    robot = equilibrium.robot
    return np.asarray(robot.motor_units / robot.kernel_arrays.energy_unit)

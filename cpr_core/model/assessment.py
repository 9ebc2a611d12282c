# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What an equilibrium is measured by before a robot may move there."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from ..validation import cached_property
from .bending_strain import bending_strains, strain_reserves
from .equilibrium import Equilibrium
from .kinemato_statics import KinematoStatics, kinemato_statics
from .linear_problems import LinearProblem, Singularity

__all__ = [
    "DEFAULT_THRESHOLDS",
    "MEASURES",
    "Assessment",
    "Measure",
    "Threshold",
    "Thresholds",
    "crossed_thresholds",
    "thresholds_problem",
]

#: Least distance of a warning from its stop where levels are computed: finite, so that these are.
_NO_WAY = 1e-9


@dataclass(frozen=True)
class Threshold:
    """Two values of a measure. A warning that is not above its stop counts as if it were equal to it.

    Attributes:
        warning: Below it motion towards the danger slows down, linearly.
        stop: Below it no motion towards the danger is allowed.
    """

    warning: float
    stop: float

    def level(self, value: float) -> float:
        """1 at the warning, 0 at the stop, linear everywhere; NaN of NaN."""
        return (value - self.stop) / max(self.warning - self.stop, _NO_WAY)

    @property
    def crossed(self) -> bool:
        """Whether nothing slows the robot down before it halts."""
        return self.stop >= self.warning


#: A threshold for every measure.
Thresholds = Mapping[str, Threshold]


@dataclass(frozen=True)
class Measure:
    """What a robot is watched by on its way: falls towards what it warns of.

    Attributes:
        threshold: Of whoever names no other.
        event: Kind of a ``PathEvent`` where nothing of it is left; empty: no way ends there.
        of_poses: Whether it counts on the way to poses only.
    """

    threshold: Threshold
    event: str = ""
    of_poses: bool = False


#: All measures by name, each a property of :class:`Assessment`. Parameters of the node repeat the
#: thresholds: its --help does not wait for this.
MEASURES: Mapping[str, Measure] = {
    "margin": Measure(Threshold(0.2, 0.05), "stability"),
    "forward_singularity": Measure(Threshold(1e-4, 2e-5)),
    "inverse_singularity": Measure(Threshold(2e-3, 5e-4), of_poses=True),
    "motor_range": Measure(Threshold(0.05, 0.0), "motor_limit"),
    "effort_reserve": Measure(Threshold(0.2, 0.02), "effort_limit"),
    "strain_reserve": Measure(Threshold(0.2, 0.05), "strain_limit"),
}
DEFAULT_THRESHOLDS: Thresholds = {name: each.threshold for name, each in MEASURES.items()}


def thresholds_problem(thresholds: Thresholds, ordered: Collection[str]) -> str:
    """Why thresholds cannot be used; empty if they can.

    Args:
        thresholds: Of every measure.
        ordered: Measures whose stop has to be below its warning.
    """
    for name, threshold in thresholds.items():
        if not np.isfinite([threshold.warning, threshold.stop]).all():
            return (
                f"expected finite thresholds, got {name}_warning {threshold.warning}, "
                f"{name}_stop {threshold.stop}"
            )
        if name in ordered and threshold.crossed:
            return (
                f"expected {name}_stop below {name}_warning, "
                f"got {threshold.stop} and {threshold.warning}"
            )
    return ""


def crossed_thresholds(thresholds: Thresholds) -> list[str]:
    """What is to be said about thresholds in the wrong order, one line each."""
    return [
        f"{name}_warning {threshold.warning} is not above {name}_stop {threshold.stop}: the robot "
        f"halts at {threshold.stop} without slowing down before"
        for name, threshold in thresholds.items()
        if threshold.crossed
    ]


@dataclass(frozen=True, eq=False)
class Assessment:
    """An equilibrium and its measures, each computed when it is first asked for.

    Attributes:
        equilibrium: The equilibrium.
        characteristic_length: Weighs rotations in singular values [m]; None: mean rod length.
        solve_time: Wall time of the solve [s].
    """

    equilibrium: Equilibrium
    characteristic_length: float | None = None
    solve_time: float = 0.0

    @cached_property
    def kinemato_statics(self) -> KinematoStatics:
        """First-order behaviour."""
        return kinemato_statics(self.equilibrium)

    @cached_property
    def forward(self) -> Singularity:
        """Distance of the forward problem from a singularity."""
        return self.kinemato_statics.singularity("forward", self.characteristic_length)

    @cached_property
    def inverse(self) -> Singularity | None:
        """Distance of the inverse problem from a singularity; None where there is no such problem."""
        if not self.equilibrium.robot.description.controlled:
            return None
        return self.kinemato_statics.singularity("inverse", self.characteristic_length)

    @property
    def index(self) -> int:
        """Negative eigenvalues of H_r, motors held."""
        return self.equilibrium.index_locked

    @property
    def margin(self) -> float:
        """Smallest eigenvalue of H_r relative to the elastic stiffness, motors held."""
        return self.equilibrium.margin

    @cached_property
    def forward_singularity(self) -> float:
        """Smallest singular value of the forward problem."""
        return self._smallest("forward")

    @cached_property
    def inverse_singularity(self) -> float:
        """Smallest singular value of the inverse problem; infinite where there is none."""
        return (
            self._smallest("inverse") if self.equilibrium.robot.description.controlled else np.inf
        )

    def _smallest(self, problem: LinearProblem) -> float:
        return self.kinemato_statics.smallest_singular_value(problem, self.characteristic_length)

    @cached_property
    def motor_range(self) -> float:
        """Smallest distance of a motor from its position limits, in radians and rod lengths."""
        robot = self.equilibrium.robot
        # In lists: a control loop asks, and numpy takes longer on so few numbers.
        motors, units = self.equilibrium.motors.tolist(), robot.motor_units.tolist()
        return min(
            (
                min(motors[number] - motor.limits.lower, motor.limits.upper - motors[number])
                / units[number]
                for number, motor in robot.limited_motors
            ),
            default=math.inf,
        )

    @cached_property
    def effort_reserve(self) -> float:
        """1 - |effort| / limit, the smallest over the motors."""
        efforts = self.equilibrium.efforts.tolist()
        return min(
            (
                1.0 - abs(efforts[number]) / motor.limits.effort
                for number, motor in self.equilibrium.robot.limited_motors
                if motor.limits.effort < math.inf
            ),
            default=math.inf,
        )

    @cached_property
    def strain_reserve(self) -> float:
        """1 - bending strain / yield strain, the smallest over the rods."""
        robot = self.equilibrium.robot
        if not robot.limits_strain:
            return np.inf
        return float(strain_reserves(robot, bending_strains(self.equilibrium)).min())

    def value(self, measure: str) -> float:
        """A measure by name."""
        return float(getattr(self, measure))

"""From one equilibrium to a requested one, along a straight path in what the request imposes.

A way of up to half a radian or half a rod length is tried in one step, a longer one in several. A
step is accepted only if every Newton correction contracts, so the solution belongs to the branch of
the start; otherwise the step is halved. A request that cannot be reached this way is an error, never
another branch.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from .arrays import LoadArrays, workspace
from .equilibrium import RESIDUAL_TOLERANCE, Equilibrium
from .errors import NoSolution
from .lie import roll_pitch_yaw, rotation_exp, rotation_from_angles, rotation_log
from .loads import Loads
from .newton_kernel import CONVERGED, newton

__all__ = ["EffortTarget", "MotorTarget", "PlatformTarget", "Target", "follow"]

Floats = NDArray[np.float64]

#: A correction must be smaller than this times the one before.
CONTRACTION = 0.5
#: Newton steps of one path step.
ITERATIONS = 12
#: Smallest path step before the path is given up, as a fraction of the way.
SMALLEST_STEP = 1e-4
#: Longest path step in what is imposed, in radians and rod lengths. A motor several turns away looks
#: near to Newton's method, yet the rod has to be wound there.
LONGEST_STEP = 0.5
#: Requests farther away than so many longest steps are refused at once.
MOST_STEPS = 1000


class Imposed:
    """Values a problem is solved for, all arrays written in place.

    Attributes:
        motors: Motor positions, (n,).
        efforts: Motor efforts, (n,); used where they are imposed.
        rotation: Platform rotation, (3, 3).
        position: Platform position, (3,) [m].
    """

    __slots__ = ("efforts", "motors", "position", "rotation")

    def __init__(self, motors: Floats, efforts: Floats, rotation: Floats, position: Floats) -> None:
        """Take the arrays over."""
        self.motors, self.efforts = motors, efforts
        self.rotation, self.position = rotation, position


class Target(Protocol):
    """What a problem imposes, and the straight path there."""

    #: Key of ``Robot.problems``.
    problem: ClassVar[str]

    def distance(self, start: Equilibrium) -> float:
        """How far it is from the start to here, in radians and rod lengths."""
        ...

    def impose(self, start: Equilibrium, fraction: float, values: Imposed) -> None:
        """Write what holds at a fraction of the way from the start."""
        ...


@dataclass(frozen=True, eq=False)
class MotorTarget:
    """Motor positions: the forward problem.

    Attributes:
        motors: (n,) [rad or m].
    """

    motors: Floats
    problem: ClassVar[str] = "motors"

    def distance(self, start: Equilibrium) -> float:
        """Largest change of a motor."""
        if not self.motors.size:
            return 0.0
        return float(np.abs((self.motors - start.motors) / start.robot.motor_units).max())

    def impose(self, start: Equilibrium, fraction: float, values: Imposed) -> None:
        """Straight in the motor positions."""
        values.motors[:] = (1.0 - fraction) * start.motors + fraction * self.motors


@dataclass(frozen=True, eq=False)
class EffortTarget:
    """Motor efforts: the forward problem by effort.

    Attributes:
        efforts: (n,) [N m or N].
    """

    efforts: Floats
    problem: ClassVar[str] = "efforts"

    def distance(self, start: Equilibrium) -> float:
        """Nothing: efforts have no turns, Newton's method sees how far they are."""
        return 0.0

    def impose(self, start: Equilibrium, fraction: float, values: Imposed) -> None:
        """Straight in the efforts."""
        values.efforts[:] = (1.0 - fraction) * start.efforts + fraction * self.efforts


@dataclass(frozen=True, eq=False)
class PlatformTarget:
    """Controlled platform coordinates: the inverse problem.

    Attributes:
        rotation: Platform rotation, (3, 3); read where the orientation is controlled.
        position: Platform position, (3,) [m]; read where it is controlled.
    """

    rotation: Floats
    position: Floats
    problem: ClassVar[str] = "platform"

    def distance(self, start: Equilibrium) -> float:
        """Distance of the positions."""
        moved = float(np.max(np.abs(self.position - start.platform_position)))
        return moved / start.robot.mean_length

    def impose(self, start: Equilibrium, fraction: float, values: Imposed) -> None:
        """Straight in the position and in single angles, about one axis in the whole orientation."""
        axes = start.robot.controlled_axes
        held = axes[axes >= 3] - 3
        between = (1.0 - fraction) * start.platform_position + fraction * self.position
        values.position[held] = between[held]
        if start.robot.controls_angles:
            values.rotation[:] = self._angles_between(start, fraction, values.rotation)
        elif len(held) < len(axes):
            turn = rotation_log(self.rotation @ start.platform_rotation.T)
            values.rotation[:] = rotation_exp(fraction * turn) @ start.platform_rotation

    def _angles_between(self, start: Equilibrium, fraction: float, rotation: Floats) -> Floats:
        """The controlled angles on the short way, the others as they are."""
        first = roll_pitch_yaw(start.platform_rotation)
        turn = roll_pitch_yaw(self.rotation) - first
        turn -= 2.0 * np.pi * np.round(turn / (2.0 * np.pi))
        axes = start.robot.controlled_axes
        held = axes[axes < 3]
        angles = roll_pitch_yaw(rotation)
        angles[held] = (first + fraction * turn)[held]
        return rotation_from_angles(*angles)


def follow(start: Equilibrium, target: Target, loads: Loads) -> Equilibrium:
    """Follow the branch of an equilibrium until a target is met.

    Args:
        start: Equilibrium to start from.
        target: What to impose.
        loads: Loads to arrive with; they change along the way as well.

    Returns:
        The equilibrium on the same branch.

    Raises:
        NoSolution: With the fraction of the way and the last equilibrium on it.
    """
    path = _Path(start, target, loads)
    steps = target.distance(start) / LONGEST_STEP
    if not steps <= MOST_STEPS:
        raise NoSolution("it is too far away to be followed there", 0.0, start)
    longest = 1.0 / max(1.0, steps)
    reached, step, here, iterations = 0.0, longest, start, 0
    while reached < 1.0:
        ahead = min(1.0, reached + step)
        result, used = path.step(here, ahead)
        iterations += used
        if result is None:
            step = 0.5 * (ahead - reached)
            if step < SMALLEST_STEP * longest:
                raise NoSolution(
                    "no equilibrium is near the last one on the way",
                    reached,
                    here,
                )
            continue
        here, step, reached = result, min(longest, 2.0 * (ahead - reached)), ahead
    return here if here.iterations == iterations else replace(here, iterations=iterations)


class _Path:
    """The straight path to a target and one solve on it."""

    def __init__(self, start: Equilibrium, target: Target, loads: Loads) -> None:
        robot = start.robot
        self.robot, self.start, self.target, self.loads = robot, start, target, loads
        self.loads_change = loads is not start.loads
        self.last_loads = robot.load_arrays(loads) if self.loads_change else start.load_arrays
        self.columns, self.rows = robot.problems[target.problem]
        self.angles = target.problem == "platform" and robot.controls_angles
        size = len(robot.arrays.unit)
        self.residual, self.tangent = np.empty(size), np.zeros((size, size))
        self.work = workspace(robot.arrays)

    def loads_at(self, fraction: float) -> LoadArrays:
        """Loads part of the way; all entries are linear in what is given."""
        if not self.loads_change or fraction == 1.0:
            return self.last_loads
        pairs = zip(self.start.load_arrays, self.last_loads, strict=True)
        return LoadArrays(*[(1.0 - fraction) * first + fraction * last for first, last in pairs])

    def step(self, here: Equilibrium, fraction: float) -> tuple[Equilibrium | None, int]:
        """Solve at a fraction of the way, starting from an equilibrium before it."""
        robot, motor_index = self.robot, self.robot.arrays.motor_index
        state, efforts = here.state.copy(), np.zeros(robot.motor_count)
        rotation, position = here.platform_rotation.copy(), here.platform_position.copy()
        self.target.impose(
            self.start, fraction, Imposed(state[motor_index:], efforts, rotation, position)
        )
        lengths = robot.length_indices
        if lengths.size and state[lengths].min() <= 0.0:
            return None, 0
        loads = self.loads_at(fraction)
        status, iterations, largest, energy = newton(
            robot.arrays, loads, state, rotation, position, self.columns, self.rows, self.angles,
            efforts, RESIDUAL_TOLERANCE, ITERATIONS, CONTRACTION, self.residual, self.tangent, self.work,
        )  # fmt: skip
        if status != CONVERGED or (lengths.size and state[lengths].min() <= 0.0):
            return None, iterations
        result = Equilibrium(
            robot=robot,
            loads=self.loads,
            state=state,
            platform_rotation=rotation,
            platform_position=position,
            efforts=self.residual[motor_index:].copy(),
            residual=largest,
            iterations=iterations,
            energy=energy,
            load_arrays=loads,
        )
        return result, iterations

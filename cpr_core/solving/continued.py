# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""An equilibrium goes on as one of the same robot with other parameters.

The numbers of the description change along a straight way while motors, pose or efforts are held. A step
is taken where Newton's method contracts, the robot moves little and nothing happens to the signs of its
tangent, as along any other path.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..description.changed_description import between, check_numbers_only
from ..description.inherited_loads import inherited_loads
from ..description.loads import Loads
from ..description.robot_description import RobotDescription
from ..errors import DescriptionError, InvalidRequest
from ..kernels.continuation_kernel import UNPREDICTED
from ..kernels.natural_units import LONGEST_STEP
from ..kernels.problems import ProblemName
from ..model.equilibrium import Equilibrium, check_equilibrium
from ..model.equilibrium_steps import stepped
from ..model.robot import Robot, checked_robot, kept_with_robot
from .deadline import Deadline
from .events import EventKind, PathEvent
from .held_problem import checked_problem, held
from .limits import check_limits
from .not_reached import NotReached, refusal_of
from .path import Path, Point
from .targets import PoseTarget

__all__ = ["continued"]

#: Steps smaller than this part of the way are not tried.
_SMALLEST_STEP = 1e-4


def continued(
    start: Equilibrium,
    robot: Robot,
    problem: ProblemName = "motors",
    *,
    stable_only: bool = False,
    time_limit: float | None = None,
) -> Equilibrium:
    """The equilibrium of a robot with other parameters, on the branch of one that is known.

    Args:
        start: Equilibrium of the robot as it was.
        robot: The same with other numbers in its description (``Robot.with_parameters``).
        problem: What is held: ``motors``, ``pose`` or ``efforts``. Loads of the description change with
            it, those of a request do not.
        stable_only: Refuse to pass or reach an unstable equilibrium.
        time_limit: Give up after this time [s]; default never.

    Raises:
        InvalidRequest: No equilibrium, a robot that differs in more than numbers, or no problem it has.
        NoForwardSolution: A singularity lies between the parameters, motors or efforts held.
        NoInverseSolution: The same, with the pose held.
        MotorLimitExceeded: A motor would be beyond its position range or effort.
        StrainLimitExceeded: A rod would yield.
        UnstableEquilibrium: Stability ends on the way, and only stable equilibria were asked for.
        TimeLimitExceeded: The time allowed was over.
    """
    check_equilibrium(start)
    checked_robot(robot)
    if robot.held_motors != start.robot.held_motors or robot.state_size != start.robot.state_size:
        same = "the same legs, numbers of modes and held motors"
        raise InvalidRequest(
            "robot", f"expected the robot of the start with other parameters: {same}"
        )
    _check_numbers_only(robot, start.robot.description)
    checked_problem(start.robot, problem)
    walk = _Walk(start, robot, problem, stable_only, Deadline(time_limit))
    found = walk.end()
    check_limits(found)
    return found


@partial(kept_with_robot, most=1)
def _check_numbers_only(last: Robot, first: RobotDescription) -> None:
    """Whether a robot differs from a description in numbers only.

    Raises:
        InvalidRequest: It differs in more.
    """
    check_numbers_only(first, last.description)


@dataclass(frozen=True, eq=False)
class _Walk:
    """A way through robots between two.

    Attributes:
        start: Where it begins.
        robot: Where it ends.
        problem: What is held.
        stable_only: Whether stability must not end.
        deadline: When to give up.
    """

    start: Equilibrium
    robot: Robot
    problem: ProblemName
    stable_only: bool
    deadline: Deadline

    def end(self) -> Equilibrium:
        """The equilibrium at the end.

        Raises:
            NotReached: It is not reached.
        """
        reached = self._point(0.0, self.start)
        if self.stable_only and (reached.index > 0 or not self._conservative(self.start.loads)):
            raise self._stopped(
                "stability", reached, reached, "the start is not known to be stable"
            )
        fraction, step = 0.0, 1.0
        iterations = 0
        while fraction < 1.0:
            if self.deadline.over:
                raise self._stopped("time_limit", reached, reached, "the time allowed was over")
            ahead = min(1.0, fraction + step)
            found = self._at(reached.equilibrium, ahead)
            if found is None or self._happens(reached, found):
                if step > _SMALLEST_STEP:
                    step = 0.5 * (ahead - fraction)
                    continue
                raise self._refused(reached, found)
            iterations += found.equilibrium.iterations
            fraction, reached, step = ahead, found, 2.0 * step
        return reached.equilibrium.with_iterations(iterations)

    def _at(self, before: Equilibrium, fraction: float) -> Point | None:
        """The equilibrium part of the way, from one near by; None where none is near."""
        robot = self._robot(fraction)
        if robot is None:
            return None
        loads = inherited_loads(
            self.start.loads, self.start.robot.default_loads, robot.default_loads
        )
        load_arrays = robot.load_arrays(loads)
        target = held(self.start, self.problem)
        given = target.given(self.start)
        found = stepped(before, robot, loads, load_arrays, self.problem, given, UNPREDICTED)
        return self._point(fraction, found) if found is not None and _near(before, found) else None

    def _robot(self, fraction: float) -> Robot | None:
        """The robot part of the way; None where there is none."""
        if fraction == 1.0:
            return self.robot
        first = self.start.robot
        try:
            description = between(first.description, self.robot.description, fraction)
        except DescriptionError:
            return None
        return first.with_description(description)

    def _point(self, fraction: float, equilibrium: Equilibrium) -> Point:
        """With its signs, as on any path."""
        path = Path(equilibrium, held(equilibrium, self.problem), equilibrium.loads)
        return replace(path.begin(), fraction=fraction)

    def _happens(self, low: Point, high: Point) -> bool:
        """Whether a singularity of the problem, or the end of what was asked for, lies between."""
        if low.sign != high.sign:
            return True
        if not self._conservative(high.equilibrium.loads):
            return self.stable_only
        if self.problem == "pose":
            return self.stable_only and high.index > 0
        return low.index != high.index

    def _conservative(self, loads: Loads) -> bool:
        return self.robot.has_potential(loads)

    def _refused(self, low: Point, high: Point | None) -> NotReached:
        """The error where no step leads on."""
        if high is None:
            return self._stopped("lost", low, low, "no equilibrium is near the last one")
        change = f"index {low.index} -> {high.index}"
        if self.stable_only and high.index > 0:
            return self._stopped("stability", low, high, f"stability is lost ({change})")
        if self.problem == "pose":
            return self._stopped("singularity", low, high, "an inverse singularity is passed")
        return self._stopped("bifurcation", low, high, f"a singularity is passed ({change})")

    def _stopped(self, kind: EventKind, low: Point, high: Point, text: str) -> NotReached:
        """The error of a way that ended early."""
        event = PathEvent(kind, low.fraction, low.equilibrium, low.index, high.index, text)
        message = (
            f"parameters: not reached with the {self.problem} held, {text}: the branch could be "
            f"followed over {100.0 * low.fraction:.2f} % of the way"
        )
        return refusal_of(event, message, low.equilibrium, self.problem, self.stable_only)


def _near(before: Equilibrium, after: Equilibrium) -> bool:
    """Whether platform and motors moved no farther than a step may."""
    pose = PoseTarget(after.platform_rotation, after.platform_position).distance(before)
    motors = np.abs(after.motors - before.motors) / before.robot.motor_units
    return max(pose, float(motors.max(initial=0.0))) <= LONGEST_STEP

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Small steps of robots: where the warm solves that are measured go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from cpr_core import (
    Equilibrium,
    NotReached,
    Robot,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
)
from paper.cases import RFRFR, SIX_RFS, Case

__all__ = ["PAPER_CASES", "PROBLEMS", "ROBOTS", "SOLVERS", "Walk", "robot_with", "walk_of"]

ROBOTS = ("rfrfr", "planar_body", "three_rfs", "six_rfs", "gough_stewart", "six_rus")
PROBLEMS = {"forward": "motors", "inverse": "pose", "by effort": "efforts"}
SOLVERS: dict[str, Callable[..., Equilibrium]] = {
    "forward": solve_forward,
    "inverse": solve_inverse,
    "by effort": solve_forward_by_effort,
}
#: Robots that walk on the motor paths of the paper, 1/50 of the path a step.
PAPER_CASES = {case.name: case for case in (RFRFR, SIX_RFS)}
#: Motor steps of the others [rad].
MOTOR_STEPS = {
    "planar_body": (0.02, -0.01, 0.01),
    "six_rus": (0.01, -0.005, 0.008, 0.005, -0.01, 0.003),
    "three_rfs": (0.02, -0.01, 0.01),
}
#: Pose step of the robot with extensible legs, 1.4 mm [m].
POSE_STEP = 1.4e-3 / np.sqrt(3.0) * np.ones(3)
#: Steps of robots that have no path in the paper.
STEPS = 20
#: Steps of inverse problems that end before poses come near an inverse singularity: there the steps are
#: cut into many, and say nothing about one.
INVERSE_STEPS = {"rfrfr": 35, "six_rfs": 28}
#: A walk shorter than this says nothing about many solves.
SHORTEST = 5


@dataclass(frozen=True, eq=False)
class Walk:
    """Requests one after the other, each from the solution before.

    Attributes:
        problem: ``forward``, ``inverse`` or ``by effort``.
        start: Equilibrium to start from.
        requests: Values given, one row a step.
    """

    problem: str
    start: Equilibrium
    requests: tuple[NDArray[np.float64], ...]

    def run(self) -> Equilibrium:
        """Solve for all of them; the last equilibrium."""
        solve, robot, last = SOLVERS[self.problem], self.start.robot, self.start
        for request in self.requests:
            last = solve(robot, request, start=last)
        return last

    def equilibria(self) -> tuple[Equilibrium, ...]:
        """The same, all of them."""
        solve, robot, found = SOLVERS[self.problem], self.start.robot, [self.start]
        for request in self.requests:
            found.append(solve(robot, request, start=found[-1]))
        return tuple(found[1:])


@cache
def robot_with(name: str, modes: int) -> Robot:
    """A shipped robot with so many modes per direction."""
    return load_robot(name, modes=modes)


@cache
def walk_of(name: str, modes: int, problem: str, whole: bool = False) -> Walk:
    """A walk of a robot, as far as the branch leads.

    Args:
        name: A shipped robot.
        modes: Strain modes per direction.
        problem: ``forward``, ``inverse`` or ``by effort``.
        whole: Go on where poses come near an inverse singularity.
    """
    robot = robot_with(name, modes)
    places = _places(robot)
    if problem == "inverse" and not whole:
        places = places[: INVERSE_STEPS.get(name, STEPS) + 1]
    requests = [getattr(place, PROBLEMS[problem]) for place in places[1:]]
    if not len(requests[0]):
        raise ValueError(f"{name} has no {problem} problem")
    solve, last = SOLVERS[problem], places[0]
    reached = 0
    for request in requests:
        try:
            last = solve(robot, request, start=last)
        except NotReached:
            break
        reached += 1
    if reached < SHORTEST:
        raise ValueError(f"{name} with {modes} modes, {problem}: only {reached} steps are possible")
    return Walk(problem, places[0], tuple(requests[:reached]))


@cache
def _places(robot: Robot) -> tuple[Equilibrium, ...]:
    """Equilibria along the way of a robot, the start first."""
    name = robot.description.name
    found = [solve_home(robot)]
    if name == "gough_stewart":
        for step in range(1, STEPS + 1):
            pose = solve_home(robot).pose
            pose[:3] += step * POSE_STEP
            found.append(solve_inverse(robot, pose, start=found[-1]))
        return tuple(found)
    if name in PAPER_CASES:
        case: Case = PAPER_CASES[name]
        motors = case.path()
        found = [solve_forward(robot, motors[0])]
    else:
        steps = np.arange(STEPS + 1.0)[:, None]
        motors = solve_home(robot).motors + steps * np.array(MOTOR_STEPS[name])
    for request in motors[1:]:
        found.append(solve_forward(robot, request, start=found[-1]))
    return tuple(found)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Warm and cold solves of robots, and what is asked of a solution."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from cpr_core import (
    Equilibrium,
    NotReached,
    Robot,
    kinemato_statics,
    solve_forward,
    solve_home,
    spectrum,
)

from .measure import Case
from .walks import PROBLEMS, ROBOTS, Walk, robot_with, walk_of

__all__ = ["MODES", "analysis_cases", "cold_cases", "steps_per_solve", "warm_cases"]

MODES = (3, 5, 8, 12)
#: How far motors are moved at random from home in cold starts [rad or m].
RANGES = {
    "gough_stewart": 0.05,
    "planar_body": 0.6,
    "rfrfr": 1.2,
    "six_rfs": 0.7,
    "six_rus": 0.4,
    "three_rfs": 0.5,
}
COLD_TARGETS = 10


def warm_cases(modes: tuple[int, ...]) -> Iterator[Case]:
    """One small step after the other, residual below 1e-10."""
    for name in ROBOTS:
        for count in modes:
            for problem in PROBLEMS:
                walk = walk_of(name, count, problem)
                yield Case(f"{problem}/{name}/{count}", walk.run, len(walk.requests))


def steps_per_solve(modes: tuple[int, ...]) -> dict[str, float]:
    """Newton steps of the warm cases, by key."""
    found = {}
    for name in ROBOTS:
        for count in modes:
            for problem in PROBLEMS:
                points = walk_of(name, count, problem).equilibria()
                steps = float(np.mean([point.iterations for point in points]))
                found[f"{problem}/{name}/{count}"] = steps
    return found


def cold_cases(modes: int = 5) -> Iterator[Case]:
    """From home to random motors that can be reached."""
    for name in ROBOTS:
        robot, random = robot_with(name, modes), np.random.default_rng(1)
        targets: list[np.ndarray] = []
        while len(targets) < COLD_TARGETS:
            away = random.uniform(-RANGES[name], RANGES[name], robot.motor_count)
            try:
                targets.append(solve_forward(robot, solve_home(robot).motors + away).motors)
            except NotReached:
                continue

        yield Case(f"cold start/{name}/{modes}", partial(_from_home, robot, targets), len(targets))


def analysis_cases(modes: int = 5) -> Iterator[Case]:
    """Questions about the equilibria of a walk, and solves together with them."""
    questions: dict[str, Callable[[Equilibrium], object]] = {
        "stability locked": _locked,
        "stability free": _free,
        "kinemato-statics": _kinemato,
    }
    for name in ROBOTS:
        walk = walk_of(name, modes, "forward")
        points, count = walk.equilibria(), len(walk.requests)
        for asked, question in questions.items():
            yield Case(f"{asked}/{name}/{modes}", partial(_asked, points, question), count)
        for asked, question in {"locked index": _index, "everything": _everything}.items():
            run = partial(_solved_and_asked, walk, question)
            yield Case(f"forward and {asked}/{name}/{modes}", run, count)


def _from_home(robot: Robot, targets: Sequence[np.ndarray]) -> None:
    for target in targets:
        solve_forward(robot, target)


def _asked(points: Sequence[Equilibrium], question: Callable[[Equilibrium], object]) -> None:
    for point in points:
        question(point)


def _solved_and_asked(walk: Walk, question: Callable[[Equilibrium], object]) -> None:
    last = walk.start
    for request in walk.requests:
        last = solve_forward(last.robot, request, start=last)
        question(last)


def _index(equilibrium: Equilibrium) -> object:
    return equilibrium.index_locked


def _locked(equilibrium: Equilibrium) -> tuple[float, float]:
    found = spectrum(equilibrium, "locked")
    return found.smallest, found.margin


def _free(equilibrium: Equilibrium) -> float:
    return spectrum(equilibrium, "free").smallest


def _kinemato(equilibrium: Equilibrium) -> object:
    model = kinemato_statics(equilibrium)
    return model.jacobian, model.platform_by_wrench, model.efforts_by_motors


def _everything(equilibrium: Equilibrium) -> object:
    """Both readings of stability with eigenvalues, and the kinemato-statics."""
    return _locked(equilibrium), _free(equilibrium), _kinemato(equilibrium)

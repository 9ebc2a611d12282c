"""Warm and cold solves of every shipped robot, and what is asked of a solution."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cpr_core import (
    Equilibrium,
    NotReached,
    given_at,
    kinemato_statics,
    solve_forward,
    spectrum,
)

from .measure import Case
from .walks import PROBLEMS, ROBOTS, robot_with, walk_of

__all__ = ["MODES", "all_of", "analysis_cases", "cold_cases", "steps_per_solve", "warm_cases"]

MODES = (3, 5, 8, 12)
#: How far motors are moved at random from home in cold starts [rad or m].
RANGES = {
    "gough_stewart": 0.05,
    "planar_body": 0.6,
    "rfrfr": 1.2,
    "six_rfs": 0.7,
    "three_rfs": 0.5,
}
COLD_TARGETS = 10


def warm_cases(modes: tuple[int, ...]) -> Iterator[Case]:
    """One small step after the other, residual below 1e-10."""
    for name in ROBOTS:
        for count in modes:
            for problem in PROBLEMS:
                walk = walk_of(name, count, problem)
                yield Case(f"{problem}/{name}/{count}", walk.go, len(walk.requests))


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
                targets.append(given_at(solve_forward(robot, robot.home.motors + away), "motors"))
            except NotReached:
                continue

        def run(robot=robot, targets=tuple(targets)) -> None:
            for target in targets:
                solve_forward(robot, target)

        yield Case(f"cold start/{name}/{modes}", run, len(targets))


def all_of(here: Equilibrium) -> tuple[object, ...]:
    """Both readings of stability with eigenvalues, and the kinemato-statics."""
    model = kinemato_statics(here)
    return (
        spectrum(here, "locked"),
        spectrum(here, "free"),
        model.platform_by_motors,
        model.platform_by_wrench,
        model.efforts_by_motors,
    )


def analysis_cases(modes: int = 5) -> Iterator[Case]:
    """Questions about the equilibria of a walk, and solves together with them."""
    for name in ROBOTS:
        walk = walk_of(name, modes, "forward")
        points, count = walk.equilibria(), len(walk.requests)

        def locked(points=points) -> None:
            for point in points:
                spectrum(point, "locked")

        def free(points=points) -> None:
            for point in points:
                spectrum(point, "free")

        def kinemato(points=points) -> None:
            for point in points:
                model = kinemato_statics(point)
                _ = model.platform_by_motors, model.platform_by_wrench, model.efforts_by_motors

        def with_index(walk=walk) -> None:
            here = walk.start
            for request in walk.requests:
                here = solve_forward(here.robot, request, start=here)
                _ = here.index_locked

        def with_everything(walk=walk) -> None:
            here = walk.start
            for request in walk.requests:
                here = solve_forward(here.robot, request, start=here)
                all_of(here)

        yield Case(f"stability locked/{name}/{modes}", locked, count)
        yield Case(f"stability free/{name}/{modes}", free, count)
        yield Case(f"kinemato-statics/{name}/{modes}", kinemato, count)
        yield Case(f"forward and locked index/{name}/{modes}", with_index, count)
        yield Case(f"forward and everything/{name}/{modes}", with_everything, count)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The paths of the paper, by this library and by the models it is compared with."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache, partial

import numpy as np

from cpr_core import solve_forward, trace_through
from cpr_core.reference.continuous_rods import follow_motors
from cpr_core.reference.shooting_method import ShootingMethod
from paper.cases import Case as PaperCase
from paper.timing import EXACT_METHOD, cheapest_method, models_of

from .measure import Case
from .walks import PAPER_CASES, Walk, walk_of

__all__ = ["ACCURACY", "accuracy_facts", "equally_accurate", "path_cases"]

#: Largest position error along a path of models that are compared at equal accuracy [m].
ACCURACY = 1e-6
#: Steps of the slow models.
FEW = 5


def path_cases() -> Iterator[Case]:
    """51 points each; per point, as all models take one step after the other."""
    for case in PAPER_CASES.values():
        walk = walk_of(case.name, 5, "forward")
        yield Case(f"path of 51 points/{case.name}/5", partial(_whole_path, walk))
        yield Case(f"path of 51 points in one call/{case.name}/5", partial(_trajectory, walk))
        back = walk_of(case.name, 5, "inverse", whole=True)
        yield Case(f"inverse path of {len(back.requests) + 1} points/{case.name}/5", back.run)
        modes, method = equally_accurate(case)
        accurate = walk_of(case.name, modes, "forward")
        ours = partial(_trajectory, accurate)
        yield Case(f"at 1e-6 m, this library/{case.name}", ours, len(accurate.requests))
        path = case.path()[1:]
        shooting = partial(follow_motors, case.continuous_home(), path, method=method)
        yield Case(f"at 1e-6 m, continuous shooting/{case.name}", shooting, len(path))
        for model in models_of(case, EXACT_METHOD):
            if model.key in ("#0", "#3"):
                name = {"#0": "literal procedure", "#3": "finite differences"}[model.key]
                run = partial(model.run, path[:FEW])
                yield Case(f"{name}/{case.name}", run, FEW, slow=True)


@cache
def equally_accurate(case: PaperCase) -> tuple[int, ShootingMethod]:
    """Fewest modes and cheapest shooting that keep the error below ``ACCURACY`` all along a path."""
    exact = case.continuous_path()
    modes = next(
        count for count in range(5, 20) if largest_error(case.modes_path(count), exact) <= ACCURACY
    )
    method = cheapest_method(case, lambda found: largest_error(found, exact) <= ACCURACY)
    return modes, method


def accuracy_facts() -> dict[str, str]:
    """What is compared at equal accuracy, in words."""
    facts = {}
    for case in PAPER_CASES.values():
        exact = case.continuous_path()
        modes, method = equally_accurate(case)
        ours = largest_error(case.modes_path(modes), exact)
        found = follow_motors(case.continuous_home(), case.path(), method=method)
        facts[case.name] = (
            f"{modes} modes per bending direction, largest error {ours:.1e} m; {method.tableau} with "
            f"{method.steps} steps a rod, largest error {largest_error(found, exact):.1e} m"
        )
    return facts


def largest_error(points: Sequence, exact: Sequence) -> float:
    """Largest distance of platform positions [m]."""
    pairs = zip(points, exact, strict=True)
    return max(
        float(np.linalg.norm(first.platform_position - second.platform_position))
        for first, second in pairs
    )


def _whole_path(walk: Walk) -> None:
    """A walk, its first point solved too: 51 points."""
    solve_forward(walk.start.robot, walk.start.motors, start=walk.start)
    walk.run()


def _trajectory(walk: Walk) -> None:
    """A walk in one call."""
    robot, requests = walk.start.robot, np.array(walk.requests)
    trace_through(robot, motors=requests, start=walk.start, singularities=False)

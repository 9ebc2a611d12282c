# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Computation times of all models on the motor paths: Tables III and VI.

Measured is the processor time of this process on one core, so what else the machine does is not
counted.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cpr_core import NoSolution, solve_home, trace_through
from cpr_core.kernels.square_problem import RESIDUAL_TOLERANCE
from cpr_core.reference.continuous_rods import follow_motors
from cpr_core.reference.finite_differences import (
    FiniteDifferenceEquilibrium,
    follow_finite_differences,
    solve_finite_differences,
)
from cpr_core.reference.literal_procedure import follow_literally, solve_literally
from cpr_core.reference.shooting_method import ShootingMethod

from .cases import Case

__all__ = [
    "CONFIGURATIONS",
    "EXACT_METHOD",
    "Measurement",
    "Model",
    "cheapest_method",
    "comparable_method",
    "dense_factorization",
    "machine",
    "measure",
    "models_of",
]

#: n_c of Tables III and VI.
CONFIGURATIONS = (50, 30, 15, 10, 5)
MODES = 5
ELEMENTS = 1000
#: Setting of Mod. #2 with errors of 1e-10 m and below.
EXACT_METHOD = ShootingMethod("DOP853", 16, RESIDUAL_TOLERANCE)
#: Position error above which a model is said to have left the branch [m].
LOST = 0.01

Path_ = NDArray[np.float64]


@dataclass(frozen=True)
class Model:
    """A model that follows a motor path.

    Attributes:
        key: Short name.
        title: What it is.
        run: Follows a path (K, n) from t = 0; returns the points.
        slow: Whether one run takes seconds: then it is repeated less.
    """

    key: str
    title: str
    run: Callable[[Path_], Sequence]
    slow: bool = False


@dataclass(frozen=True)
class Measurement:
    """Time of a model for n_c + 1 configurations.

    Attributes:
        model: Key of the model.
        count: n_c.
        seconds: Median of the repeats, processor time.
        spread: Largest over smallest of the repeats.
        repeats: Number of repeats.
        mean_error: Mean position error against continuous rods [m].
        iterations: Newton or Levenberg-Marquardt steps per configuration.
    """

    model: str
    count: int
    seconds: float
    spread: float
    repeats: int
    mean_error: float
    iterations: float


def models_of(case: Case, comparable: ShootingMethod) -> tuple[Model, ...]:
    """All models of a case. Their starting points are solved here, not in the measured time."""
    robot = case.robot(MODES)
    continuous = case.continuous_home()
    literal = solve_literally(solve_home(robot))

    def modes(path: Path_) -> Sequence:
        found = trace_through(robot, motors=path, start=solve_home(robot), singularities=False)
        if not found.reached:
            raise NoSolution(found.events[-1].message, found.events[-1].fraction, found.last)
        return found.equilibria

    def shooting(method: ShootingMethod) -> Callable[[Path_], Sequence]:
        return lambda path: follow_motors(continuous, path, method=method)

    def title(method: ShootingMethod) -> str:
        return f"continuous rods by shooting, {method.tableau} with {method.steps} steps a rod"

    models = [
        Model("#1", f"strain modes, {MODES} per bending direction, this library", modes),
        Model("#2", title(comparable), shooting(comparable)),
        Model("#2 exact", title(EXACT_METHOD), shooting(EXACT_METHOD)),
    ]
    if case.robot(MODES).planar:
        elements = solve_finite_differences(continuous, ELEMENTS)
        models.append(
            Model(
                "#3",
                f"finite differences, {ELEMENTS} elements a rod, sparse LU",
                lambda path: follow_finite_differences(elements, path),
                slow=True,
            )
        )
    models.append(
        Model(
            "#0",
            f"the paper's procedure taken literally, {MODES} modes",
            lambda path: follow_literally(literal, path),
            slow=True,
        )
    )
    return tuple(models)


def comparable_method(case: Case) -> ShootingMethod:
    """The cheapest setting of Mod. #2 whose mean error is no larger than that of our 5 modes."""
    exact = case.continuous_path()
    wanted = _mean_error(case.modes_path(MODES), exact)
    return cheapest_method(case, lambda found: _mean_error(found, exact) <= wanted)


def cheapest_method(case: Case, accurate: Callable[[Sequence], bool]) -> ShootingMethod:
    """The cheapest setting of Mod. #2 whose points along the path are accurate enough."""
    start, path = case.continuous_home(), case.path()
    cheapest, best = EXACT_METHOD, np.inf
    for tableau in ("RK4", "DOPRI5", "DOP853"):
        for steps in range(2, 65):
            method = ShootingMethod(tableau, steps, RESIDUAL_TOLERANCE)
            try:
                found = follow_motors(start, path, method=method)
            except NoSolution:
                continue
            if accurate(found):
                run = partial(follow_motors, start, path, method=method)
                seconds = float(np.median([_time(run) for _ in range(9)]))
                if seconds < best:
                    cheapest, best = method, seconds
                break
    return cheapest


def measure(
    models: Sequence[Model],
    case: Case,
    count: int,
    repeats: int,
    slow_repeats: int,
    progress: Callable[[], object] = lambda: None,
) -> dict[str, Measurement | None]:
    """Time models on a path, taking turns, so that changes of the machine's pace befall them all.

    Args:
        models: The models.
        case: The case.
        count: n_c.
        repeats: Repeats of fast models.
        slow_repeats: Repeats of slow ones, the first run among them: they have nothing to warm up.
        progress: Called after every run of a slow model.

    Returns:
        By key of the model; None where it leaves the branch on so coarse a path.
    """
    path, exact = case.path(count), case.continuous_path(count)
    first: dict[str, Sequence] = {}
    seconds: dict[str, list[float]] = {}
    for model in models:
        begin = time.process_time()
        points = _followed(model, path, exact)
        if points is not None:
            first[model.key] = points
            seconds[model.key] = [time.process_time() - begin] if model.slow else []
        if model.slow:
            progress()
    for _ in range(max(repeats, slow_repeats)):
        for model in models:
            wanted = slow_repeats if model.slow else repeats
            if model.key in first and len(seconds[model.key]) < wanted:
                seconds[model.key].append(_time(partial(model.run, path)))
                if model.slow:
                    progress()
    found: dict[str, Measurement | None] = dict.fromkeys(model.key for model in models)
    for key, points in first.items():
        found[key] = Measurement(
            model=key,
            count=count,
            seconds=float(np.median(seconds[key])),
            spread=max(seconds[key]) / min(seconds[key]),
            repeats=len(seconds[key]),
            mean_error=_mean_error(points, exact),
            iterations=float(np.mean([point.iterations for point in points])),
        )
    return found


def _followed(model: Model, path: Path_, exact: Sequence) -> Sequence | None:
    try:
        points = model.run(path)
    except NoSolution:
        return None
    pairs = zip(points, exact, strict=True)
    worst = max(np.linalg.norm(a.platform_position - b.platform_position) for a, b in pairs)
    return points if worst <= LOST else None


def dense_factorization(case: Case) -> tuple[float, float]:
    """Seconds to solve one Newton step of Mod. #3 with dense and with sparse matrices."""
    start: FiniteDifferenceEquilibrium = solve_finite_differences(case.continuous_home(), ELEMENTS)
    model = start.model
    residual, tangent = model.evaluate(start.motors, start.unknowns)
    dense = tangent.toarray()
    return (
        float(np.median([_time(lambda: np.linalg.solve(dense, residual)) for _ in range(3)])),
        float(np.median([_time(lambda: model.correction(tangent, residual)) for _ in range(9)])),
    )


def machine() -> str:
    """Processor and number of cores."""
    name = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text().splitlines():
            if line.startswith("model name"):
                name = line.split(":", 1)[1].strip()
                break
    return f"{name}, {os.cpu_count()} cores"


def _time(run: Callable[[], object]) -> float:
    begin = time.process_time()
    run()
    return time.process_time() - begin


def _mean_error(points: Sequence, exact: Sequence) -> float:
    return float(
        np.mean(
            [
                np.linalg.norm(a.platform_position - b.platform_position)
                for a, b in zip(points, exact, strict=True)
            ]
        )
    )

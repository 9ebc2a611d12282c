# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The estimated error of an answer over the true one, at random configurations of every robot.

``python -m benchmarks.discretisation_error`` prints the table of docs/performance.md.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cpr_core import Equilibrium, NotReached, Robot, error_of, load_robot, solve_forward, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.kernels.square_problem import CONTRACTION, ITERATIONS, RESIDUAL_TOLERANCE, Tolerances
from cpr_core.model.equilibrium_steps import corrected
from cpr_core.solving.discretisation_error import MORE_MODES, embedded

__all__ = ["MODES", "RANGE", "TRUE_MODES", "Compared", "compare", "in_richer_space"]

Floats = NDArray[np.float64]
Answer = TypeVar("Answer")

MODES = range(3, 9)
#: Modes of what is taken for the truth.
TRUE_MODES = 16
#: Way of the motors from home, in their units [rad or rod lengths].
RANGE = 0.5
#: How far away a request may be that one step of Newton's method answers, in units of the motors.
NEAR = (1e-5, 1e-4, 1e-3, 1e-2)
#: Each time is the smallest of so many.
REPEATS = 3
#: Truths below this, in rod lengths and relative to the efforts, are rounding of the solutions.
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Compared:
    """Estimates over truths, of those that are not rounding.

    Attributes:
        truths: Distance of the platform from that with many modes, of all configurations [m].
        distances: Estimate over truth of the distance.
        efforts: The same of the largest effort.
        costs: Time of an estimate over that of a step of Newton's method in the richer space, which is
            that of a request that one step answers.
    """

    truths: Floats
    distances: Floats
    efforts: Floats
    costs: Floats

    @property
    def ratios(self) -> Floats:
        """Of distances and efforts."""
        return np.concatenate([self.distances, self.efforts])


def in_richer_space(equilibrium: Equilibrium, richer: Robot) -> Equilibrium | None:
    """The equilibrium of a robot with more modes at the same motors, next to this one."""
    start = embedded(equilibrium, richer)
    tolerances = Tolerances(RESIDUAL_TOLERANCE, ITERATIONS, CONTRACTION)
    found = corrected(richer, start.loads, start.load_arrays, start.record, tolerances)
    return found if found.converged else None


def compare(name: str, modes: int, count: int, seed: int = 0) -> Compared:
    """Estimates and truths at random motors, each reached from the configuration before."""
    robot = load_robot(name, modes=modes)
    exact = Robot(robot.description.with_richer_modes(TRUE_MODES - modes))
    richer = Robot(robot.description.with_richer_modes(MORE_MODES))
    random, home = np.random.default_rng(seed), solve_home(robot)
    truths: list[float] = []
    distances: list[float] = []
    efforts: list[float] = []
    costs: list[float] = []
    last = home
    while len(truths) < count:
        motors = home.motors + RANGE * robot.motor_units * random.uniform(-1, 1, robot.motor_count)
        try:
            found = solve_forward(robot, motors, start=last, stable_only=True)
        except NotReached:
            last = home
            continue
        last, true = found, in_richer_space(found, exact)
        if true is None:
            continue
        estimate, seconds = _timed(partial(error_of, found))
        start = in_richer_space(found, richer)
        if start is not None and (step := _step_time(start)) is not None:
            costs.append(seconds / step)
        away = float(np.linalg.norm(true.platform_position - found.platform_position))
        truths.append(away)
        if away > ROUNDING * robot.mean_length:
            distances.append(estimate.distance / away)
        change = float(np.abs(true.efforts - found.efforts).max())
        if change > ROUNDING * np.abs(found.efforts).max():
            efforts.append(float(np.abs(estimate.efforts).max()) / change)
    return Compared(*(np.array(numbers) for numbers in (truths, distances, efforts, costs)))


def _step_time(start: Equilibrium) -> float | None:
    """Processor time of a request that one step of Newton's method answers; None where none does."""
    for near in NEAR:
        request = start.motors + near * start.robot.motor_units
        try:
            found, seconds = _timed(partial(solve_forward, start.robot, request, start=start))
        except NotReached:
            return None
        if found.iterations == 1:
            return seconds
    return None


def _timed(call: Callable[[], Answer]) -> tuple[Answer, float]:
    """What a call answers, and its processor time [s]."""
    samples = []
    for _ in range(REPEATS):
        begin = time.thread_time()
        answer = call()
        samples.append(time.thread_time() - begin)
    return answer, min(samples)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=2000, help="configurations; default 2000")
    parser.add_argument("--modes", type=int, nargs="+", default=list(MODES))
    parser.add_argument("--robots", nargs="+", default=list(shipped_robots()))
    options = parser.parse_args()
    print(
        "| robot | modes | true error, median and largest [m] | estimate over truth, least", end=" "
    )
    print("| 2.5 % | 97.5 % | largest | within 3 | cost |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in options.robots:
        for modes in options.modes:
            found = compare(name, modes, options.count)
            ratios = found.ratios if len(found.ratios) else np.array([np.nan])
            low, high = np.quantile(ratios, [0.025, 0.975])
            within = np.mean((ratios > 1.0 / 3.0) & (ratios < 3.0))
            print(
                f"| {name} | {modes} | {np.median(found.truths):.1e}, {found.truths.max():.1e} | "
                f"{ratios.min():.2f} | {low:.2f} | {high:.2f} | {ratios.max():.2f} | "
                f"{100.0 * within:.1f} % | {np.median(found.costs):.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()

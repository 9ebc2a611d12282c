# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Random small steps of every robot with few and many modes: is any of them much slower than most?

``python -m benchmarks.near_requests`` prints the table of docs/performance.md.
"""

from __future__ import annotations

import argparse
import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from cpr_core import Equilibrium, NotReached, Robot, kinemato_statics, load_robot, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.kernels.natural_units import EFFORT_UNIT
from cpr_core.solving.near_request import solve_near
from cpr_core.solving.requests import target_of

from .walks import PROBLEMS, SOLVERS

__all__ = ["MODES", "Times", "is_walked", "straight_stewart_gough", "times_of", "walk_near"]

Floats = NDArray[np.float64]

MODES = range(3, 13)
#: How far a request is from the equilibrium before: motors in their units [rad or rod lengths], poses in
#: radians and rod lengths.
SMALL_STEPS = {"forward": 1e-3, "inverse": 3e-3}
#: By effort: how far the motors go to first order, in their units, and how much the efforts change, in
#: those of a motor's radian. What hangs in cranks goes far by small efforts, a column hardly by large.
SMALL_WAY, SMALL_EFFORTS = 1e-2, 5e-3
#: Requests from home on, before a walk begins anew.
WALK = 25
#: Each is solved so many times, the smallest time counts: what else the machine does is not asked for.
REPEATS = 3
#: Rod of the robot whose legs are nearly straight [m].
ROD_LENGTH, ROD_RADIUS = 0.48, 0.65e-3


def straight_stewart_gough() -> dict[str, Any]:
    """Description of a Stewart-Gough robot whose legs are straight at home, and nearly so around it.

    Like the shipped one, with thin rods that lead straight to their joints on the platform, hinges about
    their tangents.
    """
    content = yaml.safe_load(Path(shipped_robots()["gough_stewart"]).read_text(encoding="utf-8"))
    content["name"] = "straight_stewart_gough"
    content["rod"]["length"] = ROD_LENGTH
    content["rod"]["section"]["radius"] = ROD_RADIUS
    content["gravity"] = [0.0, 0.0, 0.0]
    height = 0.0
    for leg in content["legs"]:
        across = np.array(leg["tip"]["position"]) - np.array(leg["base"]["position"])
        height = float(np.sqrt(ROD_LENGTH**2 - across @ across))
        straight = (across + [0.0, 0.0, height]) / ROD_LENGTH
        leg["base"]["tangent"] = straight.tolist()
        leg["base"]["normal"] = np.cross([0.0, 1.0, 0.0], straight).tolist()
        leg["tip"] = {
            "type": "revolute",
            "position": leg["tip"]["position"],
            "axis": straight.tolist(),
            "axis_in_rod": [1, 0, 0],
        }
    content["home"] = {
        "motors": [ROD_LENGTH] * len(content["legs"]),
        "platform": {"position": [0.0, 0.0, height]},
    }
    return content


@dataclass(frozen=True)
class Times:
    """Of many requests near by.

    Attributes:
        median: Half take less [s].
        slow: The slowest hundredth takes more [s].
        count: How many there were.
        walked: How many were not served by the compiled near path.
    """

    median: float
    slow: float
    count: int
    walked: int


def walk_near(
    robot: Robot,
    problem: str,
    count: int,
    solve: Callable[[Equilibrium, Floats], Equilibrium | None],
) -> None:
    """Random small steps, each from the equilibrium before; after some, and where one fails, from home.

    Args:
        robot: The robot.
        problem: ``forward``, ``inverse`` or ``by effort``.
        count: Steps.
        solve: Called with start and request; returns the equilibrium there, if it is reached.
    """
    random = np.random.default_rng(0)
    last: Equilibrium | None = None
    for number in range(count):
        start = solve_home(robot) if last is None or number % WALK == 0 else last
        given = getattr(start, PROBLEMS[problem])
        change = random.uniform(-1.0, 1.0, len(given))
        request = given + _small(start, problem, change)
        if problem == "inverse" and "orientation" in robot.description.controlled:
            request[-4:] /= np.linalg.norm(request[-4:])  # a quaternion
        last = solve(start, request)


def _small(start: Equilibrium, problem: str, change: Floats) -> Floats:
    """A small step of a request in a direction of numbers up to 1."""
    robot, motor_units = start.robot, start.robot.motor_units
    if problem == "forward":
        return SMALL_STEPS[problem] * motor_units * change
    if problem == "inverse":
        controlled = robot.description.controlled
        units = [robot.mean_length if name in "xyz" else 1.0 for name in controlled]
        units += [1.0] * (len(change) - len(units))
        return np.asarray(SMALL_STEPS[problem] * np.array(units) * change)
    efforts = kinemato_statics(start).efforts_by_motors @ (SMALL_WAY * motor_units * change)
    natural = efforts * motor_units / (EFFORT_UNIT * robot.kernel_arrays.energy_unit)
    return np.asarray(efforts * min(1.0, SMALL_EFFORTS / np.abs(natural).max()))


def times_of(robot: Robot, problem: str, count: int) -> Times:
    """Processor times of requests near by."""
    taken, walked = [], 0

    def timed(start: Equilibrium, request: Floats) -> Equilibrium | None:
        nonlocal walked
        walked += is_walked(start, problem, request)
        samples, found = [], None
        for _ in range(REPEATS):
            begin = time.thread_time()
            with contextlib.suppress(NotReached):
                found = SOLVERS[problem](robot, request, start=start)
            samples.append(time.thread_time() - begin)
        taken.append(min(samples))
        return found

    walk_near(robot, problem, count, timed)
    return Times(float(np.median(taken)), float(np.quantile(taken, 0.99)), len(taken), walked)


def is_walked(start: Equilibrium, problem: str, request: Floats) -> bool:
    """Whether a request is not served by the compiled near path."""
    target = target_of(start, PROBLEMS[problem], request)
    return solve_near(start, target, stable_only=False) is None


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=2000, help="requests of each; default 2000")
    parser.add_argument("--modes", type=int, nargs="+", default=list(MODES))
    parser.add_argument(
        "--robots",
        nargs="+",
        choices=list(shipped_robots()),
        help="default all, and a straight one",
    )
    options = parser.parse_args()
    print("| robot | modes | problem | median | slowest hundredth | ratio | walked |")
    print("|---|---|---|---|---|---|---|")
    worst = 0.0
    for source in options.robots or (*shipped_robots(), straight_stewart_gough()):
        for modes in options.modes:
            robot = load_robot(source, modes=modes)
            # Straight legs buckle under small changes of lengths or efforts: these are not near.
            for problem in PROBLEMS if isinstance(source, str) else ("inverse",):
                found = times_of(robot, problem, options.count)
                ratio = found.slow / found.median
                worst = max(worst, ratio)
                print(
                    f"| {robot.description.name} | {modes} | {problem} | "
                    f"{1e6 * found.median:.0f} µs | {1e6 * found.slow:.0f} µs | {ratio:.1f} | "
                    f"{found.walked} |",
                    flush=True,
                )
    print(f"\nlargest ratio: {worst:.1f}")


if __name__ == "__main__":
    main()

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What it costs to know a robot: derivatives by parameters, calibrations, felt wrenches.

``python -m benchmarks.identification`` prints the tables of docs/performance.md, and how often intervals
of calibrations hold the truth. Times are processor times, medians.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpr_core import (
    Equilibrium,
    Measurement,
    Robot,
    StandardDeviations,
    calibrate,
    continued,
    derivatives,
    estimate_wrench,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.lie import quaternion_from_rotation, rotation_exp
from cpr_core.model.world_response import wrench_units

Floats = NDArray[np.float64]

PATHS = ("rod.young_modulus", *(f"legs[{leg}].motor.offset" for leg in range(6)))
#: Of positions [m] and rotations [rad].
POSITION_DEVIATION, ROTATION_DEVIATION = 5e-4, 2e-3
DEVIATIONS = StandardDeviations(position=POSITION_DEVIATION, rotation=ROTATION_DEVIATION)
#: How far away a request is that one step of Newton's method answers [rad].
NEAR = 1e-3
#: Errors of the simulated robot: of its modulus, relative, and of its zeros [rad].
MODULUS_ERROR, OFFSET_ERROR = 0.05, 0.02
#: Poses of a data set, how far from home they are [rad], and the load they are measured under [N].
POSES, REACH, PAYLOAD = 20, 0.3, 1.0
#: Samples of a wrench that changes [1/s], how many of them, and how fast it does [rad/s].
RATE, SAMPLES, SPEEDS = 200.0, 300, (2.0, 6.0)
#: Standard deviations of efforts in E J / l, of the pose in m and rad.
EFFORT_DEVIATION, POSE_DEVIATION = 1e-3, (1e-4, 1e-3)
WRENCHED = ("rfrfr", "six_rfs", "delta")


def seconds(call: Callable[[], object]) -> float:
    """Processor time of one call [s]."""
    begin = time.thread_time()
    call()
    return time.thread_time() - begin


def derivative_rows() -> Iterator[str]:
    """Derivatives of pose and efforts beside the request that one Newton step answers."""
    robot = load_robot("six_rfs")
    start = solve_home(robot)

    def request() -> Equilibrium:
        return solve_forward(robot, start.motors + NEAR, start=start)

    def asked(count: int) -> float:
        fresh = request()  # what is found once about an equilibrium is of the first question
        return seconds(lambda: derivatives(fresh, PATHS[:count], of=("pose", "efforts")))

    assert request().iterations == 1
    asked(len(PATHS))
    # In turns, so that what disturbs the machine befalls all alike.
    samples = [(seconds(request), asked(1), asked(len(PATHS))) for _ in range(300)]
    step, by_one, by_all = np.median(samples, axis=0)
    further = (by_all - by_one) / (len(PATHS) - 1)
    yield "| request near by, one Newton step | derivatives by one parameter | every further one |"
    yield "|---|---|---|"
    yield f"| {1e6 * step:.0f} µs | {1e6 * by_one:.0f} µs | {1e6 * further:.0f} µs |"


def data_set(robot: Robot, seed: int) -> tuple[list[Measurement], Floats]:
    """Measured poses of a robot that is not quite the described one, and its parameters."""
    random, home = np.random.default_rng(seed), solve_home(robot)
    truth = np.concatenate(
        [
            robot.parameter_values(PATHS[:1]) * (1.0 + MODULUS_ERROR * random.normal()),
            OFFSET_ERROR * random.normal(size=6),
        ]
    )
    real = robot.with_parameters(dict(zip(PATHS, truth, strict=True)))
    loads = robot.default_loads.with_(wrench_world=[0, 0, 0, 0, 0, -PAYLOAD])
    rows, start = [], continued(home, real)
    for _ in range(POSES):
        motors = home.motors + random.uniform(-REACH, REACH, 6)
        reached = solve_forward(real, motors, start=start, loads=loads)
        turn = rotation_exp(ROTATION_DEVIATION * random.normal(size=3))
        rows.append(
            Measurement(
                motors=motors,
                position=reached.platform_position + POSITION_DEVIATION * random.normal(size=3),
                quaternion_wxyz=quaternion_from_rotation(turn @ reached.platform_rotation),
                loads=loads,
            )
        )
    return rows, truth


def calibration_rows(sets: int) -> Iterator[str]:
    """Modulus and six zeros of the 6-RFS: times, and how often intervals hold the truth."""
    simulated = load_robot("six_rfs")
    times: list[list[float]] = []
    inside = []
    for seed in range(sets + 1):  # the first one loads machine code
        rows, truth = data_set(simulated, seed)
        loaded, at_home = load_robot("six_rfs"), load_robot("six_rfs")
        solve_home(at_home)
        times.append(
            [
                seconds(partial(calibrate, robot, rows, PATHS, DEVIATIONS))
                for robot in (loaded, at_home, at_home)
            ]
        )
        answer = calibrate(at_home, rows, PATHS, DEVIATIONS)
        low, high = answer.intervals.T
        inside.append((low < truth) & (truth < high))
    loaded_time, home_time, used_time = 1e3 * np.median(times[1:], axis=0)
    within = 100.0 * np.mean(inside[1:], axis=0)
    yield "| robot just loaded | home known | robot used before | truth within intervals of 95 % |"
    yield "|---|---|---|---|"
    yield (
        f"| {loaded_time:.0f} ms | {home_time:.0f} ms | {used_time:.0f} ms | {within.mean():.1f} % "
        f"(by parameter {within.min():.1f} to {within.max():.1f}), {sets} data sets |"
    )


def wrench_rows() -> Iterator[str]:
    """Estimates of a wrench that changes, each from the one before, of exact measurements."""
    yield "| robot | efforts | pose | both | largest error where all is felt [N m, N] |"
    yield "|---|---|---|---|---|"
    for name in WRENCHED:
        robot = load_robot(name)
        motors, samples = _pushed(robot)
        cells, worst = [], 0.0
        for measured in (("efforts",), ("pose",), ("efforts", "pose")):
            found, error = _estimated(robot, motors, samples, measured)
            cells.append(f"{1e3 * found:.2f} ms")
            worst = max(worst, error)
        yield f"| {name} | {' | '.join(cells)} | {worst:.0e} |"


def _pushed(robot: Robot) -> tuple[Floats, list[tuple[Floats, Equilibrium]]]:
    """Motors that stay, wrenches, and where the robot is under them."""
    random, axes, reached = np.random.default_rng(0), robot.platform_axes, solve_home(robot)
    motors = reached.motors + 0.01 * robot.motor_units
    phases, speeds = random.uniform(0.0, 6.0, 6), random.uniform(*SPEEDS, 6)
    samples = []
    for moment in np.arange(SAMPLES) / RATE:
        wrench = np.zeros(6)
        wrench[axes] = 0.1 * np.sin(speeds * moment + phases)[axes] * wrench_units(robot)
        known = robot.default_loads
        loads = known.with_(wrench_world=known.wrench_world + wrench)
        reached = solve_forward(robot, motors, start=reached, loads=loads)
        samples.append((wrench, reached))
    return motors, samples


def _estimated(
    robot: Robot,
    motors: Floats,
    samples: Sequence[tuple[Floats, Equilibrium]],
    measured: Sequence[str],
) -> tuple[float, float]:
    """Median time of an estimate, the best of five rounds [s]; largest error where all is felt."""
    rows: list[dict[str, Any]] = []
    for _, reached in samples:
        row: dict[str, Any] = {}
        if "efforts" in measured:
            deviation = EFFORT_DEVIATION * robot.kernel_arrays.energy_unit
            row |= {"efforts": reached.efforts, "effort_deviation": deviation}
        if "pose" in measured:
            pose = np.concatenate([reached.platform_position, reached.platform_quaternion])
            row |= {"pose": pose, "pose_deviation": POSE_DEVIATION}
        rows.append(row)
    worst, medians = 0.0, []
    for _ in range(5):
        estimate, times = estimate_wrench(robot, motors, **rows[0]), []
        for (wrench, _), row in zip(samples, rows, strict=True):
            begin = time.thread_time()
            estimate = estimate_wrench(robot, motors, start=estimate, **row)
            times.append(time.thread_time() - begin)
            if len(estimate.unfelt) == 0:
                worst = max(worst, float(np.abs(estimate.wrench_world - wrench).max()))
        medians.append(float(np.median(times)))
    return min(medians), worst


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=int, default=200, help="sets of measurements; default 200")
    options = parser.parse_args()
    for table in (derivative_rows(), calibration_rows(options.sets), wrench_rows()):
        for row in table:
            print(row, flush=True)
        print()


if __name__ == "__main__":
    main()

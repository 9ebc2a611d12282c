# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether modes chosen for a tolerance keep it at random motors, or the estimated error tells."""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpr_core import NotReached, Robot, error_of, load_robot, solve_forward, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.solving.chosen_modes import TOLD, choose_modes

from .discretisation_error import RANGE, TRUE_MODES

__all__ = ["Kept", "compare_with_tolerance"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Kept:
    """Errors of a robot whose modes were chosen.

    Attributes:
        robot: The robot.
        tolerance: What they were chosen for [m].
        truths: Distance of the platform from that with many modes, per configuration [m].
        estimates: What `error_of` says of it [m].
    """

    robot: Robot
    tolerance: float
    truths: Floats
    estimates: Floats

    @property
    def met(self) -> float:
        """Share of configurations within the tolerance."""
        return float(np.mean(self.truths <= self.tolerance))

    @property
    def told(self) -> float:
        """Share of configurations beyond the tolerance of which the estimate says so."""
        return float(np.mean(self._beyond & self._warned))

    @property
    def silent(self) -> Floats:
        """Errors beyond the tolerance that the estimate does not tell [m]."""
        return self.truths[self._beyond & ~self._warned]

    @property
    def _beyond(self) -> NDArray[np.bool_]:
        return self.truths > self.tolerance

    @property
    def _warned(self) -> NDArray[np.bool_]:
        return self.estimates > TOLD * self.tolerance


def compare_with_tolerance(name: str, tolerance: float, count: int, seed: int = 0) -> Kept:
    """Errors at random motors, each reached from the configuration before."""
    robot = choose_modes(load_robot(name), tolerance)
    most = (0, 0, TRUE_MODES) if robot.planar else (TRUE_MODES, TRUE_MODES, TRUE_MODES)
    exact = Robot(robot.description.with_mode_counts([most] * len(robot.description.rods)))
    random, home = np.random.default_rng(seed), solve_home(robot)
    last, true = home, solve_home(exact)
    truths: list[float] = []
    estimates: list[float] = []
    while len(truths) < count:
        motors = home.motors + RANGE * robot.motor_units * random.uniform(-1, 1, robot.motor_count)
        try:
            found = solve_forward(robot, motors, start=last, stable_only=True)
            with_many = solve_forward(exact, motors, start=true, stable_only=True)
        except NotReached:
            last, true = home, solve_home(exact)
            continue
        last, true = found, with_many
        truths.append(float(np.linalg.norm(true.platform_position - found.platform_position)))
        estimates.append(error_of(found).distance)
    return Kept(robot, tolerance, np.array(truths), np.array(estimates))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tolerance", type=float, default=1e-5, help="[m]; default 1e-5")
    parser.add_argument("--count", type=int, default=300, help="configurations; default 300")
    parser.add_argument("--robots", nargs="+", default=list(shipped_robots()))
    options = parser.parse_args()
    print(
        "| robot | modes, least to most | within | beyond, told | silent | largest of these [m] |"
    )
    print("|---|---|---|---|---|---|")
    for name in options.robots:
        kept = compare_with_tolerance(name, options.tolerance, options.count)
        counts = np.array([rod.modes.counts for rod in kept.robot.description.rods])
        modes = " ".join(
            f"{low}-{high}" for low, high in zip(counts.min(0), counts.max(0), strict=True)
        )
        silent = kept.silent
        print(
            f"| {name} | {modes} | {100.0 * kept.met:.1f} % | {100.0 * kept.told:.1f} % | "
            f"{100.0 * len(silent) / len(kept.truths):.1f} % | {max(silent, default=0.0):.1e} |",
            flush=True,
        )


if __name__ == "__main__":
    main()

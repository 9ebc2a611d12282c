# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Random requests far from home, walked there and back: writes docs/robustness.md."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from cpr_core import (
    Equilibrium,
    NotReached,
    PathEvent,
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
)
from cpr_core.model.model_state import evaluate
from cpr_core.solving.limits import margins

PAGE = Path(__file__).parents[1] / "docs" / "robustness.md"

#: How far motors are moved from home, rad or m.
RANGES = {
    "delta": 0.8,
    "four_rfr": 0.8,
    "gough_stewart": 0.15,
    "planar_body": 1.2,
    "rfrfr": 2.5,
    "six_rfs": 1.5,
    "six_rus": 0.7,
    "three_prs": 0.08,
    "three_rfr_hubs": 0.8,
    "three_rfs": 1.0,
    "two_rods": 0.9,
}
#: Robots of the page: those of the short form, and two of chains; a 6-RUS walks for minutes.
ROBOTS = (
    "delta",
    "gough_stewart",
    "planar_body",
    "rfrfr",
    "six_rfs",
    "three_rfs",
    "two_rods",
)
#: Targets of a robot, by problem.
COUNTS = {"motors": 400, "pose": 300, "efforts": 300}
SOLVERS: dict[str, Callable[..., Equilibrium]] = {
    "motors": solve_forward,
    "pose": solve_inverse,
    "efforts": solve_forward_by_effort,
}


@dataclass
class Outcome:
    """What became of many requests.

    Attributes:
        ends: How many ended in what way: ``reached`` or the kind of event.
        not_real: Events that are not what they say, in words.
        not_equilibria: Answers that do not solve the model.
        worst_return: Largest dimensionless distance from home after walking back.
        not_returned: Walks back that were stopped, in words.
    """

    ends: Counter[str] = field(default_factory=Counter)
    not_real: list[str] = field(default_factory=list)
    not_equilibria: int = 0
    worst_return: float = 0.0
    not_returned: list[str] = field(default_factory=list)


class Requests:
    """Random requests of a robot from home; a walk there by motors is made once, whoever asks.

    Attributes:
        robot: The robot.
        home: Its home.
    """

    def __init__(self, name: str, seed: int = 1) -> None:
        """Those of a shipped robot."""
        self.robot = load_robot(name)
        self.home = solve_home(self.robot)
        self._random = np.random.default_rng(seed)
        self._walks: list[Equilibrium | NotReached] = []

    def ends(self, problem: str, count: int) -> Iterator[Equilibrium | NotReached]:
        """Ends of walks from home: to motors in a box around it, or to poses or efforts found there."""
        walks = map(self._walk, itertools.count())
        if problem == "motors":
            yield from itertools.islice(walks, count)
            return
        reached = (end for end in walks if isinstance(end, Equilibrium))
        for end in itertools.islice(reached, count):
            yield walked(problem, getattr(end, problem), self.home)

    def _walk(self, number: int) -> Equilibrium | NotReached:
        if number == len(self._walks):
            self._walks.append(walked("motors", self._random_motors(), self.home))
        return self._walks[number]

    def _random_motors(self) -> np.ndarray:
        limits = [motor.limits for motor in self.robot.description.motors]
        reach, middle = RANGES[self.robot.description.name], self.home.motors
        lower = np.maximum(middle - reach, [limit.lower + 0.01 * reach for limit in limits])
        upper = np.minimum(middle + reach, [limit.upper - 0.01 * reach for limit in limits])
        return self._random.uniform(lower, upper)


def walked(problem: str, target: np.ndarray, start: Equilibrium) -> Equilibrium | NotReached:
    """The equilibrium at a target, or what the walk there ended with."""
    try:
        return SOLVERS[problem](start.robot, target, start=start)
    except NotReached as end:
        return end


def experiment(requests: Requests, problem: str, count: int) -> Outcome:
    """Ask for random targets from home, and from every answer for home again."""
    home, outcome = requests.home, Outcome()
    for number, end in enumerate(requests.ends(problem, count)):
        if isinstance(end, NotReached):
            event = _event_of(end)
            outcome.ends[event.kind] += 1
            reached = event.equilibrium
            if not _real(event, problem, home):
                outcome.not_real.append(f"{number}: {end}")
        else:
            outcome.ends["reached"] += 1
            reached = end
        if residual(reached) > 1e-10:
            outcome.not_equilibria += 1
        back = walked(problem, getattr(home, problem), reached)
        if isinstance(back, NotReached):
            outcome.not_returned.append(f"{number}: {back}")
        else:
            outcome.worst_return = max(outcome.worst_return, distance(back, home))
    return outcome


def _event_of(end: NotReached) -> PathEvent:
    """What a walk ended with; an end without an event is not to happen here."""
    if end.event is None:
        raise end
    return end.event


def _real(event: PathEvent, problem: str, home: Equilibrium) -> bool:
    """Whether an event is what it says, by quantities the walk does not use."""
    equilibrium = event.equilibrium
    if event.kind.endswith("_limit"):
        return bool(np.abs(margins(equilibrium)).min() < 1e-6)
    if event.kind in ("fold", "bifurcation"):
        return regularity(equilibrium, problem) < 1e-2 * regularity(home, problem)
    return False


def regularity(equilibrium: Equilibrium, problem: str) -> float:
    """How far a problem is from having no unique solution."""
    if problem == "motors":
        return float(np.abs(equilibrium.spectrum_locked.eigenvalues).min())
    if problem == "efforts":
        return float(np.abs(equilibrium.spectrum_free.eigenvalues).min())
    return kinemato_statics(equilibrium).singularity("inverse").smallest


def residual(equilibrium: Equilibrium) -> float:
    """Largest dimensionless residual, by a fresh evaluation under the loads."""
    robot = equilibrium.robot
    value = evaluate(
        robot,
        robot.load_arrays(equilibrium.loads),
        equilibrium.state,
        equilibrium.platform_rotation,
        equilibrium.platform_position,
    )
    rows = np.arange(robot.kernel_arrays.motor_index)
    unit = robot.kernel_arrays.unit[rows] / robot.kernel_arrays.energy_unit
    return float(np.abs(value.residual[rows] * unit).max())


def distance(first: Equilibrium, second: Equilibrium) -> float:
    """Largest dimensionless difference of two equilibria."""
    return max(
        float(np.abs((first.state - second.state) / first.robot.kernel_arrays.unit).max()),
        float(np.abs(first.platform_rotation - second.platform_rotation).max()),
        float(
            np.abs(first.platform_position - second.platform_position).max()
            / first.robot.mean_length
        ),
    )


def main() -> None:
    """Run every experiment and write the page."""
    kinds = [
        "reached",
        "fold",
        "bifurcation",
        "motor_limit",
        "effort_limit",
        "strain_limit",
        "lost",
    ]
    lines = [
        "# Robustness",
        "",
        "Random requests from home, as far as the ranges below, each walked there and from where it "
        "ended back to home. Targets of the inverse problem and of the problem by effort are poses and "
        "efforts of equilibria that motors can reach; the straight path in the pose or in the efforts "
        "may all the same lead through folds or limits. Written by `python -m benchmarks.robustness`; "
        "`test/cpr_core/solving/test_robustness.py` runs the same. Left out are `six_rus`, which walks "
        "for minutes, `three_prs` and `three_rfr_hubs`, of chains as `delta` is, and `four_rfr`, whose "
        "inverse problem is one of an objective.",
        "",
        f"| robot | range | given | targets | {' | '.join(kinds)} | events not real | no equilibrium "
        "| walk back stopped | farthest from home after walking back |",
        "|---" * (len(kinds) + 8) + "|",
    ]
    for name in ROBOTS:
        requests = Requests(name)
        for problem, count in COUNTS.items():
            found = experiment(requests, problem, count)
            cells = [name, f"±{RANGES[name]}", problem, count]
            cells += [found.ends[kind] for kind in kinds]
            cells += [len(found.not_real), found.not_equilibria, len(found.not_returned)]
            cells.append(f"{found.worst_return:.1e}")
            lines.append(f"| {' | '.join(map(str, cells))} |")
            print(lines[-1], *found.not_real[:3], *found.not_returned[:3], sep="\n  ", flush=True)
    lines += [
        "",
        "- *reached*: every Newton correction contracted, and the signs of the tangent never changed "
        "without an event; the residual was evaluated anew.",
        "- *fold*, *bifurcation*: the smallest eigenvalue of the reduced Hessian (motors, efforts) or "
        "the smallest singular value of the inverse problem (pose) is below a hundredth of the one at "
        "home. *Limits*: within 1e-6 of the limit.",
        "- *farthest from home*: largest difference of any coordinate, dimensionless (radians, rod "
        "lengths, E J / l).",
        "",
    ]
    PAGE.write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()

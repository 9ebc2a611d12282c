# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Commands ``cpr trace`` and ``cpr equilibria``: what they read, do and print."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ..description.loads import Loads
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..solving.find_equilibria import FoundEquilibrium, find_equilibria
from ..solving.geometrico_statics import solve_forward, solve_forward_by_effort, solve_inverse
from ..solving.home import solve_home
from ..solving.trace import Trace, trace
from .answer import Answer, written
from .argument_types import real
from .reports import as_json, json_number
from .shared_options import add_objective, add_plot, add_seed, progress_bar

__all__ = ["add_equilibria_options", "add_trace_options"]


def add_trace_options(parser: argparse.ArgumentParser) -> None:
    """Options of ``cpr trace``."""
    parser.set_defaults(run=_trace)
    parser.add_argument(
        "--from",
        dest="first",
        nargs="+",
        type=real,
        metavar="Q",
        help="where the path begins; else home",
    )
    parser.add_argument(
        "--to",
        dest="last",
        nargs="+",
        type=real,
        required=True,
        metavar="Q",
        help="where the path ends",
    )
    parser.add_argument(
        "--given",
        choices=["motors", "pose", "efforts"],
        required=True,
        help="what --from and --to are: motor positions, controlled coordinates or motor efforts",
    )
    parser.add_argument(
        "--points",
        type=int,
        default=51,
        metavar="N",
        help="equilibria kept, equally spaced; default %(default)s",
    )
    parser.add_argument(
        "--stable-only", action="store_true", help="stop where stability is lost; else go on"
    )
    add_objective(parser)
    parser.add_argument(
        "--past-folds", action="store_true", help="follow the branch around folds; else stop there"
    )
    add_plot(parser, "the path")


def add_equilibria_options(parser: argparse.ArgumentParser) -> None:
    """Options of ``cpr equilibria``."""
    parser.set_defaults(run=_equilibria)
    parser.add_argument(
        "--starts",
        type=int,
        default=1000,
        metavar="N",
        help="how many random starts; default %(default)s",
    )
    add_seed(parser, "seed of the random starts")
    add_plot(parser, "them")


def _trace(robot: Robot, loads: Loads | None, options: argparse.Namespace) -> Answer:
    """Trace a path, done if the target was reached."""
    solves: dict[str, Callable[..., Equilibrium]] = {
        "motors": solve_forward,
        "pose": solve_inverse,
        "efforts": solve_forward_by_effort,
    }
    solve = solves[options.given]
    start = solve_home(robot)
    if options.first is not None or loads is not None:
        first = options.first
        start = (
            solve_forward(robot, start.motors, loads=loads)
            if first is None
            else solve(robot, first, loads=loads)
        )
    with progress_bar("of the way") as progress:
        found = trace(
            robot,
            **{options.given: options.last},
            start=start,
            points=options.points,
            stable_only=options.stable_only,
            past_folds=options.past_folds,
            progress=progress,
            objective=options.objective,
        )
    problems = written(partial(_plot_trace, found), options.plot)
    if options.json:
        text = as_json(_trace_as_dict(found))
        return Answer(text, found.reached, problems)
    return Answer(_trace_as_text(found), found.reached, problems)


def _plot_trace(found: Trace, file: Path) -> None:
    from ..drawing.path_plots import plot_trace

    plot_trace(found, file)


def _trace_as_dict(found: Trace) -> dict[str, Any]:
    return {
        "robot": found.robot.description.name,
        "reached": found.reached,
        "fractions": found.fractions.tolist(),
        "motors": found.motors.tolist(),
        "efforts": found.efforts.tolist(),
        "platform_positions": found.platform_positions.tolist(),
        "platform_quaternions_wxyz": found.platform_quaternions.tolist(),
        "energies": found.energies.tolist(),
        "smallest_eigenvalues_locked": found.eigenvalues_locked.tolist(),
        "indices_locked": found.indices_locked.tolist(),
        "indices_free": found.indices_free.tolist(),
        "bending_strains": [
            [*map(json_number, strains)] for strains in found.bending_strains.tolist()
        ],
        "events": [
            {
                "kind": event.kind,
                "fraction": float(event.fraction),
                "index_before": event.index_before,
                "index_after": event.index_after,
                "message": event.message,
                "motors": event.equilibrium.motors.tolist(),
                "platform_position": event.equilibrium.platform_position.tolist(),
            }
            for event in found.events
        ],
    }


def _trace_as_text(found: Trace) -> str:
    last = found.last
    lines = [
        f"{found.robot.description.name}: {len(found.equilibria)} equilibria, "
        + ("the target is reached" if found.reached else "the target is NOT reached")
    ]
    for event in found.events:
        place = ", ".join(f"{value:.5g}" for value in event.equilibrium.platform_position)
        lines.append(
            f"  {event.kind:<13} at {event.fraction:.8f} of the way, platform ({place}) m: "
            f"{event.message}"
        )
    if not found.events:
        lines.append("  no event")
    lines.append(f"  end: {_numbers(last)}")
    return "\n".join(lines)


def _numbers(found: Equilibrium) -> str:
    moved = zip(found.robot.description.motors, found.motors, strict=True)
    motors = ", ".join(f"{at:.6g} {motor.unit}" for motor, at in moved)
    place = ", ".join(f"{value:.6g}" for value in found.platform_position)
    return f"motors ({motors}), platform ({place}) m, index {found.index_locked}"


def _equilibria(robot: Robot, loads: Loads | None, options: argparse.Namespace) -> Answer:
    """Search all equilibria, done if there are any."""
    motors = solve_home(robot).motors if options.motors is None else options.motors
    with progress_bar("of the starts") as progress:
        found = find_equilibria(
            robot,
            motors,
            starts=options.starts,
            seed=options.seed,
            loads=loads,
            progress=progress,
        )
    problems = written(partial(_plot_equilibria, found), options.plot if found else None)
    if options.json:
        values = {
            "robot": robot.description.name,
            "equilibria": [_as_dict(entry) for entry in found],
        }
        return Answer(as_json(values), bool(found), problems)
    lines = [
        f"{robot.description.name}: {len(found)} equilibria, "
        f"{sum(entry.stable for entry in found)} stable with the motors held",
        "   energy [J]  index locked  free  starts  platform [m]",
    ]
    for entry in found:
        equilibrium = entry.equilibrium
        place = "  ".join(f"{value:9.5f}" for value in equilibrium.platform_position)
        lines.append(
            f"  {equilibrium.energy:11.6f}  {equilibrium.index_locked:12d}"
            f"  {equilibrium.index_free:4d}  {entry.starts:6d}"
            f"  {place}{'  branch of home' if entry.from_home else ''}"
            f"{f'  ({entry.beyond})' if entry.beyond else ''}"
        )
    return Answer("\n".join(lines), bool(found), problems)


def _plot_equilibria(found: Sequence[FoundEquilibrium], file: Path) -> None:
    from ..drawing.path_plots import plot_equilibria

    plot_equilibria(found, file)


def _as_dict(found: FoundEquilibrium) -> dict[str, Any]:
    equilibrium = found.equilibrium
    return {
        "energy": equilibrium.energy,
        "index_locked": equilibrium.index_locked,
        "index_free": equilibrium.index_free,
        "from_home": found.from_home,
        "starts": found.starts,
        "beyond": found.beyond,
        "platform_position": equilibrium.platform_position.tolist(),
        "platform_quaternion_wxyz": equilibrium.platform_quaternion.tolist(),
        "efforts": equilibrium.efforts.tolist(),
    }

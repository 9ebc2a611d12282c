# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Command ``cpr workspace``: what it reads, does and prints."""

from __future__ import annotations

import argparse
import re
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from tqdm import tqdm

from ..description.loads import Loads
from ..drawing.map_plots import FIELDS, check_field, plot_map, prepare
from ..errors import InvalidRequest
from ..model.robot import Robot
from ..solving.geometrico_statics import solve_forward, solve_inverse
from ..solving.home import solve_home
from ..workspace import Grid, WorkspaceMap, map_workspace, motor_grid, pose_grid
from ..workspace.flood import Progress
from ..workspace.map_files import MapNotWritten
from ..workspace.summary import summary_of
from .answer import Answer, written
from .argument_types import count, not_negative, number, picture, real
from .reports import as_json
from .shared_options import add_objective

__all__ = ["add_workspace_options"]

_PART = re.compile(r"^(.+)=([^:=]+)(?::([^:=]+))?$")


def add_workspace_options(parser: argparse.ArgumentParser) -> None:
    """Options of ``cpr workspace``; long, for every one has its lines."""
    parser.set_defaults(run=_workspace)
    parser.add_argument(
        "--slice",
        nargs="+",
        required=True,
        metavar="NAME=A[:B]",
        help="coordinates: NAME=A:B from A to B along an axis, NAME=A held; x y z angle roll pitch "
        "yaw, or ZYZ Euler angles phi theta psi, or motors; numbers may be like pi/3; those not "
        "named are held at 0 (motors: home)",
    )
    parser.add_argument(
        "--given",
        choices=["pose", "motors"],
        default="pose",
        help="what the names of --slice are: controlled coordinates (pose), or motors; default "
        "%(default)s",
    )
    parser.add_argument(
        "--resolution",
        type=number,
        default=0.01,
        metavar="R",
        help="distance of neighbours on all axes, m and rad; default %(default)s",
    )
    parser.add_argument(
        "--from",
        dest="first",
        nargs="+",
        type=real,
        metavar="Q",
        help="where to start: controlled coordinates or motors, as --given says; else home",
    )
    parser.add_argument(
        "--tolerance",
        type=number,
        default=1e-5,
        metavar="T",
        help="to which borders are bisected, in units of the axes; 0: not at all; default "
        "%(default)s",
    )
    add_objective(parser)
    parser.add_argument(
        "--workers", type=count, metavar="N", help="threads; 0: none; else one per core"
    )
    parser.add_argument("--plot", type=picture, metavar="FILE", help="draw the map (png, svg, pdf)")
    parser.add_argument(
        "--field",
        default="index",
        metavar="NAME",
        help=f"what --plot draws: {', '.join(FIELDS)}, where the robot has limits limit_margin, a "
        "motor, or the effort of one (MOTOR_effort); motor:NAME is a motor called like one of these; "
        "default %(default)s",
    )
    parser.add_argument(
        "--threshold",
        type=not_negative,
        default=1e-4,
        metavar="C",
        help="where the inverse condition number of H_r is below, the picture is red; default "
        "%(default)s",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="write the map (NetCDF); one that is there is gone on with",
    )
    parser.add_argument(
        "--restart",
        action="store_true",
        help="begin anew where --out has a map; else go on with it",
    )


def _workspace(robot: Robot, loads: Loads | None, options: argparse.Namespace) -> Answer:
    """Make a map, done if it is complete."""
    grid = _grid(robot, options)
    check_field(robot, options.field)
    if options.restart and options.out is None:
        raise InvalidRequest(
            "restart", "expected --out FILE with it: there is no map to begin anew"
        )
    if options.plot is not None:
        threading.Thread(target=prepare, daemon=True).start()
    start = solve_home(robot)
    if options.first is not None:
        solve = solve_forward if options.given == "motors" else solve_inverse
        start = solve(robot, options.first, loads=loads)
    problems: tuple[str, ...] = ()
    try:
        with _progress() as progress:
            found = map_workspace(
                robot,
                grid,
                start=start,
                loads=loads,
                workers=options.workers,
                tolerance=options.tolerance,
                file=options.out,
                resume=not options.restart,
                progress=progress,
                objective=options.objective,
            )
    except MapNotWritten as error:
        found, problems = error.found, (str(error),)
    draw = partial(plot_map, found, field=options.field, threshold=options.threshold)
    problems += written(draw, options.plot)
    values = _as_dict(found, options.threshold)
    if options.json:
        text = as_json(values)
        return Answer(text, found.complete, problems)
    return Answer(_as_text(values), found.complete, problems)


def _grid(robot: Robot, options: argparse.Namespace) -> Grid:
    vary: dict[str, tuple[float, float]] = {}
    held: dict[str, float] = {}
    for part in options.slice:
        match = _PART.match(part)
        if match is None:
            raise InvalidRequest("slice", f"expected NAME=A or NAME=A:B, got {part!r}")
        name, first, last = match.groups()
        if name in vary or name in held:
            raise InvalidRequest("slice", f"{name} is given twice")
        try:
            if last is None:
                held[name] = number(first)
            else:
                vary[name] = number(first), number(last)
        except argparse.ArgumentTypeError:
            raise InvalidRequest("slice", f"expected numbers, got {part!r:.200}") from None
    make = motor_grid if options.given == "motors" else pose_grid
    return make(robot, vary, held, resolution=options.resolution)


def _as_dict(found: WorkspaceMap, threshold: float) -> dict[str, Any]:
    return {
        "robot": found.robot.description.name,
        **asdict(summary_of(found, threshold)),
        "energy_criterion_applies": found.energy_criterion_applies,
        "borders": [
            {
                "kind": border.kind,
                "points": border.points.tolist(),
                "before": border.before.tolist(),
                "after": border.after.tolist(),
            }
            for border in found.borders
        ],
    }


def _as_text(values: dict[str, Any]) -> str:
    shape = " x ".join(str(number) for number in values["shape"])
    stable = "stable with the motors held"
    if not values["energy_criterion_applies"]:
        stable = "energy does not decide stability under these loads; index 0"
    lines = [
        f"{values['robot']}: {values['reached']} of {values['cells']} cells ({shape}) are reached"
        + ("" if values["complete"] else "; the map is NOT complete"),
        f"  {stable}: {values['stable']}; beyond limits: {values['beyond_limits']}",
        f"  usable (stable and within limits all the way): {values['usable']}",
        f"  inverse condition number of H_r below the threshold: {values['below_threshold']}",
        f"  two ways to a cell disagree: {values['disagreements']}",
    ]
    for border in values["borders"]:
        lines.append(f"  border {border['kind']}: {len(border['points'])} points")
    return "\n".join(lines)


@contextmanager
def _progress() -> Iterator[Callable[[Progress], None]]:
    """A progress bar with rate and time left on a terminal, nothing elsewhere."""
    with tqdm(total=None, unit=" cells", desc="mapped", disable=None, leave=False) as bar:

        def show(state: Progress) -> None:
            bar.total = state.total
            bar.set_postfix(reached=state.reached, refresh=False)
            bar.update(state.done - bar.n)

        yield show

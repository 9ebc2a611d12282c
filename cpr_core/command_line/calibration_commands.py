# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Commands ``cpr measure`` and ``cpr calibrate``: where to measure, and what measurements tell."""

from __future__ import annotations

import argparse
import math
import sys
import warnings
from functools import partial
from pathlib import Path
from typing import Any, get_args

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..identification.calibration import calibrate
from ..identification.calibration_result import CalibrationResult, CalibrationWarning
from ..identification.compared_layout import KINDS
from ..identification.measurement_file import read_measurements, write_poses
from ..identification.measurements import StandardDeviations
from ..identification.proposed_poses import ProposedPoses, propose_poses
from ..identification.robust_loss import Loss
from ..model.robot import Robot
from .answer import Answer, written
from .argument_types import new_file, picture
from .reports import as_json, json_number
from .shared_options import add_seed, progress_bar

__all__ = ["add_calibrate_options", "add_measure_options"]


def add_calibrate_options(parser: argparse.ArgumentParser) -> None:
    """Options of ``cpr calibrate``."""
    parser.set_defaults(run=_calibrate)
    parser.add_argument("data", type=Path, metavar="DATA", help="CSV file of measurements")
    _add_parameters(parser)
    parser.add_argument(
        "--bound",
        nargs=3,
        action="append",
        default=[],
        metavar=("PATH", "LOW", "HIGH"),
        help="lowest and highest value of a parameter; may be given several times",
    )
    parser.add_argument(
        "--loss",
        choices=get_args(Loss),
        default="linear",
        help="how measurements that are far off count: as squares (linear), or less; default "
        "%(default)s",
    )
    parser.add_argument(
        "--out", type=new_file, metavar="FILE", help="write the calibrated description (yaml)"
    )
    parser.add_argument(
        "--plot", type=picture, metavar="FILE", help="draw the residuals (png, svg, pdf)"
    )
    parser.add_argument(
        "--despite-warnings", action="store_true", help="write also where something looks wrong"
    )


def add_measure_options(parser: argparse.ArgumentParser) -> None:
    """Options of ``cpr measure``."""
    parser.set_defaults(run=_measure)
    _add_parameters(parser)
    parser.add_argument(
        "--count", type=int, default=20, metavar="N", help="how many poses; default %(default)s"
    )
    parser.add_argument(
        "--reach",
        type=float,
        default=0.5,
        metavar="R",
        help="farthest that motors move from home, rad and rod lengths; default %(default)s",
    )
    parser.add_argument(
        "--margin",
        type=float,
        default=0.2,
        metavar="M",
        help="smallest margin of stability at a pose; default %(default)s",
    )
    add_seed(parser, "seed of the random candidates")
    parser.add_argument(
        "--out", type=new_file, metavar="FILE", help="write motors and expected poses (csv)"
    )
    parser.add_argument(
        "--replace",
        action="store_true",
        help="write --out also where a file is, which may have measurements by now",
    )


def _add_parameters(parser: argparse.ArgumentParser) -> None:
    """What is to be found, and how exact measurements are."""
    parser.add_argument(
        "--parameters",
        nargs="+",
        action="extend",
        required=True,
        metavar="PATH",
        help="numbers of the description, such as rod.young_modulus",
    )
    parser.add_argument(
        "--deviations",
        nargs="+",
        action="extend",
        required=True,
        type=_deviation,
        metavar="KIND=VALUE",
        help="standard deviations of what is measured: "
        + ", ".join(f"{name} [{kind.unit}]" for name, kind in KINDS.items()),
    )


def _deviation(text: str) -> tuple[str, float]:
    kind, _, value = text.partition("=")
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if kind not in KINDS or not 0.0 < number < math.inf:
        raise argparse.ArgumentTypeError(
            f"expected one of {', '.join(KINDS)}, =, and a positive number, got {text!r}"
        )
    return kind, number


def _deviations(options: argparse.Namespace) -> StandardDeviations:
    """Standard deviations of what is measured.

    Raises:
        InvalidRequest: One of them is given twice, or is beyond what can be computed with.
    """
    kinds = [kind for kind, _ in options.deviations]
    for number, kind in enumerate(kinds):
        if kind in kinds[:number]:
            raise InvalidRequest("--deviations", f"expected every kind once, {kind} is given twice")
    return StandardDeviations(**dict(options.deviations))


def _bounds(options: argparse.Namespace) -> dict[str, tuple[float, float]]:
    """Bounds by path.

    Raises:
        InvalidRequest: No numbers, or bounds of one parameter twice.
    """
    found: dict[str, tuple[float, float]] = {}
    for path, low, high in options.bound:
        if path in found:
            raise InvalidRequest("--bound", f"expected every parameter once, {path} is given twice")
        try:
            found[path] = float(low), float(high)
        except ValueError:
            problem = f"expected two numbers after {path}, got {low} {high}"
            raise InvalidRequest("--bound", problem) from None
    return found


def _calibrate(robot: Robot, loads: Loads | None, options: argparse.Namespace) -> Answer:
    """Calibrate, done if the answer can be used without a second look."""
    deviations, bounds = _deviations(options), _bounds(options)
    rows = read_measurements(robot, options.data, loads)
    with progress_bar("of the calibration") as progress, warnings.catch_warnings():
        warnings.simplefilter("ignore", CalibrationWarning)  # the report has them
        found = calibrate(
            robot,
            rows,
            options.parameters,
            deviations,
            bounds=bounds,
            loss=options.loss,
            progress=progress,
        )
    usable = not found.doubts or options.despite_warnings
    files: list[str] = []
    problems: tuple[str, ...] = ()
    for write, file in ((_write_description, options.out), (_plot, options.plot)):
        if usable and file is not None:
            problem = written(partial(write, found), file)
            problems += problem
            files += [] if problem else [str(file)]
    if str(options.out) in files and options.modes is not None:
        print(
            f"cpr: {options.out} does not hold the number of modes: what was found holds with "
            f"--modes {options.modes}, or with that number in its strain",
            file=sys.stderr,
        )
    if not usable and (options.out is not None or options.plot is not None):
        print(
            "cpr: nothing is written: see the warnings, or say --despite-warnings", file=sys.stderr
        )
    if options.json:
        text = as_json(_result_as_dict(found, files))
        return Answer(text, usable, problems)
    return Answer(_result_as_text(found, files), usable, problems)


def _write_description(found: CalibrationResult, file: Path) -> None:
    file.write_text(found.robot.description.text, encoding="utf-8")


def _plot(found: CalibrationResult, file: Path) -> None:
    from ..drawing.calibration_plot import plot_calibration

    plot_calibration(found, file)


def _result_as_dict(found: CalibrationResult, files: list[str]) -> dict[str, Any]:
    """The answer as plain values, SI units."""
    return {
        "robot": found.robot.description.name,
        "rows": len(found.rows),
        "parameters": {
            path: {
                "before": float(before),
                "value": float(value),
                "standard_deviation": json_number(deviation),
            }
            for path, before, value, deviation in zip(
                found.parameters, found.start, found.values, found.standard_deviations, strict=True
            )
        },
        "correlations": [[json_number(value) for value in row] for row in found.correlations],
        "residuals": {
            kind: {"before": before, "after": after}
            for kind, before, after in _root_mean_squares(found)
        },
        "fit": found.fit,
        "undetermined": list(found.undetermined),
        "warnings": list(found.doubts),
        "written": files,
    }


def _root_mean_squares(found: CalibrationResult) -> list[tuple[str, float, float]]:
    """Kinds, and the root mean square of their residuals before and after."""
    before, after = found.differences(calibrated=False), found.differences()
    return [
        (kind, float((before[kind] ** 2).mean() ** 0.5), float((after[kind] ** 2).mean() ** 0.5))
        for kind in after
    ]


def _result_as_text(found: CalibrationResult, files: list[str]) -> str:
    """The same for people."""
    width = max(len(path) for path in found.parameters)
    name = found.robot.description.name
    lines = [f"{name}: {len(found.parameters)} parameters from {len(found.rows)} rows"]
    lines.append(f"  {'':{width}}  {'before':>13}  {'value':>13}  standard deviation")
    each = zip(found.parameters, found.start, found.values, found.standard_deviations, strict=True)
    for path, before, value, deviation in each:
        shown = f"{deviation:18.3g}" if math.isfinite(deviation) else "    not determined"
        lines.append(f"  {path:{width}}  {before:13.7g}  {value:13.7g}  {shown}")
    for kind, before, after in _root_mean_squares(found):
        lines.append(f"  {kind:<9} root mean square {before:.3g} -> {after:.3g} {KINDS[kind].unit}")
    lines.append(f"  residuals over what the standard deviations say: {found.fit:.2f}")
    lines += [f"  {line}" for line in found.undetermined]
    lines += [f"  WARNING: {line}" for line in found.doubts]
    lines += [f"  written: {file}" for file in files]
    return "\n".join(lines)


def _measure(robot: Robot, loads: Loads | None, options: argparse.Namespace) -> Answer:
    """Propose poses."""
    deviations = _deviations(options)
    if options.out is not None and options.out.is_file() and not options.replace:
        problem = (
            f"{options.out} is there already: another name, or --replace if nothing in it counts"
        )
        raise InvalidRequest("--out", problem)
    with progress_bar("of the candidates") as progress:
        found = propose_poses(
            robot,
            options.parameters,
            deviations,
            options.count,
            loads=() if loads is None else (loads,),
            reach=options.reach,
            margin=options.margin,
            seed=options.seed,
            progress=progress,
        )
    write = partial(
        write_poses,
        equilibria=found.equilibria,
        deviations=deviations,
        loads=loads,
        home_first=found.home_first,
    )
    problems = written(write, options.out)
    if options.json:
        return Answer(as_json(_poses_as_dict(found)), True, problems)
    return Answer(_poses_as_text(found), True, problems)


def _poses_as_dict(found: ProposedPoses) -> dict[str, Any]:
    """Proposed poses as plain values, SI units."""
    robot = found.equilibria[0].robot
    return {
        "robot": robot.description.name,
        "motor_names": list(robot.motor_names),
        "motors": [each.motors.tolist() for each in found.equilibria],
        "home_first": list(found.home_first),
        "platform_positions": [each.platform_position.tolist() for each in found.equilibria],
        "platform_quaternions_wxyz": [
            each.platform_quaternion.tolist() for each in found.equilibria
        ],
        "standard_deviations": {
            path: {"proposed": json_number(own), "random": json_number(other)}
            for path, own, other in zip(
                found.parameters, found.standard_deviations, found.random, strict=True
            )
        },
        "undetermined": list(found.undetermined),
        "warnings": list(found.doubts),
    }


def _poses_as_text(found: ProposedPoses) -> str:
    """The same for people."""
    robot = found.equilibria[0].robot
    lines = [f"{robot.description.name}: {len(found.equilibria)} poses", f"  {robot.motor_list}"]
    for equilibrium, by_home in zip(found.equilibria, found.home_first, strict=True):
        line = " ".join(f"{value:9.5f}" for value in equilibrium.motors)
        lines.append(f"  {line}" + "  back home first" * by_home)
    lines.append("  standard deviations after them, and after as many random ones:")
    each = zip(found.parameters, found.standard_deviations, found.random, strict=True)
    lines += [f"  {path:<24} {own:10.3g} {other:10.3g}" for path, own, other in each]
    lines += [f"  {line}" for line in found.undetermined]
    lines += [f"  WARNING: {line}" for line in found.doubts]
    return "\n".join(lines)

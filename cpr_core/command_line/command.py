# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Command line ``cpr``: solve a robot's equilibria without ROS."""

from __future__ import annotations

import argparse
import atexit
import gc
import io
import os
import re
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from ..description.description_file import shipped_robots
from ..description.loads import Loads
from ..errors import CprError, DescriptionError, InvalidRequest, warnings_as_lines
from ..model.equilibrium import Equilibrium
from ..model.kinemato_statics import kinemato_statics
from ..model.robot import Robot
from ..rods.rod import MOST_MODES
from ..solving.discretisation_error import error_of
from ..solving.geometrico_statics import solve_forward, solve_inverse
from ..solving.home import solve_home
from ..solving.load_robot import load_robot
from ..version import __version__
from .answer import Answer, written
from .argument_types import check_files, count, length
from .calibration_commands import add_calibrate_options, add_measure_options
from .compile_command import compile_all, show_compilation
from .modes_command import add_modes_options
from .path_commands import add_equilibria_options, add_trace_options
from .reports import (
    as_json,
    equilibrium_as_dict,
    equilibrium_as_text,
    error_as_dict,
    error_as_text,
    kinemato_statics_as_dict,
    kinemato_statics_as_text,
    stability_as_dict,
    stability_as_text,
)
from .shared_options import add_motors, add_objective, add_place, add_plot, add_pose
from .view_command import add_view_options
from .workspace_commands import add_workspace_options

__all__ = ["command_parser", "main"]

_NEGATIVE_NUMBER = re.compile(
    r"^-(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$|^-(inf|nan)$|^-[\d.]*\*?pi(/[\d.]+)?$", re.IGNORECASE
)

Report = Callable[[Equilibrium, argparse.Namespace], str]
AddOptions = Callable[[argparse.ArgumentParser], None]

EXIT_NO_SOLUTION = 1
EXIT_BAD_ARGUMENTS = 2
EXIT_INTERRUPTED = 130
EXIT_NO_READER = 141  # as shells have it: 128 and SIGPIPE


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status (0; 1 no solution; 2 bad arguments; 130, 141)."""
    if arguments is None:  # the process is all ours
        _look_past_what_stays()
    if sys.stdout is None:  # closed (`cpr ... >&-`)
        print("cpr: error: standard output is closed", file=sys.stderr)
        return EXIT_NO_SOLUTION
    if isinstance(sys.stdout, io.TextIOWrapper):  # names may have letters that it has not
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        try:
            return _answered(arguments)
        finally:  # also of help, after which argparse ends it all
            sys.stdout.flush()
    except BrokenPipeError:  # whoever reads has seen enough (`cpr ... | head`)
        _print_no_more()
        return EXIT_NO_READER
    except OSError as error:  # the answer cannot be printed (`cpr ... > /dev/full`)
        _print_no_more()
        print(f"cpr: error: {error}", file=sys.stderr)
        return EXIT_NO_SOLUTION
    except KeyboardInterrupt:
        print("cpr: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED


def _look_past_what_stays() -> None:
    """Python's collector would look through all that was imported, three times at the end: for 0.2 s."""
    gc.freeze()
    atexit.register(gc.freeze)


def _answered(arguments: Sequence[str] | None) -> int:
    """Print the answer, or why there is none; returns the exit status."""
    options = command_parser().parse_args(arguments)
    try:
        with show_compilation(), warnings_as_lines("cpr: warning: "):
            return _run(options)
    except CprError as error:
        return _report_error(error, options.json)
    except MemoryError as error:  # numpy says how much it asked for
        return _report_error(CprError(f"out of memory: {error}"), options.json)


def _print_no_more() -> None:
    """What is left to be printed goes nowhere, lest the interpreter fails at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _run(options: argparse.Namespace) -> int:
    if options.robot is None:
        print(compile_all())
        return 0
    _check_files(options)
    robot = load_robot(options.robot, modes=options.modes)
    answer: Answer = options.run(robot, _loads(robot, options), options)
    if answer.text:
        print(answer.text, flush=True)
    for problem in answer.problems:  # not as JSON, for the answer was
        print(f"cpr: error: {problem}", file=sys.stderr)
    if answer.problems:
        return EXIT_BAD_ARGUMENTS
    return 0 if answer.done else EXIT_NO_SOLUTION


def _check_files(options: argparse.Namespace) -> None:
    """Whether no file of a command is lost to another one, whatever files it has.

    Raises:
        InvalidRequest: One would be.
    """
    described = shipped_robots().get(options.robot, Path(options.robot))
    check_files(
        {"ROBOT": described, "DATA": getattr(options, "data", None)},
        {f"--{name}": getattr(options, name, None) for name in ("out", "plot")},
    )


def command_parser() -> argparse.ArgumentParser:
    """All commands with their options; docs/command_line.md lists them."""
    parser = argparse.ArgumentParser(
        prog="cpr",
        description="Equilibria of continuum parallel robots. SI units, radians.",
        epilog=f"Shipped robots: {', '.join(shipped_robots())}.",
    )
    parser.add_argument("--version", action="version", version=f"cpr {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, (add_options, meaning) in _COMMANDS.items():
        about = f"{meaning[0].upper()}{meaning[1:]}."
        add_options(commands.add_parser(name, help=meaning, description=about))
    return parser


def _add_forward(parser: argparse.ArgumentParser) -> None:
    _add_common(parser, _report_equilibrium)
    add_motors(parser)
    _add_error(parser)
    add_plot(parser, "the robot")


def _add_inverse(parser: argparse.ArgumentParser) -> None:
    _add_common(parser, _report_equilibrium)
    add_pose(parser, required=True)
    add_objective(parser)
    _add_error(parser)
    add_plot(parser, "the robot")


def _add_stability(parser: argparse.ArgumentParser) -> None:
    _add_common(parser, _report_stability)
    add_place(parser)
    parser.add_argument(
        "--motors-are",
        choices=["locked", "free"],
        default="locked",
        help="held in position (locked), or at constant effort (free); default %(default)s",
    )


def _add_kinemato(parser: argparse.ArgumentParser) -> None:
    _add_common(parser, _report_kinemato_statics)
    add_place(parser)
    parser.add_argument(
        "--characteristic-length",
        type=length,
        metavar="L",
        help="weighs rotations against lengths in singular values, m; else the mean rod length",
    )


def _running(add_options: AddOptions, *, at_motors: bool = False) -> AddOptions:
    """The options of all commands before those of one that does more than to report an equilibrium."""

    def add(parser: argparse.ArgumentParser) -> None:
        _add_common(parser, None)
        if at_motors:
            add_motors(parser)
        add_options(parser)

    return add


def _add_compile(parser: argparse.ArgumentParser) -> None:
    parser.set_defaults(robot=None, json=False)


def _add_error(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--error", action="store_true", help="estimate what continuous rods would change"
    )


def _add_common(parser: argparse.ArgumentParser, report: Report | None) -> None:
    parser.set_defaults(
        run=_reported, report=report, motors=None, pose=None, objective=None, plot=None
    )
    # argparse takes -1e-3 for an option; it knows negative numbers without an exponent only.
    parser._negative_number_matcher = _NEGATIVE_NUMBER
    parser.add_argument("robot", metavar="ROBOT", help="name of a shipped robot, or YAML file")
    parser.add_argument(
        "--modes",
        type=partial(count, least=1, most=MOST_MODES),
        metavar="M",
        help="strain modes per direction, in every direction that has any; not for B-splines; else "
        "the description's",
    )
    parser.add_argument(
        "--gravity",
        nargs=3,
        type=float,
        metavar=("GX", "GY", "GZ"),
        help="m/s^2, axes of the world; else the description's",
    )
    parser.add_argument(
        "--wrench",
        nargs=6,
        type=float,
        metavar=("MX", "MY", "MZ", "FX", "FY", "FZ"),
        help="moment and force on the platform origin, fixed in space, N m and N; in place of "
        "platform_force; else the description's",
    )
    parser.add_argument("--json", action="store_true", help="print JSON; else text")


def _reported(robot: Robot, loads: Loads | None, options: argparse.Namespace) -> Answer:
    """What a command says of one equilibrium, and its picture."""
    equilibrium = _solved(robot, loads, options)
    problems = written(partial(_plot_equilibrium, equilibrium), options.plot)
    return Answer(options.report(equilibrium, options), True, problems)


def _plot_equilibrium(equilibrium: Equilibrium, file: Path) -> None:
    from ..drawing.path_plots import plot_equilibrium

    plot_equilibrium(equilibrium, file)


def _solved(robot: Robot, loads: Loads | None, options: argparse.Namespace) -> Equilibrium:
    """The equilibrium a command is about."""
    if options.pose is not None:
        return solve_inverse(robot, options.pose, loads=loads, objective=options.objective)
    motors = solve_home(robot).motors if options.motors is None else options.motors
    return solve_forward(robot, motors, loads=loads)


def _report_equilibrium(equilibrium: Equilibrium, options: argparse.Namespace) -> str:
    error = None
    if options.error:
        held = options.pose is not None and not equilibrium.robot.redundancy
        error = error_of(equilibrium, "pose" if held else "motors")
    if options.json:
        told = {} if error is None else {"discretisation_error": error_as_dict(error)}
        return as_json(equilibrium_as_dict(equilibrium) | told)
    text = equilibrium_as_text(equilibrium)
    return text if error is None else f"{text}\n{error_as_text(equilibrium, error)}"


def _report_stability(equilibrium: Equilibrium, options: argparse.Namespace) -> str:
    if options.json:
        return as_json(stability_as_dict(equilibrium, options.motors_are))
    return stability_as_text(equilibrium, options.motors_are)


def _report_kinemato_statics(equilibrium: Equilibrium, options: argparse.Namespace) -> str:
    model, length = kinemato_statics(equilibrium), options.characteristic_length
    if options.json:
        return as_json(kinemato_statics_as_dict(model, length))
    return kinemato_statics_as_text(model, length)


def _loads(robot: Robot, options: argparse.Namespace) -> Loads | None:
    if options.gravity is None and options.wrench is None:
        return None
    return robot.default_loads.with_(gravity=options.gravity, wrench_world=options.wrench)


def _report_error(error: CprError, in_json: bool) -> int:
    if in_json:
        print(as_json({"error": {"code": error.code, "message": str(error)}}))
    else:
        print(f"cpr: error: {error}", file=sys.stderr)
    bad = isinstance(error, InvalidRequest | DescriptionError)
    return EXIT_BAD_ARGUMENTS if bad else EXIT_NO_SOLUTION


#: What adds the options of every command, and what the command is for.
_COMMANDS: dict[str, tuple[AddOptions, str]] = {
    "forward": (_add_forward, "motor positions to platform pose"),
    "inverse": (_add_inverse, "platform pose to motor positions"),
    "stability": (_add_stability, "spectrum of the reduced Hessian"),
    "kinemato": (_add_kinemato, "Jacobians, compliance, singularities"),
    "trace": (_running(add_trace_options), "a path of equilibria, and what happens on it"),
    "equilibria": (
        _running(add_equilibria_options, at_motors=True),
        "all equilibria at given motors",
    ),
    "modes": (add_modes_options, "how exact numbers of strain modes are near home"),
    "workspace": (_running(add_workspace_options), "a map of what can be reached, with borders"),
    "measure": (_running(add_measure_options), "where to measure, to find parameters"),
    "calibrate": (_running(add_calibrate_options), "parameters from measurements"),
    "view": (
        _running(add_view_options, at_motors=True),
        "look at the robot and move it, in the browser",
    ),
    "compile": (_add_compile, "compile the kernels now, not when a command needs them first"),
}

"""Command line ``cpr``: solve a robot's equilibria without ROS."""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from collections.abc import Sequence
from typing import Any

from . import __version__
from .description import shipped_robots
from .equilibrium import Equilibrium
from .errors import CprError, DescriptionError, InvalidRequest
from .geometrico_statics import pose_meaning, solve_forward, solve_inverse
from .loads import Loads
from .robot import Robot, load_robot

__all__ = ["main"]

_NEGATIVE_NUMBER = re.compile(r"^-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$|^-(inf|nan)$", re.IGNORECASE)

EXIT_NO_SOLUTION = 1
EXIT_BAD_ARGUMENTS = 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status (0, 1 no solution, 2 bad arguments)."""
    options = _parser().parse_args(arguments)
    try:
        robot = load_robot(options.robot, modes=options.modes)
        result = options.solve(robot, options)
    except CprError as error:
        return _report_error(error, options.json)
    if options.json:
        print(json.dumps(equilibrium_as_dict(result), indent=2, allow_nan=False))
    else:
        print(_equilibrium_as_text(result))
    return 0


def equilibrium_as_dict(equilibrium: Equilibrium) -> dict[str, Any]:
    """An equilibrium as plain values, SI units; what a JSON value cannot hold becomes None."""
    robot = equilibrium.robot
    locked, free = equilibrium.spectrum_locked, equilibrium.spectrum_free
    return {
        "robot": robot.description.name,
        "converged": equilibrium.converged,
        "residual": equilibrium.residual,
        "iterations": equilibrium.iterations,
        "motor_names": list(robot.motor_names),
        "motors": equilibrium.motors.tolist(),
        "efforts": equilibrium.efforts.tolist(),
        "platform": {
            "position": equilibrium.platform_position.tolist(),
            "quaternion_wxyz": equilibrium.platform_quaternion.tolist(),
        },
        "leg_coordinates": equilibrium.leg_coordinates.tolist(),
        "multipliers": equilibrium.multipliers.tolist(),
        "energy": equilibrium.energy,
        "index_locked": locked.index,
        "index_free": free.index,
        "smallest_eigenvalue_locked": float(locked.eigenvalues[0]),
        "smallest_eigenvalue_free": float(free.eigenvalues[0]),
        "margin_locked": None if math.isnan(locked.margin) else locked.margin,
        "energy_criterion_applies": locked.energy_criterion_applies,
    }


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="cpr",
        description="Equilibria of continuum parallel robots. SI units, radians.",
        epilog=f"Shipped robots: {', '.join(shipped_robots())}.",
    )
    parser.add_argument("--version", action="version", version=f"cpr {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    forward = commands.add_parser("forward", help="motor positions to platform pose")
    forward.set_defaults(solve=_forward)
    _add_common(forward)
    forward.add_argument(
        "--motors", nargs="+", type=float, required=True, metavar="Q", help="motor positions"
    )

    inverse = commands.add_parser("inverse", help="platform pose to motor positions")
    inverse.set_defaults(solve=_inverse)
    _add_common(inverse)
    inverse.add_argument(
        "--pose",
        nargs="+",
        type=float,
        required=True,
        metavar="C",
        help="controlled coordinates in the order of the description; full pose: x y z qw qx qy qz",
    )
    return parser


def _add_common(parser: argparse.ArgumentParser) -> None:
    # argparse takes -1e-3 for an option; it knows negative numbers without an exponent only.
    parser._negative_number_matcher = _NEGATIVE_NUMBER
    parser.add_argument("robot", metavar="ROBOT", help="YAML file or name of a shipped robot")
    parser.add_argument(
        "--modes", type=_mode_count, metavar="M", help="strain modes per direction; else the file's"
    )
    parser.add_argument(
        "--gravity", nargs=3, type=float, metavar=("GX", "GY", "GZ"), help="m/s^2; else the file's"
    )
    parser.add_argument(
        "--wrench",
        nargs=6,
        type=float,
        metavar=("MX", "MY", "MZ", "FX", "FY", "FZ"),
        help="on the platform origin, fixed in space, N m and N; else none",
    )
    parser.add_argument("--json", action="store_true", help="print JSON")


def _mode_count(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 40:
        raise argparse.ArgumentTypeError(
            f"expected a whole number from 1 to 40, got {int(text) if text.isdecimal() else repr(text)}"
        )
    return int(text)


def _forward(robot: Robot, options: argparse.Namespace) -> Equilibrium:
    return solve_forward(robot, options.motors, loads=_loads(robot, options))


def _inverse(robot: Robot, options: argparse.Namespace) -> Equilibrium:
    return solve_inverse(robot, options.pose, loads=_loads(robot, options))


def _loads(robot: Robot, options: argparse.Namespace) -> Loads | None:
    if options.gravity is None and options.wrench is None:
        return None
    return robot.default_loads.with_(gravity=options.gravity, wrench_world=options.wrench)


def _report_error(error: CprError, as_json: bool) -> int:
    if as_json:
        print(json.dumps({"error": {"code": error.code, "message": str(error)}}, indent=2))
    else:
        print(f"cpr: error: {error}", file=sys.stderr)
    bad = isinstance(error, InvalidRequest | DescriptionError)
    return EXIT_BAD_ARGUMENTS if bad else EXIT_NO_SOLUTION


def _equilibrium_as_text(equilibrium: Equilibrium) -> str:
    robot = equilibrium.robot
    lines = [f"{robot.description.name}: equilibrium, residual {equilibrium.residual:.1e}"]
    for leg in robot.description.legs:
        if leg.motor_name is not None:
            row = robot.motor_names.index(leg.motor_name)
            effort_unit = "N m" if leg.motor.unit == "rad" else "N"
            lines.append(
                f"  {leg.motor_name:<12} {equilibrium.motors[row]:14.10f} {leg.motor.unit:<3} "
                f"{equilibrium.efforts[row]:14.10f} {effort_unit}"
            )
    position = " ".join(f"{value:14.10f}" for value in equilibrium.platform_position)
    lines.append(f"  platform     {position} m")
    if not robot.description.point_platform:
        quaternion = " ".join(f"{value:14.10f}" for value in equilibrium.platform_quaternion)
        lines.append(f"  quaternion   {quaternion} (w x y z)")
    locked, free = equilibrium.spectrum_locked, equilibrium.spectrum_free
    verdict = "stable" if locked.index == 0 else "UNSTABLE"
    if not locked.energy_criterion_applies:
        verdict = "stability not decided by energy: a non-conservative load acts"
    lines.append(
        f"  {verdict} with motors held (index {locked.index}, margin {locked.margin:.4f}); "
        f"index {free.index} at constant effort"
    )
    lines.append(f"  controlled   {' '.join(pose_meaning(robot))}")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())

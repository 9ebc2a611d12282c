# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the time of a warm forward solve goes.

    .venv/bin/python -m benchmarks.profile_solve --robot six_rfs --modes 5

The time spent in a function itself; a kernel with all kernels it calls. Profiling slows Python down, not
the kernels, so the shares of Python are upper bounds.
"""

from __future__ import annotations

import argparse
import cProfile
import pstats
import sys
from pathlib import Path

from .walks import walk_of

WALKS = 20


def shares(robot: str, modes: int, problem: str = "forward") -> list[tuple[str, float, float]]:
    """Functions by the time in them, most first: name, share, and microseconds a solve."""
    walk = walk_of(robot, modes, problem)
    walk.run()
    profile = cProfile.Profile()
    profile.enable()
    for _ in range(WALKS):
        walk.run()
    profile.disable()
    # Every function (file, line, name) with calls, and time in it.
    entries = pstats.Stats(profile).stats.items()  # type: ignore[attr-defined]
    solves = WALKS * len(walk.requests)
    total = sum(entry[2] for _, entry in entries)
    found = [(_name(*where), entry[2] / total, 1e6 * entry[2] / solves) for where, entry in entries]
    return sorted(found, key=lambda row: -row[1])


def _name(file: str, line: int, function: str) -> str:
    path = Path(file)
    if "cpr_core" in path.parts:
        return (
            f"{'.'.join(path.with_suffix('').parts[path.parts.index('cpr_core') + 1 :])}.{function}"
        )
    return function if file == "~" else f"{path.stem}.{function}"


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="six_rfs")
    parser.add_argument("--modes", type=int, default=5)
    parser.add_argument("--problem", default="forward")
    parser.add_argument("--rows", type=int, default=12)
    options = parser.parse_args()
    found = shares(options.robot, options.modes, options.problem)
    print("| function | share | µs a solve |", "|---|---|---|", sep="\n")
    for name, share, time in found[: options.rows]:
        print(f"| `{name}` | {100.0 * share:.1f} % | {time:.1f} |")
    rest = found[options.rows :]
    print(
        f"| {len(rest)} others | {100.0 * sum(row[1] for row in rest):.1f} % "
        f"| {sum(row[2] for row in rest):.1f} |"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())

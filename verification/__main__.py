# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Compare with other people's programs and published numbers: ``make verify``."""

from __future__ import annotations

import argparse
import platform
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

from tqdm import tqdm

from .cases import CASES
from .comparison import Comparison, Requirement, requirements_of
from .exudyn_comparison import compare_exudyn
from .mujoco_comparison import compare_mujoco
from .not_built import robots_not_built
from .page import publish
from .placed_robot import NotPossible
from .published import published
from .pyelastica_comparison import compare_pyelastica
from .tables import text_of

#: All of it may take so long [s].
LONGEST = 900.0


def main() -> int:
    """Run everything; 1 where a bound is not met."""
    parser = argparse.ArgumentParser(prog="make verify", description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("verification/results"), metavar="FOLDER")
    parser.add_argument("--publish", type=Path, metavar="PAGE", help="write the tables into a page")
    options = parser.parse_args()
    begin = time.perf_counter()
    comparisons: list[Comparison] = []
    requirements: list[Requirement] = []
    impossible = list(robots_not_built())
    for case in tqdm(CASES, desc="Exudyn", unit=" robots", disable=None, leave=False):
        comparisons.append(compare_exudyn(case))
        requirements += requirements_of(comparisons[-1], case.position_bound, case.effort_bound)
    for case in tqdm(CASES, desc="MuJoCo", unit=" robots", disable=None, leave=False):
        try:
            comparisons.append(compare_mujoco(case))
        except NotPossible as reason:
            impossible.append(f"{case.name}, in MuJoCo: {reason}")
            continue
        requirements += requirements_of(comparisons[-1], case.coarse_bound, case.coarse_bound)
    for case in tqdm(CASES, desc="PyElastica", unit=" robots", disable=None, leave=False):
        try:
            comparisons.append(compare_pyelastica(case))
        except NotPossible as reason:
            impossible.append(f"{case.name}, in PyElastica: {reason}")
            continue
        requirements += requirements_of(comparisons[-1], case.damped_bound, case.damped_bound)
    numbers = published()
    requirements += [
        Requirement(number.name, abs(number.difference), number.reach, "")
        for number in numbers
        if not number.met
    ]
    seconds = time.perf_counter() - begin
    requirements.append(Requirement("all tables", seconds, LONGEST, "s"))
    about = (
        f"{datetime.now(UTC):%Y-%m-%d}, {platform.machine()}, Python {platform.python_version()}; "
        f"all of it took {seconds:.0f} s."
    )
    text = text_of(about, comparisons, impossible, numbers, requirements)
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "latest.md").write_text(text, encoding="utf-8")
    print(text)
    if options.publish is not None:
        publish(options.publish, text)
    missed = [requirement for requirement in requirements if not requirement.met]
    for requirement in missed:
        print(
            f"not met: {requirement.name}: {requirement.measured:.2e} {requirement.unit}, "
            f"bound {requirement.bound:.0e}",
            file=sys.stderr,
        )
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())

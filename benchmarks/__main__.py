# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measure everything: ``make bench``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tqdm import tqdm

from .batches import batch_cases
from .linear_algebra import matrix_sizes, model_cases
from .measure import Case, measure
from .other_models import accuracy_facts, path_cases
from .processes import process_figures
from .results import changes, read, surroundings, write
from .scaling import draw, scaling_cases
from .solves import (
    MODES,
    analysis_cases,
    cold_cases,
    steps_per_solve,
    warm_cases,
)
from .tables import report

BATCH, QUICK_BATCH = 10_000, 1_000


def main() -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(prog="make bench", description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="5 modes only, few repeats")
    parser.add_argument("--baseline", type=Path, metavar="FILE", help="JSON of an earlier run")
    parser.add_argument("--out", type=Path, default=Path("benchmarks/results"), metavar="FOLDER")
    parser.add_argument("--name", default="latest", help="of the files; default latest")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="of the growth of the cost")
    options = parser.parse_args()
    begun = surroundings()
    baseline, old = (None, {}) if options.baseline is None else read(options.baseline)
    modes = (5,) if options.quick else MODES
    with tqdm(desc="measuring", unit=" samples", disable=None, leave=False) as bar:

        def progress(key: str) -> None:
            bar.set_postfix_str(key, refresh=False)
            bar.update()

        # New processes first: this one is small yet, and at rest.
        processes = process_figures(3 if options.quick else 11, not options.quick, progress)
        cases = _cases(modes, options.quick)
        repeats, slow_repeats = (5, 2) if options.quick else (25, 7)
        figures = measure(cases, repeats, slow_repeats, progress) | processes
    facts = {f"{name}, at equal accuracy": text for name, text in accuracy_facts().items()}
    sizes = matrix_sizes(modes)
    facts["rows of the matrices of the forward problem"] = ", ".join(
        f"{name.replace('/', ', ')}: {size}" for name, size in sizes.items()
    )
    about = begun | {
        "quick": options.quick,
        "facts": facts,
        "steps": steps_per_solve(modes),
    }
    file = options.out / f"{options.name}.json"
    write(file, about, figures)
    text = report(about, figures, changes(old, figures), baseline)
    file.with_suffix(".md").write_text(text, encoding="utf-8")
    draw(figures, options.plot or file.with_suffix(".png"))
    print(text)
    print(f"written: {file}, {file.with_suffix('.md')}", file=sys.stderr)
    return 0


def _cases(modes: tuple[int, ...], quick: bool) -> list[Case]:
    return [
        *model_cases(modes),
        *warm_cases(modes),
        *analysis_cases(),
        *cold_cases(),
        *path_cases(),
        *batch_cases(QUICK_BATCH if quick else BATCH),
        *scaling_cases(quick),
    ]


if __name__ == "__main__":
    sys.exit(main())

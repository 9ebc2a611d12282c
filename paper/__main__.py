# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""``python -m paper``: compute, compare, draw and report."""

from __future__ import annotations

import argparse
import platform
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import numpy as np
import scipy
from tqdm import tqdm

import cpr_core
from cpr_core import kinemato_statics, numba_fence, solve_home

from . import accuracy, claims, figures, stability, tables, timing
from .cases import RFRFR, SIX_RFS, Case
from .published import TABLE_II, TABLE_IV_ANGLE, TABLE_IV_POSITION
from .report import FIGURES, Evidence, write_report

#: Inverse condition numbers below which Figs. 6 and 12 mark the workspace.
NEAR_BORDER = 0.02


@dataclass(frozen=True)
class Extent:
    """How much is computed.

    Attributes:
        repeats: Repeats of the timing of a fast model.
        slow_repeats: Repeats of slow models.
        literal_counts: n_c for which Mod. #0 is timed.
        modes: Modes of the stability lines, RFRFR and 6-RFS.
        points: Points of the stability lines, RFRFR and 6-RFS.
        spacing: Grid of the workspaces, RFRFR and 6-RFS [m].
    """

    repeats: int
    slow_repeats: int
    literal_counts: tuple[int, ...]
    modes: tuple[int, int]
    points: tuple[int, int]
    spacing: tuple[float, float]


FULL = Extent(21, 3, timing.CONFIGURATIONS, (16, 16), (50, 50), (0.01, 0.01))
QUICK = Extent(5, 1, (50,), (16, 12), (50, 12), (0.04, 0.04))


def main(arguments: list[str] | None = None) -> int:
    """Run the reproduction; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m paper", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="coarser figures, fewer repeats")
    parser.add_argument("--output", type=Path, default=Path("paper/results"), help="folder")
    parser.add_argument("--publish", type=Path, help="folder that gets a copy of the report")
    options = parser.parse_args(arguments)
    begin, extent = time.monotonic(), QUICK if options.quick else FULL
    folder = options.output
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    slow_runs = len(timing.CONFIGURATIONS) + 2 * len(extent.literal_counts)
    steps = 9 + sum(extent.points) + slow_runs * extent.slow_repeats
    shown = "{percentage:3.0f} % |{bar:30}| {elapsed}  {desc}"
    with tqdm(total=steps, bar_format=shown, disable=None) as bar:
        found, checked, evidence = _compute(folder, extent, bar)
    run = {
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "machine": timing.machine(),
        "software": f"Python {platform.python_version()}, numpy {np.__version__}, "
        f"scipy {scipy.__version__}, numba {numba_fence.VERSION}, cpr_core {cpr_core.__version__}",
        "extent": f"{'quick' if options.quick else 'full'}, {time.monotonic() - begin:.0f} s",
    }
    for table in found.values():
        table.write(folder)
        print(table.text())
    for claim in checked:
        print(f"{'met    ' if claim.met else 'NOT MET'}  {claim.text}: {claim.found}")
    write_report(folder, run, checked, found, evidence)
    print(f"\nreport: {folder / 'REPORT.md'}")
    if options.publish is not None:
        options.publish.mkdir(parents=True, exist_ok=True)
        for name in ("REPORT.md", *(f"{figure}.png" for figure in FIGURES)):
            shutil.copy(folder / name, options.publish)
    return 0


def _compute(
    folder: Path, extent: Extent, bar: tqdm
) -> tuple[dict[str, tables.Table], list[claims.Claim], Evidence]:
    def step(text: str) -> None:
        bar.set_description_str(text, refresh=False)
        bar.update()

    step("continuous rods")
    reference_error = max(
        point.integration_error
        for case in (RFRFR, SIX_RFS)
        for point in case.continuous_path()[::10]
    )
    errors = accuracy.all_errors(step)
    planar_times, planar_notes = _times(RFRFR, extent, step)
    spatial_times, spatial_notes = _times(SIX_RFS, extent, step)
    dense = timing.dense_factorization(RFRFR)
    found = {
        **_planar_error_tables(errors),
        "Table III": tables.table_iii(planar_times, planar_notes),
        **_spatial_error_tables(errors),
        "Table VI": tables.table_vi(spatial_times, spatial_notes),
    }

    lines = {}
    for number, (case, figure) in enumerate(((RFRFR, "Fig. 7"), (SIX_RFS, "Fig. 13"))):
        modes, points = extent.modes[number], extent.points[number]
        lines[case.title] = stability.line_of(case.name, modes, points, partial(step, figure))
    _draw(folder, extent, errors, lines, step)

    checked = [
        *claims.accuracy_claims(found, errors.inverse.errors[errors.away].mean(axis=0)),
        *claims.time_claims(planar_times, spatial_times, 50),
        *claims.stability_claims("Fig. 7", lines[RFRFR.title]),
        *claims.stability_claims("Fig. 13", lines[SIX_RFS.title]),
    ]
    finite_times = planar_times["#3", 50]
    evidence = Evidence(
        errors=errors,
        reference_error=reference_error,
        home_motor_error={modes: e.errors[0].max() for modes, e in errors.straight.items()},
        home_position_error={modes: along[0] for modes, along in errors.planar.items()},
        home_from_position={modes: _motor_error_from_position(modes) for modes in errors.planar},
        dense_step=dense,
        finite_iterations=finite_times.iterations if finite_times else float("nan"),
        lines=lines,
    )
    return found, checked, evidence


def _planar_error_tables(errors: accuracy.Errors) -> dict[str, tables.Table]:
    return {
        "Table I": tables.table_i(errors.planar, errors.straight),
        "Table II": tables.error_table(
            "Table II",
            "Errors of finite differences (Mod. #3) against Mod. #2, RFRFR.",
            "Nb. of elts.",
            {"Position error [mm]": tables.Part(errors.finite, TABLE_II, 0.05)},
        ),
    }


def _spatial_error_tables(errors: accuracy.Errors) -> dict[str, tables.Table]:
    return {
        "Table IV": tables.error_table(
            "Table IV",
            "Errors against Mod. #2, 6-RFS.",
            "Modes",
            {
                "Position error [mm]": tables.Part(errors.spatial, TABLE_IV_POSITION, 0.05),
                "Angular error [deg]": tables.Part(errors.angles, TABLE_IV_ANGLE, 0.15),
            },
        ),
        "Table V": tables.table_v(
            errors.inverse,
            errors.away,
            f"those more than {accuracy.AWAY:g} step from the singularity, which is at "
            f"t = {errors.crossing:.3f} of 50",
        ),
    }


def _times(
    case: Case, extent: Extent, step: Callable[[str], None]
) -> tuple[dict[tuple[str, int], timing.Measurement | None], tuple[str, ...]]:
    """All models in one run, every n_c after the other, and what there is to say about them."""
    spatial = case is SIX_RFS
    comparable = timing.comparable_method(case)
    models = timing.models_of(case, comparable)
    measured: dict[tuple[str, int], timing.Measurement | None] = {}
    for count in timing.CONFIGURATIONS:
        chosen = [model for model in models if model.key != "#0" or count in extent.literal_counts]
        text = f"Table {'VI' if spatial else 'III'}, n_c = {count}"
        found = timing.measure(
            chosen, case, count, extent.repeats, extent.slow_repeats, partial(step, text)
        )
        measured |= {(key, count): value for key, value in found.items()}
    notes = [
        f"Medians of {extent.repeats} repeats ({extent.slow_repeats} for #0 and #3) on "
        f"one core of {timing.machine()}, processor time, models taking turns; "
        "residual below 1e-10 for all models; every configuration starts from the one before. "
        "Absolute times are not comparable with the paper's, ratios are.",
        "",
    ]
    for model in models:
        value = measured.get((model.key, 50))
        if value is not None:
            notes.append(
                f"- {model.key}: {model.title}; mean position error {1e3 * value.mean_error:.2g} mm, "
                f"{value.iterations:.1f} steps a configuration, spread of the repeats "
                f"{100 * (value.spread - 1):.0f} %"
            )
    return measured, tuple(notes)


def _motor_error_from_position(modes: int) -> float:
    """Forward error at t = 0, carried to the motors by the platform Jacobian, largest [mdeg]."""
    home = solve_home(RFRFR.robot(modes))
    jacobian = kinemato_statics(home).jacobian
    error = home.platform_position - RFRFR.continuous_path()[0].platform_position
    return float(1e3 * np.degrees(np.abs(np.linalg.solve(jacobian, error[:2])).max()))


def _draw(
    folder: Path,
    extent: Extent,
    errors: accuracy.Errors,
    lines: dict[str, stability.Line],
    step: Callable[[str], None],
) -> None:
    for case, figure in ((RFRFR, "figure_4"), (SIX_RFS, "figure_10")):
        step(FIGURES[figure])
        track = np.array([point.platform_position for point in case.continuous_path()])
        title = f"{case.title} robot, path of Eq. (53), 5 modes"
        figures.draw_path(folder, figure, title, case.modes_path(5, 10), track)
    position, orientation = "position error [mm]", "orientation error [deg]"
    for figure, model, label, shown, counted in (
        ("figure_5a", "RFRFR, strain modes", position, errors.planar, "modes"),
        ("figure_5b", "RFRFR, finite differences", position, errors.finite, "elements"),
        ("figure_11a", "6-RFS, strain modes", position, errors.spatial, "modes"),
        ("figure_11b", "6-RFS, strain modes", orientation, errors.angles, "modes"),
    ):
        title = f"{model} against continuous rods"
        figures.draw_errors(folder, figure, title, label, shown, counted)
    for number, case in enumerate((RFRFR, SIX_RFS)):
        workspace, line, determinants = (
            ("figure_6", "figure_7", "figure_8"),
            ("figure_12", "figure_13", "figure_14"),
        )[number]
        step(FIGURES[workspace])
        found = stability.workspace_of(case.name, 8 if number else 16, extent.spacing[number])
        title = "RFRFR workspace" if number == 0 else "6-RFS slice z = 0.635 m, ZYZ (π/8, π/3, 0)"
        figures.draw_workspace(
            folder, workspace, f"{title}, motors locked", found, lines[case.title], NEAR_BORDER
        )
        figures.draw_line(
            folder, line, f"{case.title} robot, motors locked", lines[case.title], 2 - number
        )
        figures.draw_determinants(folder, determinants, f"{case.title} robot", lines[case.title])


if __name__ == "__main__":
    raise SystemExit(main())

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Results on disk, compared, in tables, and against what is demanded."""

import numpy as np
import pytest

from benchmarks.measure import Figure, summary_of
from benchmarks.requirements import requirements
from benchmarks.results import changes, read, surroundings, write
from benchmarks.scaling import AXES, draw, exponents
from benchmarks.tables import report


def figure(median, spread=0.1, **others):
    return Figure(median, (1 - spread) * median, (1 + spread) * median, 0.5 * median, 9, **others)


def scaling(power, measures=("forward solve", "residual and tangent")):
    return {
        f"scaling, {measure}/{axis}/{number}": figure(1e-5 * number**power)
        for axis, numbers in AXES.items()
        for number in numbers
        for measure in measures
    }


def test_a_run_is_read_as_it_was_written(tmp_path):
    figures = {"forward/six_rfs/5": summary_of([1.0, 2.0, 4.0], "s", "processor")}
    about = surroundings() | {"facts": {"one": "two"}}
    write(tmp_path / "folder" / "run.json", about, figures)
    assert read(tmp_path / "folder" / "run.json") == (about, figures)
    assert {"date", "commit", "machine", "versions"} <= about.keys()


def test_changes_are_flagged_where_the_spreads_do_not_overlap():
    old = {"a": figure(1.0), "b": figure(1.0), "c": figure(1.0), "gone": figure(1.0)}
    new = {"a": figure(1.1), "b": figure(1.5), "c": figure(0.5), "new": figure(1.0)}
    found = changes(old, new)
    assert found.keys() == {"a", "b", "c"}
    assert [found[key].beyond_spread for key in "abc"] == [False, True, True]
    assert found["b"].ratio == pytest.approx(1.5)


def test_tables_show_ratios_and_requirements():
    old = {"forward/six_rfs/5": figure(2e-4), "other": figure(1.0)}
    new = {"forward/six_rfs/5": figure(0.9e-4), "other": figure(1.0)}
    about = surroundings() | {"steps": {"forward/six_rfs/5": 3.25}}
    text = report(about, new, changes(old, new), about)
    row = next(line for line in text.splitlines() if line.startswith("| forward, six_rfs, 5 "))
    assert "90 µs" in row
    assert "3.25" in row
    assert row.endswith("| **0.45** |")
    assert "| other | 1 s | 0.9 s to 1.1 s | 0.5 s | 9 |  |  | 1.00 |" in text
    assert "| warm forward solve, 6-RFS, 5 modes: below 0.1 ms | 90 µs | yes |" in text


@pytest.mark.parametrize("cores", [0.0, 2.5])
def test_a_machine_that_was_busy_is_told(cores):
    about = surroundings() | {"busy cores before": cores}
    said = "2.5 cores busy before the run" in report(about, {"other": figure(1.0)}, {})
    assert said == (cores > 1.0)


def test_requirements_are_met_or_not():
    good = {
        "forward/six_rfs/5": figure(9e-5),
        "dense LU, scipy/six_rfs/5": figure(5e-5),
        "dense LU, LAPACK/six_rfs/5": figure(4e-5),
        "at 1e-6 m, continuous shooting/six_rfs": figure(6e-4),
        "at 1e-6 m, this library/six_rfs": figure(1e-4),
        "forward/rfrfr/5": figure(1.9e-5),
        "path of 51 points/six_rfs/5": figure(5.9e-3),
        "forward/six_rus/8": figure(2.9e-4),
        "forward/six_rfs/8": figure(1e-4),
        "forward and locked index/six_rfs/5": figure(9.1e-5),
        "forward and everything/six_rfs/5": figure(2e-4),
        "inverse/gough_stewart/5": figure(2.9e-4),
        "batch of 9, 1 core/six_rfs/5": figure(1e-4),
        "batch of 9, 2 cores/six_rfs/5": figure(5.2e-5),
        "import cpr_core": figure(0.4),
        "first solve, warm cache": figure(1.4),
        **scaling(1.05),
    }
    met = {line.name: line.met for line in requirements(good)}
    assert len(met) == 17
    assert [name for name in met if not met[name]] == [
        "the same against one dense LU of its matrix (84 x 84, LAPACK): at most 2 times"
    ]
    bad = good | {
        "forward/six_rfs/5": figure(1.1e-4),
        "forward/rfrfr/5": figure(2.1e-5),
        "path of 51 points/six_rfs/5": figure(6.1e-3),
        "at 1e-6 m, this library/six_rfs": figure(2e-4),
        "forward/six_rus/8": figure(3.1e-4),
        "forward and locked index/six_rfs/5": figure(1.4e-4),
        "forward and everything/six_rfs/5": figure(2.8e-4),
        "inverse/gough_stewart/5": figure(3.1e-4),
        "batch of 9, 2 cores/six_rfs/5": figure(9e-5),
        "import cpr_core": figure(0.6),
        "first solve, warm cache": figure(1.6),
        **scaling(2.2),
    }
    assert [line.name for line in requirements(bad) if line.met] == []


def test_exponents_and_plot_are_those_of_the_curves(tmp_path):
    figures = scaling(1.5)
    assert np.allclose(list(exponents(figures).values()), 1.5)
    draw(figures, tmp_path / "cost.png")
    assert (tmp_path / "cost.png").stat().st_size > 10_000

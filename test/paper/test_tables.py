# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Verdicts, formats and files of the tables."""

import csv

import pytest

from paper.accuracy import InverseErrors
from paper.tables import Entry, Part, Table, error_table, number, table_i, table_iii
from paper.tables import statistics as statistics_of
from paper.timing import CONFIGURATIONS, Measurement


@pytest.mark.parametrize(
    ("ours", "paper", "within", "verdict"),
    [
        (1.51, "1.50", 0.03, "agrees"),
        (1.56, "1.50", 0.03, "same size"),
        (0.0136, "0.01", 0.1, "agrees"),  # prints as 0.01
        (0.144, "0.13", 0.1, "agrees"),  # 6.7 % from 0.135, which prints as 0.13 or 0.14
        (0.149, "0.13", 0.1, "same size"),
        (3.3e-3, "3.0e-4", 0.1, "differs"),
        (0.4, "1", 0.1, "differs"),
        (2.0, "", 0.1, ""),
        (None, "2.0", 0.1, ""),
    ],
)
def test_verdicts(ours, paper, within, verdict):
    assert Entry(ours, paper, within).verdict == verdict


def test_deviations_are_from_the_printed_number_and_from_what_rounds_to_it():
    entry = Entry(0.144, "0.13")
    assert entry.deviation == pytest.approx(0.144 / 0.13 - 1)
    assert entry.least_deviation == pytest.approx(0.144 / 0.135 - 1)
    assert Entry(0.128, "0.13").least_deviation == 0.0
    assert Entry(6.6e-5, "6.5e-5").least_deviation == pytest.approx(6.6 / 6.55 - 1)


@pytest.mark.parametrize(
    ("value", "text"),
    [(1.5, "1.50"), (54.834, "54.8"), (325.2, "325"), (9.37e-5, "9.37e-5"), (0.0, "0")],
)
def test_numbers_have_three_digits(value, text):
    assert number(value) == text


def test_a_table_is_written_in_both_forms(tmp_path):
    import numpy as np

    errors = {3: np.array([1.0, 2.0, 6.0])}
    table = error_table(
        "Table X", "Title.", "modes", {"error": Part(errors, {3: ("1.0", "9.0", "3.0")}, 0.05)}
    )
    assert table.columns == ("error Min", "error Max", "error Mean")
    assert statistics_of(errors[3]) == (1.0, 6.0, 3.0)
    table.write(tmp_path)
    assert (
        "| 3 | 1.00 (1.0) ✓ | 6.00 (9.0) ≈ | 3.00 (3.0) ✓ |"
        in (tmp_path / "table_x.md").read_text()
    )
    assert "6.00 (9.0) ≈" in table.text()
    with (tmp_path / "table_x.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["verdict"] for row in rows] == ["agrees", "same size", "agrees"]
    assert float(rows[1]["ours"]) == 6.0
    assert float(rows[1]["deviation"]) == pytest.approx(6.0 / 9.0 - 1.0, abs=1e-4)


def test_what_was_not_measured_stays_empty(tmp_path):
    table = Table("Table Y", "Title.", "n_c", ("a", "b"), (("5", (Entry(None), Entry(2.0))),))
    table.write(tmp_path)
    assert "| 5 | – | 2.00 |" in table.markdown()
    assert ",,," in (tmp_path / "table_y.csv").read_text()


def test_times_are_in_milliseconds_and_ratios_over_the_first_model():
    seconds = {"#1": 0.002, "#2": 0.008, "#3": 0.4}
    measured = {
        (model, count): Measurement(model, count, time, 1.0, 1, 0.0, 3.0)
        for model, time in seconds.items()
        for count in CONFIGURATIONS
    }
    table = table_iii(measured, ())
    entries = dict(zip(table.columns, table.rows[0][1], strict=True))
    found = {name: entry.ours for name, entry in entries.items() if entry.ours is not None}
    assert found == pytest.approx(
        {
            "Mod. #1 [ms]": 2.0,
            "Mod. #2 [ms]": 8.0,
            "Mod. #3 [ms]": 400.0,
            "#2 / #1": 4.0,
            "#3 / #1": 200.0,
        }
    )


def test_poses_that_are_unstable_do_not_count_in_table_i():
    import numpy as np

    errors, position = np.array([[1.0, 2.0], [3.0, 4.0], [50.0, 60.0]]), np.array([0.1, 0.3])
    motors = {modes: InverseErrors(errors, 51, (0, 0, 1)) for modes in (3, 4, 5)}
    table = table_i(dict.fromkeys((3, 4, 5), position), motors)
    for _, entries in table.rows:
        assert [entry.ours for entry in entries[3:]] == [1.0, 4.0, 2.5]

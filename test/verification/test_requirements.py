# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Bounds, and the page they are written to."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from verification.cases import CASES, OurSolve
from verification.comparison import Comparison, requirements_of
from verification.page import FIRST, LAST, publish
from verification.tables import requirement_table, text_of

ROOT = Path(__file__).parents[2]
FOUND = Comparison(
    CASES[0], "Exudyn 1", "cables", "straight", 3e-7, 2e-10, 3e-9, 0.5, OurSolve(9, 1e-12, 0.1), ""
)


def test_a_bound_is_met_below_it_only():
    position, efforts = requirements_of(FOUND, 1e-9, 1e-8)
    assert position.met and efforts.met
    assert position.name == "Exudyn, rfrfr: position"
    position, efforts = requirements_of(replace(FOUND, distance=1e-9, efforts=math.nan), 1e-9, 1e-8)
    assert not position.met and not efforts.met
    assert ["**no**" in line for line in requirement_table([position, efforts])[2:]] == [True, True]


def test_the_bounds_are_those_that_were_promised():
    bounds = {case.name: case.position_bound for case in CASES}
    assert (bounds["rfrfr"], bounds["six_rfs"], bounds["clamped"]) == (1e-9, 1e-7, 1e-6)


def test_the_clamped_robot_twists_its_rods():
    case = next(case for case in CASES if case.name == "clamped")
    strains = case.ours.leg_coordinates.reshape(3, -1)
    assert np.abs(strains[:, 0]).min() > 0.4  # 1/m: torsion is the first direction
    assert case.distance(case.ours.platform_position) < 1e-12


def test_our_modes_are_as_few_as_the_distance_allows():
    case = CASES[0]
    near, far = case.as_accurate_as(1e-9, repeats=1), case.as_accurate_as(1e-4, repeats=1)
    assert near.distance <= 1e-9 and far.distance <= 1e-4
    assert far.modes < near.modes < 14


def test_tables_go_between_the_marks_and_nowhere_else(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(f"before\n{FIRST}\nold\n{LAST}\nafter\n")
    publish(page, text_of("today", [FOUND], ["why not"], [], requirements_of(FOUND, 1e-9, 1e-8)))
    text = page.read_text()
    assert text.startswith(f"before\n{FIRST}\ntoday\n") and text.endswith(f"yes |\n{LAST}\nafter\n")
    assert (
        "old" not in text and "| rfrfr | Exudyn 1: cables | straight | 3.0e-07 | 2.0e-10 |" in text
    )
    page.write_text("no marks")
    with pytest.raises(SystemExit, match="no place for the tables"):
        publish(page, "text")


def test_the_page_has_tables_of_a_run_that_met_all_bounds():
    text = (ROOT / "docs/verification.md").read_text()
    tables = text[text.index(FIRST) : text.index(LAST)]
    assert "**no**" not in tables
    for case in CASES:
        assert f"| {case.name} | Exudyn " in tables
    assert "| rfrfr | PyElastica " in tables

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the tables of errors have to show; continuous rods themselves against the reference paths."""

import csv
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from cpr_core.lie import rotation_exp, rotation_from_quaternion
from paper import accuracy, published
from paper.cases import RFRFR, SIX_RFS, SLICE_ROTATION, slice_pose

DATA = Path(__file__).parents[1] / "data"


@pytest.mark.parametrize(
    ("case", "file"), [(RFRFR, "rfrfr_forward_path.csv"), (SIX_RFS, "6rfs_forward_path.csv")]
)
def test_what_errors_refer_to(case, file):
    lines = [line for line in (DATA / file).read_text().splitlines() if not line.startswith("#")]
    place = ["x", "y"] if case is RFRFR else ["px", "py", "pz"]
    compared = 0
    for row in csv.DictReader(lines):
        t = int(row["t"])
        expected = [float(row[key]) for key in place]
        point = case.continuous_path()[t]
        assert_allclose(point.platform_position[: len(place)], expected, atol=1e-10)
        motors = [float(row[f"q{k + 1}"]) for k in range(len(case.first))]
        assert_allclose(case.path()[t], motors, atol=1e-12)
        compared += 1
    assert compared == (51 if case is RFRFR else 6)


@pytest.mark.parametrize("modes", accuracy.MODES)
def test_table_i(modes):
    errors = accuracy.position_errors(RFRFR, modes)
    _, largest, mean = (float(text) for text in published.TABLE_I_POSITION[modes])
    assert errors.mean() == pytest.approx(mean, rel=0.03)
    # 0.13 is printed with two digits: 0.144 is within 10 % of what rounds to it.
    assert errors.max() == pytest.approx(largest, rel=0.1, abs=0.1 * largest + 0.005)


@pytest.mark.parametrize("elements", accuracy.ELEMENTS)
def test_table_ii(elements):
    mean = float(published.TABLE_II[elements][2])
    assert accuracy.finite_difference_errors(elements).mean() == pytest.approx(mean, rel=0.05)


@pytest.mark.parametrize("modes", accuracy.MODES)
def test_table_iv(modes):
    position = float(published.TABLE_IV_POSITION[modes][2])
    angle = float(published.TABLE_IV_ANGLE[modes][2])
    assert accuracy.position_errors(SIX_RFS, modes).mean() == pytest.approx(position, rel=0.05)
    assert accuracy.angle_errors(SIX_RFS, modes).mean() == pytest.approx(angle, rel=0.15)


@pytest.mark.parametrize("axis", np.eye(3))
def test_an_angle_counts_about_every_axis(axis):
    paths = [[SimpleNamespace(platform_rotation=rotation_exp(size * axis))] for size in (0.0, 0.01)]
    case = SimpleNamespace(modes_path=lambda modes: paths[0], continuous_path=lambda: paths[1])
    assert_allclose(accuracy.angle_errors(case, 5), [np.degrees(2.0 * np.sin(0.01))], rtol=1e-12)


def test_table_v():
    singular, crossing = accuracy.inverse_singularity()
    assert crossing == pytest.approx(47.814, abs=2e-3)
    of_path, before = accuracy.inverse_errors_of_six_rfs()
    means = np.array([float(text) for text in published.TABLE_V["Mean"]])
    assert list(np.sign(singular)) == [1.0] * 48 + [-1.0] * 3
    away = np.abs(np.arange(51) - crossing) > 1.0
    assert away.sum() == 49
    ratios = of_path.errors[away].mean(axis=0) / means
    assert np.all((ratios > 0.5) & (ratios < 2.0))
    # Same solutions before the singularity (to the residual, magnified there), two sides afterwards.
    assert_allclose(before.errors[:47], of_path.errors[:47], atol=1e-2)
    assert before.errors[49:].max(axis=1).min() > 10 * of_path.errors[49:].max()


def test_the_straight_path_of_table_i_leaves_its_branch():
    for modes in accuracy.MODES:
        found = accuracy.inverse_errors_of_rfrfr(modes)
        assert 20 < len(found.errors) < 40
        assert found.poses == 51
        assert found.indices[0] == 0 < found.indices[-1]
        assert found.errors[0].max() > float(published.TABLE_I_MOTORS[modes][1])


def test_the_slice_has_the_angles_of_the_paper():
    turn = rotation_from_quaternion(slice_pose(-0.4, 0.1)[3:])
    assert_allclose(turn, SLICE_ROTATION, atol=1e-12)
    # ZYZ: the tilt is the second angle, towards the first.
    assert_allclose(turn[2, 2], np.cos(np.pi / 3), atol=1e-12)
    assert_allclose(np.arctan2(turn[1, 2], turn[0, 2]), np.pi / 8, atol=1e-12)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Pencils put together again from factors, against the tangents they were factored from."""

import numpy as np
import pytest
from helpers.kernel_entry import entry
from helpers.whole_pencil import ROBOTS, WholePencil
from scipy import linalg

from cpr_core import load_robot, solve_home
from cpr_core.kernels import recall_kernel
from cpr_core.kernels.kept_factors import kept_factors
from cpr_core.kernels.pencil import pencil_of

recall_pencil = entry(recall_kernel.recall_pencil)
LARGEST = 5e6


@pytest.mark.parametrize("name", ROBOTS)
def test_factors_are_put_together_to_what_they_were_factored_from(name):
    """With the tangent of the robot itself, by states."""
    whole = WholePencil(name, modes=5)
    home, arrays = solve_home(whole.robot), whole.kernel_arrays
    assert recall_pencil(arrays, home.factors, whole.pencil, LARGEST)
    expected = home.robot.kernel_arrays.energy_unit * linalg.eigvalsh(*whole.matrices(True))
    np.testing.assert_allclose(expected, home.spectrum_free.eigenvalues, rtol=0.0, atol=1e-10)


def test_a_leg_nearly_straight_is_refused():
    """Three modes can hardly shorten these legs: their stiffness hides all other."""
    home = solve_home(load_robot("gough_stewart", modes=3))
    assert not recall_pencil(
        home.robot.kernel_arrays,
        home.factors,
        pencil_of(home.robot.kernel_arrays, home.robot.strain_grams),
        LARGEST,
    )
    expected = home.spectrum_free.eigenvalues[0]  # from the tangent
    assert home.spectrum_free.smallest == pytest.approx(expected, rel=1e-10)


def test_a_leg_without_stiffness_is_refused():
    robot = load_robot("rfrfr", modes=3)
    kept, pencil = (
        kept_factors(robot.kernel_arrays),
        pencil_of(robot.kernel_arrays, robot.strain_grams),
    )
    kept[:] = solve_home(robot).factors
    kept["lane"][1, 1] *= 1e9  # an inverse pivot
    assert not recall_pencil(robot.kernel_arrays, kept, pencil, LARGEST)

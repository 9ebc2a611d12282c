# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Equilibria at which measurements were made."""

import numpy as np
from helpers.simulated_measurements import equilibria, measured
from numpy.testing import assert_allclose

import cpr_core
from cpr_core.identification.measured_equilibria import first_equilibria


def test_a_fraction_is_told_after_every_row_and_is_of_rows_that_are_found():
    robot = cpr_core.load_robot("six_rfs")
    true, told = equilibria(robot, cpr_core.solve_home(robot), count=5), []
    found = first_equilibria(robot, measured(true), progress=told.append)
    assert_allclose(told, np.arange(1, 6) / 5, rtol=1e-15)
    for equilibrium, expected in zip(found, true, strict=True):
        assert_allclose(equilibrium.platform_position, expected.platform_position, atol=1e-9)

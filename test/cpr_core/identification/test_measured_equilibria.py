# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Equilibria at which measurements were made."""

import numpy as np
from helpers.simulated_measurements import equilibria, measured
from numpy.testing import assert_allclose

import cpr_core
from cpr_core import Measurement
from cpr_core.identification.measured_equilibria import first_equilibria
from cpr_core.model.configurations import configuration_distance


def test_a_fraction_is_told_after_every_row_and_is_of_rows_that_are_found():
    robot = cpr_core.load_robot("six_rfs")
    true, told = equilibria(robot, cpr_core.solve_home(robot), count=5), []
    found = first_equilibria(robot, measured(true), progress=told.append)
    assert_allclose(told, np.arange(1, 6) / 5, rtol=1e-15)
    for equilibrium, expected in zip(found, true, strict=True):
        assert_allclose(equilibrium.platform_position, expected.platform_position, atol=1e-9)


def test_where_two_ways_end_at_two_equilibria_that_counts_which_was_measured():
    """Motors at which six_rfs rests in two ways: straight from home, and by the row before."""
    robot = cpr_core.load_robot("six_rfs")
    home = cpr_core.solve_home(robot)
    first = home.motors + [-0.03, 0.93, 1.04, -0.34, 0.17, -0.43]
    last = home.motors + [-0.72, 1.06, -0.32, -0.95, 0.31, 1.03]
    way = first + np.linspace(0.0, 0.7, 8)[:, None] * (last - first)
    before = list(cpr_core.trace_through(robot, motors=way).equilibria[-8:])
    straight = cpr_core.solve_forward(robot, last)
    onwards = cpr_core.solve_forward(robot, last, start=before[-1])
    assert straight.stable and onwards.stable
    assert configuration_distance(robot, straight.configuration, onwards.configuration) > 0.1
    for true in (straight, onwards):
        placed = measured([*before, true])
        felt = [Measurement(motors=each.motors, efforts=each.efforts) for each in (*before, true)]
        for rows in (placed, felt):
            found = first_equilibria(robot, rows)[-1]
            assert_allclose(found.configuration, true.configuration, atol=1e-6)

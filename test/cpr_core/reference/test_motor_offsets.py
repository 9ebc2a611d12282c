# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Zeros of motors in the other models: joints are where they are without, at other motor positions."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.rough_homes import continuous_home
from numpy.testing import assert_allclose

from cpr_core import Robot, load_robot, solve_home
from cpr_core.reference.continuous_rods import solve_continuous
from cpr_core.reference.finite_differences import solve_finite_differences
from cpr_core.reference.literal_procedure import solve_literally

OFFSETS = np.array([0.3, -0.2])


@pytest.fixture(scope="module")
def robots():
    """RFRFR without and with zeros of its motors, at the same home."""
    plain = load_robot("rfrfr").description
    legs = tuple(
        replace(leg, drive=replace(leg.drive, zero=offset))
        for leg, offset in zip(plain.legs, OFFSETS, strict=True)
    )
    home = replace(plain.home, motors=plain.home.motors - OFFSETS)
    return Robot(plain), Robot(replace(plain, legs=legs, home=home))


def test_continuous_rods(robots):
    without, with_offsets = map(continuous_home, robots)
    assert_allclose(with_offsets.motors, without.motors - OFFSETS)
    assert_allclose(with_offsets.platform_position, without.platform_position, atol=1e-10)
    assert_allclose(with_offsets.efforts, without.efforts, atol=1e-10)
    refined = solve_continuous(solve_home(robots[1]))
    assert_allclose(refined.platform_position, without.platform_position, atol=1e-10)


def test_finite_differences(robots):
    without, with_offsets = (
        solve_finite_differences(continuous_home(robot), 50) for robot in robots
    )
    assert_allclose(with_offsets.platform_position, without.platform_position, atol=1e-10)


def test_the_procedure_of_the_paper(robots):
    without, with_offsets = (solve_literally(solve_home(robot)) for robot in robots)
    assert_allclose(with_offsets.platform_position, without.platform_position, atol=1e-6)
    assert_allclose(
        with_offsets.platform_position, solve_home(robots[1]).platform_position, atol=1e-4
    )

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rods with known answers: cantilever, circular arc, elastica, torsion, Euler columns."""

import numpy as np
import pytest
from helpers.columns import AT_TIP, BENDING, LENGTH, TORSION, Guided, column
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from cpr_core import Loads, Robot, load_robot, solve_forward
from cpr_core.description import joints, motors

X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def under(robot, **loads):
    return solve_forward(robot, [], loads=Loads.none().with_(**loads))


@pytest.mark.parametrize("planar", [True, False])
def test_cantilever_under_a_small_tip_load(planar):
    robot = column(motors.Welded(), joints.Fixed(AT_TIP), planar=planar)
    force = 1e-4 * BENDING / LENGTH**2
    tip = under(robot, wrench_world=[0, 0, 0, 0, force, 0])
    deflection = force * LENGTH**3 / (3.0 * BENDING)
    slope = force * LENGTH**2 / (2.0 * BENDING)
    assert tip.platform_position[1] == pytest.approx(deflection, rel=1e-7)
    assert tip.platform_rotation[1, 0] == pytest.approx(slope, rel=1e-7)


@pytest.mark.parametrize("turns", [0.1, 0.5, 1.0])
def test_a_moment_bends_a_rod_into_a_circular_arc(turns):
    robot = column(motors.Welded(), joints.Fixed(AT_TIP), modes=1)
    curvature = 2.0 * np.pi * turns / LENGTH
    tip = under(robot, wrench_world=[0, 0, BENDING * curvature, 0, 0, 0])
    angle = curvature * LENGTH
    np.testing.assert_allclose(
        tip.platform_position[:2],
        [np.sin(angle) / curvature, (1.0 - np.cos(angle)) / curvature],
        atol=1e-10,
    )


@pytest.mark.parametrize("load", [1.0, 5.0, 10.0])
def test_elastica_under_a_tip_load(load):
    """Large deflection under a dead load across the clamp, by elliptic integrals."""
    alpha = np.sqrt(load)

    def modulus(angle):
        return (1.0 + np.sin(angle)) / 2.0  # k^2

    def amplitude(angle):
        return np.arcsin(1.0 / np.sqrt(2.0 * modulus(angle)))

    angle = brentq(
        lambda a: ellipk(modulus(a)) - ellipkinc(amplitude(a), modulus(a)) - alpha,
        1e-6,
        np.pi / 2 - 1e-9,
        xtol=1e-14,
    )
    m = modulus(angle)
    height = 1.0 - 2.0 / alpha * (ellipe(m) - ellipeinc(amplitude(angle), m))
    reach = np.sqrt(2.0 * np.sin(angle)) / alpha
    robot = column(motors.Welded(), joints.Fixed(AT_TIP), modes=14)
    tip = under(robot, wrench_world=[0, 0, 0, 0, load * BENDING / LENGTH**2, 0])
    np.testing.assert_allclose(tip.platform_position[:2] / LENGTH, [reach, height], atol=1e-9)
    assert np.arcsin(tip.platform_rotation[1, 0]) == pytest.approx(angle, abs=1e-8)


def test_a_clamped_rod_twists_by_moment_times_length_over_rigidity():
    robot = column(motors.Welded(), joints.Fixed(AT_TIP), planar=False)
    moment = 0.05
    tip = under(robot, wrench_world=[moment, 0, 0, 0, 0, 0])
    angle = np.arctan2(tip.platform_rotation[2, 1], tip.platform_rotation[1, 1])
    assert angle == pytest.approx(moment * LENGTH / TORSION, rel=1e-10)
    np.testing.assert_allclose(tip.platform_position, [LENGTH, 0, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("factor", "motor", "joint", "robot"),
    [
        (2.0, motors.Welded(), joints.Fixed(AT_TIP), Robot),
        (1.0, motors.Hinge(Z), joints.RevoluteJoint(AT_TIP), Guided),
        (0.6991556596428412, motors.Welded(), joints.RevoluteJoint(AT_TIP), Guided),
        (0.5, motors.Welded(), joints.Fixed(AT_TIP), Guided),
    ],
    ids=["clamped-free", "hinged-hinged", "clamped-hinged", "clamped-clamped"],
)
def test_euler_columns_buckle_at_their_classical_loads(factor, motor, joint, robot):
    column_robot = column(motor, joint, modes=10, robot=robot)
    critical = np.pi**2 * BENDING / (factor * LENGTH) ** 2

    def smallest(load):
        found = under(column_robot, wrench_world=[0, 0, 0, -load, 0, 0])
        np.testing.assert_allclose(found.leg_coordinates, 0.0, atol=1e-9)
        return found.spectrum_locked.eigenvalues[0]

    load = brentq(smallest, 0.9 * critical, 1.1 * critical, xtol=1e-9)
    assert load == pytest.approx(critical, rel=1e-4)
    assert under(column_robot, wrench_world=[0, 0, 0, -0.99 * critical, 0, 0]).index_locked == 0
    assert under(column_robot, wrench_world=[0, 0, 0, -1.01 * critical, 0, 0]).index_locked == 1


def test_a_straight_rod_carries_tension_to_its_tip():
    robot = column(motors.Welded(), joints.RevoluteJoint(AT_TIP), robot=Guided)
    pulled = under(robot, wrench_world=[0, 0, 0, 7.0, 0, 0])
    np.testing.assert_allclose(pulled.multipliers, [7.0, 0.0], atol=1e-12)


def test_shipped_rods_are_stiff_as_their_sections_say():
    rod = load_robot("six_rfs").description.legs[0].rod
    moment = np.pi * 0.001**4 / 4.0
    np.testing.assert_allclose(rod.rigidities, [82e9 * 2 * moment, 210e9 * moment, 210e9 * moment])

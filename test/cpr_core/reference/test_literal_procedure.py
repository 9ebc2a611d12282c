# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The paper's procedure against the library it is the baseline of."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from cpr_core import InvalidRequest, Loads, load_robot, solve_forward, solve_home
from cpr_core.reference import literal_procedure
from cpr_core.reference.literal_procedure import follow_literally, solve_literally


@pytest.fixture
def tight(monkeypatch):
    """Integrate well enough to compare digits."""
    monkeypatch.setattr(literal_procedure, "RELATIVE", 1e-10)
    monkeypatch.setattr(literal_procedure, "ABSOLUTE", 1e-12)


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs"])
def test_solutions_are_those_of_the_library(name, tight):
    robot = load_robot(name)
    equilibrium = solve_home(robot)
    motors = [equilibrium.motors + 0.05, equilibrium.motors + 0.1]
    for found, target in zip(
        follow_literally(solve_literally(equilibrium), motors), motors, strict=True
    ):
        equilibrium = solve_forward(robot, target, start=equilibrium)
        assert found.residual < 1e-10
        assert_allclose(found.platform_position, equilibrium.platform_position, atol=1e-8)
        assert_allclose(found.platform_rotation, equilibrium.platform_rotation, atol=1e-8)
        assert_allclose(found.strain, equilibrium.leg_coordinates, atol=1e-7)
        assert_allclose(found.efforts, -equilibrium.efforts, atol=1e-8)


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs"])
def test_tolerances_of_ode45_cost_less_than_the_modes(name):
    robot = load_robot(name)
    found = follow_literally(solve_literally(solve_home(robot)), [solve_home(robot).motors + 0.1])[
        0
    ]
    exact = solve_forward(robot, solve_home(robot).motors + 0.1).platform_position
    assert 1e-9 < np.linalg.norm(found.platform_position - exact) < 1e-4


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs"])
def test_jacobian_agrees_with_differences(name, tight):
    start = solve_literally(solve_home(load_robot(name)))
    generator = np.random.default_rng(1)
    size, step = len(start.jacobian), 1e-5
    point = literal_procedure._moved(start, 0.05 * generator.normal(size=size))
    _, jacobian, by_motors = literal_procedure._evaluate(point)

    def slope(move):
        ahead, behind = (literal_procedure._evaluate(move(h))[0] for h in (step, -step))
        return (ahead - behind) / (2 * step)

    for direction in generator.normal(size=(2, size)):
        found = slope(lambda h, d=direction: literal_procedure._moved(point, h * d))
        assert_allclose(jacobian @ direction, found, atol=1e-8)
    turn = generator.normal(size=len(point.motors))
    found = slope(lambda h: replace(point, motors=point.motors + h * turn))
    assert_allclose(by_motors @ turn, found, atol=1e-8)


def test_what_it_is_not_written_out_for_is_refused():
    robot = load_robot("rfrfr")
    heavy = solve_forward(
        robot, solve_home(robot).motors, loads=Loads.none().with_(gravity=[0.0, -9.81, 0.0])
    )
    with pytest.raises(InvalidRequest, match="expected none"):
        solve_literally(heavy)
    with pytest.raises(InvalidRequest, match="revolute motor"):
        solve_literally(solve_home(load_robot("gough_stewart")))

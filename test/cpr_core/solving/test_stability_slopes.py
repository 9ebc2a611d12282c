# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Slopes of margin and smallest eigenvalue by parameters."""

import numpy as np
import pytest
from helpers.compared_derivatives import STEPS_TRIED, compared, equilibrium_of, problems_of
from helpers.parameter_kinds import parameter_kinds
from helpers.shipped_steps import STEPS
from helpers.solved_beside import polished, robots_beside, solved_slopes
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose

from cpr_core import CprError, continued, derivatives, load_robot, solve_forward, solve_home
from cpr_core.description.changed_description import named_parameters
from cpr_core.lie import rotation_exp
from cpr_core.model.residual_rates import parameter_scales


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "planar_body", "four_rfr", "three_rfr_hubs"])
def test_slopes_of_stability_are_those_of_full_solves(name):
    """Robots whose eigenvalues stay apart; also legs in chains and redundant motors."""
    equilibrium, problems = equilibrium_of(name), problems_of(name)
    seen = 0
    for number, path in enumerate(parameter_kinds(equilibrium.robot)[::2]):
        try:
            problem = problems[number % len(problems)]
            seen += compared(equilibrium, path, problem, ("margin", "smallest_eigenvalue"))
        except CprError as error:
            assert "planar" in str(error), path
    assert seen > 8


def test_what_only_stretches_a_direction_does_nothing_to_stability():
    """Rounding was taken for an effect of it, and it was varied by 2^25: the whole call was refused."""
    content = shipped_content("delta")
    turn = rotation_exp([0.0, 0.0, 0.1])
    for leg in content["legs"]:
        for field in ("position", "tangent", "normal"):
            leg["base"][field] = (turn @ np.array(leg["base"][field], float)).tolist()
    robot = load_robot(content)
    away = 0.002 * robot.motor_units * np.cos(np.arange(robot.motor_count))
    start = solve_forward(robot, solve_home(robot).motors + away)  # home has two equal eigenvalues
    paths = [f"legs[{leg}].base.normal[{axis}]" for leg in range(6) for axis in range(3)]
    found = derivatives(start, paths, of=("margin", "smallest_eigenvalue"))
    for slopes in (found.margin.reshape(6, 3), found.smallest_eigenvalue.reshape(6, 3)):
        size = np.abs(slopes[:, 2]).min()
        assert size > 1e-6
        assert_allclose(slopes[:, :2], 0.0, rtol=0.0, atol=1e-6 * size)


def test_slopes_of_stability_where_descriptions_end_are_those_of_the_robot_without_limits():
    """A rod that is next to nothing at the limit of its motor has none with a smaller offset."""
    content, equilibria = shipped_content("gough_stewart"), []
    for limits in ({"position": [1e-9, 0.8]}, {}):
        content["legs"][0]["motor"] = {"type": "extensible", "offset": 0.0, "limits": limits}
        robot = load_robot(content)
        away = solve_forward(robot, solve_home(robot).motors + np.array(STEPS["gough_stewart"]))
        equilibria.append(polished(away, "motors"))
    limited, free = equilibria
    (offset,) = named_parameters(free.robot.description, "legs[0].motor.offset")
    step = STEPS_TRIED[1] * parameter_scales(free, (offset,))[0]
    assert robots_beside(limited.robot, offset, step) is None
    true = solved_slopes(free, robots_beside(free.robot, offset, step), step, "motors")
    found = derivatives(limited, offset.path, of=("margin", "smallest_eigenvalue"))
    assert found.margin[0] == pytest.approx(true["margin"], rel=1e-6)
    assert found.smallest_eigenvalue[0] == pytest.approx(true["smallest_eigenvalue"], rel=1e-6)


@pytest.mark.parametrize("path", ["legs[0].base.position[0]", "legs[1].tip.position[1]"])
@pytest.mark.parametrize("name", ["six_rus", "delta", "gough_stewart"])
def test_slopes_of_eigenvalues_that_are_close_to_others(name, path):
    """Their differences reached beyond where the next one is smaller, and were off by up to a half."""
    robot = load_robot(name)
    home = solve_home(robot)
    away = 0.002 * robot.motor_units * np.cos(np.arange(robot.motor_count))
    start = solve_forward(robot, home.motors + away, start=home)
    found = derivatives(start, [path], of=("margin", "smallest_eigenvalue"))
    value, step = float(robot.parameter_values(path)[0]), 1e-6
    before, after = (
        continued(start, robot.with_parameters({path: value + change})) for change in (-step, step)
    )
    for slope, first, last in (
        (found.margin[0], before.margin, after.margin),
        (
            found.smallest_eigenvalue[0],
            before.spectrum_locked.smallest,
            after.spectrum_locked.smallest,
        ),
    ):
        assert slope == pytest.approx((last - first) / (2.0 * step), rel=1e-3)


@pytest.mark.parametrize("name", ["three_rfs", "planar_body", "gough_stewart"])
def test_an_eigenvalue_of_two_motions_has_a_slope_where_it_stays_one(name):
    """What a number of one leg does to it hung on which of its motions was found first."""
    robot = load_robot(name)
    home = solve_home(robot)
    first, second = home.spectrum_locked.eigenvalues[:2]
    assert second == pytest.approx(first, rel=1e-9)
    of = ("margin", "smallest_eigenvalue")

    def stability(path, change):
        value = float(robot.parameter_values(path)[0])
        beside = continued(home, robot.with_parameters({path: value + change}))
        return np.array([beside.margin, beside.spectrum_locked.smallest])

    found, step = derivatives(home, "rod.section.radius", of=of), 1e-8
    before, after = (stability("rod.section.radius", change) for change in (-step, step))
    expected = (after - before) / (2.0 * step)
    slopes, rounding = [*found.margin, *found.smallest_eigenvalue], 1e-14 / step
    assert_allclose(slopes, expected, rtol=1e-5, atol=10.0 * rounding)
    path, step = "legs[0].base.position[0]", 1e-6
    found, at_home = derivatives(home, path, of=of), stability(path, 0.0)
    assert np.isnan([*found.margin, *found.smallest_eigenvalue]).all()
    ahead, behind = ((stability(path, way) - at_home) / way for way in (step, -step))
    assert (behind - ahead > 0.01 * np.abs(ahead)).all(), "they fall whichever way it goes"

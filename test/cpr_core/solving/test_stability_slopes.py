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


FINGERS = """
name: fingers
space: planar
rod:
  {length: 0.2, section: {shape: rectangular, width: 1e-3, height: 0.01}, young_modulus: 2e11,
    shear_modulus: 8e10}
gravity: [0, -1, 0]
platform: {shape: body, mass: 0.05}
legs:
- base: {position: [-0.06, 0.25, 0], tangent: [-0.3, -1, 0]}
  motor: {type: revolute, axis: [0, 0, 1]}
  tip: {type: fixed, position: [-0.03, 0, 0], tangent: [0.6, -1, 0]}
- base: {position: [0.06, 0.25, 0], tangent: [0.3, -1, 0]}
  motor: {type: revolute, axis: [0, 0, -1]}
  tip: {type: fixed, position: [0.03, 0, 0], tangent: [-0.6, -1, 0]}
controlled: [x, y]
home: {motors: [0, 0], bow: outward}
"""


def hardly_loaded():
    """The robot of the paper, with next to no weight and small forces on its rods."""
    content = shipped_content("rfrfr")
    content["gravity"] = [0.0, -0.1, 0.0]
    force = [[0, 0, 0], [0, -2e-3, 0], [1e-3, 0, 0]]
    content["loads"] = {
        "points": [{"leg": "leg1", "at": 0.5, "force": force[1]}],
        "distributed": [{"leg": "leg2", "at": [0.0, 0.3, 1.0], "force": force}],
    }
    return content


@pytest.mark.parametrize(
    ("content", "path", "part"),
    [
        (FINGERS, "rod.young_modulus", 2e-3),
        (FINGERS, "rod.section.width", 2e-3),
        (hardly_loaded(), "loads.points[0].at", 2e-4),
        (hardly_loaded(), "loads.distributed[0].at[1]", 2e-4),
    ],
)
def test_what_hardly_does_anything_is_not_changed_by_much_of_itself(content, path, part):
    """Steps were parts of what moves the robot by a natural unit, and slopes wrong by all they are."""
    robot = load_robot(content)
    start = solve_forward(robot, solve_home(robot).motors + [0.03, -0.02])
    found = derivatives(start, path, of=("pose", "margin", "smallest_eigenvalue"))
    value = float(robot.parameter_values(path)[0])
    steps = part * value * np.array([-2.0, -1.0, 1.0, 2.0])
    near = [continued(start, robot.with_parameters({path: value + step})) for step in steps]
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * part * value)
    for slopes, values in (
        (found.position[:2, 0], [each.platform_position[:2] for each in near]),
        (found.margin, [[each.margin] for each in near]),
        (found.smallest_eigenvalue, [[each.spectrum_locked.smallest] for each in near]),
    ):
        expected = weights @ np.array(values)
        assert_allclose(slopes, expected, rtol=0.0, atol=1e-5 * np.abs(expected).max())


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

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rates of the residual by parameters: against robots that are built anew, and what is left behind."""

import threading

import numpy as np
import pytest
from helpers.parameter_kinds import parameter_kinds, with_loads
from helpers.shipped_steps import STEPS
from numpy.testing import assert_array_equal

from cpr_core import InvalidRequest, load_robot, solve_forward, solve_home
from cpr_core.description.changed_description import named_parameters
from cpr_core.errors import DescriptionError
from cpr_core.model.model_state import evaluate
from cpr_core.model.residual_rates import parameter_scales, residual_rates

#: The short form, and chains of every kind of element. Derivatives are tried with all robots.
ROBOTS = ("six_rfs", "three_prs", "two_rods")


def equilibrium_of(name):
    robot = with_loads(load_robot(name))
    return solve_forward(robot, solve_home(robot).motors + np.array(STEPS[name]))


def residual_at(equilibrium, path, change):
    """Residual of a robot that is built anew, at the same state."""
    value = equilibrium.robot.parameter_values(path)[0]
    robot = equilibrium.robot.with_parameters({path: value + change})
    loads = robot.load_arrays(robot.default_loads)
    place = equilibrium.platform_rotation, equilibrium.platform_position
    return evaluate(robot, loads, equilibrium.state, *place).residual


@pytest.mark.parametrize("name", ROBOTS)
def test_rates_are_those_of_robots_that_are_built_anew(name):
    """Differences of fourth order, at several step sizes, of which one is the best."""
    equilibrium = equilibrium_of(name)
    arrays = equilibrium.robot.kernel_arrays
    natural, seen = arrays.unit / arrays.energy_unit, 0
    for path in parameter_kinds(equilibrium.robot)[::2]:
        try:
            parameter = named_parameters(equilibrium.robot.description, path)[0]
            found = residual_rates(equilibrium, [parameter]).rates[0]
            (scale,) = parameter_scales(equilibrium, (parameter,))
            expected = [
                np.tensordot(
                    [1.0, -8.0, 8.0, -1.0],
                    [
                        residual_at(equilibrium, path, factor * step * scale)
                        for factor in (-2, -1, 1, 2)
                    ],
                    1,
                )
                / (12.0 * step * scale)
                for step in (1e-4, 1e-3)
                if scale
            ]
        except DescriptionError:
            continue
        away = [np.abs((found - quotient) * natural).max() * scale for quotient in expected]
        assert min(away, default=0.0) < 1e-8, path
        if not scale:
            assert not np.any(found)
        seen += 1
    assert seen > 12


def test_a_linear_parameter_is_exact_and_takes_one_residual():
    """Beside the one that all of them are compared with."""
    equilibrium = equilibrium_of("six_rfs")
    paths = ["rod.young_modulus", "legs[1].tip.position[0]", "legs[0].motor.offset"]
    parameters = named_parameters(equilibrium.robot.description, paths)
    for parameter in parameters:
        assert residual_rates(equilibrium, [parameter]).residuals == 2, parameter.path
    assert residual_rates(equilibrium, parameters).residuals == 1 + 1 + 1 + 2
    (idle,) = named_parameters(equilibrium.robot.description, ["rod.shear_modulus"])
    straight = residual_rates(equilibrium, [idle])
    assert (straight.residuals > 0) == bool(np.any(straight.rates))


def test_mass_from_none_and_stiffness_from_none():
    """There are no robots on the other side; links without mass are skipped by the kernels."""
    robot = load_robot("three_rfr_hubs")
    path = "legs[0].chain[1].mass"
    robot = robot.with_parameters({"gravity[1]": -9.81, "legs[*].chain[1].mass": 0.0})
    home = solve_home(robot)
    parameter = named_parameters(robot.description, path)[0]
    found = residual_rates(home, [parameter]).rates[0]
    change = residual_at(home, path, 1e-2) - residual_at(home, path, 0.0)
    assert np.abs(found - change / 1e-2).max() < 1e-9
    assert np.abs(found).max() > 0.1


def test_the_arrays_are_left_as_they_were():
    equilibrium = equilibrium_of("six_rus")
    robot = equilibrium.robot
    parameters = named_parameters(robot.description, parameter_kinds(robot))
    before = [value.copy() for value in robot.kernel_arrays if isinstance(value, np.ndarray)]
    first = residual_rates(equilibrium, parameters)
    again = residual_rates(equilibrium, parameters)
    assert_array_equal(first.rates, again.rates)
    for value, old in zip(
        (value for value in robot.kernel_arrays if isinstance(value, np.ndarray)),
        before,
        strict=True,
    ):
        assert value.tobytes() == old.tobytes()


def test_threads_do_not_disturb_each_other():
    equilibrium = equilibrium_of("six_rfs")
    parameters = named_parameters(
        equilibrium.robot.description, ["rod.length", "rod.young_modulus"]
    )
    expected, wrong = residual_rates(equilibrium, parameters).rates, []

    def ask():
        for _ in range(100):
            if not np.array_equal(residual_rates(equilibrium, parameters).rates, expected):
                wrong.append(1)

    threads = [threading.Thread(target=ask) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_loads_of_the_request_stay():
    """Gravity follows the description where a request has none; what has no effect is refused."""
    robot = with_loads(load_robot("six_rfs"))
    wrench = [0.0, 0.0, 0.0, 0.1, 0.0, -0.1]
    loads = robot.default_loads.with_(wrench_world=wrench)
    equilibrium = solve_forward(robot, solve_home(robot).motors, loads=loads)
    gravity, force = named_parameters(robot.description, ["gravity[2]", "loads.platform_force[2]"])
    found = residual_rates(equilibrium, [gravity]).rates[0]
    mass = robot.description.platform_mass
    total = mass + sum(rod.rod.mass_per_length * rod.rod.length for rod in robot.description.rods)
    assert total > mass > 0.0
    assert np.any(found[robot.kernel_arrays.platform_index :])
    assert np.isclose(found[robot.platform_indices[5]], -mass)
    with pytest.raises(InvalidRequest, match=r"platform_force\[2\] has no effect: wrench_world"):
        residual_rates(equilibrium, [force])


def test_what_is_not_given_cannot_be_varied():
    robot = load_robot("six_rfs")
    (parameter,) = named_parameters(robot.description, ["rod.yield_strain"])
    with pytest.raises(InvalidRequest, match=r"rod\.yield_strain is not given"):
        residual_rates(solve_home(robot), [parameter])

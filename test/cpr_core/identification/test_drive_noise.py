# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Noise of what drives rows, as large as it may be: answers are those of all unknowns at once."""

import numpy as np
import pytest
import scipy

import cpr_core
from cpr_core import (
    Measurement,
    StandardDeviations,
    calibrate,
    continued,
    solve_forward,
    solve_forward_by_effort,
    solve_inverse,
)

PATHS = ("rod.young_modulus", "rod.length")
TRUTH = np.array([205e9, 1.005])
SOLVERS = {
    "motors": solve_forward,
    "pose": solve_inverse,
    "efforts": solve_forward_by_effort,
}
#: What drives rows, what is compared with them, and standard deviations; curvature counts with all.
CASES = {
    "efforts": (
        lambda at: np.array([at.motors[1], at.platform_position[0]]),
        lambda drive, values, loads: Measurement(
            efforts=drive, motors=[None, values[0]], position=[values[1], None, None], loads=loads
        ),
        StandardDeviations(position=3e-4, motors=1e-3, efforts=2e-3),
    ),
    "motors": (
        lambda at: np.array([*at.platform_position[:2], *at.efforts]),
        lambda drive, values, loads: Measurement(
            motors=drive, position=[*values[:2], None], efforts=values[2:], loads=loads
        ),
        StandardDeviations(position=1e-3, motors=0.05, efforts=1e-3),
    ),
    "pose": (
        lambda at: at.efforts,
        lambda drive, values, loads: Measurement(
            position=[*drive, None], efforts=values, loads=loads
        ),
        StandardDeviations(position=1e-2, efforts=5e-4),
    ),
}
OF_DRIVE = {"efforts": 2e-3, "motors": 0.05, "pose": 1e-2}
OF_VALUES = {"efforts": [1e-3, 3e-4], "motors": [1e-3, 1e-3, 1e-3, 1e-3], "pose": [5e-4, 5e-4]}


@pytest.fixture(scope="module")
def robot():
    return cpr_core.load_robot("rfrfr")


@pytest.fixture(scope="module")
def places(robot):
    """Equilibria of the true robot, under a force each."""
    home, random = cpr_core.solve_home(robot), np.random.default_rng(7)
    true = robot.with_parameters(dict(zip(PATHS, TRUTH, strict=True)))
    begin, found = continued(home, true), []
    for _ in range(12):
        force = random.normal(size=2) * robot.wrench_units[3] * 0.2
        loads = robot.default_loads.with_(wrench_world=[0, 0, 0, *force, 0])
        motors = home.motors + random.uniform(-0.1, 0.1, 2)
        found.append(solve_forward(true, motors, start=begin, loads=loads))
    return found


def noisy(places, problem, random):
    """What drives and what is compared, a pair for every row."""
    of = CASES[problem][0]
    return [
        (
            getattr(at, problem) + random.normal(size=2) * OF_DRIVE[problem],
            of(at) + random.normal(size=len(OF_VALUES[problem])) * OF_VALUES[problem],
        )
        for at in places
    ]


def all_at_once(robot, places, problem, measured):
    """Parameters, and their standard deviations, of least squares that also find what drove the rows."""
    of, scales, deviation = CASES[problem][0], TRUTH, OF_DRIVE[problem]

    def residual(unknowns):
        there = robot.with_parameters(dict(zip(PATHS, unknowns[:2] * scales, strict=True)))
        found = []
        for number, (at, (drive, values)) in enumerate(zip(places, measured, strict=True)):
            noise = unknowns[2 + 2 * number : 4 + 2 * number]
            start = continued(at, there)
            driven = SOLVERS[problem](there, drive - deviation * noise, start=start, loads=at.loads)
            found += [noise, (of(driven) - values) / OF_VALUES[problem]]
        return np.concatenate(found)

    def rates(unknowns):
        """By differences: a noise changes its own row only, so one of every row is moved at a time."""
        rows = np.split(np.arange(len(places) * (2 + len(OF_VALUES[problem]))), len(places))
        whole = np.zeros((rows[-1][-1] + 1, len(unknowns)))
        for column in range(4):
            step = np.zeros(len(unknowns))
            step[column if column < 2 else slice(column, None, 2)] = 1e-4
            slope = (residual(unknowns + step) - residual(unknowns - step)) / 2e-4
            if column < 2:
                whole[:, column] = slope
                continue
            for number, row in enumerate(rows):
                whole[row, column + 2 * number] = slope[row]
        return whole

    begin = np.concatenate([[1.0, 1.0], np.zeros(2 * len(places))])
    found = scipy.optimize.least_squares(residual, begin, rates, method="lm", xtol=1e-8)
    covariance = np.linalg.inv(found.jac.T @ found.jac)[:2, :2]
    return found.x[:2] * scales, np.sqrt(np.diag(covariance)) * scales


@pytest.mark.slow
@pytest.mark.parametrize("problem", CASES)
def test_it_is_found_as_if_it_was_among_the_unknowns(robot, places, problem):
    """Rows taken where they were measured came out by up to two deviations elsewhere, too exact."""
    _, row, deviations = CASES[problem]
    random = np.random.default_rng(1)
    for _ in range(3):
        measured = noisy(places, problem, random)
        rows = [row(*pair, at.loads) for pair, at in zip(measured, places, strict=True)]
        found = calibrate(robot, rows, PATHS, deviations)
        assert [compared.problem for compared in found.rows] == [problem] * len(rows)
        expected, exact = all_at_once(robot, places, problem, measured)
        assert np.abs((found.values - expected) / exact).max() < 0.01
        assert found.standard_deviations == pytest.approx(exact, rel=5e-3)
        assert not any("settles" in doubt for doubt in found.doubts)


@pytest.mark.filterwarnings("ignore:residuals are")
@pytest.mark.parametrize("problem", CASES)
def test_a_mistake_is_not_taken_for_noise(robot, places, problem):
    """Followed to where it would be noise it led squares to a fit of 42, ten times as far off."""
    _, row, deviations = CASES[problem]
    measured = noisy(places, problem, np.random.default_rng(3))
    drive, values = measured[4]
    measured[4] = drive, values + 60.0 * np.array(OF_VALUES[problem])
    rows = [row(*pair, at.loads) for pair, at in zip(measured, places, strict=True)]
    squares = calibrate(robot, rows, PATHS, deviations)
    found = calibrate(robot, rows, PATHS, deviations, loss="cauchy")
    for compared in (*squares.rows, *found.rows):
        assert np.abs(compared.noise).max() <= 4.0 + 1e-12
    assert np.abs((found.values - TRUTH) / found.standard_deviations).max() < 3.0

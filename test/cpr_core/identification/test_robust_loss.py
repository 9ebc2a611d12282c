# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What losses for outliers say of how exact they are: the truth is where they say, of few rows too."""

import warnings

import numpy as np
import pytest
import scipy

import cpr_core
from cpr_core import CalibrationWarning, Measurement, StandardDeviations, calibrate
from cpr_core.identification.number_doubts import HALF_95_PERCENT
from cpr_core.identification.robust_loss import loss_width, variance_factor

ROBUST = ("soft_l1", "huber", "cauchy")
SETS, UNKNOWNS = 1000, 2


def weight(loss, residuals):
    away = np.abs(residuals) / loss_width(loss)
    if loss == "huber":
        return 1.0 / np.maximum(1.0, away)
    return 1.0 / (np.sqrt(1.0 + away**2) if loss == "soft_l1" else 1.0 + away**2)


def estimates(loss, rows, noise):
    """Of linear problems, (N, P), by least squares that are weighed again and again."""
    found = np.zeros((len(rows), UNKNOWNS))
    for each in ("soft_l1", loss) if loss == "cauchy" else (loss,):
        for _ in range(200):
            weighed = weight(each, np.einsum("nmp,np->nm", rows, found) - noise)[..., None] * rows
            normal = np.einsum("nmp,nmq->npq", weighed, rows)
            before, pulled = found, np.einsum("nmp,nm->np", weighed, noise)
            found = np.linalg.solve(normal, pulled[..., None])[..., 0]
            if np.abs(found - before).max() < 1e-5:
                break
    return found


def told(loss, count, outliers=0.0):
    """In which part of the intervals the truth is, and the variance factors, (N,)."""
    random = np.random.default_rng(count)
    rows, noise = random.normal(size=(SETS, count, UNKNOWNS)), random.normal(size=(SETS, count))
    noise[random.random(noise.shape) < outliers] *= 30.0
    found = estimates(loss, rows, noise)
    left = np.einsum("nmp,np->nm", rows, found) - noise
    factors = np.array([variance_factor(loss, each, UNKNOWNS) for each in left])
    squares = np.linalg.inv(np.einsum("nmp,nmq->npq", rows, rows))
    variances = factors[:, None] * np.diagonal(squares, axis1=1, axis2=2)
    return np.mean(np.abs(found) <= HALF_95_PERCENT * np.sqrt(variances)), factors


@pytest.mark.parametrize("count", [2, 3, 4, 6, 10, 20, 60])
@pytest.mark.parametrize("loss", ROBUST)
def test_the_truth_is_within_the_intervals_of_few_and_of_many_numbers(loss, count):
    """With as many numbers as unknowns it never was: nothing is left of these residuals."""
    part, _ = told(loss, count)
    assert 0.94 < part < 0.985


@pytest.mark.parametrize("loss", ROBUST)
def test_outliers_widen_the_intervals_as_far_as_they_have_to(loss):
    part, factors = told(loss, 60, outliers=0.1)
    assert 0.925 < part < 0.975
    assert np.median(np.sqrt(factors)) < 1.4
    few, factors = told(loss, 10, outliers=0.1)
    assert 0.91 < few < 0.985
    assert np.median(np.sqrt(factors)) < 1.5


@pytest.mark.parametrize("loss", ROBUST)
def test_noise_that_is_stated_is_believed(loss):
    width, normal = loss_width(loss), scipy.stats.norm.pdf

    def pull(value):
        return value * weight(loss, value)

    def mean(of):
        ends = ((-30.0, -width), (-width, width), (width, 30.0))
        return sum(scipy.integrate.quad(of, *each)[0] for each in ends)

    square = mean(lambda value: pull(value) ** 2 * normal(value))
    slope = mean(lambda value: (pull(value + 1e-5) - pull(value - 1e-5)) / 2e-5 * normal(value))
    for exact in (np.zeros(2), np.zeros(20), np.full(2, 1e12)):
        assert variance_factor(loss, exact, 2) == pytest.approx(square / slope**2, rel=1e-5)
    assert variance_factor("linear", np.zeros(2), 2) == 1.0


def test_few_residuals_are_widened_as_huber_has_it():
    """Robust Statistics (1981), 7.6: his K^2 of three residuals of four that count in full, by hand."""
    pulled, slope, variance = 1.345**2, 3.0 / 4.0, 3.0 / 16.0
    widened = (1.0 + 1.0 / 4.0 * variance / slope**2) ** 2
    expected = widened * pulled / (4 - 1) / slope**2
    assert variance_factor("huber", np.array([0.0, 0.0, 0.0, 9.0]), 1) == pytest.approx(expected)


@pytest.mark.parametrize("loss", ROBUST)
def test_outliers_alone_leave_a_number(loss):
    """Where no residual is near, the mean slope of the loss is nothing, or less."""
    for far in (3.0, 1e3, 1e12):
        factor = variance_factor(loss, far * np.array([1.0, -1.0, 1.1, -1.2]), 2)
        assert 1.0 < factor < 1e5


@pytest.mark.parametrize("loss", ROBUST)
def test_a_calibration_by_as_many_numbers_as_parameters(loss):
    """Every parameter was known to 1e-11, and nothing was doubted."""
    robot = cpr_core.load_robot("rfrfr")
    home = cpr_core.solve_home(robot)
    loads = robot.default_loads.with_(wrench_world=[0, 0, 0, 0, 0.02, 0])
    at = cpr_core.solve_forward(robot, home.motors + [0.1, -0.2], start=home, loads=loads)
    rows = [Measurement(motors=at.motors, position=at.platform_position, loads=loads)]
    paths, noise = ("legs[0].motor.offset", "rod.young_modulus"), StandardDeviations(position=0.02)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CalibrationWarning)
        squares, robust = (
            calibrate(robot, rows, paths, noise, loss=each) for each in ("linear", loss)
        )
    assert robust.standard_deviations == pytest.approx(
        np.sqrt(1.0 / 0.95) * squares.standard_deviations, rel=1e-3
    )
    doubts = [[line.split(":")[0] for line in each.doubts] for each in (squares, robust)]
    assert doubts[0] == doubts[1] == ["rod.young_modulus is hardly told"]

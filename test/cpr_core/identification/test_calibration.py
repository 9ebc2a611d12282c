# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Parameters come back from measurements of robots that have them, with honest intervals."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from helpers.simulated_measurements import (
    DEVIATIONS,
    OFFSETS,
    PATHS,
    equilibria,
    measured,
    payload,
)

import cpr_core
from cpr_core import (
    CalibrationWarning,
    InvalidRequest,
    Measurement,
    StandardDeviations,
    calibrate,
    continued,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.identification.compared import compared_row
from cpr_core.identification.robust_loss import variance_factor
from cpr_core.lie import quaternion_from_rotation, rotation_exp

TRUTH = (200e9, 0.01, -0.02, 0.015, 0.0, 0.02, -0.01)


@pytest.fixture(scope="module")
def truth(robot):
    return robot.with_parameters(dict(zip(PATHS, TRUTH, strict=True)))


@pytest.fixture(scope="module")
def loaded(robot, truth, home):
    return equilibria(truth, home, loads=payload(robot))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("loss", ["linear", "soft_l1", "huber", "cauchy"])
def test_exact_measurements_give_the_truth_back(robot, loaded, loss):
    with pytest.warns(CalibrationWarning, match="may be too large"):
        found = calibrate(robot, measured(loaded[:6]), PATHS, DEVIATIONS, loss=loss)
    assert found.values == pytest.approx(TRUTH, rel=1e-7, abs=1e-7)
    assert found.undetermined == ()
    assert found.fit < 1e-3
    again = cpr_core.load_robot(found.robot.description.text)
    assert again.parameter_values(PATHS) == pytest.approx(found.values, rel=1e-12, abs=1e-15)
    assert found.by_path == dict(zip(PATHS, found.values, strict=True))
    said = f"<CalibrationResult of six_rfs: {len(PATHS)} parameters from 6 measurements, fit "
    assert repr(found).startswith(said)
    assert len(repr(found)) < 120
    for kind, differences in found.differences().items():
        assert np.abs(differences).max() < 1e-3 * np.abs(found.differences(False)[kind]).max()


def test_what_is_measured_of_a_row_may_be_any_part_of_it(robot, truth, loaded):
    rows = measured(loaded[:9])
    deviations = replace(DEVIATIONS, efforts=0.01, motors=1e-3)
    some = [
        replace(rows[0], quaternion_wxyz=None),
        replace(rows[1], position=None),
        replace(rows[2], position=[None, rows[2].position[1], None]),
        replace(rows[3], efforts=[None, *loaded[3].efforts[1:]]),
        replace(rows[4], motors=None, efforts=loaded[4].efforts),
        replace(rows[5], motors=[*rows[5].motors[:3], None, None, None]),
        replace(
            rows[6],
            motors=None,
            position=None,
            quaternion_wxyz=rows[6].quaternion_wxyz,
            efforts=loaded[6].efforts,
        ),
        *rows[7:],
    ]
    with pytest.warns(CalibrationWarning, match="may be too large"):
        found = calibrate(robot, some, PATHS, deviations)
    assert [row.problem for row in found.rows] == ["motors"] * 4 + ["pose"] * 2 + ["efforts"] + [
        "motors"
    ] * 2
    assert [len(row.places) for row in found.rows] == [3, 3, 4, 11, 6, 3, 3, 6, 6]
    assert found.values == pytest.approx(TRUTH, rel=1e-6, abs=1e-6)


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say(robot, loaded):
    inside = []
    for seed in range(40):
        found = calibrate(robot, measured(loaded, seed=seed), PATHS, DEVIATIONS)
        low, high = found.intervals.T
        inside.append((low < TRUTH) & (high > TRUTH))
    assert 0.90 <= np.mean(inside) <= 0.99


def test_the_answer_does_not_depend_on_where_the_descent_begins():
    robot = cpr_core.load_robot("three_prs")  # natural units of stiffness are thrice its value
    paths = ("rod.young_modulus", "legs[0].chain[0].offset", "legs[1].chain[0].offset")
    truth = robot.with_parameters({paths[0]: 203.7e9, paths[1]: 0.01})
    bent = robot.default_loads.with_(wrench_world=[0, 0, 0, 0, 0, -0.3])
    poses = cpr_core.propose_poses(robot, paths, DEVIATIONS, 5, reach=0.2, loads=[bent])
    rows = measured([cpr_core.continued(pose, truth) for pose in poses.equilibria], seed=1)
    starts = (robot, truth, robot.with_parameters({paths[0]: 220e9}))
    first, *others = [calibrate(start, rows, paths, DEVIATIONS) for start in starts]
    for other in others:
        apart = np.abs(first.values - other.values) / first.standard_deviations
        assert apart.max() < 0.01
        assert other.standard_deviations == pytest.approx(first.standard_deviations, rel=1e-3)
    rates = np.vstack(
        [row.rates(at, paths) for row, at in zip(first.rows, first.after, strict=True)]
    )
    units = np.linalg.norm(rates, axis=0)
    covariance = np.linalg.inv((rates / units).T @ (rates / units)) / np.outer(units, units)
    assert first.covariance == pytest.approx(covariance, rel=1e-6)


def test_the_zeros_of_motors_that_move_two_legs_are_as_exact_as_there_are_motors():
    """A zero for each leg is told less of: the covariance of the three follows from that of the six."""
    robot = cpr_core.load_robot("delta")
    legs = tuple(f"legs[{leg}].chain[0].offset" for leg in range(6))
    cranks = tuple(f"legs[{leg},{leg + 1}].chain[0].offset" for leg in (0, 2, 4))
    zeros = (0.01, -0.008, 0.004)
    truth = robot.with_parameters(dict(zip(cranks, zeros, strict=True)))
    rows = measured(equilibria(truth, cpr_core.solve_home(robot)), seed=3)
    rows = [replace(row, quaternion_wxyz=None) for row in rows]
    deviations = StandardDeviations(position=DEVIATIONS.position)
    of_legs = calibrate(robot, rows, legs, deviations)
    of_cranks = calibrate(robot, rows, cranks, deviations)
    both = np.kron(np.eye(3), [[1.0], [1.0]])
    told = np.linalg.inv(of_legs.covariance)
    covariance = np.linalg.inv(both.T @ told @ both)
    np.testing.assert_allclose(
        of_cranks.standard_deviations, np.sqrt(np.diag(covariance)), rtol=1e-2
    )
    assert of_legs.standard_deviations.min() > 5.0 * of_cranks.standard_deviations.max()
    assert np.all(np.abs(of_cranks.values - zeros) < 3.0 * of_cranks.standard_deviations)
    assert of_cranks.robot.parameter_values(legs) == pytest.approx(np.repeat(of_cranks.values, 2))
    assert of_cranks.undetermined == () and of_cranks.doubts == ()


def test_a_robust_loss_bears_gross_outliers(robot, loaded):
    rows = measured(loaded, seed=7)
    rows[11] = replace(rows[11], position=rows[11].position + [0.1, -0.2, 0.05])
    found = calibrate(robot, rows, PATHS, DEVIATIONS, loss="cauchy")
    assert np.all(np.abs(found.values - TRUTH) < 3.0 * found.standard_deviations)
    clean = calibrate(robot, measured(loaded, seed=7), PATHS, DEVIATIONS)
    low, high = clean.intervals.T
    assert np.all((low < found.values) & (found.values < high))
    with pytest.warns(CalibrationWarning, match="outliers"):
        squares = calibrate(robot, rows, PATHS, DEVIATIONS)
    assert not np.all((low < squares.values) & (squares.values < high))


@pytest.mark.filterwarnings("error")
def test_a_robust_loss_finds_the_truth_from_far_away(robot, home):
    far = dict(zip(OFFSETS, (0.2, -0.2, 0.2, -0.2, 0.2, -0.2), strict=True))
    rows = measured(equilibria(robot.with_parameters(far), home, count=4))
    with pytest.warns(CalibrationWarning, match="may be too large"):
        found = calibrate(robot, rows, OFFSETS, DEVIATIONS, loss="cauchy")
    assert found.values == pytest.approx(list(far.values()), abs=1e-6)


def test_descents_that_do_not_end_are_told(robot, loaded, monkeypatch):
    monkeypatch.setattr("cpr_core.identification.parameter_problem.TRIED", 1)
    with pytest.warns(CalibrationWarning, match="no least sum of squares is found"):
        calibrate(robot, measured(loaded[:4], seed=0), PATHS, DEVIATIONS)


def test_what_is_not_determined_is_named_and_stays(robot, truth, home):
    rows = measured(equilibria(truth, home, count=6), seed=1)  # no loads: stiffness moves nothing
    found = calibrate(robot, rows, PATHS, DEVIATIONS)
    assert found.undetermined == ("rod.young_modulus is not determined",)
    assert found.values[0] == pytest.approx(210e9, rel=1e-12)
    assert found.standard_deviations[0] == np.inf
    assert np.all(found.intervals[0] == [-np.inf, np.inf])
    assert np.isnan(found.correlations[0]).all() and np.isnan(found.correlations[:, 0]).all()
    assert np.diag(found.correlations)[1:] == pytest.approx(1.0)
    assert np.all(np.abs(found.values - TRUTH)[1:] < 4.0 * found.standard_deviations[1:])


@pytest.mark.parametrize("loss", ["linear", "soft_l1", "huber", "cauchy"])
@pytest.mark.parametrize("bounds", [None, {"platform.mass": (-1.0, 1.0)}])
def test_where_nothing_is_determined_everything_stays(robot, home, loss, bounds):
    rows = measured(equilibria(robot, home, count=3), seed=1)  # without gravity
    paths = ("platform.mass", "rod.density")
    found = calibrate(robot, rows, paths, DEVIATIONS, loss=loss, bounds=bounds)
    assert found.undetermined == tuple(f"{path} is not determined" for path in paths)
    assert np.array_equal(found.values, robot.parameter_values(paths))
    assert np.all(np.isinf(found.standard_deviations))
    assert found.doubts == ()


@pytest.mark.parametrize("force", [0.0, 1e-6])
@pytest.mark.parametrize(
    "paths", [("rod.young_modulus",), ("rod.young_modulus", "rod.section.radius")]
)
def test_stiffness_that_only_rounding_shows_stays(robot, home, paths, force):
    found_at = equilibria(robot, home, count=5, loads=payload(robot, -force))
    found = calibrate(robot, measured(found_at, seed=1), paths, DEVIATIONS)
    assert found.undetermined == tuple(f"{path} is not determined" for path in paths)
    assert np.array_equal(found.values, robot.parameter_values(paths))
    assert np.all(np.isinf(found.standard_deviations))


def test_what_is_weakly_determined_is_found_with_its_deviation(robot, home):
    truth = robot.with_parameters({"rod.young_modulus": 200e9})
    rows = measured(equilibria(truth, home, count=5, loads=payload(robot, -1e-3)))
    with pytest.warns(CalibrationWarning) as told:
        found = calibrate(robot, rows, "rod.young_modulus", DEVIATIONS)
    said = " ".join(str(warning.message) for warning in told)
    assert "may be too large" in said and "rod.young_modulus is hardly told" in said
    assert found.undetermined == ()
    assert 5e11 < found.standard_deviations[0] < 5e13
    assert found.values[0] == pytest.approx(200e9, rel=0.01)


@pytest.mark.parametrize(
    ("kind", "factor", "unit"),
    [("position", 1000.0, "m"), ("rotation", 57.3, "rad"), ("efforts", 1000.0, "N m or N")],
)
@pytest.mark.parametrize("loss", ["linear", "huber"])
def test_one_deviation_in_another_unit_is_not_hidden_by_the_others(
    robot, loaded, kind, factor, unit, loss
):
    true = replace(DEVIATIONS, efforts=2e-3)
    rows = measured(loaded, seed=2, deviations=true, efforts=True)
    assert calibrate(robot, rows, PATHS, true, loss=loss).doubts == ()
    wrong = replace(true, **{kind: factor * getattr(true, kind)})
    says = rf"^{kind}: residuals are 0\.\d+ times .* too large, or in another unit than {unit}$"
    with pytest.warns(CalibrationWarning, match=says):
        found = calibrate(robot, rows, PATHS, wrong, loss=loss)
    assert [doubt for doubt in found.doubts if doubt.startswith(("pos", "rot", "eff"))] == [
        doubt for doubt in found.doubts if doubt.startswith(kind)
    ]


def test_ratios_are_told_as_ratios(robot):
    weighing = robot.with_parameters(
        {"platform.mass": 0.1, "gravity[2]": -9.81, "rod.density": 0.0}
    )
    home = cpr_core.solve_home(weighing)
    paths = ("rod.young_modulus", "platform.mass")
    truth = weighing.with_parameters({"rod.young_modulus": 200e9})
    rows = measured(equilibria(truth, home, count=6), seed=2)
    found = calibrate(weighing, rows, paths, DEVIATIONS)
    assert found.undetermined == (
        "rod.young_modulus and platform.mass are determined only as their ratio",
    )
    ratio = found.values[0] / found.values[1] / (200e9 / 0.1)
    assert ratio == pytest.approx(1.0, abs=0.02)
    assert np.all(np.isinf(found.standard_deviations))
    products = calibrate(weighing, rows, ("platform.mass", "gravity[2]"), DEVIATIONS)
    assert "product" in products.undetermined[0]


def test_bounds_hold_and_are_told_where_they_do(robot, loaded):
    rows = measured(loaded[:6], seed=3)
    bounds = {"rod.young_modulus": (205e9, 230e9), PATHS[1]: (-1.0, 1.0)}
    with pytest.warns(CalibrationWarning, match="rod.young_modulus ends at its bound 2.05e"):
        found = calibrate(robot, rows, PATHS, DEVIATIONS, bounds=bounds)
    assert len(found.doubts) == 1
    assert found.values[0] == pytest.approx(205e9, rel=1e-3)
    assert found.values[0] >= 205e9
    words = "described value 210000000000 between, got 210000000001, 230000000000$"
    with pytest.raises(InvalidRequest, match=words):
        calibrate(robot, rows, PATHS, DEVIATIONS, bounds={PATHS[0]: (210e9 + 1.0, 230e9)})


@pytest.mark.parametrize("bounds", [(0.0, 0.2), (-0.1, 0.2), (-0.1, 0.0)])
def test_a_parameter_may_begin_at_its_bound(bounds):
    """A platform without mass could not be bounded by zero, the one bound that is known of it."""
    robot = load_robot("rfrfr")
    home, loads = solve_home(robot), robot.default_loads.with_(gravity=[0.0, -9.81, 0.0])
    true = robot.with_parameters({"platform.mass": 0.01})
    start = continued(home, true)
    rows = []
    for step in (0.0, 0.1, -0.1):
        found = solve_forward(true, home.motors + step, start=start, loads=loads)
        place = found.platform_position
        rows.append(Measurement(motors=found.motors, position=place, loads=loads))
    allowed = {"platform.mass": bounds}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore" if bounds[1] == 0.0 else "error", CalibrationWarning)
        found = calibrate(
            robot, rows, ["platform.mass"], StandardDeviations(position=1e-4), bounds=allowed
        )
    assert found.values[0] == pytest.approx(min(0.01, bounds[1]), abs=1e-6)


def test_rates_of_what_is_compared_are_those_of_differences(robot, home, loaded):
    row = measured(loaded[:1], seed=5)[0]
    far = rotation_exp([0.3, -0.5, 0.4]) @ row.rotation
    row = replace(row, quaternion_wxyz=quaternion_from_rotation(far), efforts=loaded[0].efforts)
    at = cpr_core.solve_forward(robot, row.motors, loads=row.loads)
    deviations = replace(DEVIATIONS, efforts=0.1, motors=1e-3)
    compared = compared_row(row, at, deviations)
    rates = compared.rates(at, PATHS)
    for column, path in enumerate(PATHS):
        step = 1e-5 * (210e9 if column == 0 else 1.0)
        value = robot.parameter_values(path)[0]
        ahead, behind = (
            compared.residual(cpr_core.continued(at, robot.with_parameters({path: value + by})))
            for by in (step, -step)
        )
        expected = (ahead - behind) / (2.0 * step)
        assert rates[:, column] == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


def test_noise_of_motors_that_drive_widens_what_is_compared(robot, home, loaded):
    row = measured(loaded[:1])[0]
    noisy = compared_row(row, loaded[0], replace(DEVIATIONS, motors=5e-3))
    covariance = np.linalg.inv(noisy.weights.T @ noisy.weights)
    generator = np.random.default_rng(0)
    moved = [
        compared_row(row, loaded[0], DEVIATIONS).differences(
            cpr_core.solve_forward(
                loaded[0].robot, row.motors + generator.normal(0.0, 5e-3, 6), start=loaded[0]
            )
        )
        for _ in range(2000)
    ]
    own = np.diag([DEVIATIONS.position**2] * 3 + [DEVIATIONS.rotation**2] * 3)
    expected = np.cov(np.array(moved).T) + own
    spread = np.sqrt(np.diag(expected))
    assert covariance / np.outer(spread, spread) == pytest.approx(
        expected / np.outer(spread, spread), abs=0.1
    )


@pytest.mark.parametrize("young", [195e9, 150e9])
def test_noise_of_efforts_that_drive_is_weighed_with_the_robot_that_is_found(robot, home, young):
    """With that of the description it came out up to a quarter too exact, and as a bad fit."""
    path, noise = ["rod.young_modulus"], StandardDeviations(position=5e-5, efforts=2e-4)
    truth, random = robot.with_parameters({path[0]: young}), np.random.default_rng(1)
    begin, squares = cpr_core.continued(home, truth), []
    ats = [
        cpr_core.solve_forward(
            truth,
            begin.motors + random.uniform(-0.15, 0.15, 6),
            loads=robot.default_loads.with_(wrench_world=[0, 0, 0, *random.normal(0, 2e-3, 3)]),
            start=begin,
        )
        for _ in range(8)
    ]
    for _ in range(12):
        rows = [
            Measurement(
                position=at.platform_position + random.normal(0.0, noise.position, 3),
                efforts=at.efforts + random.normal(0.0, noise.efforts, 6),
                loads=at.loads,
            )
            for at in ats
        ]
        found = calibrate(robot, rows, path, noise)
        again = calibrate(found.robot, rows, path, noise)
        moved = (again.values - found.values) / found.standard_deviations
        assert np.abs(moved).max() < 0.02
        assert again.standard_deviations == pytest.approx(found.standard_deviations, rel=5e-3)
        squares.append(found.fit**2)
    assert 0.85 < np.mean(squares) < 1.15


@pytest.mark.parametrize("loss", ["soft_l1", "huber", "cauchy"])
def test_robust_losses_are_nearly_as_exact_as_squares(loss):
    residuals = np.random.default_rng(0).normal(size=100_000)
    assert variance_factor(loss, residuals, 7) == pytest.approx(1.0 / 0.95, abs=0.01)
    assert variance_factor("linear", residuals, 7) == 1.0


def test_a_planar_robot():
    robot = cpr_core.load_robot("rfrfr")
    home = cpr_core.solve_home(robot)
    paths = ("legs[0].motor.offset", "legs[1].base.position[0]")
    values = robot.parameter_values(paths) + [0.01, -0.002]
    truth = robot.with_parameters(dict(zip(paths, values, strict=True)))
    found_at = equilibria(truth, home, count=8, reach=0.1)
    rows = [Measurement(motors=each.motors, position=each.platform_position) for each in found_at]
    with pytest.warns(CalibrationWarning, match="may be too large"):
        found = calibrate(robot, rows, paths, StandardDeviations(position=1e-3))
    assert [len(row.places) for row in found.rows] == [2] * 8
    assert found.values == pytest.approx(values, rel=1e-6)


def test_fractions_are_told_in_order(robot, loaded):
    told = []
    calibrate(robot, measured(loaded, seed=1), PATHS[1:], DEVIATIONS, progress=told.append)
    assert told == sorted(told) and told[-1] == 1.0 and len(told) > 20
    assert PATHS[1:] == OFFSETS

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Limits of a description do not hold the search for its numbers back; that they are passed is said."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.simulated_measurements import equilibria, measured

from cpr_core import (
    CalibrationWarning,
    DescriptionWarning,
    InvalidRequest,
    StandardDeviations,
    calibrate,
    load_robot,
    solve_home,
)
from cpr_core.solving.limits import margins

EXACT = StandardDeviations(position=3e-4, rotation=1e-3, efforts=0.02)
MASS, YOUNG = "platform.mass", "rod.young_modulus"
TEXT = load_robot("delta").description.text


def limited(old, new):
    text = TEXT.replace(old, new)
    assert text != TEXT
    return load_robot(text)


@pytest.fixture(scope="module")
def heavy():
    robot = load_robot("delta")
    truth = robot.with_parameters({MASS: 0.45})
    return equilibria(truth, solve_home(robot), count=10)


def rows_of(found):
    return [
        replace(row, loads=None) for row in measured(found, seed=0, deviations=EXACT, efforts=True)
    ]


@pytest.mark.parametrize("loss", ["linear", "cauchy"])
@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        (
            "effort: 5.0",
            "effort: 0.45",
            r"motor\d: effort -?0\.\d+ N m is outside its limits \[-0\.45, 0\.45\]",
        ),
        ("  density:", "  yield_strain: 1.35e-4\n  density:", r"strain 0\.000\d+ .*0\.000135"),
    ],
)
def test_the_answer_is_that_without_limits(heavy, loss, old, new, text):
    """The described robot is within them, the true one is not: the search ended at the limit."""
    rows, robot = rows_of(heavy), limited(old, new)
    free = calibrate(load_robot("delta"), rows, [MASS], EXACT, loss=loss)
    assert free.doubts == ()
    assert free.values == pytest.approx([0.45], abs=4.0 * free.standard_deviations[0])
    with pytest.warns(CalibrationWarning, match=text) as told:
        found = calibrate(robot, rows, [MASS], EXACT, loss=loss)
    assert len(told) == 1
    np.testing.assert_allclose(found.values, free.values, rtol=1e-11)
    np.testing.assert_allclose(found.covariance, free.covariance, rtol=1e-9)
    assert found.fit == pytest.approx(free.fit, rel=1e-9)
    # What is handed over is the robot as it is described, with its limits.
    assert all(each.robot is found.robot for each in found.after)
    assert found.robot.limited
    assert (
        "limits" in found.robot.description.text or "yield_strain" in found.robot.description.text
    )
    beyond = [row for row, each in enumerate(found.after) if margins(each).min() < -0.02]
    worst = min(beyond, key=lambda row: margins(found.after[row]).min())
    said = str(told[0].message)
    assert said.startswith(f"measurements[{worst}]")
    assert (f"(and {len(beyond) - 1} more)" in said) == (len(beyond) > 1)


def test_a_motor_at_its_stop_is_measured_past_it_by_noise(heavy):
    rows = rows_of(heavy)
    highest = max(float(row.motors.max()) for row in rows)
    robot = limited("position: [-1.2, 1.2]", f"position: [-1.2, {highest - 1e-4:.9f}]")
    found = calibrate(robot, rows, [MASS], EXACT)
    assert found.doubts == ()
    assert found.values == pytest.approx([0.45], abs=4.0 * found.standard_deviations[0])
    elsewhere = limited("position: [-1.2, 1.2]", f"position: [-1.2, {highest - 0.03:.9f}]")
    with pytest.raises(InvalidRequest, match=r"position \d\.\d+ rad is outside its limits"):
        calibrate(elsewhere, rows, [MASS], EXACT)


def test_a_robot_that_looks_wrong_with_what_was_found_is_doubted():
    """Kilograms in place of newtons: a tenth of the modulus, and nothing was said."""
    robot = load_robot("six_rfs")
    loads = robot.default_loads.with_(wrench_world=[0, 0, 0, 0, 0, -1.0])
    found = equilibria(robot, solve_home(robot), count=8, loads=loads)
    exact = replace(EXACT, efforts=None)
    in_kilograms = robot.default_loads.with_(wrench_world=[0, 0, 0, 0, 0, -1.0 / 9.81])
    rows = [replace(row, loads=in_kilograms) for row in measured(found, seed=0, deviations=exact)]
    with pytest.warns(CalibrationWarning, match="the shear modulus .* of Young's"):
        calibrate(robot, rows, [YOUNG], exact)
    # What was said of the description already is not said of what was found.
    text = robot.description.text.replace("shear_modulus: 82.0e+9", "shear_modulus: 820.0e+9")
    with pytest.warns(DescriptionWarning, match="the shear modulus"):
        strange = load_robot(text)
    rows = [replace(row, loads=loads) for row in rows]
    assert calibrate(strange, rows, [YOUNG], exact).doubts == ()

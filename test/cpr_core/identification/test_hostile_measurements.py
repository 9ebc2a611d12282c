# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measurements that cannot be right are refused, or said to be doubtful, in words that help."""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from helpers.simulated_measurements import DEVIATIONS, OFFSETS, PATHS, equilibria, measured, payload
from helpers.yaml_content import shipped_content

import cpr_core
from cpr_core import (
    CalibrationWarning,
    InvalidQuaternion,
    InvalidRequest,
    Measurement,
    NonFiniteInput,
    StandardDeviations,
    UnknownParameter,
    calibrate,
)
from cpr_core.identification.compared import compared_row
from cpr_core.identification.residual_doubts import fit_doubts
from cpr_core.identification.stuck_sensors import stuck_doubts
from cpr_core.lie import quaternion_from_rotation, rotation_exp


@pytest.fixture(scope="module")
def rows(robot):
    truth = robot.with_parameters({"legs[1].motor.offset": 0.01})
    found = equilibria(truth, cpr_core.solve_home(robot), count=6, loads=payload(robot))
    return measured(found, seed=0)


@pytest.mark.parametrize(
    ("fields", "error", "text"),
    [
        ({"position": [0.0, np.nan, 1.0]}, NonFiniteInput, "position: expected finite"),
        ({"motors": [0.0, np.inf]}, NonFiniteInput, "motors: expected finite"),
        ({"position": [0.0, 1.0]}, InvalidRequest, "expected 3 numbers, got 2"),
        ({"position": ["a", "b", "c"]}, InvalidRequest, "expected numbers or None"),
        ({"position": 1.0}, InvalidRequest, "expected numbers or None"),
        ({"quaternion_wxyz": [1.0, 0.0, 0.0, None]}, InvalidRequest, "all of w x y z or none"),
        ({"quaternion_wxyz": [1.0, 0.1, 0.0, 0.0]}, InvalidQuaternion, "unit length"),
        ({"quaternion_wxyz": [57.3, 0.0, 0.0, 0.0]}, InvalidQuaternion, "unit length"),
        ({"loads": 3.0}, InvalidRequest, "expected Loads"),
    ],
)
def test_a_row_that_is_none(fields, error, text):
    with pytest.raises(error, match=text) as caught:
        Measurement(**fields, label="line 7")
    assert caught.value.argument.startswith("line 7: ")


def changed(rows, **fields):
    return [replace(row, **{name: make(row) for name, make in fields.items()}) for row in rows]


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"position": lambda row: 1e3 * row.position}, "looks like millimetres"),
        ({"position": lambda row: 1e-3 * row.position}, "times smaller than predicted"),
        ({"motors": lambda row: np.degrees(row.motors)}, "looks like degrees"),
        ({"quaternion_wxyz": lambda row: np.roll(row.quaternion_wxyz, -1)}, "x y z w"),
        ({"motors": lambda row: row.motors[:4]}, "expected 6 numbers"),
        ({"motors": lambda row: None, "position": lambda row: None}, "nothing drives this row"),
    ],
)
def test_other_units_and_orders(robot, rows, fields, text):
    with pytest.raises(InvalidRequest, match=text):
        calibrate(robot, changed(rows, **fields), PATHS, DEVIATIONS)


@pytest.mark.parametrize("wrong", [4, 5])
def test_an_order_that_most_rows_have_wrong_is_told_with_how_many(robot, rows, wrong):
    rolled = changed(rows[:wrong], quaternion_wxyz=lambda row: np.roll(row.quaternion_wxyz, -1))
    with pytest.raises(InvalidRequest, match=f"x y z w.*as in {wrong} of 6 rows"):
        calibrate(robot, [*rolled, *rows[wrong:]], PATHS, DEVIATIONS)


def test_efforts_in_other_units(robot, rows):
    found = [
        replace(
            row, efforts=1e3 * cpr_core.solve_forward(robot, row.motors, loads=row.loads).efforts
        )
        for row in rows
    ]
    with pytest.raises(InvalidRequest, match=r"efforts: about .* times as large as predicted"):
        calibrate(robot, found, PATHS, replace(DEVIATIONS, efforts=0.1))


def test_loads_in_other_units_are_told_row_by_row(robot, rows):
    wrong = changed(rows, loads=lambda row: row.loads.scaled(1e3))
    with pytest.raises(
        InvalidRequest, match=r"6 of 6 rows have no equilibrium.*measurements\[0\]: "
    ):
        calibrate(robot, wrong, PATHS, DEVIATIONS)


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"position": lambda row: [row.position[0], 0.01, row.position[2]]}, "position y is 0.01"),
        ({"quaternion_wxyz": lambda row: [1.0, 0.0, 0.0, 0.0]}, "quaternion x is 0 in all 6"),
        ({"motors": lambda row: [5.86, *row.motors[1:]]}, "motors: motor1 is 5.86 in all 6"),
    ],
)
def test_a_sensor_that_is_stuck(robot, rows, fields, text):
    with pytest.warns(CalibrationWarning) as warned:
        found = calibrate(robot, changed(rows, **fields), OFFSETS, DEVIATIONS)
    assert any(
        text in str(warning.message) and "stuck" in str(warning.message) for warning in warned
    )
    assert found.doubts == tuple(str(warning.message) for warning in warned)


def compared_rows(robot, rows):
    described = [cpr_core.solve_forward(robot, row.motors, loads=row.loads) for row in rows]
    compared = [
        compared_row(replace(row, label=f"measurements[{number}]"), found, DEVIATIONS)
        for number, (row, found) in enumerate(zip(rows, described, strict=True))
    ]
    return compared, described


@pytest.mark.parametrize("freedom", [1, 3, 7])
@pytest.mark.parametrize(("chance", "doubted"), [(2e-3, False), (5e-4, True)])
def test_few_residuals_are_doubted_where_chance_hardly_makes_them(
    robot, rows, freedom, chance, doubted
):
    compared, described = compared_rows(robot, rows)
    fit = np.sqrt(scipy.stats.chi2.isf(chance, freedom) / freedom)
    doubts = fit_doubts(compared, described, fit, freedom)
    assert [doubt.split(":")[0] for doubt in doubts] == doubted * [
        f"residuals are {fit:.3g} times as large as the standard deviations say"
    ]


def test_many_residuals_are_doubted_where_intervals_are_a_quarter_too_narrow(robot, rows):
    """A factor of 1.6 was let pass, however many numbers tell it."""
    compared, described = compared_rows(robot, rows)
    for freedom, fit, doubted in (
        (60, 1.3, True),
        (447, 1.26, True),
        (447, 1.24, False),
        (30, 1.26, False),
    ):
        assert bool(fit_doubts(compared, described, fit, freedom)) == doubted
        assert not fit_doubts(compared, described, fit, freedom, robust=True)
    assert fit_doubts(compared, described, 1.7, 60, robust=True)


def test_the_row_that_has_most_of_the_squares_is_named(robot, rows):
    compared, described = compared_rows(robot, rows)
    left = [1.0] * len(rows)
    (doubt,) = fit_doubts(compared, described, 3.0, 60, left=left)
    assert "squares" not in doubt
    left[4] = 3.0 * len(rows)
    (doubt,) = fit_doubts(compared, described, 3.0, 60, left=left)
    share = 100.0 * left[4] / sum(left)
    assert doubt.endswith(f"; {compared[4].measurement.label} has {share:.0f} % of the squares")


def test_a_dropout_of_the_camera_is_named(robot, rows):
    rows = list(rows)
    rows[3] = replace(rows[3], position=np.zeros(3))
    with pytest.warns(CalibrationWarning, match=r"measurements\[3\] has 8\d % of the squares"):
        calibrate(robot, rows, OFFSETS, DEVIATIONS)


@pytest.mark.parametrize("fields", ["all", "position"])
def test_rows_that_are_there_twice(robot, rows, fields):
    once = rows if fields == "all" else [replace(row, quaternion_wxyz=None) for row in rows]
    assert calibrate(robot, once, OFFSETS, DEVIATIONS).doubts == ()
    twice = [*once, once[2], replace(once[5], label="line 9")]
    with pytest.warns(CalibrationWarning) as told:
        calibrate(robot, twice, OFFSETS, DEVIATIONS)
    (said,) = (text for each in told if "digit" in (text := str(each.message)))
    expected = (
        f"measurements[{len(once)}] (and 1 more): the same to the last digit as measurements[2]:"
    )
    assert said.startswith(expected)
    # Under other loads, or where a single rounded number is compared, they are no copies.
    other = payload(robot, -1.0 - 1e-9)
    calibrate(robot, [*once, replace(once[2], loads=other)], OFFSETS, DEVIATIONS)
    height = [
        replace(row, quaternion_wxyz=None, position=[None, None, row.position[2]]) for row in rows
    ]
    assert not any(
        "digit" in text for text in calibrate(robot, height * 2, OFFSETS[:1], DEVIATIONS).doubts
    )


@pytest.mark.parametrize(("name", "effort_deviation"), [("six_rfs", 0.1), ("planar_body", 0.01)])
@pytest.mark.parametrize("with_efforts", [False, True])
def test_an_orientation_that_is_stuck(name, effort_deviation, with_efforts):
    """The deviation of efforts was taken for it, and planar robots were not looked at."""
    robot = cpr_core.load_robot(name)
    home, random = cpr_core.solve_home(robot), np.random.default_rng(0)
    found = [
        cpr_core.solve_forward(robot, home.motors + 0.25 * robot.motor_units * way)
        for way in random.uniform(-1.0, 1.0, (12, robot.motor_count))
    ]
    stuck = [
        Measurement(
            motors=at.motors,
            position=at.platform_position,
            quaternion_wxyz=found[0].platform_quaternion,
            efforts=at.efforts if with_efforts else None,
        )
        for at in found
    ]
    efforts = effort_deviation if with_efforts else None
    exactness = StandardDeviations(position=1e-3, rotation=1e-3, efforts=efforts)
    compared = [compared_row(row, at, exactness) for row, at in zip(stuck, found, strict=True)]
    doubts = stuck_doubts(compared, found, found)
    assert doubts
    assert all(doubt.startswith("quaternion ") and "stuck" in doubt for doubt in doubts)


@pytest.mark.parametrize("gear", [1.0, 140.0, 300.0, 7e4])
def test_a_sensor_that_is_stuck_is_so_behind_any_gear(robot, rows, gear):
    """Large efforts had hidden it: rounding of what they differ by."""
    content = shipped_content("six_rfs")
    for leg in content["legs"]:
        leg["motor"]["ratio"] = gear
    content["home"]["motors"] = [at / gear for at in content["home"]["motors"]]
    geared = cpr_core.load_robot(content)
    found = [cpr_core.solve_forward(geared, row.motors / gear, loads=row.loads) for row in rows]
    stuck = [
        Measurement(
            motors=at.motors, efforts=[0.3513 * gear, *at.efforts[1:]], loads=at.loads, label="line"
        )
        for at in found
    ]
    exactness = StandardDeviations(efforts=1e-3 * gear)
    compared = [compared_row(row, at, exactness) for row, at in zip(stuck, found, strict=True)]
    [doubt] = stuck_doubts(compared, found, found)
    assert doubt.startswith(f"efforts: motor1 is {0.3513 * gear:g} in all 6 rows, though it should")


def test_motors_that_never_move_are_no_doubt(robot, rows):
    start = cpr_core.solve_home(robot)
    still = [
        cpr_core.solve_forward(robot, start.motors, loads=payload(robot, force))
        for force in (-0.5, -1.0, -1.5)
    ]
    found = calibrate(robot, measured(still, seed=1), "rod.young_modulus", DEVIATIONS)
    assert found.doubts == ()


def test_fewer_numbers_than_parameters(robot, rows):
    with pytest.raises(InvalidRequest, match="as many measured numbers as parameters, 7, got 6"):
        calibrate(robot, rows[:1], PATHS, DEVIATIONS)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"parameters": []}, "at least one path"),
        ({"parameters": ["rod.length", "rod.length"]}, "named twice"),
        (
            {"parameters": ["legs[0,1].motor.offset", "legs[*].motor.offset"]},
            r"legs\[0,1\]\.motor\.offset and legs\[\*\]\.motor\.offset name the same number",
        ),
        ({"measurements": []}, "at least one Measurement"),
        ({"measurements": [1]}, "expected a Measurement"),
        ({"deviations": StandardDeviations(position=1e-3)}, "the standard deviation of rotation"),
        ({"loss": "squares"}, "expected linear, "),
        ({"bounds": {"rod.density": (0, 1)}}, "none of the parameters"),
        ({"bounds": {PATHS[0]: (1.0, 2.0)}}, "between, got 1, 2"),
        ({"bounds": {PATHS[0]: (1.0,)}}, "lowest and highest"),
        ({"bounds": 3}, "two numbers by path"),
        ({"start": 3}, "expected an Equilibrium"),
    ],
)
def test_arguments_that_cannot_be(robot, rows, arguments, text):
    given = {"measurements": rows, "parameters": PATHS, "deviations": DEVIATIONS} | arguments
    with pytest.raises(InvalidRequest, match=text):
        calibrate(robot, **given)


def test_a_start_of_another_robot(robot, rows):
    other = cpr_core.solve_home(cpr_core.load_robot("six_rfs"))
    with pytest.raises(InvalidRequest, match="same robot object"):
        calibrate(robot, rows, PATHS, DEVIATIONS, start=other)


@pytest.fixture(scope="module")
def geared():
    """A robot whose motors may turn often."""
    content = shipped_content("delta")
    for leg in content["legs"]:
        leg["chain"][0] |= {"ratio": 0.01, "limits": {}}
    return cpr_core.load_robot(content)


def test_motors_with_gears_may_turn_often(geared):
    truth = geared.with_parameters({"rod.young_modulus": 150e9})
    seen = equilibria(truth, cpr_core.solve_home(geared), reach=40.0)
    assert np.abs([each.motors for each in seen]).max() > 4.0 * np.pi
    found = calibrate(geared, measured(seen, seed=2), "rod.young_modulus", DEVIATIONS)
    assert abs(found.values[0] - 150e9) < 4.0 * found.standard_deviations[0]
    assert not found.doubts


def test_degrees_for_which_there_is_an_equilibrium_are_doubted_in_a_single_row_too(geared):
    """Of few measurements nothing was said, however badly they fitted."""
    rows = measured(equilibria(geared, cpr_core.solve_home(geared), count=1, reach=0.5), seed=1)
    with pytest.warns(CalibrationWarning, match="rod.young_modulus is hardly told"):
        found = calibrate(geared, rows, "rod.young_modulus", DEVIATIONS)
    assert len(found.doubts) == 1
    degrees = changed(rows, motors=lambda row: np.degrees(row.motors))
    with pytest.warns(CalibrationWarning):
        found = calibrate(geared, degrees, "rod.young_modulus", DEVIATIONS)
    assert any("looks like degrees" in doubt for doubt in found.doubts)


def in_degrees(name, reach, **screw):
    """A robot and rows of it whose motors are few degrees: none of them looks like that."""
    content = shipped_content(name)
    if screw:
        for leg in content["legs"]:
            leg["chain"][0] |= screw
        content["home"]["motors"] = [40.0 * np.pi] * 3
    robot = cpr_core.load_robot(content)
    found = equilibria(robot, cpr_core.solve_home(robot), count=6, reach=reach)
    return robot, changed(measured(found), motors=lambda row: np.degrees(row.motors))


@pytest.mark.parametrize(
    ("name", "screw", "reach"),
    [("delta", {}, 0.1), ("three_prs", {"lead": 0.002, "limits": {"position": [0, 785]}}, 60.0)],
)
def test_degrees_that_limits_refuse_are_named_where_no_row_has_an_equilibrium(name, screw, reach):
    robot, rows = in_degrees(name, reach, **screw)
    with pytest.raises(InvalidRequest, match="rows have no equilibrium") as caught:
        calibrate(robot, rows, "rod.length", DEVIATIONS)
    assert ": motors: looks like degrees, expected radians; measurements[" in caught.value.problem


def test_motors_beyond_their_limits_are_no_degrees_where_nothing_fits_them():
    robot, rows = in_degrees("delta", 0.1)
    swapped = [
        replace(row, position=other.position, quaternion_wxyz=other.quaternion_wxyz)
        for row, other in zip(rows, rows[::-1], strict=True)
    ]
    with pytest.raises(InvalidRequest, match="rows have no equilibrium") as caught:
        calibrate(robot, swapped, "rod.length", DEVIATIONS)
    assert "degrees" not in caught.value.problem


def test_many_turns_of_a_geared_motor_are_no_degrees_when_something_else_is_wrong(geared):
    rows = measured(equilibria(geared, cpr_core.solve_home(geared), reach=40.0), seed=1)
    wrong = changed(rows, position=lambda row: row.position + [0.0, 0.0, 0.02])
    with pytest.warns(CalibrationWarning):
        found = calibrate(geared, wrong, "rod.young_modulus", DEVIATIONS)
    assert any("residuals are" in doubt for doubt in found.doubts)
    assert not any("degrees" in doubt for doubt in found.doubts)


def test_a_direction_that_another_one_is_across_cannot_be_found_alone():
    stewart = cpr_core.load_robot("gough_stewart")
    path = "legs[0].base.tangent[0]"
    seen = equilibria(stewart, cpr_core.solve_home(stewart), count=6, reach=0.02)
    turned = [
        replace(row, position=row.position + [1e-3 * number, 0.0, 0.0])
        for number, row in enumerate(measured(seen))
    ]
    with pytest.raises(InvalidRequest, match=r"tangent\[0\] cannot be changed alone.*across the t"):
        calibrate(stewart, turned, [path, "rod.young_modulus"], DEVIATIONS)


def test_a_parameter_that_is_not_there(robot, rows):
    with pytest.raises(UnknownParameter, match=r"rod\.young_modulus"):
        calibrate(robot, rows, "rod.youngs_modulus", DEVIATIONS)


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, "1", 1e-200, 1e31, 1e200])
def test_standard_deviations_are_positive_and_have_squares(value):
    with pytest.raises(InvalidRequest, match=r"deviations\.efforts"):
        StandardDeviations(efforts=value)
    with pytest.raises(InvalidRequest, match=r"to 1e\+30, got 1\.00000001e\+30$"):
        StandardDeviations(efforts=1.00000001e30)


@pytest.fixture(scope="module")
def flat():
    """Measurements of a planar robot whose platform turns."""
    robot = cpr_core.load_robot("four_rfr")
    seen = equilibria(robot, cpr_core.solve_home(robot), count=2, reach=0.1)
    return robot, [
        Measurement(
            motors=each.motors,
            position=each.platform_position,
            quaternion_wxyz=each.platform_quaternion,
        )
        for each in seen
    ]


def tilted(row, angle):
    turn = rotation_exp(np.array([angle, 0.0, 0.0]))
    return quaternion_from_rotation(turn @ row.rotation)


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"position": lambda row: row.position + [0, 0, 0.05]}, r"\[0\]: z is 0.05 m, .*z = 0"),
        ({"position": lambda row: [*row.position[:2], -0.05]}, r"\[0\]: z is -0.05 m"),
        ({"quaternion_wxyz": lambda row: tilted(row, 0.1)}, r"\[0\]: the orientation .*by 0.1 rad"),
        ({"quaternion_wxyz": lambda row: tilted(row, np.pi)}, r"by 3.14 rad"),
    ],
)
def test_what_is_far_out_of_the_plane_is_not_dropped_without_a_word(flat, fields, text):
    robot, rows = flat
    with pytest.raises(InvalidRequest, match=text):
        calibrate(robot, changed(rows, **fields), "legs[0].chain[0].offset", DEVIATIONS)


@pytest.mark.parametrize(
    ("fields", "deviations"),
    [
        ({"position": lambda row: row.position + [0, 0, 0.005]}, DEVIATIONS),
        ({"position": lambda row: [*row.position[:2], None]}, DEVIATIONS),
        ({"position": lambda row: row.position + [0, 0, 0.05]}, StandardDeviations(0.01, 0.01)),
        ({"quaternion_wxyz": lambda row: tilted(row, 0.015)}, DEVIATIONS),
        ({"quaternion_wxyz": lambda row: tilted(row, 0.08)}, StandardDeviations(0.01, 0.01)),
    ],
)
def test_what_a_measurement_may_be_out_of_the_plane_is_left_out(flat, fields, deviations):
    robot, rows = flat
    found = calibrate(robot, changed(rows, **fields), "legs[0].chain[0].offset", deviations)
    assert found.values[0] == pytest.approx(0.0, abs=1e-5)


def test_a_point_has_no_tilt():
    robot = cpr_core.load_robot("rfrfr")
    (seen,) = equilibria(robot, cpr_core.solve_home(robot), count=1, reach=0.1)
    row = Measurement(
        motors=seen.motors, position=seen.platform_position, quaternion_wxyz=[0.0, 1.0, 0.0, 0.0]
    )
    found = calibrate(robot, [row], "legs[0].motor.offset", DEVIATIONS)
    assert found.values[0] == pytest.approx(0.0, abs=1e-5)

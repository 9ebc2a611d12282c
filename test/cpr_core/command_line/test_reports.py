# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The commands `stability` and `kinemato`: the numbers of the library, as text and as JSON."""

import json

import numpy as np
import pytest
from helpers.rigid_leg import rigid_leg
from helpers.turntable import turntable

from cpr_core import (
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    spectrum,
)
from cpr_core.command_line import main
from cpr_core.command_line.reports import kinemato_statics_as_dict, kinemato_statics_as_text
from cpr_core.description.description_file import shipped_robots


def run(capsys, *arguments):
    status = main([str(argument) for argument in arguments])
    return status, capsys.readouterr().out


def values(capsys, *arguments):
    status, output = run(capsys, *arguments, "--json")
    assert status == 0
    return json.loads(output)


@pytest.mark.parametrize("motors_are", ["locked", "free"])
def test_stability_is_that_of_the_library(capsys, motors_are):
    robot = load_robot("rfrfr", modes=12)
    expected = spectrum(solve_inverse(robot, [0.0, -0.02]), motors_are)
    found = values(
        capsys, "stability", "rfrfr", "--pose", 0, -0.02, "--modes", 12, "--motors-are", motors_are
    )
    assert found["index"] == expected.index
    assert found["stable"] is False
    assert found["margin"] == pytest.approx(expected.margin)
    np.testing.assert_allclose(found["eigenvalues"], expected.eigenvalues[:6])
    softest, motion = found["softest_motion"], expected.softest_motion
    sign = np.sign(motion[robot.elastic_indices] @ softest["legs"])
    for told, indices in (
        (softest["motors"], robot.motor_indices),
        ([*softest["platform_in_world"].values()], robot.platform_indices),
        (softest["legs"], robot.elastic_indices),
    ):
        np.testing.assert_allclose(np.multiply(sign, told), motion[indices], atol=1e-6)
    assert any(softest["motors"]) is (motors_are == "free")


def test_a_moment_leaves_stability_undecided(capsys):
    found = values(capsys, "stability", "six_rfs", "--wrench", 0, 0, 0.01, 0, 0, 0)
    assert (found["stable"], found["motors_are"]) == (None, "locked")
    assert found["energy_criterion_applies"] is False
    assert (
        "not decided by energy"
        in run(capsys, "stability", "six_rfs", "--wrench", 0, 0, 0.01, 0, 0, 0)[1]
    )


def test_kinemato_has_no_stiffness_where_a_rigid_leg_holds_the_platform():
    model = kinemato_statics(solve_home(rigid_leg()))
    assert kinemato_statics_as_dict(model, None)["stiffness_motors_held"] is None
    assert "compliance" in kinemato_statics_as_text(model, None)


def test_kinemato_answers_where_motors_at_constant_effort_hold_nothing():
    model, word = kinemato_statics(solve_home(turntable())), "do not hold the robot"
    values = kinemato_statics_as_dict(model, None)
    assert values["compliance_constant_effort"] is None
    assert np.isfinite(values["compliance_motors_held"]).all()
    assert word in kinemato_statics_as_text(model, None)
    assert word not in kinemato_statics_as_text(kinemato_statics(solve_home(rigid_leg())), None)


@pytest.mark.parametrize(
    ("name", "motor", "last_of_wrench", "last_of_motion"),
    [
        ("gough_stewart", "motor6 [m]", "f_z [N]", "v_z [m]"),
        ("rfrfr", "motor2 [rad]", "f_y [N]", "v_y [m]"),
    ],
)
def test_kinemato_says_units_of_rows_and_columns(name, motor, last_of_wrench, last_of_motion):
    model = kinemato_statics(solve_home(load_robot(name)))
    text = kinemato_statics_as_text(model, None)
    tables = [part.splitlines() for part in text.split(": row per column\n")[1:]]
    for lines, last, matrix in zip(
        tables, (motor, last_of_wrench), (model.jacobian, model.compliance()), strict=True
    ):
        rows = lines[1 : 1 + len(matrix)]
        assert lines[0].endswith("  " + last)
        assert rows[-1].startswith(f"  {last_of_motion} ")
        assert float(rows[-1].split()[-1]) == pytest.approx(matrix[-1, -1], rel=1e-3)


@pytest.mark.parametrize("name", sorted(shipped_robots()))
def test_kinemato_is_that_of_the_library(capsys, name):
    robot = load_robot(name)
    model = kinemato_statics(solve_forward(robot, solve_home(robot).motors))
    found = values(capsys, "kinemato", name, "--characteristic-length", 0.3)
    loose = np.zeros(robot.motor_count)
    for key, matrix in {
        "jacobian": model.jacobian,
        "efforts_by_motors": model.efforts_by_motors,
        "efforts_by_wrench": model.efforts_by_wrench,
        "compliance_motors_held": model.compliance(),
        "stiffness_motors_held": model.stiffness(),
        "compliance_constant_effort": model.compliance(loose),
    }.items():
        np.testing.assert_allclose(found[key], matrix, rtol=1e-7, atol=1e-9, err_msg=key)
    assert len(found["platform_coordinates"]) == len(robot.platform_axes)
    assert set(found["singularities"]) == {"forward", "inverse", "inverse_by_effort"}
    for problem, singularity in found["singularities"].items():
        expected = model.singularity(problem, 0.3)
        assert singularity["smallest_singular_value"] == pytest.approx(expected.smallest)
        assert singularity["sign"] == expected.sign
        for key, vector in (("null_motors", expected.motors), ("null_platform", expected.platform)):
            np.testing.assert_allclose(singularity[key], vector, atol=1e-6)
    status, text = run(capsys, "kinemato", name)
    assert status == 0
    for motor in robot.motor_names:
        assert motor in text
    assert text.count("no sign: more unknowns than equations") == (name == "four_rfr")
    assert "+0" not in text


@pytest.mark.parametrize(
    "arguments",
    [
        ("kinemato", "six_rfs", "--characteristic-length", "0"),
        ("kinemato", "six_rfs", "--characteristic-length", "inf"),
        ("stability", "six_rfs", "--motors-are", "loose"),
        ("stability", "rfrfr", "--pose", "0", "0.8", "--motors", "2.59", "0.55"),
    ],
)
def test_bad_arguments_end_with_two(arguments):
    with pytest.raises(SystemExit) as caught:
        main(list(arguments))
    assert caught.value.code == 2

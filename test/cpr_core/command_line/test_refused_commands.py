# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Commands that cannot be answered: exit status, code, and what was expected."""

import numpy as np
import pytest

from cpr_core.command_line import command, workspace_commands
from cpr_core.description.description_file import shipped_robots


@pytest.mark.parametrize(
    ("name", "pose"), [("rfrfr", (0, 5)), ("six_rfs", (0.0, 0.0, 3.0, 1.0, 0.0, 0.0, 0.0))]
)
def test_poses_out_of_reach_are_no_solution(failed, name, pose):
    status, code, message = failed("inverse", name, "--pose", *pose)
    assert (status, code) == (1, "NO_IK_SOLUTION")
    assert message.startswith("pose: not reached from the start")
    assert "% of the way" in message


def test_motors_out_of_reach_are_no_solution(failed):
    status, code, message = failed("forward", "rfrfr", "--motors", 259, 0.55)
    assert (status, code) == (1, "NOT_CONVERGED")
    assert message.startswith("motors: not reached from the start")


@pytest.mark.parametrize("count", [1, 3])
def test_the_wrong_number_of_motors_is_refused(failed, count):
    status, code, message = failed("forward", "rfrfr", "--motors", *[0.5] * count)
    assert (status, code) == (2, "INVALID_ROBOT_STATE")
    assert message == f"motors: expected 2 numbers (motor1 motor2), got {count}"


@pytest.mark.parametrize(
    ("name", "count", "expected"),
    [
        ("rfrfr", 1, "2 numbers (x y)"),
        ("rfrfr", 3, "2 numbers (x y)"),
        ("six_rfs", 3, "7 numbers (x y z qw qx qy qz)"),
        ("six_rfs", 8, "7 numbers (x y z qw qx qy qz)"),
    ],
)
def test_the_wrong_number_of_coordinates_is_refused(failed, name, count, expected):
    status, code, message = failed("inverse", name, "--pose", *[0.5] * count)
    assert (status, code) == (2, "INVALID_ROBOT_STATE")
    assert message == f"pose: expected {expected}, got {count}"


@pytest.mark.parametrize("count", [6, 7])
def test_a_quaternion_is_refused_by_what_it_is_where_it_is_none(failed, count):
    _, code, message = failed("inverse", "three_rfr_hubs", "--pose", *[0.5] * count)
    why = "; a quaternion is taken where the orientation is controlled, x y z qw qx qy qz where all is"
    assert code == "INVALID_ROBOT_STATE"
    assert message == f"pose: expected 3 numbers (x y angle), got {count}" + why * (count == 7)


@pytest.mark.parametrize("value", ["nan", "-inf", "1e999"])
@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (("forward", "rfrfr", "--motors", 2.59, "{}"), "motors"),
        (("inverse", "rfrfr", "--pose", "{}", 0.8), "pose"),
        (("forward", "rfrfr", "--motors", 2.59, 0.55, "--gravity", 0, "{}", 0), "gravity"),
        (("forward", "rfrfr", "--motors", 2.59, 0.55, "--wrench", 0, 0, 0, "{}", 0, 0), "wrench"),
    ],
    ids=["motors", "pose", "gravity", "wrench"],
)
def test_numbers_that_are_not_finite_are_refused(failed, arguments, name, value):
    status, code, message = failed(*(str(argument).format(value) for argument in arguments))
    assert (status, code) == (2, "NON_FINITE_INPUT")
    assert message.startswith(name)
    assert "all finite" in message


def test_quaternions_far_from_unit_length_are_refused(failed):
    status, code, message = failed("inverse", "six_rfs", "--pose", 0, 0, 0.8, 1, 1, 0, 0)
    assert (status, code) == (2, "INVALID_QUATERNION")
    assert "expected unit length" in message


@pytest.mark.parametrize("robot", ["rfrf", "no/such/robot.yaml", "x" * 300], ids=len)
def test_unknown_robots_are_refused(failed, robot):
    status, code, message = failed("forward", robot, "--motors", 2.59, 0.55)
    assert (status, code) == (2, "INVALID_DESCRIPTION")
    assert message.startswith(f"{robot}: ")


def test_descriptions_with_a_mistake_are_refused(failed, tmp_path):
    path = tmp_path / "robot.yaml"
    text = shipped_robots()["rfrfr"].read_text()
    path.write_text(text.replace("radius: 0.001", "radius: -0.001"))
    status, code, message = failed("forward", path, "--motors", 2.59, 0.55)
    assert (status, code) == (2, "INVALID_DESCRIPTION")
    assert message.startswith(f"{path}: rod.section.radius: expected a number above 0, got -0.001")


@pytest.mark.parametrize(
    ("options", "name"),
    [
        (("--gravity", 0, 0, -9.81), "gravity"),
        (("--wrench", 1, 0, 0, 0, 0, 0), "wrench_world"),
        (("--wrench", 0, 0, 1, 0, 0, 0), "wrench_world"),
        (("--wrench", 0, 0, 0, 0, 0, 1), "wrench_world"),
    ],
)
def test_loads_out_of_the_plane_are_refused(failed, options, name):
    status, code, message = failed("forward", "rfrfr", "--motors", 2.59, 0.55, *options)
    assert (status, code) == (2, "INVALID_ROBOT_STATE")
    assert message.startswith(f"{name}: expected ")


@pytest.mark.parametrize(
    ("arguments", "hints"),
    [
        ((), ["COMMAND"]),
        (("sideways",), ["sideways", "forward", "inverse"]),
        (("forward",), ["ROBOT"]),
        (("inverse", "rfrfr"), ["--pose"]),
        (("forward", "rfrfr", "--motors"), ["--motors", "expected at least one argument"]),
        (("forward", "rfrfr", "--motors", "left", "0.55"), ["--motors", "a number, got 'left'"]),
        (("forward", "rfrfr", "--motors", "pi/0", "0.55"), ["--motors", "number, got 'pi/0'"]),
        (("inverse", "rfrfr", "--pose", "0", "high"), ["--pose", "'high'"]),
        (("forward", "rfrfr", "--motors", 1, 2, "--modes", 0), ["--modes", "1 to 40", "got 0"]),
        (("forward", "rfrfr", "--motors", 1, 2, "--modes", 41), ["--modes", "1 to 40", "got 41"]),
        (("forward", "rfrfr", "--motors", 1, 2, "--modes", 2.5), ["--modes", "'2.5'"]),
        (("forward", "rfrfr", "--motors", 1, 2, "--gravity", 0, 0), ["--gravity", "expected 3"]),
        (("forward", "rfrfr", "--motors", 1, 2, "--wrench", 0, 0, 0), ["--wrench", "expected 6"]),
        (("forward", "rfrfr", "--motors", 1, 2, "--speed", 3), ["--speed"]),
        (("inverse", "rfrfr", "--motors", 1, 2), ["--pose"]),
    ],
)
def test_arguments_that_cannot_be_read_are_named(misused, arguments, hints):
    message = misused(*arguments)
    for hint in hints:
        assert hint in message


@pytest.mark.parametrize("modes", ["many", "2.5", ""])
def test_mode_counts_that_are_no_numbers_are_refused_without_inner_names(misused, modes):
    message = misused("forward", "rfrfr", "--motors", 2.59, 0.55, "--modes", modes)
    assert "_positive" not in message
    assert "1 to 40" in message


def test_a_lack_of_memory_is_told(monkeypatch, failed):
    """Of a map that is too fine it was a traceback of numpy."""
    monkeypatch.setattr(workspace_commands, "map_workspace", lambda *_, **__: np.empty(2**50))
    status, code, message = failed("workspace", "rfrfr", "--slice", "x=-0.1:0.1", "y=0.7:0.8")
    assert (status, code) == (1, "FAILURE")
    assert message.startswith("out of memory: Unable to allocate 8.00 PiB")


def test_whoever_interrupts_a_command_is_told_no_more_than_that(monkeypatch, cpr):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "solve_forward", interrupted)
    assert cpr("forward", "rfrfr", "--motors", 2.59, 0.55) == (130, "", "cpr: interrupted\n")

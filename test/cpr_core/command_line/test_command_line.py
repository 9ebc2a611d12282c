# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Commands `forward` and `inverse` give the equilibria of the library, and these obey statics."""

import json
import math
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers.paper_motors import HOME
from numpy.testing import assert_allclose

from cpr_core import __version__, error_of, load_robot, solve_home, solve_inverse
from cpr_core.command_line import modes_command
from cpr_core.description.description_file import shipped_robots
from cpr_core.lie import rotation_from_quaternion
from cpr_core.solving.not_reached import NotReached

pytestmark = pytest.mark.usefixtures("compiled")  # no command has to say that it compiles


def check_rfrfr_forward(result):
    expected = [0.0003949291, 0.8390321435, 0.0]
    assert_allclose(result["platform"]["position"], expected, rtol=0.0, atol=1e-8)
    assert_allclose(result["efforts"], [0.6157606, -0.6158422], rtol=0.0, atol=1e-6)
    assert result["motors"] == HOME["rfrfr"]


def test_forward_of_rfrfr(solved):
    result = solved("forward", "rfrfr", "--motors", 2.59, 0.55, "--modes", 12)
    check_rfrfr_forward(result)
    assert result["index_locked"] == 0


@pytest.mark.parametrize("name", ["rfrfr", "delta"])
def test_forward_without_motors_is_home(solved, name):
    """It is what one types first with a file of one's own; motors were required."""
    result = solved("forward", name)
    home = solve_home(load_robot(name))
    assert_allclose(result["motors"], home.motors, rtol=0.0, atol=0.0)
    assert_allclose(result["platform"]["position"], home.platform_position, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(
    "arguments", [("forward", "delta"), ("inverse", "rfrfr", "--pose", 0, 0.5, "--json")]
)
def test_the_robot_is_drawn_where_it_is_asked_for(cpr, tmp_path, arguments):
    picture = tmp_path / "robot.png"
    without = cpr(*arguments)
    assert cpr(*arguments, "--plot", picture) == without
    assert without[0] == 0
    assert picture.read_bytes()[1:4] == b"PNG"
    (tmp_path / "folder.png").mkdir()
    status, _, told = cpr(*arguments, "--plot", tmp_path / "folder.png")
    assert status == 2 and "expected a file" in told


def test_motors_and_ways_may_be_parts_of_pi(solved):
    parts = solved("forward", "rfrfr", "--motors", "5pi/6", "-pi/16")
    numbers = solved("forward", "rfrfr", "--motors", 5 * np.pi / 6, -np.pi / 16)
    assert parts == numbers
    way = (
        "trace",
        "rfrfr",
        "--given",
        "motors",
        "--points",
        2,
        "--from",
        "5pi/6",
        "0.3",
        "--to",
        "0.8pi",
    )
    traced = solved(*way, "0.1pi")
    assert traced == solved(*way[:-1], 0.8 * np.pi, 0.1 * np.pi)


def test_forward_of_six_rfs(solved):
    result = solved("forward", "six_rfs", "--motors", *HOME["six_rfs"], "--modes", 12)
    expected = [0.0364845367, 0.0132956502, 0.8453250174]
    assert_allclose(result["platform"]["position"], expected, rtol=0.0, atol=1e-7)
    assert result["motors"] == HOME["six_rfs"]
    assert result["index_locked"] == 0


def test_inverse_of_rfrfr(solved):
    result = solved("inverse", "rfrfr", "--pose", 0, 0.8, "--modes", 12)
    assert_allclose(result["motors"], [2.7677872, 0.3738055], rtol=0.0, atol=1e-6)
    assert_allclose(result["platform"]["position"], [0.0, 0.8, 0.0], rtol=0.0, atol=1e-15)
    assert result["index_locked"] == 0


def test_the_installed_command():
    arguments = ["forward", "rfrfr", "--motors", "2.59", "0.55", "--modes", "12", "--json"]
    script = shutil.which("cpr", path=str(Path(sys.executable).parent))
    command = [script] if script else [sys.executable, "-m", "cpr_core.command_line"]
    done = subprocess.run(
        [*command, *arguments], capture_output=True, text=True, timeout=120, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    check_rfrfr_forward(json.loads(done.stdout))
    wrong = subprocess.run(
        [*command, "inverse", "rfrfr", "--pose", "0", "5"],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (wrong.returncode, wrong.stdout) == (1, "")
    assert wrong.stderr.startswith("cpr: error: pose: not reached")


def test_version_and_help(cpr):
    assert cpr("--version") == (0, f"cpr {__version__}\n", "")
    status, out, _ = cpr("--help")
    assert status == 0
    assert all(word in out for word in ("forward", "inverse", "rfrfr", "six_rfs"))
    for command, option in (("forward", "--motors"), ("inverse", "--pose")):
        status, out, _ = cpr(command, "--help")
        assert status == 0
        assert all(word in out for word in (option, "--gravity", "--wrench", "--json", "--modes"))


def test_a_file_does_as_well_as_a_name(solved):
    arguments = ("--motors", *HOME["rfrfr"])
    by_file = solved("forward", shipped_robots()["rfrfr"], *arguments)
    assert by_file == solved("forward", "rfrfr", *arguments)


def test_modes_are_those_asked_for(solved):
    for modes in (3, 12):
        result = solved("forward", "rfrfr", "--motors", *HOME["rfrfr"], "--modes", modes)
        assert len(result["leg_coordinates"]) == 2 * modes


def test_forward_and_inverse_of_six_rfs_undo_each_other(solved):
    motors = np.add(HOME["six_rfs"], [0.03, -0.05, 0.04, 0.06, -0.03, 0.02])
    forward = solved("forward", "six_rfs", "--motors", *motors)
    pose = [*forward["platform"]["position"], *forward["platform"]["quaternion_wxyz"]]
    back = solved("inverse", "six_rfs", "--pose", *(f"{value:.17f}" for value in pose))
    assert_allclose(back["motors"], motors, rtol=0.0, atol=1e-8)
    assert_allclose(back["efforts"], forward["efforts"], rtol=0.0, atol=1e-8)
    assert_allclose(back["leg_coordinates"], forward["leg_coordinates"], rtol=0.0, atol=1e-7)


@pytest.mark.parametrize(
    ("name", "held", "options"),
    [("rfrfr", "pose", {}), ("four_rfr", "motors", {"objective": "least_effort"})],
)
def test_inverse_and_its_error_are_those_of_the_library(cpr, solved, name, held, options):
    robot = load_robot(name, modes=3)
    loads = robot.default_loads.with_(gravity=[0.0, -0.3, 0.0], wrench_world=[0, 0, 0, 0.01, 0, 0])
    pose = solve_home(robot).pose + 0.01
    expected = solve_inverse(robot, pose, loads=loads, **options)
    common = ("--modes", 3, "--gravity", 0, -0.3, 0, "--wrench", 0, 0, 0, 0.01, 0, 0, "--error")
    asked = ("inverse", name, "--pose", *pose, *common)
    asked += sum(((f"--{option}", value) for option, value in options.items()), ())
    found = solved(*asked)
    told = found["discretisation_error"]
    assert_allclose(found["motors"], expected.motors, rtol=1e-9)
    error = error_of(expected, held)
    assert told["held"] == held
    for key, values in (("motors", error.motors), ("efforts", error.efforts)):
        assert_allclose(told[key], values, rtol=1e-6, atol=1e-12)
    for key, values in (("position", error.position), ("rotation", error.rotation)):
        assert_allclose(told["platform"][key], values, rtol=1e-6, atol=1e-12)
    last = cpr(*asked)[1].splitlines()[-1].split()
    assert last == ["platform", f"{error.distance:.1e}", "m", f"{error.angle:.1e}", "rad"]
    forward = solved("forward", name, "--motors", *expected.motors, *common)
    assert forward["discretisation_error"]["held"] == "motors"


def test_inverse_of_six_rfs_reaches_the_pose_asked_for(solved):
    position, quaternion = [0.05, -0.02, 0.82], [0.9, 0.1, -0.1, 0.412310562561766]
    result = solved("inverse", "six_rfs", "--pose", *position, *quaternion)
    assert_allclose(result["platform"]["position"], position, rtol=0.0, atol=1e-14)
    assert_allclose(
        rotation_from_quaternion(result["platform"]["quaternion_wxyz"]),
        rotation_from_quaternion(quaternion),
        rtol=0.0,
        atol=1e-14,
    )


@pytest.mark.parametrize("name", HOME)
def test_gravity_lowers_the_platform_and_no_gravity_is_the_default(solved, name):
    arguments = ("forward", name, "--motors", *HOME[name])
    down = {"rfrfr": (0, -9.81, 0), "six_rfs": (0, 0, -9.81)}[name]
    axis = {"rfrfr": 1, "six_rfs": 2}[name]
    without, zero = solved(*arguments), solved(*arguments, "--gravity", 0, 0, 0)
    loaded = solved(*arguments, "--gravity", *down)
    assert zero["platform"] == without["platform"]
    heights = [result["platform"]["position"][axis] for result in (without, loaded)]
    assert 1e-4 < heights[0] - heights[1] < 0.1


@pytest.mark.parametrize("gravity", [(0, 0, 0), (2, -9.81, 0)])
def test_efforts_are_the_slope_of_the_energy(solved, gravity):
    def energy(motors):
        return solved("forward", "rfrfr", "--motors", *motors, "--gravity", *gravity)["energy"]

    efforts = solved("forward", "rfrfr", "--motors", 2.5, 0.6, "--gravity", *gravity)["efforts"]
    step = 1e-3
    for motor in range(2):
        shift = step * np.eye(2)[motor]
        slope = (energy(np.array([2.5, 0.6]) + shift) - energy([2.5, 0.6] - shift)) / (2.0 * step)
        assert slope == pytest.approx(efforts[motor], abs=1e-5)


@pytest.mark.parametrize("name", HOME)
def test_rod_tips_carry_the_wrench(solved, name):
    motors = ("--motors", *HOME[name])
    if name == "rfrfr":
        moment, force = np.zeros(3), np.array([0.1, -0.05, 0.0])
    else:
        moment, force = np.array([0.01, -0.02, 0.03]), np.array([0.1, -0.05, 0.2])
    plain = solved("forward", name, *motors)
    result = solved("forward", name, *motors, "--wrench", *moment, *force)
    assert not np.allclose(result["platform"]["position"], plain["platform"]["position"])
    forces = np.zeros((len(HOME[name]), 3))
    width = 2 if name == "rfrfr" else 3
    forces[:, :width] = np.reshape(result["multipliers"], (-1, width))
    assert_allclose(forces.sum(axis=0), force, rtol=0.0, atol=1e-8)
    if name == "six_rfs":
        angles = [
            g + s * math.pi / 3.0 for g in (0, 2 * math.pi / 3, -2 * math.pi / 3) for s in (-1, 1)
        ]
        points = 0.1 * np.array([[math.cos(a), math.sin(a), 0.0] for a in angles])
        rotation = rotation_from_quaternion(result["platform"]["quaternion_wxyz"])
        moments = np.cross(points @ rotation.T, forces).sum(axis=0)
        assert_allclose(moments, moment, rtol=0.0, atol=1e-8)


def test_moments_in_space_leave_the_verdict_open(cpr, solved):
    arguments = ("forward", "six_rfs", "--motors", *HOME["six_rfs"])
    moment = (*arguments, "--wrench", 0.01, 0, 0, 0, 0, 0)
    assert solved(*moment)["energy_criterion_applies"] is False
    assert "not decided by energy" in cpr(*moment)[1]
    force = (*arguments, "--wrench", 0, 0, 0, 0.01, 0, 0)
    assert solved(*force)["energy_criterion_applies"] is True
    assert "not decided" not in cpr(*force)[1]


@pytest.mark.parametrize("x", ["-0.001", "-1e-3", "-1E-03", "-.1e-2"])
def test_negative_numbers_are_read_in_any_form(solved, x):
    result = solved("inverse", "rfrfr", "--pose", x, 0.8)
    assert_allclose(result["platform"]["position"], [-0.001, 0.8, 0.0], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("option", "scientific", "decimal"),
    [
        ("--gravity", ["0", "-1e-1", "0"], ["0", "-0.1", "0"]),
        ("--wrench", ["0", "0", "0", "-1e-3", "0", "0"], ["0", "0", "0", "-0.001", "0", "0"]),
    ],
)
def test_negative_loads_are_read_in_any_form(solved, option, scientific, decimal):
    arguments = ("forward", "rfrfr", "--motors", 2.59, 0.55, option)
    assert solved(*arguments, *scientific) == solved(*arguments, *decimal)


def test_numbers_of_modes_without_an_equilibrium_are_told_in_json_too(cpr, monkeypatch):
    """The text had a row for them."""
    compared = modes_command.compared_modes

    def of_many_modes(robot, exact):
        if robot.description.rods[0].modes.counts[2] == 2:
            raise NotReached("there is none", 0.0, None)
        return compared(robot, exact)

    monkeypatch.setattr(modes_command, "compared_modes", of_many_modes)
    status, out, _ = cpr("modes", "rfrfr", "--json")
    assert status == 0
    first, second, *_ = json.loads(out)["compared"]
    assert first["modes"] == "2" and first["estimated_error"] is first["solve_time"] is None
    assert second["modes"] == "3" and second["estimated_error"] > 0.0

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Command line ``cpr``: results, JSON, exit status, messages."""

import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose

from cpr_core import __version__, bending_strains, load_robot, solve_forward, solve_home
from cpr_core.command_line import main, modes_command
from cpr_core.description.controlled_coordinates import numbers_of
from cpr_core.description.description_file import shipped_robots
from cpr_core.kernel_warmup import compile_kernels
from cpr_core.lie import rotation_from_quaternion
from cpr_core.solving.not_reached import NotReached

CPR = (sys.executable, "-m", "cpr_core.command_line")
ANSWERED = ("forward", "rfrfr", "--motors", "2.59", "0.55")
REFUSED = ("inverse", "rfrfr", "--pose", "9", "9", "--json")
#: As at a terminal of one's own: what is printed waits for more.
BUFFERED = os.environ | {"PYTHONUNBUFFERED": ""}
PRINTED = ("answer", "refusal", "help")
HOME = {"rfrfr": [2.59, 0.55], "six_rfs": [5.86, 5.56, 5.86, 5.46, 5.86, 5.26]}


@pytest.fixture(scope="module", autouse=True)
def kernels():
    """Compiled before, so that no command has to say that it compiles."""
    list(compile_kernels())


@pytest.fixture
def cpr(capsys):
    """Run the command line; returns exit status, standard output and standard error."""

    def run(*arguments):
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as end:  # argparse
            status = end.code
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return run


@pytest.fixture
def solved(cpr):
    """Run the command line with --json; returns the equilibrium."""

    def run(*arguments):
        status, out, err = cpr(*arguments, "--json")
        assert (status, err) == (0, "")
        return json.loads(out)

    return run


@pytest.fixture
def failed(cpr):
    """Run the command line, which fails; returns status and code and message of the error."""

    def run(*arguments):
        status, out, err = cpr(*arguments, "--json")
        assert err == ""
        error = json.loads(out)
        assert set(error) == {"error"}
        assert set(error["error"]) == {"code", "message"}
        # The same without JSON, where it goes to standard error.
        assert cpr(*arguments) == (status, "", f"cpr: error: {error['error']['message']}\n")
        return status, error["error"]["code"], error["error"]["message"]

    return run


@pytest.fixture
def misused(cpr):
    """Run the command line with arguments it cannot read; returns the message."""

    def run(*arguments):
        status, out, err = cpr(*arguments)
        assert (status, out) == (2, "")
        assert err.startswith("usage: cpr")
        return err

    return run


# The three results that must show.


def check_rfrfr_forward(result):
    expected = [0.0003949291, 0.8390321435, 0.0]
    assert_allclose(result["platform"]["position"], expected, rtol=0.0, atol=1e-8)
    assert_allclose(result["efforts"], [0.6157606, -0.6158422], rtol=0.0, atol=1e-6)
    assert result["motors"] == HOME["rfrfr"]


def test_forward_of_rfrfr(solved):
    result = solved("forward", "rfrfr", "--motors", 2.59, 0.55, "--modes", 12)
    check_rfrfr_forward(result)
    assert result["index_locked"] == 0


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


@pytest.mark.parametrize("arguments", [ANSWERED, REFUSED, ("--help",)], ids=PRINTED)
def test_a_reader_who_leaves_is_no_error(arguments):
    """As `cpr ... | head`."""
    process = subprocess.Popen(
        [*CPR, *arguments],
        env=BUFFERED,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    process.stdout.close()
    assert (process.stderr.read(), process.wait(60)) == ("", 141)


# What is printed.


@pytest.mark.parametrize("name", HOME)
def test_json_says_what_was_found_and_how_well(solved, name):
    result = solved("forward", name, "--motors", *HOME[name])
    legs = len(HOME[name])
    assert result["robot"] == name
    assert result["converged"] is True
    assert 0.0 <= result["residual"] < 1e-10
    assert isinstance(result["iterations"], int)
    assert result["motor_names"] == [f"motor{k + 1}" for k in range(legs)]
    assert len(result["motors"]) == len(result["efforts"]) == legs
    assert set(result["platform"]) == {"position", "quaternion_wxyz"}
    assert len(result["platform"]["position"]) == 3
    assert np.linalg.norm(result["platform"]["quaternion_wxyz"]) == pytest.approx(1.0, abs=1e-14)
    assert len(result["leg_coordinates"]) == legs * {"rfrfr": 5, "six_rfs": 10}[name]
    assert len(result["multipliers"]) == legs * {"rfrfr": 2, "six_rfs": 3}[name]
    assert result["energy"] > 0.0
    for reading in ("locked", "free"):
        negative = result[f"smallest_eigenvalue_{reading}"] < 0.0
        assert (result[f"index_{reading}"] > 0) == negative
    assert (result["margin_locked"] > 0.0) == (result["index_locked"] == 0)
    assert result["energy_criterion_applies"] is True


@pytest.mark.parametrize("name", HOME)
def test_text_says_the_same_as_json(cpr, solved, name):
    arguments = ("forward", name, "--motors", *HOME[name])
    result = solved(*arguments)
    status, out, err = cpr(*arguments)
    assert (status, err) == (0, "")
    lines = {line.split()[0]: line.split()[1:] for line in out.splitlines()}
    for motor, position, effort in zip(
        result["motor_names"], result["motors"], result["efforts"], strict=True
    ):
        assert lines[motor] == [f"{position:.10f}", "rad", f"{effort:.10f}", "N", "m"]
    position = [f"{value:.10f}" for value in result["platform"]["position"]]
    assert lines["platform"] == [*position, "m"]
    assert lines["stable"][:4] == ["with", "motors", "held", "(index"]
    if name == "six_rfs":
        quaternion = [f"{value:.10f}" for value in result["platform"]["quaternion_wxyz"]]
        assert lines["quaternion"][:4] == quaternion
    else:
        assert "quaternion" not in lines  # a point has none
    pose = [f"{value:.10f}" for value in result["pose"]]
    assert lines["controlled"] == [*pose, *f"({' '.join(result['pose_names'])})".split()]


def strain_lines(out):
    return [line.split() for line in out.splitlines() if line.startswith("  bending ")]


@pytest.mark.parametrize("name", ["rfrfr", "gough_stewart", "six_rus"])
def test_the_largest_bending_strain_is_printed(cpr, solved, name):
    robot = load_robot(name)
    motors = solve_home(robot).motors
    strains = bending_strains(solve_forward(robot, motors))
    arguments = ("forward", name, "--motors", *motors)
    assert_allclose(solved(*arguments)["bending_strains"], strains, rtol=1e-9)
    rod = robot.rod_names[strains.argmax()]
    assert strain_lines(cpr(*arguments)[1]) == [
        f"bending {strains.max():.10f} strain of {rod}, the largest".split()
    ]


def test_the_bending_strain_nearest_to_its_limit_is_printed_where_there_are_limits(cpr, tmp_path):
    """The second leg is bent more, the first is nearer to what it bears; the third bears anything."""
    content = yaml.safe_load(shipped_robots()["three_rfs"].read_text(encoding="utf-8"))
    for leg, borne in zip(content["legs"], (0.006, 0.02), strict=False):
        leg["rod"] = content["rod"] | {"yield_strain": borne}
    file = tmp_path / "limits.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    home = solve_home(load_robot(file))
    moved = home.motors + [0.0, 0.1, 0.0]
    strains = bending_strains(solve_forward(home.robot, moved))
    assert strains[0] < strains[1]
    assert strains[0] / 0.006 > strains[1] / 0.02
    assert strain_lines(cpr("forward", file, "--motors", *moved)[1]) == [
        f"bending {strains[0]:.10f} strain of leg1, nearest to its yield strain 0.006".split()
    ]


def test_bending_strains_that_nobody_knows_are_null_and_not_printed(cpr, solved, tmp_path):
    content = yaml.safe_load(shipped_robots()["rfrfr"].read_text(encoding="utf-8"))
    stiffness = dict.fromkeys(("torsion", "bending_2", "bending_3"), 0.165)
    content["rod"] = {"length": 1.0, "section": {"shape": "given"} | stiffness}
    file = tmp_path / "given.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    arguments = ("forward", file, "--motors", *HOME["rfrfr"])
    assert solved(*arguments)["bending_strains"] == [None, None]
    assert strain_lines(cpr(*arguments)[1]) == []


@pytest.mark.parametrize("name", ["rfrfr", "three_rfr_hubs", "six_rfs", "delta"])
def test_what_forward_prints_is_a_pose_for_inverse(cpr, solved, name):
    described = load_robot(name).description
    arguments = ("forward", name, "--motors", *described.home.motors)
    result = solved(*arguments)
    assert result["pose_names"] == list(numbers_of(described.controlled))
    assert solved("inverse", name, "--pose", *result["pose"])["pose"] == pytest.approx(
        result["pose"], abs=1e-9
    )
    status, out, _ = cpr(*arguments)
    (line,) = [line for line in out.splitlines() if line.startswith("  controlled ")]
    printed = line.split("(")[0].split()[1:]
    found = solved("inverse", name, "--pose", *printed)
    assert status == 0
    assert_allclose(found["motors"], result["motors"], rtol=0.0, atol=1e-7)


def test_angles_alone_are_printed_for_inverse_too(cpr, solved, tmp_path):
    content = yaml.safe_load(shipped_robots()["six_rfs"].read_text(encoding="utf-8"))
    content |= {"controlled": ["z", "roll", "pitch", "yaw", "x", "y"]}
    file = tmp_path / "angles.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    result = solved("forward", file, "--motors", *HOME["six_rfs"])
    assert result["pose_names"] == ["z", "roll", "pitch", "yaw", "x", "y"]
    found = solved("inverse", file, "--pose", *result["pose"])
    assert_allclose(found["motors"], HOME["six_rfs"], rtol=0.0, atol=1e-9)


def test_robots_that_control_nothing_print_no_pose(cpr, solved, tmp_path):
    content = yaml.safe_load(shipped_robots()["rfrfr"].read_text(encoding="utf-8"))
    content["legs"].append(
        content["legs"][0] | {"base": {"position": [0, 0, 0], "tangent": [1, 0, 0]}}
    )
    content |= {"controlled": []}
    content["home"] = {"motors": [2.59, 0.55, 1.3], "bow": "left"}
    file = tmp_path / "nothing.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    arguments = ("forward", file, "--motors", 2.59, 0.55, 1.3)
    result = solved(*arguments)
    assert result["pose"] == result["pose_names"] == []
    assert "\n  controlled   nothing\n" in cpr(*arguments)[1] + "\n"


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


# Physics.


def test_forward_and_inverse_of_six_rfs_undo_each_other(solved):
    motors = np.add(HOME["six_rfs"], [0.03, -0.05, 0.04, 0.06, -0.03, 0.02])
    forward = solved("forward", "six_rfs", "--motors", *motors)
    pose = [*forward["platform"]["position"], *forward["platform"]["quaternion_wxyz"]]
    back = solved("inverse", "six_rfs", "--pose", *(f"{value:.17f}" for value in pose))
    assert_allclose(back["motors"], motors, rtol=0.0, atol=1e-8)
    assert_allclose(back["efforts"], forward["efforts"], rtol=0.0, atol=1e-8)
    assert_allclose(back["leg_coordinates"], forward["leg_coordinates"], rtol=0.0, atol=1e-7)


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


# Failures.


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


@pytest.mark.parametrize("value", ["nan", "inf", "1e999"])
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
        (("forward",), ["ROBOT", "--motors"]),
        (("forward", "rfrfr"), ["--motors"]),
        (("inverse", "rfrfr"), ["--pose"]),
        (("forward", "rfrfr", "--motors"), ["--motors", "expected at least one argument"]),
        (("forward", "rfrfr", "--motors", "left", "0.55"), ["--motors", "'left'"]),
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


@pytest.mark.parametrize(
    "arguments", [ANSWERED, (*ANSWERED, "--json"), REFUSED, ("--help",)], ids=["text", *PRINTED]
)
def test_an_answer_that_cannot_be_printed_is_an_error_in_a_line(arguments):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*CPR, *arguments], env=BUFFERED, stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert done.returncode == 1
    assert done.stderr == "cpr: error: [Errno 28] No space left on device\n"


def test_a_closed_output_is_an_error_in_a_line():
    command = [*CPR, *ANSWERED]
    done = subprocess.run(
        ["sh", "-c", '"$@" >&-', "sh", *command], stderr=subprocess.PIPE, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (1, "cpr: error: standard output is closed\n")


def test_letters_that_the_output_does_not_have_are_escaped(tmp_path):
    robot = tmp_path / "robot.yaml"
    text = shipped_robots()["rfrfr"].read_text()
    assert text.count("name: rfrfr") == 1
    robot.write_text(text.replace("name: rfrfr", "name: stäbe"), encoding="utf-8")
    for encoding, name in (("ascii", r"st\xe4be"), ("utf-8", "stäbe")):
        done = subprocess.run(
            [*CPR, "forward", robot, *ANSWERED[2:]],
            env=os.environ | {"PYTHONIOENCODING": encoding},
            capture_output=True,
            check=False,
        )
        assert (done.returncode, done.stderr) == (0, b"")
        assert done.stdout.decode(encoding).startswith(f"{name}: equilibrium")


@pytest.mark.parametrize("options", [(), ("--json",)])
def test_warnings_are_lines_without_source_code(tmp_path, options):
    """They came as Python's: with the file of cpr_core that warns, and its code."""
    content = yaml.safe_load(shipped_robots()["rfrfr"].read_text(encoding="utf-8"))
    content["home"]["platform"] = {"position": [3.0, 0.0, 0.0]}
    robot = tmp_path / "far.yaml"
    robot.write_text(yaml.safe_dump(content), encoding="utf-8")
    command = [*CPR, "forward", str(robot), *ANSWERED[2:], *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    begin = f"cpr: warning: {robot}: home.platform.position: the home equilibrium found is "
    assert done.returncode == 0
    assert done.stderr.startswith(begin) and done.stderr.count("\n") == 1
    assert "warning" not in done.stdout
    if options:
        assert json.loads(done.stdout)["converged"]


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

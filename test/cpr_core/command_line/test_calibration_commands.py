# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Commands ``cpr measure`` and ``cpr calibrate``: from proposed poses to a file that loads."""

import csv
import json
from pathlib import Path

import pytest
from helpers.tracked_robots import MARKER, TRACKER

import cpr_core
from cpr_core import StandardDeviations, propose_poses, read_measurements, write_poses
from cpr_core.command_line import command, main
from cpr_core.command_line.argument_types import check_files
from cpr_core.description.description_file import shipped_robots

PATHS = ("legs[0].motor.offset", "legs[1].motor.offset")
DEVIATION = "position=1e-3"


def run(capsys, *arguments):
    status = main([str(argument) for argument in arguments])
    output = capsys.readouterr()
    return status, output.out, output.err


@pytest.fixture
def data(tmp_path, capsys):
    """A file of poses that were proposed, with positions of a robot that has other offsets."""
    file = tmp_path / "data.csv"
    status, text, _ = run(
        capsys,
        "measure",
        "rfrfr",
        "--count",
        5,
        "--reach",
        0.1,
        "--parameters",
        *PATHS,
        "--deviations",
        DEVIATION,
        "--out",
        file,
    )
    assert status == 0 and "rfrfr: 5 poses" in text and "random" in text
    with file.open(newline="") as opened:
        rows = list(csv.DictReader(opened))
    robot = cpr_core.load_robot("rfrfr")
    truth = robot.with_parameters(dict(zip(PATHS, (0.01, -0.02), strict=True)))
    home = cpr_core.continued(cpr_core.solve_home(robot), truth)
    noise = iter((4e-4, -8e-4, -9e-4, 6e-4, 3e-4, 1e-3, -5e-4, -7e-4, 1.1e-3, -9e-4))
    for row in rows:
        motors = [float(row[name]) for name in robot.motor_names]
        at = cpr_core.solve_forward(truth, motors, start=home).platform_position
        row["x"], row["y"] = at[0] + next(noise), at[1] + next(noise)
    write(file, rows)
    return file


def write(file, rows):
    with file.open("w", newline="") as opened:
        writer = csv.DictWriter(opened, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def read(file):
    with file.open(newline="") as opened:
        return list(csv.DictReader(opened))


def calibrate(capsys, data, *more):
    return run(
        capsys,
        "calibrate",
        "rfrfr",
        data,
        "--parameters",
        *PATHS,
        "--deviations",
        DEVIATION,
        "rotation=0.002",
        *more,
    )


def without_rotation(data):
    rows = [
        {name: cell for name, cell in row.items() if not name.startswith("q")} for row in read(data)
    ]
    write(data, rows)


def test_from_poses_to_a_file_that_loads(capsys, data, tmp_path):
    without_rotation(data)
    new, picture = tmp_path / "new.yaml", tmp_path / "report.png"
    status, text, _ = calibrate(capsys, data, "--out", new, "--plot", picture)
    assert status == 0
    assert "rfrfr: 2 parameters from 5 rows" in text and f"written: {new}" in text
    assert "position  root mean square" in text
    found = cpr_core.load_robot(new).parameter_values(PATHS)
    assert found == pytest.approx([0.01, -0.02], abs=0.005)
    assert picture.stat().st_size > 10_000


def test_a_tracker_of_which_nothing_is_known_is_found_with_the_robot(capsys, tmp_path):
    """The way of docs/calibration.md: `tracker: {}`, poses that are proposed, and a file that loads."""
    described, poses, data, found = (
        tmp_path / name for name in ("my_robot.yaml", "poses.csv", "data.csv", "new.yaml")
    )
    described.write_text(cpr_core.load_robot("six_rfs").description.text + "tracker: {}\n")
    paths = (*TRACKER, *MARKER, "rod.young_modulus")
    asked = ("--parameters", *paths, "--deviations", "position=5e-4", "rotation=2e-3")
    status, text, _ = run(
        capsys,
        "measure",
        described,
        "--count",
        12,
        "--reach",
        0.3,
        "--out",
        poses,
        *asked,
        "--wrench",
        0,
        0,
        0,
        0,
        0,
        -1,
    )
    assert status == 0 and "rod.young_modulus" in text
    values = [0.4, -0.6, 1.8, 3.0, 0.3, -0.4, 0.02, -0.03, 0.04, 0.3, 1.1, -0.2, 200e9]
    truth = cpr_core.load_robot(described).with_parameters(dict(zip(paths, values, strict=True)))
    rows = read_measurements(truth, poses)
    write_poses(data, [cpr_core.solve_forward(truth, row.motors, loads=row.loads) for row in rows])
    status, text, _ = run(
        capsys, "calibrate", described, data, "--out", found, *asked, "--despite-warnings"
    )
    assert status == 0 and f"written: {found}" in text
    values_found = cpr_core.load_robot(found).parameter_values(paths)
    assert values_found == pytest.approx(values, rel=1e-5, abs=1e-5)


def test_a_file_that_does_not_hold_the_modes_is_told(capsys, data, tmp_path):
    """It was another robot than the one that was calibrated, and nothing said so."""
    new = tmp_path / "new.yaml"
    status, _, error = calibrate(capsys, data, "--modes", 7, "--out", new)
    assert status == 0
    assert f"{new} does not hold the number of modes: what was found holds with --modes 7" in error
    assert "modes" not in calibrate(capsys, data, "--out", new)[2]


def test_as_json(capsys, data):
    without_rotation(data)
    status, text, _ = calibrate(capsys, data, "--json", "--loss", "huber")
    values = json.loads(text)
    assert status == 0
    assert set(values["parameters"]) == set(PATHS)
    residuals = values["residuals"]["position"]
    assert residuals["after"] < residuals["before"]
    assert values["warnings"] == values["undetermined"] == values["written"] == []


def test_poses_are_those_of_the_library(capsys, tmp_path):
    """Of most options it was not known whether they are heard."""
    robot, file = cpr_core.load_robot("rfrfr"), tmp_path / "poses.csv"
    loads = robot.default_loads.with_(gravity=[0.0, -1.0, 0.0])
    deviations = StandardDeviations(position=1e-3)
    chosen = {"reach": 0.4, "margin": 0.955, "seed": 5}
    expected = propose_poses(robot, PATHS, deviations, 3, loads=(loads,), **chosen)
    asked = ("measure", "rfrfr", "--parameters", *PATHS, "--deviations", DEVIATION, "--count", 3)
    asked += ("--reach", 0.4, "--margin", 0.955, "--seed", 5, "--gravity", 0, -1, 0)
    status, text, error = run(capsys, *asked, "--out", file, "--json")
    assert (status, error) == (0, "")
    found = json.loads(text)
    assert found["motors"] == [each.motors.tolist() for each in expected.equilibria]
    assert found["home_first"] == list(expected.home_first)
    for key, attribute in (
        ("platform_positions", "platform_position"),
        ("platform_quaternions_wxyz", "platform_quaternion"),
    ):
        assert found[key] == [getattr(each, attribute).tolist() for each in expected.equilibria]
    pairs = [*zip(expected.standard_deviations.tolist(), expected.random.tolist(), strict=True)]
    assert [
        (row["proposed"], row["random"]) for row in found["standard_deviations"].values()
    ] == pairs
    rows = read_measurements(robot, file, loads)
    assert len(rows) == 3
    for row, motors in zip(rows, found["motors"], strict=True):
        assert row.motors == pytest.approx(motors)
    lines = run(capsys, *asked)[1].splitlines()[-2:]
    for line, pair in zip(lines, pairs, strict=True):
        assert line.split()[1:] == [f"{value:.3g}" for value in pair]


def test_a_calibration_is_that_of_the_library(capsys, data):
    without_rotation(data)
    robot = cpr_core.load_robot("rfrfr")
    rows = read_measurements(robot, data, robot.default_loads.with_(gravity=[0.0, -1.0, 0.0]))
    deviations, bounds = (
        StandardDeviations(position=1e-3, rotation=0.002),
        {PATHS[0]: (-1.0, 0.009)},
    )
    expected = cpr_core.calibrate(robot, rows, PATHS, deviations, bounds=bounds, loss="huber")
    asked = ("--bound", PATHS[0], -1, 0.009, "--loss", "huber", "--gravity", 0, -1, 0)
    status, text, _ = calibrate(capsys, data, *asked, "--json")
    found = json.loads(text)
    assert status == (1 if expected.doubts else 0)
    told = found["parameters"].values()
    assert [each["before"] for each in told] == expected.start.tolist() == [0.0, 0.0]
    assert [each["value"] for each in told] == pytest.approx(expected.values)
    assert [each["standard_deviation"] for each in told] == pytest.approx(
        expected.standard_deviations
    )
    assert found["correlations"] == pytest.approx(expected.correlations)
    assert found["fit"] == pytest.approx(expected.fit)
    for calibrated, key in ((False, "before"), (True, "after")):
        differences = expected.differences(calibrated=calibrated)["position"]
        mean = (differences**2).mean() ** 0.5
        assert found["residuals"]["position"][key] == pytest.approx(mean)


def test_a_load_that_is_too_small_to_tell_a_modulus_is_told(capsys):
    """Its standard deviation was more than twice of what it is, and there were no words for it."""
    asked = ("--parameters", "rod.young_modulus", "--deviations", "position=5e-4", "--count", 5)
    few = ("measure", "six_rfs", *asked, "--reach", 0.3, "--wrench", 0, 0, 0, 0, 0)
    words = "rod.young_modulus is hardly told"
    status, text, _ = run(capsys, *few, -0.01)
    assert status == 0 and f"  WARNING: {words}" in text
    status, text, _ = run(capsys, *few, -0.01, "--json")
    [warning] = json.loads(text)["warnings"]
    assert status == 0 and warning.startswith(words)
    assert json.loads(run(capsys, *few, -1, "--json")[1])["warnings"] == []


def test_nothing_is_written_where_something_looks_wrong(capsys, data, tmp_path):
    without_rotation(data)
    rows = read(data)
    write(data, [row | {"x": rows[0]["x"]} for row in rows])
    new = tmp_path / "new.yaml"
    status, text, error = calibrate(capsys, data, "--out", new)
    assert status == 1 and not new.exists()
    assert "WARNING: position x is" in text and "stuck" in text
    assert "nothing is written" in error
    assert calibrate(capsys, data, "--json")[0] == 1
    status, text, error = calibrate(capsys, data, "--out", new, "--despite-warnings")
    assert status == 0 and new.exists() and "nothing is written" not in error


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"x": "nan"}, "line 2, column x: expected a finite number"),
        ({"x": "800.0"}, "looks like millimetres"),
        ({"motor1": "150"}, "looks like degrees"),
        ({"motor1": ""}, "nothing drives this row"),
    ],
)
def test_bad_rows_are_named_and_nothing_is_written(capsys, data, tmp_path, change, text):
    without_rotation(data)
    rows = read(data)
    names = ("x", "y")
    if "motor1" in change:
        rows[0] |= dict.fromkeys(names, "") if change["motor1"] == "" else {}
    write(data, [rows[0] | change, *rows[1:]])
    new = tmp_path / "new.yaml"
    status, _, error = calibrate(capsys, data, "--out", new)
    assert status == 2 and text in error and "line 2" in error
    assert not new.exists()


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--deviations", "place=1"], "expected one of position"),
        (["--deviations", "position=-1"], "a positive number"),
        (["--deviations", "position=0"], "a positive number"),
        (["--deviations", "position"], "a positive number"),
        (["--out", "/nowhere/new.yaml"], "a folder that exists"),
        (["--plot", "report.txt"], "a name ending in"),
    ],
)
def test_bad_arguments_are_refused_at_once(capsys, arguments, text):
    with pytest.raises(SystemExit) as stopped:
        main(["calibrate", "rfrfr", "none.csv", "--parameters", PATHS[0], *arguments])
    assert stopped.value.code == 2
    assert text in capsys.readouterr().err


def test_bounds_are_numbers(capsys, data):
    without_rotation(data)
    status, _, error = calibrate(capsys, data, "--bound", PATHS[0], "low", "high")
    assert status == 2 and "expected two numbers" in error
    _, text, _ = calibrate(capsys, data, "--bound", PATHS[0], -0.001, 0.001, "--json")
    value = json.loads(text)["parameters"][PATHS[0]]["value"]
    assert value == pytest.approx(0.001, rel=0.05)


def test_what_was_found_is_told_though_it_cannot_be_written(capsys, data, tmp_path):
    """The answer, what was written of it, and a line for each file that was not."""
    full, description = tmp_path / "full.png", tmp_path / "robot.yaml"
    full.symlink_to("/dev/full")
    status, text, error = calibrate(capsys, data, "--out", description, "--plot", full, "--json")
    assert status == 2
    assert json.loads(text)["written"] == [str(description)]
    assert error == f"cpr: error: {full}: cannot be written: No space left on device\n"
    status, text, error = calibrate(capsys, data, "--out", full)
    assert status == 2
    assert "standard deviation" in text and "written" not in text
    assert error == f"cpr: error: {full}: cannot be written: No space left on device\n"
    count = ("--count", 3, "--reach", 0.1)
    status, text, error = run(
        capsys,
        "measure",
        "rfrfr",
        *count,
        "--parameters",
        *PATHS,
        "--deviations",
        DEVIATION,
        "--out",
        full,
    )
    assert status == 2
    assert "rfrfr: 3 poses" in text
    (line,) = error.splitlines()
    assert line.startswith("cpr: error: ") and "No space left on device" in line


@pytest.mark.parametrize("name", ["", "folder", "missing/x", "x" * 256])
def test_files_that_cannot_be_written_are_refused_before_any_work(capsys, tmp_path, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder.png").mkdir()
    common = ("rfrfr", "--parameters", *PATHS, "--deviations", DEVIATION)
    for arguments in (
        ("measure", *common, "--out", f"{tmp_path}/{name}"),
        ("calibrate", *common, "--plot", f"{tmp_path}/{name}.png"),
    ):
        if not name and "--plot" in arguments:
            continue  # a name like any other: .png
        with pytest.raises(SystemExit) as refused:
            run(capsys, *arguments)
        assert refused.value.code == 2
        assert "expected " in capsys.readouterr().err.splitlines()[-1]


def test_deviations_below_all_rounding_are_refused(capsys):
    small = ("--deviations", "position=1e-320")
    status, _, error = run(capsys, "measure", "rfrfr", "--parameters", *PATHS, *small)
    assert status == 2
    assert "deviations.position: expected a positive standard deviation" in error


def lost(capsys, read, *arguments):
    """The error of a command that would write over a file; what it reads stays as it was."""
    before = [file.read_bytes() for file in read]
    status, text, error = run(capsys, *arguments, "--json")
    assert (status, error) == (2, "")
    assert [file.read_bytes() for file in read] == before
    return json.loads(text)["error"]["message"]


@pytest.mark.parametrize("link", [None, "symlink_to", "hardlink_to"])
def test_nothing_that_is_read_is_written_over(capsys, tmp_path, link):
    """The description was lost to the poses, and the measurements to the description."""
    robot, data = tmp_path / "robot.yaml", tmp_path / "data.csv"
    robot.write_text(shipped_robots()["rfrfr"].read_text())
    data.write_text("motor1,motor2,x,y\n2.5,0.6,0,0.8\n")
    names = {}
    for file in (robot, data):
        names[file] = tmp_path / ".." / tmp_path.name / file.name
        if link is not None:
            names[file] = tmp_path / f"other-{file.name}"
            getattr(names[file], link)(file)
    parameters = ("--parameters", *PATHS, "--deviations", DEVIATION)
    for first, file, called in (
        (("measure", robot), robot, "ROBOT"),
        (("calibrate", robot, data), robot, "ROBOT"),
        (("calibrate", robot, data), data, "DATA"),
    ):
        message = lost(capsys, (robot, data), *first, *parameters, "--out", names[file])
        assert message == (
            f"--out: expected another file than {called}, {file}, which would be overwritten"
        )


def test_measurements_are_not_written_over(capsys, tmp_path):
    """The file of proposed poses is the one that measured ones are written into."""
    file = tmp_path / "data.csv"
    common = ("measure", "rfrfr", "--count", 2, "--reach", 0.1, "--parameters", PATHS[0])
    common += ("--deviations", DEVIATION, "--out", file)
    file.write_text("measured")
    message = lost(capsys, (file,), *common)
    assert message.startswith(f"--out: {file} is there already: ") and "--replace" in message
    status, _, error = run(capsys, *common, "--replace")
    assert (status, error) == (0, "")
    assert file.read_text().startswith("motor1,motor2,")


def test_a_shipped_description_is_not_written_over(capsys, tmp_path, monkeypatch):
    file = tmp_path / "shipped.yaml"  # a copy, lest the test itself loses it
    file.write_text(shipped_robots()["rfrfr"].read_text())
    monkeypatch.setattr(command, "shipped_robots", lambda: {"rfrfr": file})
    common = ("--parameters", *PATHS, "--deviations", DEVIATION)
    message = lost(capsys, (file,), "measure", "rfrfr", *common, "--out", file)
    assert "expected another file than ROBOT" in message


@pytest.mark.parametrize("exists", [False, True])
@pytest.mark.parametrize(
    "arguments",
    [
        ("calibrate", "rfrfr", "data.csv", "--parameters", PATHS[0], "--deviations", DEVIATION),
        ("workspace", "rfrfr", "--slice", "x=0:0.1", "--resolution", "0.1"),
    ],
)
def test_a_file_is_written_once(capsys, tmp_path, monkeypatch, exists, arguments):
    """The picture was written over the description, or over the map."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "one.png"
    if exists:
        file.write_text("something")
    read = (file,) if exists else ()
    message = lost(capsys, read, *arguments, "--out", "one.png", "--plot", file)
    assert (
        message == f"--out: expected another file than --plot, {file}, which is to be written too"
    )


def test_what_is_no_file_may_be_written_twice():
    nothing = Path("/dev/null")
    check_files({"DATA": nothing}, {"--out": nothing, "--plot": nothing})


def test_nothing_is_given_twice(capsys, data):
    """The last one was taken, without a word."""
    without_rotation(data)
    status, _, error = calibrate(capsys, data, "position=5")
    assert status == 2
    assert error == "cpr: error: --deviations: expected every kind once, position is given twice\n"
    common = ("rfrfr", "--parameters", *PATHS, "--deviations", "position=5", "position=5")
    status, _, error = run(capsys, "measure", *common)
    assert (status, "--deviations: expected every kind once" in error) == (2, True)
    again = ("--deviations", "motors=1", "--deviations", "position=5")
    status, _, error = calibrate(capsys, data, *again)
    assert (status, "--deviations: expected every kind once" in error) == (2, True)
    bound = ("--bound", PATHS[0], -1, 1)
    status, _, error = calibrate(capsys, data, *bound, "--bound", PATHS[1], -1, 1, *bound)
    assert status == 2
    expected = f"expected every parameter once, {PATHS[0]} is given twice"
    assert error == f"cpr: error: --bound: {expected}\n"


def test_options_with_several_values_may_be_given_several_times(capsys):
    """Only the last ones counted."""
    common = ("measure", "rfrfr", "--count", 2, "--reach", 0.1, "--deviations", DEVIATION, "--json")
    parameters = ("--parameters", PATHS[0], "--parameters", PATHS[1])
    status, text, _ = run(capsys, *common, *parameters)
    assert status == 0
    told = json.loads(text)
    assert list(told["standard_deviations"]) == list(PATHS)
    assert (told["robot"], told["motor_names"]) == ("rfrfr", ["motor1", "motor2"])


def test_before_which_pose_the_robot_has_to_go_home_is_told(capsys, tmp_path):
    file, asked = tmp_path / "poses.csv", ("--parameters", "legs[0].tip.position[0]")
    common = ("measure", "six_rus", "--count", 6, "--reach", 0.8, "--deviations", DEVIATION, *asked)
    home_first = json.loads(run(capsys, *common, "--json")[1])["home_first"]
    status, text, _ = run(capsys, *common, "--out", file)
    assert status == 0 and len(home_first) == 6
    rows = text.splitlines()[2:8]
    assert [row.endswith("back home first") for row in rows] == home_first
    assert file.read_text().count("# back home first") == sum(home_first) > 0


def test_the_zero_of_a_motor_that_moves_two_legs_is_one_parameter(capsys, tmp_path):
    data, out = tmp_path / "data.csv", tmp_path / "new.yaml"
    cranks = [f"legs[{leg},{leg + 1}].chain[0].offset" for leg in (0, 2, 4)]
    common = ("--parameters", *cranks, "--deviations", "position=5e-4")
    measure = ("measure", "delta", "--count", 4, "--reach", 0.2, *common, "--out", data)
    assert run(capsys, *measure)[0] == 0
    without_rotation(data)
    options = ("--bound", cranks[0], -0.1, 0.1, "--despite-warnings", "--out", out, "--json")
    status, text, _ = run(capsys, "calibrate", "delta", data, *common, *options)
    assert status == 0 and list(json.loads(text)["parameters"]) == cranks
    legs = [f"legs[{leg}].chain[0].offset" for leg in range(6)]
    assert cpr_core.load_robot(out).parameter_values(legs) == pytest.approx([0.0] * 6, abs=1e-6)
    twice = ("--parameters", "legs[1,1].chain[0].offset", "--deviations", DEVIATION)
    status, _, error = run(capsys, "calibrate", "delta", data, *twice)
    assert (status, "entry 1 is named twice" in error) == (2, True)

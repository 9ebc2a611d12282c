# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""CSV files of measurements: what is written is read, and every bad row is named."""

import numpy as np
import pytest
from helpers.simulated_measurements import payload
from helpers.yaml_content import shipped_content

import cpr_core
from cpr_core import InvalidRequest, read_measurements, write_poses


@pytest.fixture(scope="module")
def robot():
    return cpr_core.load_robot("rfrfr")


@pytest.fixture(scope="module")
def spatial():
    return cpr_core.load_robot("six_rfs")


@pytest.mark.parametrize("loaded", [False, True])
def test_poses_that_are_written_are_measurements(spatial, tmp_path, loaded):
    home = cpr_core.solve_home(spatial)
    loads = payload(spatial) if loaded else None
    found = [
        cpr_core.solve_forward(spatial, home.motors + 0.1 * turn, loads=loads)
        for turn in (-1.0, 0.0, 1.0)
    ]
    write_poses(tmp_path / "poses.csv", found)
    rows = read_measurements(spatial, tmp_path / "poses.csv")
    for row, each in zip(rows, found, strict=True):
        assert row.motors == pytest.approx(each.motors, rel=1e-11)
        assert row.position == pytest.approx(each.platform_position, abs=1e-11)
        assert row.rotation == pytest.approx(each.platform_rotation, abs=1e-11)
        assert row.efforts is None
        force = None if row.loads is None else row.loads.wrench_world.tolist()
        assert force == ([0, 0, 0, 0, 0, -1] if loaded else None)


@pytest.mark.parametrize(
    "others",
    [{"wrench_body": [0, 0, 0, 0, 0, -1]}, {"gravity": [0, 0, -5]}, {"rod_force": [1, 0, 0]}],
)
def test_loads_that_a_file_does_not_have_are_given_beside_it(spatial, tmp_path, others):
    """They were left out without a word, and calibrated with others."""
    loads = spatial.default_loads.with_(**others)
    file, start = tmp_path / "poses.csv", cpr_core.solve_home(spatial)
    pushed = loads.with_(wrench_world=[0, 0, 0, 0, 0, -1])
    found = [
        cpr_core.solve_forward(spatial, start.motors, loads=acting) for acting in (loads, pushed)
    ]
    with pytest.raises(InvalidRequest, match=r"equilibria\[0\]: .* as loads here and to read_"):
        write_poses(file, found)
    assert not file.exists()
    write_poses(file, found, loads=loads)
    for row, each in zip(read_measurements(spatial, file, loads), found, strict=True):
        again = cpr_core.solve_forward(spatial, row.motors, loads=row.loads)
        assert again.platform_position == pytest.approx(each.platform_position, abs=1e-7)


def test_what_are_no_equilibria_of_one_robot_leaves_the_file_alone(robot, spatial, tmp_path):
    """Two robots whose motors have the same names were mixed; others left half a file."""
    file = tmp_path / "poses.csv"
    file.write_text("measured")
    homes = [cpr_core.solve_home(cpr_core.load_robot(name)) for name in ("six_rus", "six_rfs")]
    for wrong in ([], homes[0], [*homes], [cpr_core.solve_home(robot), homes[0]], [1.0]):
        with pytest.raises(InvalidRequest, match="equilibri"):
            write_poses(file, wrong)
    assert file.read_text() == "measured"


@pytest.mark.parametrize("force", [0.0, -1.0, -2.5])
def test_a_wrench_that_is_not_the_description_s_is_written_though_it_is_none(tmp_path, force):
    """Poses without a wrench were read as those of the description's."""
    content = shipped_content("rfrfr")
    content["loads"] = {"platform_force": [0.0, -1.0, 0.0]}
    robot = cpr_core.load_robot(content)
    loads = robot.default_loads.with_(wrench_world=[0.0, 0.0, 0.0, 0.0, force, 0.0])
    found = cpr_core.solve_forward(robot, cpr_core.solve_home(robot).motors, loads=loads)
    write_poses(tmp_path / "poses.csv", [found])
    (row,) = read_measurements(robot, tmp_path / "poses.csv")
    assert row.loads.wrench_world.tolist() == [0.0, 0.0, 0.0, 0.0, force, 0.0]
    again = cpr_core.solve_forward(robot, row.motors, loads=row.loads)
    assert row.position == pytest.approx(again.platform_position, abs=1e-7)


def test_cells_may_be_empty_and_columns_in_any_order(robot, tmp_path):
    name, other = robot.motor_names
    file = tmp_path / "some.csv"
    file.write_text(
        f"\ufeff# from the tracker\n\n y , {name},{other},effort:{other},fx\n"
        "0.5,0.1,0.2,,\n,,,,\n,0.3,0.4,1.5,-2\n",
        encoding="utf-8",
    )
    first, last = read_measurements(robot, file)
    assert first.motors.tolist() == [0.1, 0.2]
    assert np.isnan(first.position[[0, 2]]).all() and first.position[1] == 0.5
    assert first.efforts is None and first.loads is None and first.label == "line 4"
    assert last.position is None and np.isnan(last.efforts[0]) and last.efforts[1] == 1.5
    assert last.loads.wrench_world.tolist() == [0, 0, 0, -2, 0, 0]
    assert last.loads.gravity.tolist() == robot.default_loads.gravity.tolist()


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "expected a header and at least one row"),
        ("motor1,motor2\n", "expected a header and at least one row"),
        ("motor1,moter2\n1,2\n", "'moter2', did you mean motor2?; expected"),
        (
            "motor1;motor2\n1;2\n",
            "line 1: expected commas between cells, and decimal points, got ';'",
        ),
        ("motor1\tmotor2\n1\t2\n", "line 1: expected commas between cells, and decimal points"),
        ("motor1,motor1\n1,2\n", "column motor1 is there twice"),
        ("motor1,motor2\n1,2,3\n", "line 2: expected 2 cells, got 3"),
        ("motor1,motor2\n1,2\n1,two\n", "line 3, column motor2: expected a number"),
        ("motor1,motor2\n1,2.0_059\n", "line 2, column motor2: expected a number, or nothing"),
        ("motor1,motor2\n1,2\n1," + "2" * 131073, "line 3: cannot be read: field larger"),
        ("# long\nmotor1," + "m" * 131073 + "\n1,2\n", "line 2: cannot be read: field larger"),
        ("motor1,motor2\n1,nan\n", "line 2, column motor2: expected a finite number, got nan"),
        ("motor1,motor2\n1,\n", "line 2: nothing drives this row"),
        ("motor1,motor2,qw\n1,2,1\n", "line 2: quaternion_wxyz: expected all of w x y z"),
        ("motor1,motor2,qw,qx,qy,qz\n1,2,1,1,0,0\n", "line 2: quaternion_wxyz: expected unit"),
    ],
)
def test_bad_files(robot, tmp_path, text, problem):
    file = tmp_path / "bad.csv"
    names = dict(zip(("motor1", "motor2"), robot.motor_names, strict=True))
    assert names == {"motor1": "motor1", "motor2": "motor2"}
    file.write_text(text)
    with pytest.raises(InvalidRequest) as caught:
        read_measurements(robot, file)
    assert problem in str(caught.value) and "bad.csv" in str(caught.value)


def test_all_bad_rows_are_named_at_once(robot, tmp_path):
    (tmp_path / "bad.csv").write_text("motor1,motor2\n1,a\n1,2\nb,2\n" + "c,c\n" * 10)
    with pytest.raises(InvalidRequest, match=r"line 2, .*line 4, .*and 4 more"):
        read_measurements(robot, tmp_path / "bad.csv")


def test_no_file(robot, tmp_path):
    with pytest.raises(InvalidRequest, match="cannot be read"):
        read_measurements(robot, tmp_path / "none.csv")
    with pytest.raises(InvalidRequest, match="cannot be written"):
        write_poses(tmp_path / "none" / "poses.csv", [cpr_core.solve_home(robot)])


def test_motors_may_be_called_as_coordinates(tmp_path):
    content = shipped_content("delta")
    for leg, name in zip(content["legs"], "xxyyzz", strict=True):
        leg["chain"][0]["motor"] = name
    gantry = cpr_core.load_robot(content)
    home = cpr_core.solve_home(gantry)
    write_poses(tmp_path / "poses.csv", [home])
    (row,) = read_measurements(gantry, tmp_path / "poses.csv")
    assert row.motors == pytest.approx(home.motors, abs=1e-8)
    assert row.position == pytest.approx(home.platform_position, abs=1e-8)


@pytest.mark.parametrize(
    ("names", "text"),
    [
        (("#q", "r"), "motor '#q': expected a name, one that does not begin with #"),
        ((" q", "r"), "motor ' q': expected a name, one without spaces around it"),
        (("q", "r\ns"), "expected a name, one without spaces around it and without line breaks"),
        (("q", "r\0s"), r"motor 'r\x00s': expected a name, one without control characters"),
        (("q\a", "r"), r"motor 'q\x07': expected a name, one without control characters"),
        (("x", "motor:x"), "motor 'motor:x': expected a name, another one"),
        (("effort:q", "q"), "motor 'effort:q': expected a name, another one"),
    ],
)
def test_names_of_motors_that_could_not_be_read_are_refused(names, text):
    content = shipped_content("rfrfr")
    for leg, name in zip(content["legs"], names, strict=True):
        leg["motor"]["name"] = name
    with pytest.raises(cpr_core.DescriptionError) as caught:
        cpr_core.load_robot(content)
    assert text in str(caught.value)


@pytest.mark.parametrize("names", [("a,b", "q#"), ("motor:z", 'say "q"')])
def test_names_of_motors_are_read_as_they_are_written(tmp_path, names):
    content = shipped_content("rfrfr")
    for leg, name in zip(content["legs"], names, strict=True):
        leg["motor"]["name"] = name
    home = cpr_core.solve_home(cpr_core.load_robot(content))
    write_poses(tmp_path / "poses.csv", [home])
    (row,) = read_measurements(home.robot, tmp_path / "poses.csv")
    assert row.motors == pytest.approx(home.motors, abs=1e-8)


def test_before_which_pose_to_go_home_is_said_between_the_rows(tmp_path):
    home = cpr_core.solve_home(cpr_core.load_robot("rfrfr", modes=3))
    file = tmp_path / "poses.csv"
    write_poses(file, [home] * 3, home_first=[False, True, False])
    lines = file.read_text().splitlines()
    assert [line.startswith("#") for line in lines] == [False, False, True, False, False]
    assert lines[2] == "# back home first"
    assert len(read_measurements(home.robot, file)) == 3
    with pytest.raises(InvalidRequest, match="home_first: expected one for each of 3"):
        write_poses(file, [home] * 3, home_first=[True])

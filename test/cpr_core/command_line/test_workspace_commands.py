# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Command ``cpr workspace`` and its pictures."""

import errno
import json
import os
from dataclasses import asdict

import numpy as np
import pytest
import yaml
from helpers.workspace_cases import content_of_rfrfr, rfrfr, six_rfs, small_map

from cpr_core import InvalidRequest, load_robot, solve_home, solve_inverse
from cpr_core.command_line import main
from cpr_core.drawing.map_plots import field_label, field_names, fields_of, plot_map
from cpr_core.workspace import map_workspace, pose_grid, summary_of
from cpr_core.workspace.store import read_map

SMALL = ("--slice", "x=-0.6:0.6", "y=-0.1:0.7", "--resolution", "0.1")


def run(capsys, *arguments):
    status = main(["workspace", *[str(argument) for argument in arguments]])
    output = capsys.readouterr()
    return status, output.out, output.err


def test_a_map_from_one_command(capsys, tmp_path):
    picture, file = tmp_path / "map.png", tmp_path / "map.nc"
    status, text, _ = run(capsys, "rfrfr", *SMALL, "--plot", picture, "--out", file)
    assert status == 0
    assert f"{small_map().reached.sum()} of 117 cells (13 x 9) are reached" in text
    assert picture.stat().st_size > 10_000
    np.testing.assert_array_equal(read_map(file, rfrfr()).reached, small_map().reached)


def test_as_json_and_multiples_of_pi(capsys):
    plane = ["x=-0.4:-0.3", "y=0:0.1", "z=0.635", "phi=pi/8", "theta=pi/3"]
    options = ["--modes", 3, "--slice", *plane, "--resolution", 0.05, "--json"]
    status, text, _ = run(capsys, "six_rfs", *options)
    values = json.loads(text)
    assert status == 0
    assert values["shape"] == [3, 3]
    assert values["reached"] == 9


@pytest.mark.parametrize(
    ("name", "plane", "place", "options"),
    [
        ("rfrfr", ("x=-0.3:0.3", "y=-0.1:0.3"), (0.0, 0.2), {}),
        ("four_rfr", ("x=-0.02:0.02", "y=0:0.02"), (0, 0, 0), {"objective": "least_effort"}),
    ],
)
def test_a_map_is_that_of_the_library(capsys, tmp_path, name, plane, place, options):
    """Of most options it was not known whether they are heard."""
    robot, size = load_robot(name, modes=3), 0.1 if name == "rfrfr" else 0.02
    loads = robot.default_loads.with_(gravity=[0.0, -0.3, 0.0])
    vary = {part[0]: [float(end) for end in part[2:].split(":")] for part in plane}
    found = map_workspace(
        robot,
        pose_grid(robot, vary, resolution=size),
        start=solve_inverse(robot, place, loads=loads),
        tolerance=0.02,
        **options,
    )
    threshold = float(np.nanmedian(found.inverse_condition_number))
    asked = [name, "--modes", 3, "--gravity", 0, -0.3, 0, "--slice", *plane, "--resolution", size]
    asked += ["--tolerance", 0.02, "--threshold", threshold, "--from", *place, "--json"]
    asked += ["--out", tmp_path / "map.nc"]
    for option, value in options.items():
        asked += [f"--{option}", value]
    told = json.loads(run(capsys, *asked)[1])
    assert 0 < told["below_threshold"] < told["reached"]
    assert told.pop("borders") == [
        {
            "kind": border.kind,
            "points": border.points.tolist(),
            "before": border.before.tolist(),
            "after": border.after.tolist(),
        }
        for border in found.borders
    ]
    for key, value in asdict(summary_of(found, threshold)).items():
        assert key == "borders" or told[key] == (list(value) if key == "shape" else value), key
    assert read_map(tmp_path / "map.nc", robot, loads).objective == found.objective


def test_motors_are_mapped_from_a_start(capsys):
    plane = ["--given", "motors", "--slice", "motor1=2.3:2.9", "motor2=0.2:0.8"]
    start = ["--from", 2.4, 0.5, "--gravity", 0, -1, 0]
    status, text, _ = run(capsys, "rfrfr", *plane, "--resolution", 0.2, *start)
    assert status == 0
    assert "16 of 16 cells (4 x 4)" in text


def test_nothing_is_said_to_be_stable_where_energy_does_not_decide_it(capsys, tmp_path):
    """Cells with index 0 were called stable, and usable: equilibria there say that they are not."""
    plane = [
        "--given",
        "motors",
        "--slice",
        "motor1=5.3:5.5",
        "motor2=5.3:5.5",
        "--resolution",
        0.1,
    ]
    moment = ["--wrench", 0, 0, 0.001, 0, 0, 0]
    picture = tmp_path / "map.svg"
    for options, applies in (([], True), (moment, False)):
        asked = ["three_rfs", "--modes", 3, *plane, *options]
        status, text, _ = run(capsys, *asked, "--json")
        values = json.loads(text)
        assert status == 0 and values["stable"] == 9
        assert values["energy_criterion_applies"] is applies
        assert values["usable"] == (9 if applies else 0)
        _, text, _ = run(capsys, *asked, "--plot", picture)
        assert ("stable with the motors held: 9" in text) is applies
        assert ("energy does not decide stability under these loads; index 0: 9" in text) != applies
        assert ("<!-- index 0: stable -->" in picture.read_text()) is applies
        assert ("<!-- index 0 -->" in picture.read_text()) != applies


def test_motors_of_any_name_are_mapped(capsys, tmp_path):
    """Names with a dash were refused with the form that they had."""
    file = tmp_path / "named.yaml"
    text, unnamed = rfrfr().description.text, "motor: {type: revolute"
    assert text.count(unnamed) == 2
    for name in ("left-motor", "a=b"):
        text = text.replace(unnamed, f"motor: {{name: {name}, type: revolute", 1)
    file.write_text(text)
    plane = ["--given", "motors", "--slice", "left-motor=2.3:2.9", "a=b=0.2:0.8"]
    status, told, _ = run(capsys, file, *plane, "--resolution", 0.2, "--from", 2.4, 0.5)
    assert status == 0
    assert "of 16 cells (4 x 4)" in told


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("--slice", "x=0:1"), "at least two axes"),
        (("--slice", "x=0:1", "x=1:2"), "x is given twice"),
        (("--slice", "x=0", "y=0:1", "x=1:2"), "x is given twice"),
        (("--slice", "x=0:1", "y=a:b"), "expected numbers, got 'y=a:b'"),
        (("--slice", "x=0:1", "y=0:pi/0"), "expected numbers, got 'y=0:pi/0'"),
        (("--slice", "x=0:1", "y=0:1e400"), "expected numbers, got 'y=0:1e400'"),
        (("--slice", "x=0:1", "y=nan:1"), "expected numbers, got 'y=nan:1'"),
        (("--slice", "x=0:1", "y=0:1", "z=inf"), "expected numbers, got 'z=inf'"),
        (("--slice", "x=0:1", "y=-1e308:1e308"), "y: inf cells are too many"),
        (("--slice", "x"), "expected NAME=A or NAME=A:B"),
        (("--slice", "x=0:1", "q=0:1"), "out of x, y"),
        ((*SMALL, "--plot", "map.png", "--field", "beauty"), "field: expected index, "),
        ((*SMALL, "--field", "beauty"), "field: expected index, "),
        ((*SMALL, "--restart"), "restart: expected --out FILE with it"),
    ],
)
def test_bad_requests_are_refused(capsys, tmp_path, monkeypatch, arguments, text):
    monkeypatch.chdir(tmp_path)
    status, _, error = run(capsys, "rfrfr", *arguments)
    assert status == 2
    assert text in error


@pytest.mark.parametrize("option", ["--resolution", "--tolerance", "--threshold"])
@pytest.mark.parametrize("value", ["pi/0", "nan", "inf", "1e400", "", "two"])
def test_what_is_no_number_is_refused(capsys, option, value):
    with pytest.raises(SystemExit) as refused:
        run(capsys, "rfrfr", *SMALL, option, value)
    assert refused.value.code == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert f"argument {option}: expected a finite number, got {value!r}" in last


def test_a_negative_threshold_is_refused_before_the_map_is_made(capsys):
    with pytest.raises(SystemExit) as refused:
        run(capsys, "rfrfr", *SMALL, "--threshold", "-1e-9")
    assert refused.value.code == 2
    assert "--threshold: expected a number of at least 0, got -1e-9" in capsys.readouterr().err


def test_files_that_are_no_map_are_not_replaced(capsys, tmp_path):
    file = tmp_path / "map.nc"
    file.write_text("precious")
    status, _, error = run(capsys, "rfrfr", *SMALL, "--restart", "--out", file)
    assert status == 2
    assert f"cpr: error: file: expected a map, {file} is none" in error
    assert file.read_text() == "precious"


def test_a_map_that_cannot_be_written_is_told_all_the_same(capsys, tmp_path, monkeypatch):
    """Whatever fails in the end: the map, its picture or both."""
    full = tmp_path / "full.png"
    full.symlink_to("/dev/full")
    whole = run(capsys, "rfrfr", *SMALL)[1]

    def fails(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", fails)
    out = tmp_path / "map.nc"
    status, text, error = run(capsys, "rfrfr", *SMALL, "--out", out, "--plot", full)
    assert status == 2
    assert text == whole
    assert error.splitlines() == [
        f"cpr: error: file: {out}: cannot be written: No space left on device",
        f"cpr: error: {full}: cannot be written: No space left on device",
    ]
    assert list(tmp_path.iterdir()) == [full]


def test_every_field_can_be_drawn(tmp_path):
    found = small_map()
    fields = fields_of(found)
    assert len(fields) > 5
    for field in fields:
        file = tmp_path / f"{field}.png"
        plot_map(found, file, field=field)
        assert file.stat().st_size > 10_000
    with pytest.raises(InvalidRequest, match="field"):
        plot_map(found, tmp_path / "no.png", field="no")
    with pytest.raises(InvalidRequest, match=r"no\.pngg: cannot be drawn to: .*png"):
        plot_map(found, tmp_path / "no.pngg")


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_picture_says_what_is_not_known_of_any_cell(tmp_path):
    """It was empty, as that of a robot that gets nowhere, with a warning of numpy."""
    content = content_of_rfrfr()
    stiffness = dict.fromkeys(("torsion", "bending_2", "bending_3"), 0.165)
    content["rod"] = {"length": 1.0, "section": {"shape": "given"} | stiffness}
    robot = load_robot(content)
    found = map_workspace(
        robot, pose_grid(robot, {"x": [-0.1, 0.1], "y": [0.4, 0.6]}, resolution=0.1)
    )
    assert np.any(found.reached)
    pictures = {field: tmp_path / f"{field}.svg" for field in ("strain", "energy")}
    for field, file in pictures.items():
        plot_map(found, file, field=field)
    unknown = [
        field for field, file in pictures.items() if "is not known of any cell" in file.read_text()
    ]
    assert unknown == ["strain"]


@pytest.mark.parametrize(
    ("field", "label"),
    [
        ("index", "index"),
        ("forward_margin", "forward margin"),
        ("energy", "energy [J]"),
        ("smallest_eigenvalue", "smallest eigenvalue [J]"),
        ("limit_margin", "limit margin [rad, rod lengths, or of the limit]"),
        ("motor1", "motor1 [m]"),
        ("motor1_effort", "motor1_effort [N]"),
    ],
)
def test_fields_are_drawn_with_their_units(field, label):
    assert field_label(load_robot("gough_stewart"), field) == label


def with_motors(*names):
    """Content of the RFRFR robot with motors of these names."""
    content = content_of_rfrfr()
    for leg, name in zip(content["legs"], names, strict=True):
        leg["motor"]["name"] = name
    return content


@pytest.mark.parametrize(
    ("names", "fields"),
    [
        (("thumb", "index"), ("thumb", "motor:index")),
        (("energy", "limit_margin"), ("motor:energy", "motor:limit_margin")),
        (("a", "a_effort"), ("a", "motor:a_effort")),
        (("usable_effort", "usable"), ("motor:usable_effort", "motor:usable")),
    ],
)
def test_motors_called_like_a_field_do_not_take_its_place(names, fields):
    robot = load_robot(with_motors(*names))
    grid = pose_grid(robot, {"x": [-0.1, 0.1], "y": [0.4, 0.6]}, resolution=0.1)
    found = map_workspace(robot, grid, tolerance=0.0)
    drawn = fields_of(found)
    assert tuple(drawn) == tuple(dict.fromkeys(field_names(robot))) == field_names(robot)
    np.testing.assert_array_equal(
        drawn["index"], np.where(found.reached, found.index_locked, np.nan)
    )
    np.testing.assert_array_equal(drawn["energy"], found.cells.energy)
    for number, (name, field) in enumerate(zip(names, fields, strict=True)):
        np.testing.assert_array_equal(drawn[field], found.motors[:, number])
        np.testing.assert_array_equal(drawn[f"{name}_effort"], found.cells.efforts[:, number])
        assert field_label(robot, field) == f"{field} [rad]"
        assert field_label(robot, f"{name}_effort") == f"{name}_effort [N m]"
    assert field_label(robot, "energy") == "energy [J]"
    assert field_label(robot, "index") == "index"


def test_pictures_of_a_hand_show_stability_unless_a_finger_is_asked_for(capsys, tmp_path):
    file = tmp_path / "hand.yaml"
    file.write_text(yaml.safe_dump(with_motors("thumb", "index")), encoding="utf-8")
    texts = {}
    for field in ("index", "motor:index", "index_effort"):
        picture = tmp_path / "hand.svg"
        drawn = ("--plot", picture, "--field", field, "--threshold", 0.02)
        status, _, _ = run(capsys, file, *SMALL, *drawn)
        assert status == 0
        texts[field] = picture.read_text(encoding="utf-8")
    assert "index 0: stable" in texts["index"] and "number below 0.02" in texts["index"]
    for field, unit in (("motor:index", "rad"), ("index_effort", "N m")):
        assert f"{field} [{unit}]" in texts[field]
        assert "index 0: stable" not in texts[field]


def test_slices_of_three_dimensions_are_drawn(tmp_path):
    robot = six_rfs()
    x, y, z = solve_home(robot).platform_position
    grid = pose_grid(
        robot, {"x": [x, x + 0.1], "y": [y, y + 0.1], "z": [z - 0.3, z + 0.1]}, resolution=0.05
    )
    found = map_workspace(robot, grid)
    file = tmp_path / "slices.svg"
    plot_map(found, file, field="smallest_eigenvalue")
    plot_map(found, tmp_path / "index.png")
    assert file.stat().st_size > 10_000

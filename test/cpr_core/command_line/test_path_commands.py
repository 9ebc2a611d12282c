# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Commands ``cpr trace`` and ``cpr equilibria``."""

import io
import json
import sys

import numpy as np
import pytest
import yaml
from helpers.yaml_content import shipped_content

from cpr_core import (
    find_equilibria,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
    trace,
)
from cpr_core.command_line import main, path_commands, shared_options

SOLVES = {"motors": solve_forward, "pose": solve_inverse, "efforts": solve_forward_by_effort}
#: A load, as an argument and as an option.
GRAVITY = [0.0, -0.3, 0.0]
LOADED = ("--gravity", *GRAVITY, "--modes", 3)


def run(capsys, *arguments):
    status = main([str(argument) for argument in arguments])
    output = capsys.readouterr()
    return status, output.out, output.err


def test_trace_prints_events_and_end(capsys):
    status, text, _ = run(
        capsys,
        "trace",
        "rfrfr",
        "--given",
        "pose",
        "--from",
        0,
        0.8,
        "--to",
        0,
        -0.2,
        "--modes",
        12,
    )
    assert status == 0
    assert "51 equilibria, the target is reached" in text
    assert text.count("stability is lost") == 2
    assert "at 0.764298" in text
    assert " rad, " in text.splitlines()[-1]
    assert text.rstrip().endswith(", 0) m, index 2")


def test_trace_as_json(capsys):
    status, text, _ = run(
        capsys, "trace", "rfrfr", "--given", "motors", "--to", 5.76, 3.67, "--points", 5, "--json"
    )
    values = json.loads(text)
    assert status == 0
    assert values["reached"] is True
    np.testing.assert_allclose(values["fractions"], np.linspace(0, 1, 5))
    assert np.shape(values["platform_positions"]) == (5, 3)
    np.testing.assert_allclose(values["motors"][-1], [5.76, 3.67])


def test_strains_that_are_not_known_are_null(capsys, tmp_path):
    """JSON has no NaN."""
    content = shipped_content("rfrfr")
    stiff = dict.fromkeys(("torsion", "bending_2", "bending_3"), 0.1)
    content["rod"] = {"length": 1.0, "section": {"shape": "given"} | stiff}
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(content))
    status, text, _ = run(
        capsys,
        *("trace", tmp_path / "robot.yaml", "--given", "motors", "--to", 2.7, 0.6),
        *("--points", 2, "--json"),
    )
    assert status == 0
    assert json.loads(text)["bending_strains"] == [[None, None], [None, None]]


@pytest.mark.parametrize(
    ("name", "given", "first", "last", "options"),
    [
        ("rfrfr", "motors", None, (2.7, 0.6), {}),
        ("rfrfr", "efforts", (0.6, -0.6), (0.8, -0.4), {"past_folds": True}),
        ("four_rfr", "pose", None, (0.02, 0.01, 0.0), {"objective": "least_effort"}),
    ],
)
def test_a_trace_is_that_of_the_library(capsys, name, given, first, last, options):
    """Of most of what it is asked, and of what it tells, it was not known whether it is heard."""
    robot = load_robot(name, modes=3)
    loads = robot.default_loads.with_(gravity=GRAVITY)
    at, solve = (
        (solve_home(robot).motors, solve_forward) if first is None else (first, SOLVES[given])
    )
    start = solve(robot, at, loads=loads)
    expected = trace(robot, **{given: last}, start=start, points=4, **options)
    asked = ["trace", name, *LOADED, "--given", given, "--to", *last, "--points", 4, "--json"]
    asked += ["--from", *first] if first else []
    for option, value in options.items():
        asked += [f"--{option.replace('_', '-')}", *([] if value is True else [value])]
    status, text, _ = run(capsys, *asked)
    found = json.loads(text)
    assert (status, found["reached"]) == (0 if expected.reached else 1, expected.reached)
    for key, values in {
        "fractions": expected.fractions,
        "motors": expected.motors,
        "efforts": expected.efforts,
        "platform_positions": expected.platform_positions,
        "platform_quaternions_wxyz": expected.platform_quaternions,
        "energies": expected.energies,
        "smallest_eigenvalues_locked": expected.eigenvalues_locked,
        "indices_locked": expected.indices_locked,
        "indices_free": expected.indices_free,
        "bending_strains": expected.bending_strains,
    }.items():
        np.testing.assert_allclose(found[key], values, rtol=1e-9, atol=1e-9, err_msg=key)
    assert [
        (event["kind"], event["index_before"], event["index_after"]) for event in found["events"]
    ] == [(event.kind, event.index_before, event.index_after) for event in expected.events]
    assert ("fold" in [event.kind for event in expected.events]) is ("past_folds" in options)


def test_a_stopped_trace_says_so(capsys):
    status, text, _ = run(
        capsys, "trace", "rfrfr", "--given", "pose", "--to", 0, -0.2, "--stable-only", "--json"
    )
    values = json.loads(text)
    assert status == 1
    assert values["reached"] is False
    assert values["events"][-1]["kind"] == "stability"
    assert values["events"][-1]["index_after"] == 1
    asked = ("trace", "rfrfr", "--given", "pose", "--to", 0, -0.2, "--stable-only")
    status, text, _ = run(capsys, *asked)
    assert (status, "the target is NOT reached" in text) == (1, True)


def test_bad_targets_are_refused(capsys):
    status, _, error = run(capsys, "trace", "rfrfr", "--given", "motors", "--to", 1.0)
    assert status == 2
    assert "motors: expected 2 numbers" in error
    status, _, error = run(
        capsys, "trace", "rfrfr", "--given", "motors", "--to", 1, 2, "--points", 1
    )
    assert status == 2
    assert "points: expected at least 2" in error


def test_equilibria_are_listed_by_energy(capsys):
    status, text, _ = run(capsys, "equilibria", "rfrfr", "--starts", 100)
    assert status == 0
    lines = text.splitlines()
    assert "equilibria" in lines[0]
    energies = [float(line.split()[0]) for line in lines[2:]]
    assert energies == sorted(energies)
    assert energies[0] == pytest.approx(0.754803, abs=1e-6)
    assert lines[2].endswith("branch of home")


def test_equilibria_are_those_of_the_library(capsys):
    robot = load_robot("rfrfr", modes=3)
    loads = robot.default_loads.with_(gravity=GRAVITY)
    expected = find_equilibria(robot, [2.8, 0.4], starts=20, seed=3, loads=loads)
    assert len({entry.starts for entry in expected}) > 1
    asked = ("equilibria", "rfrfr", *LOADED, "--motors", 2.8, 0.4, "--starts", 20, "--seed", 3)
    status, text, _ = run(capsys, *asked, "--json")
    found = json.loads(text)["equilibria"]
    assert status == 0
    for told, entry in zip(found, expected, strict=True):
        at = entry.equilibrium
        assert (told["starts"], told["from_home"]) == (entry.starts, entry.from_home)
        assert told["beyond"] == entry.beyond
        assert (told["index_locked"], told["index_free"]) == (at.index_locked, at.index_free)
        assert told["energy"] == pytest.approx(at.energy)
        assert told["efforts"] == pytest.approx(at.efforts)
        assert told["platform_position"] == pytest.approx(at.platform_position, abs=1e-9)
        assert told["platform_quaternion_wxyz"] == pytest.approx(at.platform_quaternion)
    rows = [line.split() for line in run(capsys, *asked)[1].splitlines()[2:]]
    for row, entry in zip(rows, expected, strict=True):
        at = entry.equilibrium
        assert row[:4] == [
            f"{at.energy:.6f}",
            *map(str, (at.index_locked, at.index_free, entry.starts)),
        ]
        assert row[4:7] == [f"{value:.5f}" for value in at.platform_position]


def test_where_no_equilibrium_is_found_nothing_is_drawn(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(path_commands, "find_equilibria", lambda *_, **__: ())
    file = tmp_path / "none.png"
    for options in ((), ("--json",)):
        status, text, error = run(capsys, "equilibria", "rfrfr", "--plot", file, *options)
        assert (status, error, file.exists()) == (1, "", False)
        assert text


def test_progress_is_told_in_percent_on_a_terminal(monkeypatch):
    terminal = io.StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)
    with shared_options.progress_bar("of the way") as show:
        show(1.0)
    assert "of the way: 100%" in terminal.getvalue()


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_pictures(capsys, tmp_path, kind):
    path = tmp_path / f"trace.{kind}"
    run(capsys, "trace", "rfrfr", "--given", "pose", "--to", 0, -0.2, "--plot", path)
    many = tmp_path / f"many.{kind}"
    run(capsys, "equilibria", "rfrfr", "--starts", 50, "--plot", many)
    for file in (path, many):
        assert file.stat().st_size > 10_000
    spatial = tmp_path / f"spatial.{kind}"
    motors = [5.9, 5.5, 5.9, 5.4, 5.9, 5.2]
    run(
        capsys,
        "trace",
        "six_rfs",
        "--given",
        "motors",
        "--to",
        *motors,
        "--points",
        3,
        "--plot",
        spatial,
    )
    assert spatial.stat().st_size > 10_000


def test_a_path_past_folds_is_drawn_by_steps(capsys, tmp_path):
    file = tmp_path / "folds.png"
    status, text, _ = run(
        capsys,
        "trace",
        "rfrfr",
        "--given",
        "efforts",
        "--to",
        2.0,
        -2.0,
        "--past-folds",
        "--plot",
        file,
    )
    assert file.stat().st_size > 10_000
    assert status in (0, 1)
    assert "equilibria" in text


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--plot", "/no/such/folder/a.png"], "expected a folder that exists"),
        (["--plot", "a.xyz"], "expected a name ending in .png"),
    ],
)
def test_pictures_that_cannot_be_drawn_are_refused_at_once(capsys, arguments, text):
    for command in (
        ["trace", "rfrfr", "--given", "motors", "--to", "3.0", "0.9"],
        ["workspace", "rfrfr", "--slice", "x=0:1", "y=0.3"],
    ):
        with pytest.raises(SystemExit) as caught:
            main([*command, *arguments])
        assert caught.value.code == 2
        assert text in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ["equilibria", "rfrfr", "--seed", "-1"],
        ["workspace", "rfrfr", "--slice", "x=0:1", "y=0.3", "--workers", "-1"],
    ],
)
def test_what_is_counted_is_not_negative(capsys, arguments):
    with pytest.raises(SystemExit):
        main(arguments)
    assert "expected a whole number of at least 0" in capsys.readouterr().err


def test_more_points_than_there_is_room_for_are_refused(capsys):
    path = ("trace", "rfrfr", "--given", "motors", "--to", 3.0, 0.9)
    status, _, error = run(capsys, *path, "--points", 10**14)
    assert status == 2
    assert "points: expected at most 1000000" in error


def test_more_starts_than_anybody_waits_for_are_refused(capsys):
    status, _, error = run(capsys, "equilibria", "rfrfr", "--starts", 10**17)
    assert status == 2
    assert "starts: expected at most 1000000" in error


@pytest.mark.parametrize("command", ["trace", "equilibria"])
def test_an_answer_is_told_though_its_picture_cannot_be_drawn(capsys, tmp_path, command):
    full = tmp_path / "full.png"
    full.symlink_to("/dev/full")
    options = {
        "trace": ("--given", "motors", "--to", 2.6, 0.6, "--points", 3),
        "equilibria": ("--starts", 3),
    }[command]
    whole = run(capsys, command, "rfrfr", *options, "--json")[1]
    status, text, error = run(capsys, command, "rfrfr", *options, "--json", "--plot", full)
    assert status == 2
    assert text == whole
    assert error == f"cpr: error: {full}: cannot be written: No space left on device\n"

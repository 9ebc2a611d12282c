# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Commands ``cpr trace`` and ``cpr equilibria``."""

import json

import numpy as np
import pytest
import yaml
from helpers.yaml_content import shipped_content

from cpr_core.command_line import main


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


def test_trace_by_efforts_and_under_gravity(capsys):
    status, text, _ = run(
        capsys, "trace", "rfrfr", "--given", "efforts", "--to", 0.5, -0.5, "--gravity", 0, -9.81, 0
    )
    assert status == 0
    assert "the target is reached" in text


def test_a_stopped_trace_says_so(capsys):
    status, text, _ = run(
        capsys, "trace", "rfrfr", "--given", "pose", "--to", 0, -0.2, "--stable-only", "--json"
    )
    values = json.loads(text)
    assert status == 1
    assert values["reached"] is False
    assert values["events"][-1]["kind"] == "stability"
    assert values["events"][-1]["index_after"] == 1


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


def test_equilibria_as_json(capsys):
    status, text, _ = run(
        capsys, "equilibria", "rfrfr", "--starts", 50, "--motors", 2.8, 0.4, "--json"
    )
    values = json.loads(text)
    assert status == 0
    assert values["equilibria"][0]["from_home"] is True
    assert values["equilibria"][0]["index_locked"] == 0


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

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the launch file makes of its arguments."""

from pathlib import Path

import pytest
import yaml

from cpr_ros.settings.launch_choices import ARGUMENTS, LaunchChoices, misspelt
from cpr_ros.settings.parameter_table import PARAMETERS

ROOT = Path(__file__).parents[3]


def choices(**given):
    return LaunchChoices({name: default for name, (default, _) in ARGUMENTS.items()} | given, ROOT)


@pytest.fixture
def file(tmp_path):
    file = tmp_path / "left.yaml"
    values = {"robot": "rfrfr", "frame_prefix": "left/"}
    file.write_text(yaml.safe_dump({"/**": {"ros__parameters": values}}))
    return str(file)


def test_nothing_given_is_the_robot_of_the_node_with_its_file():
    assert choices().parameters() == [str(ROOT / "config/node/six_rfs.yaml")]


def test_a_parameter_file_keeps_its_robot(file):
    assert choices(parameters=file).parameters() == [file]
    assert choices(parameters=file, robot="delta").parameters() == [file, {"robot": "delta"}]


def test_a_robot_brings_its_file_if_it_has_one():
    own = str(ROOT / "config/node/rfrfr.yaml")
    assert choices(robot="rfrfr").parameters() == [own, {"robot": "rfrfr"}]
    assert choices(robot="delta").parameters() == [{"robot": "delta"}]


def test_every_parameter_is_an_argument_and_comes_with_its_type():
    given = {
        parameter.name: parameter.default_text.strip("'") or "x"
        for parameter in PARAMETERS
        if parameter.name != "robot"
    }
    values = choices(robot="delta", **given).parameters()[-1]
    assert {name: type(value) for name, value in values.items()} == {
        parameter.name: type(parameter.default) for parameter in PARAMETERS
    }


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"modes": "many"}, "modes: expected an integer, got 'many'"),
        ({"max_speed": "fast"}, "max_speed: expected a number"),
        ({"autostart": "maybe"}, "autostart: expected true or false"),
        ({"parameters": "/no/such.yaml"}, "there is no /no/such.yaml"),
    ],
)
def test_values_that_cannot_be_are_refused_before_anything_is_started(given, text):
    with pytest.raises(ValueError, match=text):
        choices(**given).parameters()


def test_the_view_stands_in_the_base_frame_of_the_node(file):
    assert choices().fixed_frame() == "base"
    assert choices(parameters=file).fixed_frame() == "left/base"
    assert choices(parameters=file, base_frame="table").fixed_frame() == "left/table"
    assert choices(frame_prefix="right/").fixed_frame() == "right/base"
    assert choices(rviz="True").wants_view()
    assert not choices().wants_view()


def test_a_misspelt_argument_is_told_and_one_of_somebody_else_is_not():
    told = misspelt(["robot", "robto", "margin_waning", "use_gripper_camera"])
    assert [line.split(": ")[1] for line in told] == [
        "did you mean robot?",
        "did you mean margin_warning?",
    ]

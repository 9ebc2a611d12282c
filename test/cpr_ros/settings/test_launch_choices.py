# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the launch file makes of its arguments."""

from pathlib import Path

import pytest
import yaml

from cpr_ros.settings.launch_choices import ARGUMENTS, LaunchChoices, unknown
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


def topics(configuration):
    """Those that rviz is to subscribe to, and the prefix before frames of the URDF."""
    displays = yaml.safe_load(configuration)["Visualization Manager"]["Displays"]
    (model,) = (each for each in displays if each["Class"] == "rviz_default_plugins/RobotModel")
    found = [each.get("Topic", each.get("Description Topic")) for each in displays]
    return [topic["Value"] for topic in found if topic], model.get("TF Prefix", "")


def test_a_view_hears_every_topic_of_a_node_of_another_name():
    """The description was asked of a cpr_node that was not there."""
    shown, prefix = topics(choices().view_file().read_text())
    assert "cpr_node/robot_description" in shown and not prefix
    remapped = dict(choices(name="arm").view_remappings())
    assert [remapped[topic] for topic in shown] == [
        topic.replace("cpr_node/", "arm/") for topic in shown
    ]


def test_a_view_puts_the_prefix_before_the_frames_of_the_urdf(file):
    """RobotModel found none of them."""
    assert choices().view_configuration() == choices().view_doubt() == ""
    shown, _ = topics(choices().view_file().read_text())
    # rviz puts a / behind the prefix.
    assert topics(choices(parameters=file).view_configuration()) == (shown, "left")
    assert topics(choices(frame_prefix="cell/right/").view_configuration()) == (shown, "cell/right")
    assert choices(parameters=file).view_doubt() == ""
    assert "frame_prefix left_ does not end with /" in choices(frame_prefix="left_").view_doubt()


def test_simulated_time_is_that_of_node_and_view(tmp_path):
    """The argument was taken without a word, and had no effect."""
    assert "use_sim_time" in ARGUMENTS
    simulated = choices(robot="delta", use_sim_time="true")
    assert simulated.parameters()[-1] == {"robot": "delta", "use_sim_time": True}
    assert simulated.view_parameters() == [{"use_sim_time": True}]
    assert choices().view_parameters() == []
    file = tmp_path / "simulated.yaml"
    file.write_text(yaml.safe_dump({"/**": {"ros__parameters": {"use_sim_time": True}}}))
    assert choices(parameters=str(file)).view_parameters() == [{"use_sim_time": True}]
    real = choices(parameters=str(file), use_sim_time="false")
    assert real.parameters()[-1] == {"use_sim_time": False} and real.view_parameters() == []
    with pytest.raises(ValueError, match="use_sim_time: expected true or false"):
        choices(use_sim_time="perhaps").parameters()


def test_every_unknown_argument_is_told_and_what_launch_keeps_is_not():
    told = unknown(["robot", "robto", "margin_waning", "camera", "ros_namespace", "global_params"])
    assert told == [
        "unknown argument robto: did you mean robot?",
        "unknown argument margin_waning: did you mean margin_warning?",
        "unknown argument camera: it changes nothing here",
    ]

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What stands behind ``cpr_node`` on a command line; no ROS is started."""

import os
import subprocess
import sys

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from cpr_core.rods.rod import MOST_MODES
from cpr_ros.settings.node_arguments import files_of_others, unknown_arguments, usage
from cpr_ros.settings.parameter_table import PARAMETERS

NAMES = [parameter.name for parameter in PARAMETERS]


def ended(*arguments, code=""):
    """A process of the command, after code that changes what it finds."""
    start = f"{code}\nimport sys\nfrom cpr_ros.cpr_node import main\nsys.exit(main())"
    return subprocess.run(
        [sys.executable, "-c", start, *arguments],
        env=os.environ | {"ROS_DOMAIN_ID": "nowhere"},  # of which ROS would complain
        capture_output=True,
        text=True,
        timeout=60,
    )


def test_the_node_takes_as_many_modes_as_a_description():
    [modes] = [parameter for parameter in PARAMETERS if parameter.name == "modes"]
    assert modes.limits == (0, MOST_MODES)


@given(st.lists(st.sampled_from(NAMES), min_size=1), st.text(min_size=1))
def test_parameters_of_the_node_are_known_in_every_form_of_ros(names, value):
    given_to_ros = [word for name in names for word in ("-p", f"{name}:={value}")]
    by_node = [word for name in names for word in ("--param", f"cpr_node:{name}:={value}")]
    assert unknown_arguments(["--ros-args", *given_to_ros]) == []
    assert unknown_arguments(["--ros-args", *by_node, "--", "--ros-args", *given_to_ros]) == []
    assert unknown_arguments(["--ros-args", "-r", "a:=b", "--params-file", value, "--"]) == []


@given(st.sampled_from(NAMES), st.data())
def test_a_parameter_with_a_letter_too_few_is_refused_with_its_right_name(name, data):
    gone = data.draw(st.integers(0, len(name) - 1))
    wrong = name[:gone] + name[gone + 1 :]
    (problem,) = unknown_arguments(["--ros-args", "-p", f"{wrong}:=1"])
    assert problem == f"unknown parameter {wrong}: did you mean {name}?"


@given(st.lists(st.text(min_size=1).filter(lambda word: not word.startswith("-")), min_size=1))
def test_every_word_outside_the_arguments_of_ros_is_named(words):
    assert len(unknown_arguments(words)) == len(words)
    for word, problem in zip(words, unknown_arguments(words), strict=True):
        assert problem.startswith(f"unknown argument {word}")


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (["robot:=rfrfr"], "--ros-args -p robot:=rfrfr"),
        (["robt:=rfrfr"], "--ros-args -p robot:=rfrfr"),
        (["--robot", "rfrfr"], "--ros-args -p robot:=rfrfr"),
        (["--robot=rfrfr"], "--ros-args -p robot:=rfrfr"),
        (["rfrfr"], "--ros-args -p robot:=rfrfr"),
        (["-p", "robot:=rfrfr"], "--ros-args -p robot:=rfrfr"),
        (["__ns:=/left"], "--ros-args -r __ns:=/left"),
        (["--params-file", "mine.yaml"], "--ros-args --params-file mine.yaml"),
        (["--ros-args", "robot:=rfrfr"], "-p robot:=rfrfr"),
        (["--ros-args", "-p", "modes:=5", "robot:=rfrfr", "-r", "a:=b"], "-p robot:=rfrfr"),
        (["--ros-args", "--robot", "rfrfr"], "-p robot:=rfrfr"),
        (["--ros-args", "--log-level", "debug", "__ns:=/left"], "-r __ns:=/left"),
    ],
)
def test_an_argument_of_another_form_ends_the_node_with_2_and_what_was_meant(arguments, meant):
    done = ended(*arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"did you mean {meant}?" in done.stderr
    assert len(done.stderr.splitlines()) == 2


def test_a_misspelt_parameter_ends_the_node_with_2():
    done = ended("--ros-args", "-p", "robto:=rfrfr", "-p", "robot:=rfrfr")
    assert done.returncode == 2
    assert "unknown parameter robto: did you mean robot?" in done.stderr


@pytest.mark.parametrize(
    ("section", "meant"),
    [
        ("/**", True),
        ("cpr_node", False),  # one in the root, for ROS
        ("/left/cpr_node", True),
        ("left/cpr_node", True),
        ("/*/cpr_node", True),
        ("/**/cpr_node", True),
        ("/left/cpr_nod", False),
        ("/*", False),
    ],
)
def test_a_parameter_file_that_is_for_others_is_told(tmp_path, section, meant):
    file = tmp_path / "parameters.yaml"
    file.write_text(f"{section}:\n  ros__parameters:\n    robot: rfrfr\n")
    told = files_of_others(["--ros-args", "--params-file", str(file)], "/left/cpr_node")
    assert told == (
        [] if meant else [f"{file} has no parameters for /left/cpr_node: they are for {section}"]
    )


@pytest.mark.parametrize(
    ("content", "named"),
    [
        ({"/left": {"cpr_node": {}}}, []),
        ({"left": {"/cpr_node": {}, "other": {}}}, []),
        ({"/**": {"cpr_node": {}}}, []),
        (
            {"/right": {"cpr_node": {}, "deep": {"node": {}}}},
            ["/right/cpr_node", "/right/deep/node"],
        ),
    ],
)
def test_namespaces_of_a_parameter_file_may_be_sections_of_their_own(tmp_path, content, named):
    """What was read was said to be left aside."""

    def with_parameters(sections):
        return {
            name: with_parameters(inside) if inside else {"ros__parameters": {"robot": "rfrfr"}}
            for name, inside in sections.items()
        }

    file = tmp_path / "parameters.yaml"
    file.write_text(yaml.safe_dump(with_parameters(content)))
    told = files_of_others(["--ros-args", "--params-file", str(file)], "/left/cpr_node")
    assert [line.partition("they are for ")[2] for line in told] == (
        [", ".join(named)] if named else []
    )


def test_help_lists_every_parameter_with_type_unit_and_default_and_imports_no_ros():
    code = "import sys\nfor name in ('rclpy', 'numpy', 'cpr_core'): sys.modules[name] = None"
    done = ended("--help", code=code)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == usage() + "\n"
    for parameter in PARAMETERS:
        (line,) = [
            line for line in done.stdout.splitlines() if line.startswith(f"  {parameter.name}  (")
        ]
        assert parameter.kind in line and parameter.unit in line
        assert f"default {parameter.default_text}" in line

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a description comes from: files, names, texts, and what in them is no YAML."""

import pytest
import yaml
from helpers.spoilt_descriptions import ROBOTS, TEXTS, refused
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, load_robot
from cpr_core.description.description_file import read_description, shipped_robots


@pytest.mark.parametrize(
    "text", ["name: [1, 2\n: }", "a: b: c", "'open", "\tname: x", "a: 1\n---\n"]
)
def test_what_is_not_yaml_is_refused_with_its_place(file, text):
    refused(file(text), "", "is not valid YAML", "line ")


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("line", ["name: again\n", "gravity: [0, 0, 0]\n"])
def test_fields_given_twice_are_refused_with_their_place(file, name, line):
    number = TEXTS[name].count("\n") + 1
    refused(file(TEXTS[name] + line), "", line.split(":")[0], "given twice", f"line {number}")


def test_fields_given_twice_are_refused_in_depth(file):
    text = TEXTS["rfrfr"].replace("radius: 0.001}", "radius: 0.001, radius: 0.002}")
    refused(file(text), "", "'radius' is given twice", "line ")


@pytest.mark.parametrize("text", ["", "# nothing\n", "null", "[1, 2]", "rfrfr", "3.0", "- a: 1"])
def test_files_without_fields_are_refused(file, text):
    refused(file(text), "", "expected fields and values, got ")


@pytest.mark.parametrize(
    "content",
    [bytes(range(256)), b"\x7fELF\x02\x01\x01\x00", b"\x89PNG\r\n\x1a\n\xff", b"name: \x00"],
)
def test_binary_files_are_refused(file, content):
    error = refused(file(content), "")
    assert "cannot be read" in error.problem or "is not valid YAML" in error.problem


@pytest.mark.parametrize("character", ["\0", "\x01", "\x1b[31m", "\x7f"])
@pytest.mark.parametrize(
    ("robot", "part", "blamed"),
    [
        ("rfrfr", [], "name"),
        ("rfrfr", ["legs", 1], "legs[1].name"),
        ("three_prs", ["legs", 2, "chain", 2], "legs[2]"),
    ],
)
def test_names_with_control_characters_are_refused(file, robot, part, blamed, character):
    """They ended names in messages of ROS, coloured terminals, and made URDF that nobody reads."""
    content = shipped_content(robot)
    named = content
    for step in part:
        named = named[step]
    named["name"] = f"a{character}b"
    error = refused(file(yaml.safe_dump(content)), blamed, "expected a name without control")
    assert character not in str(error) and ascii(character)[1:-1] in str(error)


@pytest.mark.parametrize("robot", ["rfrf", "no/such/file.yaml", "cpr_node", "a\0b"])
def test_missing_files_are_refused_with_the_shipped_robots(robot):
    refused(robot, "", "no such file", "rfrfr", "six_rfs")


@pytest.mark.parametrize("robot", ["", " "])
def test_an_empty_name_is_called_one(robot):
    text = f"^description: expected a name, a file or its content, got {robot!r}$"
    with pytest.raises(DescriptionError, match=text):
        read_description(robot)


def test_names_too_long_for_a_file_are_refused():
    refused("x" * 300, "")


@pytest.mark.parametrize(
    "text",
    [
        "? [1, 2]\n: 3\n",  # a list as key
        "? {a: 1}\n: 3\n",
        "a: &a [*a]\n",  # contains itself
        "name: 2020-13-45\n",  # a date that is none
        "name: 0b_\n",  # a number that is none
        "name: !!int seven\n",
        "name: !!float seven\n",
        "name: !!python/name:os.system\n",
        "name: !unknown x\n",
        "[" * 5000,
        "name: 1" + "0" * 5000 + "\n",  # more digits than Python turns into a number
    ],
    ids=lambda text: text[:24].strip(),
)
def test_strange_yaml_is_a_description_error(file, text):
    refused(file(text), "")


@pytest.mark.parametrize("name", shipped_robots())
def test_a_description_may_be_given_as_text(name):
    text = shipped_robots()[name].read_text()
    description = read_description(text)
    assert (description.name, description.text) == (name, text)
    assert load_robot(
        yaml.safe_dump(shipped_content(name), default_flow_style=True)
    ).description.name


@pytest.mark.parametrize("text", ["name: x\nspace: [", "just\nwords", "{name: x}"])
def test_texts_that_are_no_description_are_refused_shortly(text):
    with pytest.raises(DescriptionError) as caught:
        load_robot(text + "\n" + 500 * "# more\n" if "{" not in text else text)
    assert caught.value.source == "description"
    assert len(str(caught.value)) < 400


def test_parts_of_a_file_can_be_shared_by_anchors_and_merge_keys(file):
    text = shipped_robots()["rfrfr"].read_text()
    tip = "tip: {type: revolute, position: [0, 0, 0]}"
    shared = text.replace(tip, "tip: &tip {type: revolute, position: [0, 0, 0]}", 1)
    shared = shared.replace(tip, "tip: {<<: *tip}", 1)
    assert shared.count("tip") > 2
    robot = load_robot(file(shared))
    assert robot.description.legs[1].joint == load_robot("rfrfr").description.legs[1].joint


def test_a_folder_is_no_description(tmp_path):
    refused(tmp_path, "", "file")
    with pytest.raises(DescriptionError, match="it is a folder"):
        load_robot(tmp_path)


def test_what_is_no_file_is_said_to_be_something_else():
    with pytest.raises(DescriptionError, match="it is something else"):
        load_robot("/dev/null")

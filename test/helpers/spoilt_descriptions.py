# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Descriptions that say everything, to be spoilt at one place, and the error that names it."""

import copy

import pytest
import yaml

from cpr_core.description.description_file import read_description, shipped_robots
from cpr_core.errors import DescriptionError

ROBOTS = ["rfrfr", "six_rfs"]
TEXTS = {name: path.read_text(encoding="utf-8") for name, path in shipped_robots().items()}


CONTENTS = {name: yaml.safe_load(TEXTS[name]) for name in ROBOTS}
#: Everything that may be said of a home.
CONTENTS["rfrfr"]["home"] |= {
    "platform": {"position": [0.0, 0.84, 0]},
    "strain": [{"bending_3": [-2.0, 0.0]}, {"bending_3": [2.0, 0.0]}],
}
CONTENTS["six_rfs"]["home"] |= {
    "platform": {
        "position": [0.036, 0.013, 0.845],
        "quaternion_wxyz": [0.9434, -0.0406, -0.0496, 0.3255],
    },
    "strain": [{"bending_2": [-2.0]} for _ in range(6)],
}
#: A planar robot with a platform that turns.
CONTENTS["planar_body"] = copy.deepcopy(CONTENTS["rfrfr"]) | {"platform": {"shape": "body"}}


def full_content(name):
    return copy.deepcopy(CONTENTS[name])


def put(content, path, value):
    """Set what is at a path such as ``("legs", 0, "motor", "axis")``."""
    for part in path[:-1]:
        content = content[part]
    content[path[-1]] = value


def remove(content, path):
    for part in path[:-1]:
        content = content[part]
    del content[path[-1]]


def written(path):
    """A path as messages write it."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def refused(robot, field, *expected):
    """The error of a description, with source, field and hints in its text."""
    with pytest.raises(DescriptionError) as caught:
        read_description(robot)
    error = caught.value
    source = robot["name"] if isinstance(robot, dict) and "name" in robot else str(robot)
    if not isinstance(robot, dict) or "name" in robot:
        assert error.source == source
    assert error.field == field
    assert error.code == "INVALID_DESCRIPTION"
    text = str(error)
    assert text.startswith(f"{error.source}: {field}: " if field else f"{error.source}: ")
    for hint in expected:
        assert hint in text
    return error

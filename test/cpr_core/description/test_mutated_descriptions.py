# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Descriptions changed at random are read or refused, and what is read can be built."""

import copy

import numpy as np
import yaml
from helpers.spoilt_descriptions import CONTENTS, ROBOTS, TEXTS, full_content, put, remove
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cpr_core.description.description_file import read_description
from cpr_core.description.robot_description import RobotDescription
from cpr_core.errors import CprError, DescriptionError
from cpr_core.solving.load_robot import load_robot

FUZZ = settings(deadline=None, derandomize=True, max_examples=300)
#: Reading YAML takes 20 ms.
FUZZ_FILES = settings(
    FUZZ, max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 50),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(["x", "y", "orientation", "planar", "spatial", "body", "point", "revolute"]),
    st.builds(list),
    st.builds(dict),
)
#: Values with which many descriptions still load.
moderate = st.one_of(st.floats(0.1, 10.0), st.integers(0, 6), st.sampled_from([-1.0, 0.0, 5.0]))


@st.composite
def mutated(draw, values):
    """A shipped description with one to three nodes deleted or replaced."""
    # Places are drawn evenly: hypothesis itself would take the first of everything much too often.
    chance = draw(st.randoms(use_true_random=True))
    content = full_content(chance.choice(sorted(CONTENTS)))
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        # Downwards branch by branch: legs have by far the most nodes, but are no more than one.
        path, node = (), content
        while isinstance(node, dict | list) and node and (not path or chance.random() < 0.8):
            path = (
                *path,
                chance.choice(list(node) if isinstance(node, dict) else range(len(node))),
            )
            node = node[path[-1]]
        if not path:
            break
        if chance.random() < 0.2:
            remove(content, path)
        else:
            put(content, path, draw(values))
    return content


@given(mutated(scalars))
@FUZZ
def test_mutated_descriptions_are_read_or_refused(content):
    before = copy.deepcopy(content)
    try:
        description = read_description(content)
    except DescriptionError as error:
        assert error.problem
    else:
        assert isinstance(description, RobotDescription)
    assert repr(content) == repr(before)  # repr, as NaN differs from itself


def _check_read_or_refused(path):
    """A refusal names the file."""
    try:
        description = read_description(path)
    except DescriptionError as error:
        assert str(path) in str(error)
    else:
        assert isinstance(description, RobotDescription)


@given(mutated(scalars))
@FUZZ_FILES
def test_mutated_files_are_read_or_refused(tmp_path, content):
    path = tmp_path / "robot.yaml"
    path.write_text(yaml.safe_dump(content, allow_unicode=True), encoding="utf-8")
    _check_read_or_refused(path)


@given(st.sampled_from(ROBOTS), st.data())
@FUZZ_FILES
def test_files_with_other_characters_are_read_or_refused(tmp_path, name, data):
    text = TEXTS[name]
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(text) - 1))
        gone = data.draw(st.integers(0, 12))
        new = data.draw(st.text(alphabet="[]{}:,-&*!?|>'\"%@`#~<=\n\t 0159.eEx_ab", max_size=4))
        text = text[:place] + new + text[place + gone :]
    path = tmp_path / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    _check_read_or_refused(path)


@given(mutated(moderate))
@FUZZ
def test_what_is_read_can_be_built(content):
    try:
        robot = load_robot(content)
    except DescriptionError:
        return
    try:
        arrays = robot.kernel_arrays
    except CprError:
        return
    assert np.all(np.isfinite(robot.strain_stiffness))
    assert np.all(arrays.unit > 0.0)
    assert len(robot.multiplier_indices) + len(robot.elastic_indices) == arrays.platform_index
    assert all(len(unknowns) == len(rows) for unknowns, rows in robot.problems.values())

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Inertia of the platform: in which order it is read, and which numbers no body can have."""

import numpy as np
import pytest
from helpers.yaml_content import shipped_content
from hypothesis import given
from hypothesis import strategies as st

from cpr_core import DescriptionError, load_robot, solve_home
from cpr_core.description.description_file import read_description


def with_platform(name, **platform):
    content = shipped_content(name)
    content["platform"] = content.get("platform", {}) | platform
    return content


def test_six_numbers_are_the_entries_of_the_matrix():
    content = with_platform("six_rfs", mass=0.3, inertia=[3e-3, 4e-3, 5e-3, 1e-4, -2e-4, 3e-4])
    np.testing.assert_array_equal(
        read_description(content).platform_inertia,
        [[3e-3, 1e-4, -2e-4], [1e-4, 4e-3, 3e-4], [-2e-4, 3e-4, 5e-3]],
    )
    assert not read_description("six_rfs").platform_inertia.any()


def test_statics_does_not_ask_for_it():
    with_it = solve_home(
        load_robot(with_platform("six_rfs", mass=0.3, inertia=[1e-3] * 3 + [0] * 3))
    )
    without = solve_home(load_robot(with_platform("six_rfs", mass=0.3)))
    np.testing.assert_array_equal(with_it.state, without.state)


@given(st.lists(st.tuples(*[st.floats(-1.0, 1.0)] * 3), min_size=1, max_size=5))
def test_masses_somewhere_are_a_body(points):
    """Also all in a plane or on a line, where moments add up exactly."""
    at = np.array(points) - np.mean(points, axis=0)
    inertia = sum(np.eye(3) * (r @ r) - np.outer(r, r) for r in at)
    six = [*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    content = with_platform("six_rfs", mass=1.0, inertia=[float(f"{value:.4g}") for value in six])
    np.testing.assert_allclose(
        read_description(content).platform_inertia, inertia, rtol=1e-3, atol=1e-3
    )


@pytest.mark.parametrize(
    ("name", "platform", "says"),
    [
        ("six_rfs", {"mass": 1.0, "inertia": [1, 1, 1, 0, 0]}, "exactly 6 entries"),
        ("six_rfs", {"mass": 1.0, "inertia": [1, 1, -1, 0, 0, 0]}, "moments -1, 1, 1: expected"),
        ("six_rfs", {"mass": 1.0, "inertia": [1, 1, 2.1, 0, 0, 0]}, "none greater than"),
        ("six_rfs", {"mass": 1.0, "inertia": [1, 1, 1, 0.6, 0, 0]}, "moments 0.4, 1, 1.6"),
        ("six_rfs", {"mass": 1.0, "inertia": [1, 1, 1, 0, 0, 1.1]}, "none negative"),
        ("six_rfs", {"mass": 0, "inertia": [1, 1, 1, 0, 0, 0]}, "expected mass too"),
        ("rfrfr", {"mass": 1.0, "inertia": [1, 1, 1, 0, 0, 0]}, "point platform does not turn"),
        ("planar_body", {"mass": 1.0, "inertia": [0, 0, -1, 0, 0, 0]}, "Izz of at least zero"),
    ],
)
def test_what_no_body_has_is_refused(name, platform, says):
    with pytest.raises(DescriptionError, match=says) as caught:
        read_description(with_platform(name, **platform))
    assert caught.value.field == "platform.inertia"


def test_in_the_plane_only_the_moment_about_its_normal_counts():
    content = with_platform("planar_body", mass=1.0, inertia=[0, 0, 0.02, 0, 0, 0])
    assert read_description(content).platform_inertia[2, 2] == 0.02

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rods that are pulled straight."""

import pytest
from helpers.yaml_content import shipped_content

from cpr_core import load_robot, solve_home, trace
from cpr_core.solving.taut_rods import taut_legs


def test_a_way_that_ends_as_rods_are_taut_says_so():
    """It was said to be farther than 300 steps along the branch, and no more."""
    content = shipped_content("rfrfr")
    content["legs"][1]["base"]["tangent"] = [0, 1, 0]
    content["legs"][1]["motor"] = {"type": "prismatic", "axis": [1, 0, 0]}
    content["home"] = {"motors": [2.59, 0.0], "platform": {"position": [0, 0.5, 0]}}
    found = trace(load_robot(content), motors=[2.59, 3.0], points=2)  # 1.6 m: both are straight
    assert 1.4 < found.last.motors[1] < 1.6
    words = r"steps along the branch (leg1, leg2: pulled taut, with "
    assert found.stopped.kind == "lost" and words in found.stopped.message


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "delta", "two_rods"])
def test_bent_rods_are_not_taut(name):
    assert taut_legs(solve_home(load_robot(name))) == ""

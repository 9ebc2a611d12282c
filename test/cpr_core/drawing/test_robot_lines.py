# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Lines of a robot: their colours, and the pieces they are drawn as."""

from itertools import pairwise

import numpy as np
import pytest
from helpers.yaml_content import shipped_content
from numpy.testing import assert_array_equal

from cpr_core import load_robot, solve_home
from cpr_core.drawing.robot_lines import (
    POINTS,
    bending_curvature,
    equilibrium_lines,
    platform_outline,
    segments,
    shades,
)
from cpr_core.lie import rotation_exp


@pytest.mark.parametrize(
    ("fraction", "color"),
    [(0.0, (0, 0, 1)), (0.5, (0, 1, 0)), (1.0, (1, 0, 0)), (-3.0, (0, 0, 1)), (7.0, (1, 0, 0))],
)
def test_shades_go_from_blue_over_green_to_red(fraction, color):
    assert_array_equal(shades(np.array([fraction])), [color])


def test_torsion_is_no_bending():
    assert_array_equal(bending_curvature(np.array([[5.0, 3.0, -4.0], [1.0, 0.0, 2.0]])), [5.0, 2.0])


@pytest.mark.parametrize("counts", [(), (0,), (1,), (2,), (24, 3, 2), (1, 5, 0, 2), (0, 5)])
def test_pieces_join_neighbours_of_a_line_and_no_two_lines(counts):
    lines = [np.random.default_rng(count).normal(size=(count, 3)) for count in counts]
    expected = [[line[k], line[k + 1]] for line in lines for k in range(len(line) - 1)]
    assert_array_equal(segments(*lines), np.reshape(expected, (-1, 2, 3)))


@pytest.mark.parametrize(("name", "rods"), [("rfrfr", 2), ("two_rods", 4), ("delta", 6)])
def test_rods_are_drawn_as_rods_and_links_once(name, rods):
    """Cranks were drawn twice, as links and with the line of their leg."""
    robot = load_robot(name)
    lines = equilibrium_lines(solve_home(robot))
    assert len(lines.rods) == len(lines.shades) == rods == len(robot.description.rods)
    for line, tones, element in zip(lines.rods, lines.shades, robot.description.rods, strict=True):
        assert line.shape == tones.shape == (POINTS, 3)
        length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
        assert 0.98 * element.rod.length < length <= element.rod.length


@pytest.mark.parametrize("shift", [0.0, 1.0, -0.3])
def test_the_outline_of_a_platform_does_not_depend_on_its_origin(shift):
    content = shipped_content("six_rfs")
    around = platform_outline(load_robot(content))
    assert sorted(around[:-1]) == list(range(6))
    assert around[0] == around[-1]
    for leg in content["legs"]:
        x, y, z = leg["tip"]["position"]
        leg["tip"]["position"] = [x + shift, y - 2.0 * shift, z]
    moved = platform_outline(load_robot(content))
    first = moved.index(around[0])
    assert [*moved[first:-1], *moved[:first], around[0]] == around


@pytest.mark.parametrize(
    "turn", [[0, 0, 0], [np.pi / 2, 0, 0], [0, np.pi / 2, 0], [0.9, -0.7, 0.4]]
)
def test_the_outline_goes_around_however_the_plate_lies_in_its_frame(turn):
    """Sorted by angles in x and y, of a plate that stands upright it crossed itself."""
    content = shipped_content("gough_stewart")
    flat = load_robot(content)
    rotation = rotation_exp(turn)
    for leg in content["legs"]:
        leg["tip"]["position"] = (rotation @ leg["tip"]["position"]).tolist()
        if "axis" in leg["tip"]:
            leg["tip"]["axis"] = (rotation @ leg["tip"]["axis"]).tolist()
    turned = load_robot(content)
    sides = [{*side} for side in pairwise(platform_outline(flat))]
    assert all({*side} in sides for side in pairwise(platform_outline(turned)))

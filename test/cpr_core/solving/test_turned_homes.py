# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How a robot stands in the world, and how its platform's frame is drawn, does not choose its home."""

import numpy as np
import pytest
from helpers.ring_robots import hinged_tripod
from helpers.turned_robots import turned_in_world, with_turned_platform
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose

from cpr_core import load_robot, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.lie import rotation_exp

IN_THE_PLANE = [[0, 0, 0.7], [0, 0, 2.1], [0, 0, 3.0], [0, 0, -2.0]]
IN_SPACE = [*IN_THE_PLANE, [1.5, 0, 0], [0.4, 2.5, 0], [-1, 1, 2]]
CONTENTS = {name: shipped_content(name) for name in shipped_robots()} | {
    f"tripod {tip}": hinged_tripod(tip) for tip in ("revolute", "universal")
}


def turns_of(content):
    """Rotations the robot can have."""
    turns = IN_THE_PLANE if content["space"] == "planar" else IN_SPACE
    return [rotation_exp(np.array(turn)) for turn in turns]


@pytest.mark.parametrize("name", CONTENTS)
def test_home_turns_with_the_robot(name):
    """It was refused at one heading and another one at the next."""
    home = solve_home(load_robot(CONTENTS[name]))
    for turn in turns_of(CONTENTS[name]):
        turned = solve_home(load_robot(turned_in_world(CONTENTS[name], turn)))
        assert_allclose(turned.platform_position, turn @ home.platform_position, atol=1e-8)
        if not home.robot.description.point_platform:
            assert_allclose(turned.platform_rotation, turn @ home.platform_rotation, atol=1e-8)
        assert turned.margin == pytest.approx(home.margin, abs=1e-7)


@pytest.mark.parametrize(
    "name",
    [name for name in CONTENTS if CONTENTS[name].get("platform", {}).get("shape") != "point"],
)
def test_home_is_where_it_is_however_the_frame_of_the_platform_lies_in_it(name):
    """With a rough position and no orientation it was another one, without a word."""
    home = solve_home(load_robot(CONTENTS[name]))
    for turn in turns_of(CONTENTS[name]):
        drawn = solve_home(load_robot(with_turned_platform(CONTENTS[name], turn)))
        assert_allclose(drawn.platform_position, home.platform_position, atol=1e-8)
        assert_allclose(drawn.platform_rotation @ turn, home.platform_rotation, atol=1e-8)
        assert drawn.margin == pytest.approx(home.margin, abs=1e-7)

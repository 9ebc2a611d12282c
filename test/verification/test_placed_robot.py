# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What other programs are told of our robots."""

import numpy as np
import pytest

from cpr_core import leg_shapes, load_robot, solve_forward
from verification.cases import CASES
from verification.not_built import robots_not_built
from verification.placed_robot import BOW, NotPossible, placed
from verification.walk import bowed, gathered


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_rods_begin_where_ours_do_and_are_as_long(case):
    found = solve_forward(case.robot(5), case.motors)
    legs = placed(found.robot.description, case.motors).legs
    for leg, shape in zip(legs, leg_shapes(found), strict=True):
        first = np.flatnonzero(shape.rod == 0)[0]
        np.testing.assert_allclose(leg.clamp.position, shape.position[first], atol=1e-9)
        np.testing.assert_allclose(leg.clamp.rotation, shape.rotation[first], atol=1e-9)
        on_rods = [shape.arc_length[shape.rod == number] for number in range(len(leg.rods))]
        lengths = [stations[-1] - stations[0] for stations in on_rods]
        np.testing.assert_allclose([rod.length for rod in leg.rods], lengths, atol=1e-9)


def test_a_bowed_tip_ends_an_arc_of_the_length_of_the_leg():
    robot = placed(load_robot("six_rfs").description, CASES[1].motors)
    for number, leg in enumerate(robot.legs):
        tangent = leg.clamp.rotation[:, 0]
        way = leg.bowed_tip(1.0) - leg.clamp.position
        assert np.linalg.norm(way) == pytest.approx(2.0 * np.sin(0.5 * BOW) / BOW * leg.reach)
        assert way @ tangent == pytest.approx(leg.reach * np.sin(BOW) / BOW)
        assert way @ leg.bow < 0.0  # the middle stands out to that side, so the tip is on the other
        in_world = robot.platform @ bowed(robot, number, 0.0)
        straight = leg.clamp.position + leg.reach * tangent
        np.testing.assert_allclose(in_world.position, straight, atol=1e-14)
        held = gathered(robot, number, 1.0)
        np.testing.assert_allclose(held.position, leg.tip.position, atol=1e-15)


def test_robots_with_other_legs_are_named_with_what_is_in_the_way():
    lines = robots_not_built()
    assert [line.split(",")[0] for line in lines] == ["delta", "six_rus", "three_prs"]
    assert "a prismatic motor" in lines[2]
    bent = load_robot("six_rus").description
    with pytest.raises(NotPossible, match="across the leg"):
        placed(bent, bent.home.motors)

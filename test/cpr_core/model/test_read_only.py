# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Arrays that are kept and shared are not written to: what is solved later would be wrong."""

import pytest

from cpr_core import kinemato_statics, load_robot, solve_home


@pytest.mark.parametrize("name", ["three_prs", "planar_body"])
def test_arrays_that_are_kept_are_read_only(name):
    """`units = robot.motor_units; units *= 100` changed all answers."""
    robot = load_robot(name)
    for kept in (
        robot.motor_units,
        robot.strain_limits,
        kinemato_statics(solve_home(robot)).tangent,
    ):
        with pytest.raises(ValueError, match="read-only"):
            kept *= 2

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Arrays that are kept and shared are not written to: what is solved later would be wrong."""

import numpy as np
import pytest

from cpr_core import (
    derivatives,
    estimate_wrench,
    kinemato_statics,
    leg_shapes,
    load_robot,
    solve_home,
    trace_through,
)


@pytest.mark.parametrize("name", ["three_prs", "planar_body"])
def test_arrays_that_are_kept_are_read_only(name):
    """`units = robot.motor_units; units *= 100` changed all answers."""
    robot = load_robot(name)
    home = solve_home(robot)
    for kept in (
        robot.motor_units,
        robot.strain_limits,
        kinemato_statics(home).tangent,
        home.platform_quaternion,
        home.spectrum_locked.eigenvalues,
        home.spectrum_locked.motions,
    ):
        with pytest.raises(ValueError, match="read-only"):
            kept *= 2


def test_so_are_the_arrays_of_answers():
    """Some were changed in place, and what was asked again of the same answer was that."""
    home = solve_home(load_robot("six_rfs"))
    answers = (
        trace_through(home.robot, motors=[home.motors, home.motors + 0.01], start=home),
        derivatives(home, ["rod.young_modulus"], of=("pose", "margin")),
        estimate_wrench(home.robot, home.motors, efforts=home.efforts, effort_deviation=1e-3),
        *leg_shapes(home),
        kinemato_statics(home).singularity("forward"),
    )
    seen = 0
    for answer in answers:
        for name, value in vars(answer).items():
            if isinstance(value, np.ndarray):
                seen += 1
                with pytest.raises(ValueError, match="read-only"):
                    value[...] = 0
                assert not value.flags.writeable, name
    assert seen > 20

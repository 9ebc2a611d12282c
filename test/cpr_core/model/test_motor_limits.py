# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Limits of motors as arrays, beside those of the description one by one."""

import numpy as np
from helpers.yaml_content import shipped_content

from cpr_core import load_robot
from cpr_core.model.motor_limits import motor_limit_arrays

LIMITS = ({"position": [0.1, 6.9]}, {"effort": 2.0}, {}, {"position": [-1, 6], "effort": 0.5})


def robot_with(limits):
    content = shipped_content("six_rfs")
    for number, leg in enumerate(content["legs"]):
        leg["motor"]["limits"] = dict(limits[number]) if number < len(limits) else {}
    return load_robot(content)


def test_they_are_those_of_every_motor_at_many_places_at_once():
    robot, random = robot_with(LIMITS), np.random.default_rng(0)
    motors, efforts = random.uniform(-2.0, 9.0, (2, 5, 7, robot.motor_count))
    units = random.uniform(0.5, 2.0, robot.motor_count)
    limits = motor_limit_arrays(robot.description, units)
    found = limits.left(motors, efforts)
    left, reserves = found[..., ~limits.of_effort], found[..., limits.of_effort]
    for place in np.ndindex(5, 7):
        at, effort = motors[place], efforts[place]
        ranges = [at[0] - 0.1, 6.9 - at[0], at[3] + 1.0, 6.0 - at[3]]
        expected = np.array(ranges) / units[[0, 0, 3, 3]]
        np.testing.assert_allclose(left[place], expected, rtol=1e-14)
        shares = effort[1] / 2.0, effort[3] / 0.5
        borne = [1.0 + sign * share for share in shares for sign in (1.0, -1.0)]
        np.testing.assert_allclose(reserves[place], borne, rtol=1e-14)
    np.testing.assert_array_equal(limits.motors, [0, 0, 1, 1, 3, 3, 3, 3])
    np.testing.assert_array_equal(limits.of_effort, [0, 0, 1, 1, 0, 0, 1, 1])
    np.testing.assert_array_equal(limits.upper, [False, True] * 4)


def test_a_robot_without_limits_has_none_to_reach():
    robot = robot_with(())
    limits = robot.motor_limits
    motors = np.zeros((3, robot.motor_count))
    assert limits.left(motors, motors).shape == (3, 0)
    assert limits.left(motors[0], motors[0]).shape == (0,)

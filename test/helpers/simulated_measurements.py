# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measurements of robots that are known, with noise."""

import numpy as np

import cpr_core
from cpr_core import Measurement, StandardDeviations
from cpr_core.lie import quaternion_from_rotation, rotation_exp

DEVIATIONS = StandardDeviations(position=0.5e-3, rotation=2e-3)
OFFSETS = tuple(f"legs[{leg}].motor.offset" for leg in range(6))
PATHS = ("rod.young_modulus", *OFFSETS)


def payload(robot, force=-1.0):
    return robot.default_loads.with_(wrench_world=[0, 0, 0, 0, 0, force])


def equilibria(truth, start, *, count=20, loads=None, reach=0.3, seed=0):
    """Of the true robot, at random motors around an equilibrium of the described one."""
    generator = np.random.default_rng(seed)
    home = cpr_core.continued(start, truth)
    return [
        cpr_core.solve_forward(
            truth,
            start.motors + generator.uniform(-reach, reach, truth.motor_count),
            start=home,
            loads=loads,
        )
        for _ in range(count)
    ]


def measured(found, *, seed=None, deviations=DEVIATIONS, efforts=False):
    """What sensors would show; exact without a seed."""
    generator = np.random.default_rng(seed)
    noise = 0.0 if seed is None else 1.0
    rows = []
    for each in found:
        turn = rotation_exp(noise * generator.normal(0.0, deviations.rotation, 3))
        shift = noise * generator.normal(0.0, deviations.position, 3)
        push = noise * generator.normal(0.0, deviations.efforts or 0.0, len(each.efforts))
        rows.append(
            Measurement(
                motors=each.motors,
                position=each.platform_position + shift,
                quaternion_wxyz=quaternion_from_rotation(turn @ each.platform_rotation),
                efforts=each.efforts + push if efforts else None,
                loads=each.loads,
            )
        )
    return rows

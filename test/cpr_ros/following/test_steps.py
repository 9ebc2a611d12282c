# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Steps from one equilibrium to the next: how large one is, and what time it is given."""

import time

import numpy as np
import pytest
from helpers.turntable import turntable

from cpr_core import load_robot, solve_forward, solve_home
from cpr_core.model.assessment import Assessment
from cpr_ros.following.goals import MotorGoal
from cpr_ros.following.steps import Undecided, attempt, change_between


@pytest.mark.parametrize("angle", [0.01, 0.3, -1.5])
def test_a_platform_that_only_turns_has_moved(angle):
    home = solve_home(turntable())
    turned = solve_forward(home.robot, [angle], start=home)
    expected = np.abs(turned.platform_rotation - home.platform_rotation).max()
    assert expected >= 0.9 * abs(np.sin(angle))
    assert change_between(home, turned) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "gough_stewart", "delta"])
def test_legs_and_platform_count_in_their_units_motors_and_forces_do_not(name):
    robot = load_robot(name)
    home = solve_home(robot)
    ways = 0.05 * robot.motor_units * (np.arange(robot.motor_count) == 0)
    moved = solve_forward(robot, home.motors + ways)
    strains = moved.leg_coordinates - home.leg_coordinates
    changes = [
        strains / robot.kernel_arrays.unit[robot.elastic_indices],
        (moved.platform_position - home.platform_position) / robot.mean_length,
        (moved.platform_rotation - home.platform_rotation).ravel(),
    ]
    expected = max(np.abs(change).max(initial=0.0) for change in changes)
    assert expected > 1e-3
    assert change_between(home, moved) == change_between(moved, home) == expected
    assert change_between(home, home) == 0.0


class Late(MotorGoal):
    """Motors whose first solution has no time left: it is spent before, asleep or at work."""

    def __init__(self, robot, motors, spend):
        super().__init__(robot, motors)
        self.spend, self.asked_for = spend, 0

    def solve(self, start, fraction, loads, time_limit=None):
        self.asked_for += 1
        if self.asked_for > 1:
            return super().solve(start, fraction, loads, time_limit)
        self.spend(time_limit)
        return super().solve(start, fraction, loads, 0.0)


def work(seconds):
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


@pytest.mark.parametrize(("spend", "tries"), [(time.sleep, 2), (work, 1)])
def test_time_that_others_had_the_processor_is_not_the_solution_s(spend, tries):
    """A motion was given up where a busy computer had held the node up within a solution."""
    home = solve_home(load_robot("rfrfr"))
    late = Late(home.robot, home.motors + [0.3, 0.0], spend)
    found = attempt(Assessment(home), late, 1.0, home.loads, time_limit=0.05)
    assert late.asked_for == tries
    if tries == 1:
        assert isinstance(found, Undecided)
        assert found.text == "no equilibrium is found within 0.05 s"
    else:
        np.testing.assert_array_equal(found.equilibrium.motors, late.motors)

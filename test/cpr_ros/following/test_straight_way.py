# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Ways of the motors on which nothing halts them: through what would be refused they are not taken."""

import re
from dataclasses import replace
from itertools import chain, repeat

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode
from helpers.branches import stable_elsewhere
from helpers.drive import SETTINGS, robot
from helpers.geared_robots import geared

from cpr_core import solve_forward, solve_home, solve_inverse
from cpr_core.model.assessment import Assessment, Threshold
from cpr_core.solving.deadline import Deadline
from cpr_ros.error_codes import RequestError
from cpr_ros.following.straight_way import check_straight_way


def in_time():
    return Deadline(1e3)


def over_after(readings):
    """Of a clock that stands still until it has been read so often; it is read first to begin."""
    return Deadline(1e3, chain(repeat(0.0, 1 + readings), repeat(1e9)).__next__)


def checked(start, commands, target, deadline=None):
    deadline = in_time() if deadline is None else deadline
    check_straight_way(Assessment(start), commands, target, SETTINGS.thresholds, deadline)


def refusal(*arguments, **options):
    with pytest.raises(RequestError) as refused:
        checked(*arguments, **options)
    assert str(refused.value).startswith("apply: ")
    return refused.value


def test_a_way_on_the_branch_is_taken_from_wherever_commands_are():
    home = solve_home(robot("rfrfr"))
    target = solve_forward(home.robot, [2.9, 0.2])
    checked(home, home.motors, target)
    checked(home, np.array([2.7, 0.4]), target)
    checked(target, home.motors, target)  # its commands are still on their way
    checked(target, np.array([2.7, 0.4]), home)  # and are taken back


def test_nothing_is_asked_of_a_solution_at_the_last_commands():
    """That is how the node is told in which equilibrium the robot is."""
    home = solve_home(robot("rfrfr"))
    checked(solve_forward(home.robot, [2.9, 0.2]), home.motors, home)


def test_a_stop_threshold_is_not_passed():
    home = solve_home(robot("rfrfr"))
    low = solve_inverse(home.robot, [0.0, 0.038])
    assert 0.0 < Assessment(low).value("margin") < SETTINGS.thresholds["margin"].stop
    refused = refusal(home, home.motors, low)
    assert refused.val == ErrorCode.INVALID_MOTION_PLAN
    assert "of the way: margin would be 0.0" in str(refused)
    assert "below margin_stop 0.05" in str(refused)
    checked(low, low.motors, home)  # out of it one may


def test_where_it_is_not_free_is_told_from_the_commands_on():
    """Wherever the model is meanwhile: that is the way that who asks sees."""
    thresholds = SETTINGS.thresholds | {"margin": Threshold(0.8, 0.6)}
    home = solve_home(robot("rfrfr"))
    target = solve_forward(home.robot, [5.4, -2.2])
    commands = home.motors + 0.3 * (target.motors - home.motors)
    told = []
    for start in (home, solve_forward(home.robot, commands)):
        with pytest.raises(RequestError) as refused:
            check_straight_way(Assessment(start), commands, target, thresholds, in_time())
        told.append(float(re.search(r"after (\d+) % of the way: margin", str(refused.value))[1]))
    assert 10.0 < told[0] < 90.0
    assert told[0] == pytest.approx(told[1], abs=2.0)


def test_gears_change_nothing_of_what_is_said_of_a_way():
    """Motors behind them turn a hundred times as far, and are looked at as often."""
    thresholds = SETTINGS.thresholds | {"margin": Threshold(0.8, 0.6)}
    plain, behind_gears, ratios = geared("rfrfr")
    told = []
    for machine, way_of_motors in ((plain, 1.0), (behind_gears, 1.0 / ratios)):
        home = solve_home(machine)
        near, far = (
            solve_forward(machine, way_of_motors * np.array(joints))
            for joints in ([2.9, 0.2], [5.4, -2.2])
        )
        check_straight_way(Assessment(home), home.motors, near, thresholds, in_time())
        with pytest.raises(RequestError) as refused:
            check_straight_way(Assessment(home), home.motors, far, thresholds, in_time())
        told.append(str(refused.value))
    assert "% of the way: margin would be 0.59" in told[0]
    assert told[1] == told[0]


def test_a_fold_between_is_found_though_both_ends_are_on_the_branch_of_home():
    """Found from home, and gone to from elsewhere: straight in the motors the robot snaps."""
    home = solve_home(robot("rfrfr"))
    away = solve_inverse(home.robot, [0.1287537, -0.30454163], start=home)
    target = solve_inverse(home.robot, [0.09470072, 0.19875977], start=home)
    assert away.stable
    assert target.stable
    refused = refusal(away, away.motors, target)
    assert refused.val == ErrorCode.INVALID_MOTION_PLAN
    assert "of the way: " in str(refused)


def test_another_equilibrium_at_its_end_is_another():
    home = solve_home(robot("rfrfr"))
    target = solve_forward(home.robot, [2.7, 0.5], start=stable_elsewhere(home.robot))
    assert "leads to another equilibrium" in str(refusal(home, home.motors, target))


def test_loads_of_the_solution_act_on_the_way():
    home = solve_home(robot("rfrfr"))
    loads = home.loads.with_(wrench_world=[0, 0, 0, 0.2, 0, 0])
    pushed = solve_forward(home.robot, [2.9, 0.2], start=home, loads=loads)
    checked(home, home.motors, pushed)
    crushed = replace(pushed, loads=home.loads.with_(wrench_world=[0, 0, 0, 0, -20.0, 0]))
    assert "where the robot is: " in str(refusal(home, home.motors, crushed))


def test_what_takes_too_long_is_not_taken():
    home = solve_home(robot("six_rfs"))
    target = solve_forward(home.robot, home.motors + 0.3)
    refused = refusal(home, home.motors, target, over_after(0))
    assert refused.val == ErrorCode.TIMED_OUT
    assert "before the way of the motors to it was followed to its end" in str(refused)


def test_the_loads_of_a_solution_have_the_same_deadline():
    """They were put on without any."""
    home = solve_home(robot("rfrfr"))
    loads = home.loads.with_(wrench_world=[0, 0, 0, 0.2, 0, 0])
    pushed = solve_forward(home.robot, [2.9, 0.2], start=home, loads=loads)
    refused = refusal(home, home.motors, pushed, over_after(0))
    assert refused.val == ErrorCode.TIMED_OUT
    assert "before its loads acted where the motors are" in str(refused)


def test_a_way_ends_with_its_deadline_between_two_looks_too():
    """Sixty of them, or 0.05 s, were always solved to the end."""
    home = solve_home(robot("rfrfr"))
    target = solve_forward(home.robot, [2.9, 0.2])
    assert refusal(home, home.motors, target, over_after(1)).val == ErrorCode.TIMED_OUT

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The estimated error of a border of stability against borders of many modes."""

import numpy as np
import pytest

from cpr_core import (
    InvalidRequest,
    border_error,
    critical_load,
    critical_load_factor,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    trace,
)

TRUE_MODES = 16


def border_on_axis(modes):
    """Where the paper's robot, moved down its axis, loses stability: branches cross there."""
    robot = load_robot("rfrfr", modes=modes)
    found = trace(robot, pose=[0.0, -0.2], start=solve_inverse(robot, [0.0, 0.8]))
    return next(event for event in found.events if event.kind == "stability")


@pytest.mark.parametrize("modes", [5, 6, 7, 8, 9])
def test_a_border_on_the_way_of_a_pose(modes):
    event, true = border_on_axis(modes), border_on_axis(TRUE_MODES)
    farther = true.fraction - event.fraction
    assert abs(farther) > 1e-5
    assert 1.0 / 3.0 < border_error(event.equilibrium, pose=[0.0, -1.0]) / farther < 3.0


def fold(name, modes, way):
    """Where a robot snaps when its motors are moved."""
    robot = load_robot(name, modes=modes)
    home = solve_home(robot)
    found = trace(robot, motors=home.motors + way, start=home)
    event = found.events[-1]
    assert event.kind == "fold"
    return event


@pytest.mark.parametrize(
    "way", [[2.0, -0.5, 0.3, -2.8, 1.5, 0.2], [2.8, 1.3, 0.2, -1.3, -2.0, 2.8]]
)
@pytest.mark.parametrize("modes", [4, 5, 6, 7])
def test_a_fold_on_the_way_of_motors(way, modes):
    event, true = fold("six_rfs", modes, way), fold("six_rfs", TRUE_MODES, way)
    farther = true.fraction - event.fraction
    assert abs(farther) > 1e-7
    assert 1.0 / 3.0 < border_error(event.equilibrium, motors=way) / farther < 3.0


@pytest.mark.parametrize("modes", [4, 5, 6])
@pytest.mark.parametrize("growing", ["a force", "all loads"])
def test_a_critical_load(modes, growing):
    def critical(modes):
        robot = load_robot("rfrfr", modes=modes)
        start = solve_forward(robot, [2.3, 0.7])
        if growing == "a force":
            return critical_load(start, [0.0, -1.0, 0.0])
        loaded = start.loads.with_(wrench_world=[0, 0, 0, 0.3, -1.0, 0])
        return critical_load_factor(solve_forward(robot, start.motors, loads=loaded))

    found, true = critical(modes), critical(TRUE_MODES)
    loads = found.equilibrium.loads
    added = (
        loads.scaled(1.0 / found.value)
        if growing == "all loads"
        else loads.none().with_(wrench_world=[0, 0, 0, 0, -1.0, 0])
    )
    farther = true.value - found.value
    assert abs(farther) > 1e-6
    assert 1.0 / 3.0 < border_error(found.equilibrium, loads=added) / farther < 3.0


def test_with_many_modes_nothing_is_left():
    event = border_on_axis(TRUE_MODES)
    assert abs(border_error(event.equilibrium, pose=[0.0, -1.0])) < 1e-6


def test_bad_questions_are_refused():
    home = solve_home(load_robot("rfrfr"))
    with pytest.raises(InvalidRequest, match="expected one way"):
        border_error(home)
    with pytest.raises(InvalidRequest, match="expected one way"):
        border_error(home, motors=[1.0, 0.0], pose=[1.0, 0.0])
    with pytest.raises(InvalidRequest, match="motors"):
        border_error(home, motors=[1.0, 0.0, 0.0])
    with pytest.raises(InvalidRequest, match="expected an Equilibrium"):
        border_error("home", motors=[1.0, 0.0])
    redundant = solve_home(load_robot("four_rfr"))
    with pytest.raises(InvalidRequest, match="no twist"):
        border_error(redundant, pose=np.zeros(3))

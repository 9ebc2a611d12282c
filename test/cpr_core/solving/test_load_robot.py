# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Loading robots again and again."""

import pytest

from cpr_core import InvalidRequest, load_robot, solve_forward, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.description.motors import MOTORS


def test_a_shipped_robot_is_loaded_once():
    robot = load_robot("rfrfr")
    assert load_robot("rfrfr") is robot
    assert load_robot("rfrfr", modes=4) is load_robot("rfrfr", modes=4)
    assert load_robot("rfrfr", modes=4) is not robot
    assert load_robot("six_rfs") is not robot
    start = solve_home(load_robot("rfrfr"))
    assert solve_forward(load_robot("rfrfr"), start.motors, start=start).robot is robot


def test_files_and_contents_are_read_again():
    file = shipped_robots()["rfrfr"]
    for source in (file, str(file), file.read_text()):
        assert load_robot(source) is not load_robot(source)
        assert load_robot(source) is not load_robot("rfrfr")


def test_with_another_kind_of_motor_it_is_read_again(monkeypatch):
    robot = load_robot("rfrfr")
    monkeypatch.setitem(MOTORS, "geared", MOTORS["revolute"])
    assert load_robot("rfrfr") is not robot
    monkeypatch.undo()
    assert load_robot("rfrfr") is robot


@pytest.mark.parametrize("modes", [True, 4.0, 0, "4", [4]])
def test_what_is_no_number_of_modes_is_refused_beside_one_that_is(modes):
    load_robot("rfrfr", modes=4)
    load_robot("rfrfr", modes=1)
    with pytest.raises(InvalidRequest, match="modes: expected"):
        load_robot("rfrfr", modes=modes)

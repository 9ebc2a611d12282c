# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Maps of the workspace, made by a real node for a client in this process."""

import math
import os
import signal

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from cpr_msgs.action import MapWorkspace
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from geometry_msgs.msg import WrenchStamped
from helpers.map_client import HUGE, LONG, MEDIUM, SMALL, MapClient, lives, workers_of

import cpr_core
from cpr_core import solve_home
from cpr_core.workspace import map_workspace, motor_grid, pose_grid, summary_of
from cpr_core.workspace.store import read_map

pytestmark = pytest.mark.waits(seconds=55)

Goal = MapWorkspace.Goal


@pytest.fixture
def maps(rfrfr):
    client = MapClient(rfrfr.client)
    yield client
    client.close()


def grid_of(robot, axes=SMALL):
    return pose_grid(
        robot,
        {name: (first, last) for name, (first, last, _) in axes.items()},
        resolution={name: step for name, (_, _, step) in axes.items()},
    )


def assert_same_cells(found, expected):
    """Two maps of two processes, whose compiled code may round differently."""
    np.testing.assert_array_equal(found.reached, expected.reached)
    np.testing.assert_array_equal(found.index_locked, expected.index_locked)
    for name in ("state", "eigenvalues", "measures", "edge_fraction"):
        mine, other = getattr(found.cells, name), getattr(expected.cells, name)
        np.testing.assert_allclose(mine, other, rtol=1e-5, atol=1e-9)
    for border, other in zip(found.borders, expected.borders, strict=True):
        np.testing.assert_allclose(border.points, other.points, atol=1e-9)


def test_a_goal_makes_the_map_that_the_library_makes(drive, maps, tmp_path):
    file = tmp_path / "map.nc"
    status, result = maps.make(file, threshold=0.02)
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert result.error_code.val == ErrorCode.SUCCESS
    assert result.file == str(file)
    robot = cpr_core.load_robot("rfrfr")
    wanted = map_workspace(robot, grid_of(robot))
    assert_same_cells(read_map(file, robot), wanted)
    summary = summary_of(wanted, 0.02)
    assert result.complete
    assert list(result.shape) == [13, 9]
    assert result.cell_area == pytest.approx(0.01)
    for name in (
        "cells",
        "reached",
        "stable",
        "usable",
        "beyond_limits",
        "below_threshold",
        "disagreements",
    ):
        assert getattr(result, name) == getattr(summary, name), name
    assert 0 < result.stable < result.reached < result.cells
    assert 0 < result.below_threshold < result.reached
    assert [border.kind for border in result.borders] == [border.kind for border in wanted.borders]
    assert result.borders
    for border, other in zip(result.borders, summary.borders, strict=True):
        assert border.points == other.points > 0
        np.testing.assert_allclose(border.lower, other.lower, atol=1e-9)
        np.testing.assert_allclose(border.upper, other.upper, atol=1e-9)
    maps.client.spin_until(lambda: maps.feedback)  # the result may be taken first
    assert all(feedback.total == 117 for feedback in maps.feedback)
    assert all(feedback.done <= feedback.reached <= result.reached for feedback in maps.feedback)


def test_motors_are_mapped_and_others_held(six_rfs, tmp_path):
    maps = MapClient(six_rfs.client)
    robot = cpr_core.load_robot("six_rfs")
    home = dict(zip(robot.motor_names, solve_home(robot).motors, strict=True))
    axes = {name: (home[name] - 0.05, home[name] + 0.05, 0.05) for name in ("motor1", "motor4")}
    held = home["motor2"] + 0.1
    try:
        _, result = maps.make(
            tmp_path / "map.nc", axes, given=Goal.GIVEN_MOTORS, held=["motor2"], held_values=[held]
        )
    finally:
        maps.close()
    assert result.error_code.val == ErrorCode.SUCCESS, result.error_code.message
    found = read_map(tmp_path / "map.nc", robot)
    grid = motor_grid(
        robot,
        {name: (first, last) for name, (first, last, _) in axes.items()},
        {"motor2": held},
        resolution=0.05,
    )
    assert_same_cells(found, map_workspace(robot, grid))
    np.testing.assert_array_equal(found.motors[:, 1], held)


def test_a_map_begins_where_the_robot_is_and_under_its_loads(drive, maps, tmp_path):
    drive.send_platform(0.21, 0.62)
    drive.until(lambda: np.allclose(drive.position[:2], [0.21, 0.62], atol=1e-8))
    robot = cpr_core.load_robot("rfrfr")
    pushed = robot.default_loads.with_(wrench_world=[0, 0, 0, 0.1, -0.2, 0])
    for start, place in (
        (Goal.START_CURRENT, [0.2, 0.6]),
        (Goal.START_HOME, [0.0, 0.7]),
    ):
        wrench = WrenchStamped()
        wrench.wrench.force.x, wrench.wrench.force.y = 0.1, -0.2
        goal = {"wrench": [wrench], "start": start}
        file = tmp_path / f"map{start}.nc"
        _, result = maps.make(file, **goal)
        assert result.error_code.val == ErrorCode.SUCCESS, result.error_code.message
        found = read_map(file, robot, pushed)
        np.testing.assert_allclose(found.place(found.first), place, atol=1e-12)
    assert_same_cells(found, map_workspace(robot, grid_of(robot), loads=pushed))


def test_the_node_follows_setpoints_and_streams_while_a_map_is_made(drive, maps, tmp_path):
    handle = maps.send(tmp_path / "map.nc", HUGE)  # on all cores
    maps.until_done(1)
    maps.until_status(handle, GoalStatus.STATUS_EXECUTING)
    for motors in ([2.65, 0.50], [2.50, 0.70]):
        drive.send_motors(*motors)
        drive.until(lambda motors=motors: np.array_equal(drive.motors, motors))
    drive.forget()
    drive.client.spin_until(lambda: len(drive.all(StabilityMetrics)) > 20)
    drive.assert_correct(
        2.59, 0.55, expected=solve_home(cpr_core.load_robot("rfrfr")).platform_position
    )
    assert maps.status(handle) == GoalStatus.STATUS_EXECUTING
    assert maps.feedback[-1].rate > 0.0
    assert maps.cancel(handle) == 1
    assert maps.result(handle)[0] == GoalStatus.STATUS_CANCELED


def test_one_map_at_a_time(drive, maps, tmp_path):
    first = maps.send(tmp_path / "first.nc", LONG, workers=1)
    maps.until_done(1)
    status, result = maps.make(tmp_path / "second.nc")
    assert status == GoalStatus.STATUS_ABORTED
    assert result.error_code.val == ErrorCode.NOT_READY
    assert "one at a time" in result.error_code.message
    assert maps.cancel(first) == 1
    assert maps.result(first)[0] == GoalStatus.STATUS_CANCELED
    assert maps.make(tmp_path / "second.nc")[0] == GoalStatus.STATUS_SUCCEEDED


def test_a_cancelled_map_is_kept_and_gone_on_with(drive, maps, rfrfr, tmp_path):
    file, whole = tmp_path / "map.nc", tmp_path / "whole.nc"
    handle = maps.send(file, MEDIUM, workers=1)
    maps.until_done(500)
    maps.cancel(handle)
    status, result = maps.result(handle)
    assert status == GoalStatus.STATUS_CANCELED
    assert result.error_code.val == ErrorCode.PREEMPTED
    assert not result.complete
    assert result.file == str(file)
    assert 500 <= result.reached < result.cells
    assert list(tmp_path.iterdir()) == [file]
    assert workers_of(rfrfr.process.process.pid) == []
    robot = cpr_core.load_robot("rfrfr")
    assert 500 <= read_map(file, robot).expanded < result.reached

    status, result = maps.make(file, MEDIUM, existing_file=Goal.RESUME)
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert maps.feedback[0].done >= 500
    assert maps.make(whole, MEDIUM)[1].reached == result.reached
    assert file.read_bytes() == whole.read_bytes()


def test_files_that_exist(drive, maps, tmp_path):
    file, text = tmp_path / "map.nc", tmp_path / "text.nc"
    text.write_text("precious")

    def refused(file, **fields):
        _, result = maps.make(file, **fields)
        assert result.error_code.val == ErrorCode.INVALID_FILE
        return result.error_code.message

    assert maps.make(file)[1].complete
    before = file.read_bytes()
    other = {"x": (-0.5, 0.5, 0.1), "y": (0.3, 0.7, 0.1)}
    assert "set existing_file to RESUME or REPLACE" in refused(file)
    assert "a map of another grid" in refused(file, axes=other, existing_file=Goal.RESUME)
    assert "expected a NetCDF file" in refused(text, existing_file=Goal.RESUME)
    assert "is none and is not replaced" in refused(text, existing_file=Goal.REPLACE)
    assert "folder that exists" in refused(tmp_path / "no" / "map.nc")
    assert "expected the name" in refused("")
    assert file.read_bytes() == before
    assert text.read_text() == "precious"
    assert maps.make(file, other, existing_file=Goal.REPLACE)[1].complete
    robot = cpr_core.load_robot("rfrfr")
    assert read_map(file, robot).grid.shape == (11, 5)


@pytest.mark.parametrize(
    ("axes", "fields", "code", "text"),
    [
        ({"x": (0.0, 0.1, 0.1)}, {}, ErrorCode.INVALID_ROBOT_STATE, "at least two axes"),
        ({"x": (0.1, 0.0, 0.1), "y": (0, 1.0, 0.1)}, {}, ErrorCode.INVALID_ROBOT_STATE, "larger"),
        ({"x": (0.0, 0.1, 0.0), "y": (0, 1.0, 0.1)}, {}, ErrorCode.INVALID_ROBOT_STATE, "positive"),
        (
            {"x": (0.0, 1.0, 1e-5), "y": (0, 1.0, 1e-5)},
            {},
            ErrorCode.INVALID_ROBOT_STATE,
            "at most",
        ),
        ({"x": (0.0, math.nan, 0.1), "y": (0, 1.0, 0.1)}, {}, ErrorCode.NON_FINITE_INPUT, "x"),
        ({"x": (0.0, 0.1, 0.1), "z": (0.0, 1.0, 0.1)}, {}, ErrorCode.INVALID_ROBOT_STATE, "'z'"),
        (SMALL, {"held": ["y"], "held_values": [0.1]}, ErrorCode.INVALID_ROBOT_STATE, "y is given"),
        (SMALL, {"held": ["y"]}, ErrorCode.INVALID_ROBOT_STATE, "held_values: expected 1"),
        (SMALL, {"given": 7}, ErrorCode.INVALID_ROBOT_STATE, "given: expected"),
        (SMALL, {"start": 7}, ErrorCode.INVALID_ROBOT_STATE, "start: expected"),
        (SMALL, {"existing_file": 7}, ErrorCode.INVALID_ROBOT_STATE, "existing_file: expected"),
        (SMALL, {"tolerance": -1.0}, ErrorCode.INVALID_ROBOT_STATE, "tolerance: expected"),
        (SMALL, {"tolerance": math.nan}, ErrorCode.NON_FINITE_INPUT, "tolerance"),
        (SMALL, {"threshold": math.inf}, ErrorCode.NON_FINITE_INPUT, "threshold"),
        (
            {"x": (5.0, 5.1, 0.1), "y": (5.0, 5.1, 0.1)},
            {},
            ErrorCode.NO_IK_SOLUTION,
            "cells of the grid is reached",
        ),
    ],
)
def test_goals_that_cannot_be_met_say_why(maps, tmp_path, axes, fields, code, text):
    axes = {name: tuple(float(value) for value in values) for name, values in axes.items()}
    status, result = maps.make(tmp_path / "map.nc", axes, **fields)
    assert status == GoalStatus.STATUS_ABORTED
    assert result.error_code.val == code, result.error_code
    assert text in result.error_code.message
    assert result.file == ""
    assert not result.complete
    assert list(tmp_path.iterdir()) == []


def test_a_process_that_dies_aborts_the_goal(drive, maps, rfrfr, tmp_path):
    handle = maps.send(tmp_path / "map.nc", LONG, workers=1)
    maps.until_done(1)
    (worker,) = workers_of(rfrfr.process.process.pid)
    os.kill(worker, signal.SIGKILL)
    status, result = maps.result(handle)
    assert status == GoalStatus.STATUS_ABORTED
    assert result.error_code.val == ErrorCode.FAILURE
    assert "ended with SIGKILL" in result.error_code.message
    assert not lives(worker)
    assert maps.make(tmp_path / "map.nc")[0] == GoalStatus.STATUS_SUCCEEDED
    drive.send_motors(2.65, 0.50)
    drive.until(lambda: np.array_equal(drive.motors, [2.65, 0.50]))

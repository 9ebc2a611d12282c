# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What users of ROS expect of a node: frames of one of two robots, parameters, files of maps."""

from types import SimpleNamespace

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from cpr_msgs.action import MapWorkspace
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from cpr_msgs.srv import SolveInverse
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from helpers.driver import Driver
from helpers.map_client import MEDIUM, MapClient
from helpers.node_process import running_node
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
from sensor_msgs.msg import JointState
from visualization_msgs.msg import MarkerArray

import cpr_core
from cpr_core.workspace import map_workspace, pose_grid


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    """The left one of two robots, with a folder for its maps."""
    folder = tmp_path_factory.mktemp("left")
    values = ["robot:=rfrfr", "frame_prefix:=left/", "max_speed:=4"]
    values += [f"map_directory:={folder / 'maps'}", "forward_singularity_stop:=2e-5"]
    with running_node(folder, *values) as running:
        yield SimpleNamespace(process=running.process, client=running.client, folder=folder)


@pytest.fixture
def drive(left):
    driver = Driver(left.client)
    driver.go_home()
    yield driver
    driver.close()


def number(name, value):
    return Parameter(
        name=name,
        value=ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value),
    )


def set_each(client, *parameters):
    """As the tools of ROS do it: one after the other, each for itself."""
    request = SetParameters.Request(parameters=list(parameters))
    return client.call(SetParameters, "/cpr_node/set_parameters", request).results


def values(client, *names):
    request = GetParameters.Request(names=list(names))
    return client.call(GetParameters, "/cpr_node/get_parameters", request).values


def assert_rests(drive, motors):
    """A second of the stream, in which nothing moves."""
    drive.until(lambda: len(drive.all(StabilityMetrics)) >= 20)
    states = {metrics.state for metrics in drive.all(StabilityMetrics)}
    assert states == {StabilityMetrics.STATE_IDLE}
    assert all(
        np.array_equal(joint_state.position, motors) for joint_state in drive.all(JointState)
    )


def test_every_frame_has_the_prefix(left, drive):
    (markers,) = left.client.messages(MarkerArray, "/cpr_node/leg_markers", 1)
    frames = {marker.header.frame_id for marker in markers.markers}
    drive.until(lambda: True)
    for kind in (StabilityMetrics, JointState, PoseStamped):
        frames.add(drive.all(kind)[-1].header.frame_id)
    assert frames == {"left/base"}


def test_poses_are_taken_in_the_frame_of_this_robot_only(left, drive):
    for frame, code in (
        ("left/base", ErrorCode.SUCCESS),
        ("", ErrorCode.SUCCESS),
        ("base", ErrorCode.FRAME_TRANSFORM_FAILURE),
        ("right/base", ErrorCode.FRAME_TRANSFORM_FAILURE),
    ):
        request = SolveInverse.Request()
        request.platform.header.frame_id = frame
        request.platform.pose.position.y = 0.8
        answer = left.client.call(SolveInverse, "/cpr_node/solve_inverse", request)
        assert answer.error_code.val == code, answer.error_code
    assert "expected 'left/base', got 'right/base'" in answer.error_code.message


def test_a_parameter_of_a_type_that_ros_has_not_is_answered(left):
    strange = Parameter(name="margin_stop", value=ParameterValue(type=77))
    (refused,) = set_each(left.client, strange)
    assert not refused.successful
    assert "margin_stop: expected a type 0 to 9" in refused.reason


def test_an_unknown_parameter_is_answered_with_the_nearest_name(left):
    (refused,) = set_each(left.client, number("margin_waning", 0.3))
    assert not refused.successful
    assert refused.reason == "unknown parameter margin_waning: did you mean margin_warning?"


@pytest.mark.parametrize("kind", [SetParameters, SetParametersAtomically])
def test_a_call_with_thousands_of_parameters_changes_none(left, kind):
    """Ticks and stream waited for it, for seconds: a supervisor took the node for dead."""
    service = f"/cpr_node/set_parameters{'_atomically' if kind is SetParametersAtomically else ''}"
    request = kind.Request(parameters=[number("max_speed", 1.0 + 1e-4 * i) for i in range(5000)])
    answer = left.client.call(kind, service, request)
    results = [answer.result] if kind is SetParametersAtomically else answer.results
    assert len(results) in (1, 5000) and not any(result.successful for result in results)
    expected = "expected at most 100 parameters in a call, got 5000: none is changed"
    assert {result.reason for result in results} == {expected}
    assert values(left.client, "max_speed")[0].double_value == 4.0


def test_an_endless_name_is_not_repeated_whole(left):
    (refused,) = set_each(left.client, number("margin_stop" * 100_000, 0.1))
    assert refused.reason.startswith("unknown parameter margin_stopmargin_stop")
    assert len(refused.reason) < 150


def test_numbers_are_taken_as_the_tools_of_ros_send_them(left):
    """`ros2 param set` and `load` make a word of 2e-05 and an integer of 3."""
    word = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value="3e-05")
    whole = ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=3)
    wide = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value="wide")
    names = ("forward_singularity_stop", "max_speed")
    assert [value.double_value for value in values(left.client, *names)] == [2e-5, 4.0]
    try:
        told = set_each(
            left.client,
            Parameter(name=names[0], value=word),
            Parameter(name=names[1], value=whole),
            Parameter(name=names[0], value=wide),
        )
        assert [result.successful for result in told] == [True, True, False]
        assert [value.double_value for value in values(left.client, *names)] == [3e-5, 3.0]
    finally:
        set_each(left.client, number(names[0], 2e-5), number(names[1], 4.0))


@pytest.mark.parametrize(
    "order", [("margin_warning", "margin_stop"), ("margin_stop", "margin_warning")]
)
def test_thresholds_of_a_file_are_taken_one_by_one_in_any_order(left, drive, order):
    for file in (
        {"margin_warning": 0.9, "margin_stop": 0.8},
        {"margin_warning": 0.2, "margin_stop": 0.05},
    ):
        for name in order:
            (told,) = set_each(left.client, number(name, file[name]))
            assert told.successful, told.reason
        drive.until(lambda: True)
        metrics = drive.metrics
        assert (metrics.margin_warning, metrics.margin_stop) == tuple(file.values())


def test_a_warning_below_its_stop_is_told_and_the_stop_halts(left, drive):
    margin = drive.metrics.margin
    try:
        assert set_each(left.client, number("margin_stop", 0.9 * margin))[0].successful
        left.process.wait_for_log("is not above margin_stop")
        told = left.client.messages(DiagnosticArray, "/diagnostics", 2)[-1].status[1]
        assert told.level == DiagnosticStatus.WARN
        assert (
            "is not above margin_stop"
            in {pair.key: pair.value for pair in told.values}["thresholds"]
        )
        drive.send_platform(0.0, 0.0)
        drive.until_state(StabilityMetrics.STATE_HALTED)
        assert drive.metrics.margin >= 0.9 * margin
    finally:
        set_each(left.client, number("margin_stop", 0.05))


def test_thresholds_that_let_a_halted_robot_go_start_no_motion(left, drive):
    margin = drive.metrics.margin
    limits = [number("margin_warning", 0.95 * margin), number("margin_stop", 0.9 * margin)]
    try:
        assert all(result.successful for result in set_each(left.client, *limits))
        drive.send_platform(0.0, 0.4)
        drive.until_state(StabilityMetrics.STATE_HALTED)
    finally:
        set_each(left.client, number("margin_stop", 0.05), number("margin_warning", 0.2))
    drive.until_state(StabilityMetrics.STATE_IDLE)
    assert drive.position[1] > 0.41
    assert_rests(drive, drive.motors)
    drive.send_platform(0.0, 0.4)
    drive.until(lambda: np.allclose(drive.position[:2], [0.0, 0.4], atol=1e-8))


def test_a_longer_timeout_does_not_revive_a_stale_setpoint(left, drive):
    try:
        slow = [number("setpoint_timeout", 0.2), number("max_speed", 0.05)]
        assert all(result.successful for result in set_each(left.client, *slow))
        drive.send_motors(2.9, 0.3)
        drive.until_state(StabilityMetrics.STATE_STALE)
    finally:
        set_each(left.client, number("setpoint_timeout", 0.0), number("max_speed", 4.0))
    drive.until_state(StabilityMetrics.STATE_IDLE)
    assert_rests(drive, drive.motors)
    drive.send_motors(2.9, 0.3)
    drive.until(lambda: np.array_equal(drive.motors, [2.9, 0.3]))


def begun(file):
    """A map that is hardly begun."""
    robot = cpr_core.load_robot("rfrfr")
    grid = pose_grid(
        robot,
        {name: (first, last) for name, (first, last, _) in MEDIUM.items()},
        resolution={name: step for name, (_, _, step) in MEDIUM.items()},
    )
    told = []
    map_workspace(
        robot, grid, file=file, workers=1, progress=told.append, cancelled=lambda: bool(told)
    )


def test_maps_go_to_their_folder_and_nowhere_else(left, drive):
    maps = MapClient(left.client)
    outside = left.folder / "outside"
    outside.mkdir()
    try:
        status, result = maps.make("map.nc")
        assert status == GoalStatus.STATUS_SUCCEEDED, result.error_code.message
        assert result.file == str(left.folder / "maps" / "map.nc")
        (left.folder / "maps" / "away").symlink_to(outside)
        for name in (outside / "map.nc", "../outside/map.nc", "away/map.nc", "../maps2/map.nc"):
            status, refused = maps.make(name)
            assert status == GoalStatus.STATUS_ABORTED
            assert refused.error_code.val == ErrorCode.INVALID_FILE
            assert "parameter map_directory" in refused.error_code.message
            assert "map_anywhere" in refused.error_code.message
        for name in ("long" * 100_000, "~nobody-of-this-name/map.nc", "no/such/folder.nc"):
            _, refused = maps.make(name)
            assert refused.error_code.val == ErrorCode.INVALID_FILE, refused.error_code
        assert list(outside.iterdir()) == []

        kept = left.folder / "maps" / "long.nc"
        begun(kept)
        handle = maps.send("long.nc", MEDIUM, workers=1, existing_file=MapWorkspace.Goal.RESUME)
        maps.cancel(handle)
        assert maps.result(handle)[1].file == str(kept)
    finally:
        maps.close()
    left.process.wait_for_log(f"map: not complete, but kept in {kept}")


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"held": ["y"] * 30_000, "held_values": [0.0] * 30_000}, "at most 6 axes and held"),
        ({"axes": {"x" * 100_000: (0.0, 1.0, 0.1), "y": (0.0, 1.0, 0.1)}}, "at most 1000 letters"),
        ({"axes": {"x": (0.0, 1.0, 1e-7), "y": (0.0, 1.0, 0.1)}}, "cells along an axis"),
        ({"objective": "z" * 100_000}, "at most 1000 letters"),
    ],
)
def test_goals_that_only_take_time_are_refused_at_once(left, fields, text):
    maps = MapClient(left.client)
    try:
        _, refused = maps.make("map2.nc", fields.pop("axes", None), **fields)
    finally:
        maps.close()
    assert refused.error_code.val == ErrorCode.INVALID_ROBOT_STATE
    assert text in refused.error_code.message

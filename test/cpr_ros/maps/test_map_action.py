# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a goal of a map comes to, by how its process ended; without ROS and without a process."""

from pathlib import Path
from unittest.mock import MagicMock

import pytest
from cpr_msgs.msg import ErrorCode

from cpr_core import InvalidRequest
from cpr_core.workspace import MapSummary
from cpr_ros.error_codes import RequestError
from cpr_ros.maps import map_action
from cpr_ros.maps.map_action import MapAction
from cpr_ros.maps.map_order import MapFailure, MapState


def summary(complete):
    return MapSummary(
        complete=complete,
        shape=(2, 3),
        cells=6,
        reached=5,
        stable=4,
        usable=3,
        beyond_limits=1,
        below_threshold=1,
        disagreements=0,
        cell_area=0.1,
        borders=(),
    )


@pytest.fixture
def action():
    """What the methods are called with instead of an action: its map goes on."""
    made = MagicMock(_stopped_by=RequestError(ErrorCode.PREEMPTED, "the map was cancelled"))
    made._process.configure_mock(state=None, result=None, ended=False, death="", written=True)
    made._process.order.file = Path("/maps/a.nc")
    return made


@pytest.mark.parametrize(
    ("found", "death", "code", "file", "words"),
    [
        (summary(True), "", ErrorCode.SUCCESS, "/maps/a.nc", ""),
        (summary(False), "", ErrorCode.PREEMPTED, "/maps/a.nc", "was cancelled"),
        (None, "", ErrorCode.PREEMPTED, "/maps/a.nc", "was cancelled"),
        (None, "SIGKILL", ErrorCode.FAILURE, "/maps/a.nc", "ended with SIGKILL"),
        (
            MapFailure(InvalidRequest, "no map", "file"),
            "",
            ErrorCode.INVALID_FILE,
            "",
            "no map",
        ),
    ],
    ids=["complete", "cancelled", "ended at once", "died", "failed"],
)
@pytest.mark.parametrize("written", [True, False])
def test_a_result_says_what_there_is_and_why(action, found, death, code, file, words, written):
    action._process.configure_mock(result=found, death=death, written=written)
    result = MapAction._result(action, action._process)
    assert words in result.error_code.message
    assert result.file == (file if written else "")
    assert result.error_code.val == code
    assert result.cells == (6 if isinstance(found, MapSummary) else 0)


def test_a_map_is_told_of_where_there_is_something_new_and_ends_once(action):
    process, handle, timer = action._process, action._handle, action._timer
    for new, state, told in ((True, None, 0), (False, MapState(1, 1, 6, 0.5), 0), (True, None, 0)):
        process.look.return_value, process.state = new, state
        MapAction._look(action)
        assert handle.publish_feedback.call_count == told
    process.look.return_value, process.state = True, MapState(1, 1, 6, 0.5)
    MapAction._look(action)
    assert handle.publish_feedback.call_count == 1
    assert not action._end.called
    process.ended = True
    MapAction._look(action)
    action._node.destroy_timer.assert_called_once_with(timer)
    action._end.assert_called_once_with(handle, action._result.return_value)
    assert action._process is None and action._handle is None


def test_a_look_that_fails_ends_the_process_and_the_goal(action):
    process, handle = action._process, action._handle
    process.look.side_effect = ZeroDivisionError("own")
    MapAction._look(action)
    process.close.assert_called_once_with()
    (ended, result), _ = action._end.call_args
    assert ended is handle and result.error_code.val == ErrorCode.FAILURE
    assert action._process is None


def test_only_the_map_that_is_made_can_be_cancelled(action):
    process = action._process
    assert not MapAction._cancel(action, MagicMock())
    assert not process.stop.called
    assert MapAction._cancel(action, action._handle)
    assert process.stop.call_count == 1
    action._process = None
    assert not MapAction._cancel(action, action._handle)


def test_why_a_map_was_stopped_is_not_why_the_next_one_is(action, monkeypatch):
    monkeypatch.setattr(map_action, "MapProcess", MagicMock())
    MapAction.stop(action, "cleaned up")
    assert action._process.stop.call_count == 1
    assert action._stopped_by.val == ErrorCode.NOT_READY
    action._process = None
    MapAction._begin(action, MagicMock())
    assert action._stopped_by.val == ErrorCode.PREEMPTED
    clock = action._node.create_timer.call_args.kwargs["clock"]
    assert clock.clock_type == map_action.ClockType.STEADY_TIME


def test_a_second_map_is_told_how_far_the_first_one_is(action):
    for state, words in ((None, "it has begun"), (MapState(2, 1, 6, 0.5), "2 of 6 cells are done")):
        action._process.state = state
        with pytest.raises(RequestError, match=f"another map is being made .{words}"):
            MapAction._ordered(action, MagicMock())

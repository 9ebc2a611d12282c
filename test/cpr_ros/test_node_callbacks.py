# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the node does in a tick, in a transition and with parameters: its methods, without ROS."""

from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import MagicMock, call

import numpy as np
import pytest
from helpers.session_bench import LIVE
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter

from cpr_core import CprError
from cpr_core.model.assessment import Threshold
from cpr_ros import node as node_module
from cpr_ros.following.supervision import Action
from cpr_ros.node import CprNode
from cpr_ros.process.stop_signal import Stopped


@pytest.fixture
def node(monkeypatch):
    """What the methods are called with instead of a node."""
    monkeypatch.setattr(node_module.rclpy, "ok", lambda: True)
    made = MagicMock(problem="", _active=True, _last_action=Action.NONE)
    made._stop.requested = False
    made._required_session.return_value = made._session
    return made


def said(node, level):
    return [told.args[0] for told in getattr(node.get_logger(), level).call_args_list]


def changed(node, monkeypatch, live, *names, forgotten=False):
    """Set parameters: what came of it, and what of the session was changed."""
    applied = MagicMock(return_value=forgotten)
    monkeypatch.setattr(node_module, "apply_live", applied)
    node._live.return_value = live
    parameters = [Parameter(name, value=0.1) for name in names]
    result = CprNode._on_parameters(node, parameters)
    assert node._live.call_args == call(dict(zip(names, parameters, strict=True)))
    return result, applied


def with_margin(warning, stop):
    thresholds = LIVE.settings.thresholds | {"margin": Threshold(warning, stop)}
    return replace(LIVE, settings=replace(LIVE.settings, thresholds=thresholds))


def test_parameters_that_cannot_be_together_change_nothing(node, monkeypatch):
    names = ["margin_warning", "margin_stop"]
    result, applied = changed(node, monkeypatch, with_margin(0.1, 0.3), *names)
    assert not result.successful and "below margin_warning" in result.reason
    assert not applied.called and not node.interfaces.apply.called


def test_parameters_go_to_session_and_interfaces_and_crossed_thresholds_are_told(node, monkeypatch):
    crossed = with_margin(0.1, 0.3)  # one after the other they may be so for a while
    for name, told, forgotten in (("margin_stop", 1, True), ("max_speed", 0, False)):
        node.reset_mock()
        result, applied = changed(node, monkeypatch, crossed, name, forgotten=forgotten)
        assert result.successful
        assert applied.call_args.args[:2] == (node._session, crossed)
        node.interfaces.apply.assert_called_once_with(crossed)
        assert len(said(node, "warning")) == told
        assert said(node, "info") == ["parameters changed: the setpoint is forgotten"] * forgotten


def test_parameters_are_taken_before_there_is_a_robot(node, monkeypatch):
    node._session = node.interfaces = None
    result, applied = changed(node, monkeypatch, LIVE, "max_speed")
    assert result.successful and not applied.called


@pytest.mark.parametrize("wanted", [True, False])
@pytest.mark.parametrize("action", [Action.NONE, Action.HALT])
def test_another_action_is_told_out_of_turn_to_whoever_listens(node, action, wanted):
    node._session.tick.return_value = SimpleNamespace(moved=False, home_missed=False)
    node._session.verdict.return_value = SimpleNamespace(action=action)
    node.outputs.stability.wanted.return_value = wanted
    CprNode._tick(node, 7.0)
    assert node._tell.called == (wanted and action == Action.HALT)
    assert node._last_action == action
    node.interfaces.after_tick.assert_called_once_with(node._session, 7.0)


@pytest.mark.parametrize("flag", [True, False])
def test_a_step_is_published_and_a_home_that_is_missed_is_an_error(node, flag):
    node._session.tick.return_value = SimpleNamespace(moved=flag, home_missed=flag)
    node._session.verdict.return_value = SimpleNamespace(action=Action.NONE)
    CprNode._tick(node, 7.0)
    assert node.outputs.step.call_args_list == [call(node._session, 7.0)] * flag
    assert len(said(node, "error")) == flag


def test_after_a_pause_others_are_given_more_time(node):
    for ahead in (False, True):
        CprNode._command(node, np.zeros(2), ahead)
    shorter, longer = (told.args[0] for told in node._giving_way.sleep.call_args_list)
    assert 0.0 < shorter < longer


@pytest.mark.parametrize("work", [None, iter(())])
def test_a_stream_that_takes_long_is_told_in_pieces(node, work):
    stream = MagicMock(tell=lambda *_: work)
    CprNode._tell(node, stream, node._session)
    assert node._telling.begin.call_args_list == [call(stream.name, work)] * (work is not None)


def test_where_the_robot_cannot_be_the_node_is_inactive_and_an_end_is_no_error(node):
    node._whereabouts.place.side_effect = Stopped
    CprNode._place(node, np.zeros(2))
    assert not node.trigger_deactivate.called and said(node, "error") == []
    node._whereabouts.place.side_effect = CprError("nowhere")
    CprNode._place(node, np.zeros(2))
    node.trigger_deactivate.assert_called_once_with()
    assert node.problem == "nowhere" and said(node, "error") == ["deactivated: nowhere"]


@pytest.mark.parametrize(("active", "held", "told"), [(1, 1, 1), (1, 0, 0), (0, 1, 0)])
def test_an_inactive_node_holds_and_is_silent(node, active, held, told):
    node._active = bool(active)
    node._session.orders.hold_commands.return_value = bool(held)
    CprNode._deactivate(node)
    assert len(said(node, "warning")) == told and not node._active
    node.interfaces.stop_motions.assert_called_once_with(node._session)
    node._ticking.stop.assert_called_once_with()
    node._streams.begin.assert_called_once_with(0.0)  # nothing is added: nothing is told
    node._telling.stop.assert_called_once_with()


def test_a_robot_that_is_forgotten_leaves_nothing(node):
    CprNode._forget(node)
    assert [told[0] for told in node.mock_calls] == [
        "_deactivate",
        "interfaces.stop_maps",
        "_operate",
        "_lose_whereabouts",
    ]


def test_a_configuration_that_fails_is_forgotten(node):
    node._set_up.side_effect = CprError("no robot")
    with pytest.raises(CprError):
        CprNode._configure(node)
    node._forget.assert_called_once_with()


def test_a_node_that_becomes_active_begins_anew(node):
    node.outputs.streams = [SimpleNamespace(rate=5.0, wanted=None)]
    node._session.verdict.return_value = SimpleNamespace(action=Action.SLOW)
    node._active, before = False, node._announcements
    CprNode._activate(node)
    node._session.stand.assert_called_once_with()
    node._whereabouts.look.assert_called_once_with()
    node.interfaces.forget_messages.assert_called_once_with()
    node.outputs.description.assert_called_once_with(node._session)
    assert node._active and node._announcements is not before
    assert node._last_action == Action.SLOW
    assert node._ticking.start.called and node._streams.begin.called
    assert node._streams.add.call_args.args[0] == 5.0


@pytest.mark.parametrize(
    ("error", "ending", "told"),
    [
        (CprError("wrong"), False, "wrong"),
        (ZeroDivisionError("own"), False, "Traceback"),
        (CprError("wrong"), True, None),
    ],
)
def test_a_transition_that_fails_says_why_unless_the_node_ends(node, error, ending, told):
    node._stop.requested = ending
    later = MagicMock()

    def fail():
        raise error

    assert CprNode._transition(node, fail, later) == TransitionCallbackReturn.FAILURE
    assert node.problem == str(error) and not later.called
    assert [text.startswith(told) for text in said(node, "error")] == [True] * (told is not None)


@pytest.mark.parametrize(
    ("done", "ending", "started", "errors"),
    [(True, False, True, 0), (False, False, False, 1), (False, True, True, 0)],
)
def test_a_start_fails_unless_the_node_ends(node, done, ending, started, errors):
    returned = TransitionCallbackReturn
    node.trigger_activate.return_value = returned.SUCCESS if done else returned.FAILURE
    node.trigger_configure.return_value = returned.SUCCESS
    node._stop.requested = False
    if ending:
        node.trigger_activate.side_effect = lambda: setattr(node._stop, "requested", True)
    assert CprNode.start(node) == started
    assert len(said(node, "error")) == errors

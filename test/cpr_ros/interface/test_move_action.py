# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A goal of ``~/move_to`` that ends, on a clock of the test."""

from types import SimpleNamespace

import pytest
import rclpy
from cpr_msgs.action import MoveTo
from cpr_msgs.msg import ErrorCode
from helpers.closed_loop import FRAMES, PERIOD, ClosedLoop, live
from helpers.node_process import free_domain
from rclpy.context import Context
from sensor_msgs.msg import JointState

from cpr_ros.following.supervision import State
from cpr_ros.interface.move_action import MoveAction


@pytest.fixture
def node():
    context = Context()
    rclpy.init(context=context, domain_id=free_domain())
    node = rclpy.create_node("mover", context=context)
    yield node
    node.destroy_node()
    rclpy.shutdown(context=context)


def test_out_of_patience_it_holds_commands_that_a_wrench_held_back(node, monkeypatch):
    """They went out as soon as the wrench was gone, of a goal that had failed."""
    bench = ClosedLoop("rfrfr")
    session, home = bench.session, bench.model
    session.apply(live(wrench_timeout=2.0), bench.now)
    session.begin_at(home, home.motors + 0.1, 0.0)
    pushed = home.loads.with_(wrench_world=[0, 0, 0, -500.0, 0, 0])
    session.wrench.take(pushed, bench.now)
    action, results = MoveAction(node, FRAMES, lambda: session), []
    monkeypatch.setattr(action, "_finish", lambda handle, val, result: results.append(result))
    motors = JointState(name=[*session.robot.motor_names], position=home.motors.tolist())
    request = MoveTo.Goal(given=MoveTo.Goal.GIVEN_MOTORS, motors=motors, patience=0.5)
    told = SimpleNamespace(
        request=request, is_cancel_requested=False, publish_feedback=lambda feedback: None
    )
    action._begin(told)
    states, commands = [], []
    for _ in range(int(3.0 / PERIOD)):
        bench.now += PERIOD
        states.append(session.tick(bench.now).state)
        commands.append(session.next_command(bench.now))
        action.after_tick(session, bench.now)
    assert states[0] == State.ALIGNING
    assert [result.error_code.val for result in results] == [ErrorCode.CONTROL_FAILED]
    assert states[-1] == State.PAUSED
    assert all(command is None for command in commands)

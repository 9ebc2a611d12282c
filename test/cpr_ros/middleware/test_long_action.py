# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Results and stamps of an action in simulated time, over real DDS."""

import time

import pytest
import rclpy
from action_msgs.msg import GoalInfo, GoalStatus
from action_msgs.srv import CancelGoal
from builtin_interfaces.msg import Time
from cpr_msgs.action import MoveTo
from cpr_msgs.msg import ErrorCode
from helpers.node_process import TIMEOUT, free_domain
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock

from cpr_ros.middleware import long_action
from cpr_ros.middleware.long_action import LongAction

#: How long results are kept here [s].
KEPT = 2


class Patient(LongAction):
    """Goals with patience wait to be cancelled, others are reached at once."""

    def _begin(self, handle):
        if not handle.request.patience:
            self._finish(handle, ErrorCode.SUCCESS, MoveTo.Result())

    def _refuse(self, handle, error):
        raise error

    def _cancel(self, handle):
        return True


class Bench:
    """The action, a client and a /clock on one node."""

    def __init__(self, node, executor):
        self.node, self.executor = node, executor
        self.action = Patient(node, MoveTo, "~/move_to")
        self.client = ActionClient(node, MoveTo, "~/move_to")
        self.cancelling = node.create_client(CancelGoal, "~/move_to/_action/cancel_goal")
        self.clock = node.create_publisher(Clock, "/clock", 1)

    def until(self, done):
        end = time.monotonic() + TIMEOUT
        while not done():
            assert time.monotonic() < end
            self.executor.spin_once(timeout_sec=0.02)

    def answer(self, future):
        self.until(future.done)
        return future.result()

    def set_time(self, seconds):
        self.until(lambda: self.clock.get_subscription_count() == 1)
        self.clock.publish(Clock(clock=Time(sec=seconds)))
        self.until(lambda: self.node.get_clock().now().nanoseconds == seconds * 10**9)

    def send(self, patience=0.0):
        self.until(self.client.server_is_ready)
        return self.answer(self.client.send_goal_async(MoveTo.Goal(patience=patience)))

    def status(self, goal):
        """What an answer to who asks for the result says of it."""
        return self.answer(goal.get_result_async()).status

    def until_forgotten(self, goal):
        """Ask for the result again and again, not without a break: that would keep a processor busy."""

        def forgotten():
            time.sleep(0.05)
            return self.status(goal) == GoalStatus.STATUS_UNKNOWN

        self.until(forgotten)

    def cancel(self, **info):
        """The goals that are being cancelled."""
        self.until(self.cancelling.service_is_ready)
        request = CancelGoal.Request(goal_info=GoalInfo(**info))
        return self.answer(self.cancelling.call_async(request)).goals_canceling


@pytest.fixture
def simulated():
    """Whether time is simulated from the start."""
    return True


@pytest.fixture(params=[SingleThreadedExecutor, EventsExecutor])
def bench(request, monkeypatch, simulated):
    monkeypatch.setattr(long_action, "_RESULT_KEPT", KEPT)
    context = Context()
    rclpy.init(context=context, domain_id=free_domain())
    given = [Parameter("use_sim_time", value=simulated)]
    node = rclpy.create_node("asked", context=context, parameter_overrides=given)
    executor = request.param(context=context)
    executor.add_node(node)
    bench = Bench(node, executor)
    yield bench
    bench.client.destroy()
    bench.action.close()
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)


def test_a_result_is_there_after_a_jump_of_simulated_time(bench):
    """It was forgotten by simulated time, though its client asked for it soon."""
    bench.set_time(100)
    goal = bench.send()
    assert bench.status(goal) == GoalStatus.STATUS_SUCCEEDED
    bench.set_time(1000)
    assert bench.status(bench.send()) == GoalStatus.STATUS_SUCCEEDED
    assert bench.status(goal) == GoalStatus.STATUS_SUCCEEDED
    bench.set_time(10)
    assert bench.status(bench.send()) == GoalStatus.STATUS_SUCCEEDED
    assert bench.status(goal) == GoalStatus.STATUS_SUCCEEDED


@pytest.mark.parametrize("seconds", [0, 100])
def test_a_result_is_forgotten_in_time_while_simulated_time_stands_still(bench, seconds):
    """It was kept for ever, and every step of every goal told the state of all of them."""
    if seconds:
        bench.set_time(seconds)
    begun = time.monotonic()
    goals = [bench.send()]
    time.sleep(0.2)  # the first one is forgotten in another breath than those that came later
    goals += [bench.send() for _ in range(2)]
    told = [bench.status(goal) for goal in goals]
    assert told == [GoalStatus.STATUS_SUCCEEDED] * 3
    bench.until_forgotten(goals[0])
    assert time.monotonic() - begun > KEPT
    bench.until_forgotten(goals[2])
    assert bench.status(bench.send()) == GoalStatus.STATUS_SUCCEEDED


def test_all_results_are_forgotten_of_goals_that_come_one_after_the_other(bench):
    begun = time.monotonic()
    while time.monotonic() < begun + 0.8:
        bench.send()
    bench.until(lambda: not bench.action._server._goal_handles)


@pytest.mark.parametrize("simulated", [False])
def test_results_are_there_after_a_change_between_real_and_simulated_time(bench):
    """They were forgotten at once where simulated time was left, and kept for ever where it came."""
    for now in (False, True):
        bench.node.set_parameters([Parameter("use_sim_time", value=now)])
        if now:
            bench.set_time(100)
        goal = bench.send()
        assert (goal.stamp.sec == 100) == now
        bench.node.set_parameters([Parameter("use_sim_time", value=not now)])
        assert bench.status(bench.send()) == GoalStatus.STATUS_SUCCEEDED
        assert bench.status(goal) == GoalStatus.STATUS_SUCCEEDED
        bench.until_forgotten(goal)


def test_goals_are_cancelled_by_the_ros_time_they_came_at(bench):
    came = {}
    for seconds in (100, 200, 300):
        bench.set_time(seconds)
        came[seconds] = bench.send(patience=1.0)
        assert came[seconds].stamp == Time(sec=seconds)
    named = [bytes(info.goal_id.uuid) for info in bench.cancel(stamp=Time(sec=200))]
    assert sorted(named) == sorted(bytes(came[at].goal_id.uuid) for at in (100, 200))
    [last] = bench.cancel(goal_id=came[300].goal_id)
    assert last.stamp == Time(sec=300)

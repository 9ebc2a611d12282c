# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Requests in line let everything else go first, and all are answered, over real DDS."""

import math
import time
from types import SimpleNamespace

import pytest
import rclpy
from helpers.node_process import free_domain
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from std_srvs.srv import SetBool, Trigger

from cpr_ros.middleware import waiting_requests
from cpr_ros.middleware.late_clients import LateClients
from cpr_ros.middleware.waiting_requests import SERVICE_QOS, WaitingRequests

COUNT = 300


@pytest.fixture(params=[SingleThreadedExecutor, EventsExecutor])
def burst(request):
    """Asks for much, then to stop; what was done in which order, and the responses."""
    context = Context()
    rclpy.init(context=context, domain_id=free_domain())
    node = rclpy.create_node("asked", context=context)
    waiting, done = WaitingRequests(time.monotonic), []

    def solve(asked, response):
        response.success, response.message = asked.data, str(len(done))
        done.append("solve")
        return response

    def stop(_asked, response):
        done.append("stop")
        return response

    waiting.create_service(node, SetBool, "~/solve", solve)
    node.create_service(Trigger, "~/stop", stop)
    LateClients(node, time.monotonic).watch()  # as the node has it
    solving = node.create_client(SetBool, "~/solve", qos_profile=SERVICE_QOS)
    stopping = node.create_client(Trigger, "~/stop")
    executor = request.param(context=context)
    executor.add_node(node)

    def spin_until(reached, answering=True):
        end = time.monotonic() + 60.0
        while not reached():
            assert time.monotonic() < end
            executor.spin_once(timeout_sec=0.0 if waiting.due < 0.0 else 0.1)
            if answering:
                waiting.look(time.monotonic())

    def ask():
        assert solving.wait_for_service(20.0)
        assert stopping.wait_for_service(20.0)
        asked = [solving.call_async(SetBool.Request(data=k % 3 == 0)) for k in range(COUNT)]
        return asked, stopping.call_async(Trigger.Request())

    yield SimpleNamespace(ask=ask, spin_until=spin_until, waiting=waiting, done=done)
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)


def test_what_stops_does_not_wait_for_a_burst_before_it(burst, monkeypatch):
    monkeypatch.setattr(waiting_requests, "_SELDOM", 60.0)  # however slow the machine is
    asked, stopped = burst.ask()
    burst.spin_until(lambda: stopped.done() and all(future.done() for future in asked))
    assert burst.done.index("stop") <= 1
    responses = [future.result() for future in asked]
    assert [response.success for response in responses] == [k % 3 == 0 for k in range(COUNT)]
    assert [int(response.message) for response in responses[1:]] == list(range(2, COUNT + 1))
    assert burst.waiting.due == math.inf


def test_a_burst_longer_than_the_line_is_answered_as_it_comes(burst, monkeypatch):
    monkeypatch.setattr(waiting_requests, "_MOST", 20)
    asked, stopped = burst.ask()
    answered = COUNT - 20
    burst.spin_until(lambda: burst.done.count("solve") == answered and stopped.done(), False)
    burst.spin_until(lambda: all(future.done() for future in asked))


def test_while_requests_keep_coming_some_are_answered(burst, monkeypatch):
    monkeypatch.setattr(waiting_requests, "_SELDOM", 0.0)
    asked, _ = burst.ask()
    burst.spin_until(lambda: burst.waiting.due < 0.0, False)
    assert burst.done.count("solve") == 0
    burst.waiting.look(time.monotonic())  # one has just joined
    assert burst.done.count("solve") == 1
    burst.spin_until(lambda: all(future.done() for future in asked))

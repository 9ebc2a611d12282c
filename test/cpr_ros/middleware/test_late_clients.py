# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Clients that DDS finds late get their response all the same, over real DDS."""

import time
import warnings
from functools import partial
from itertools import pairwise
from types import SimpleNamespace

import pytest
import rclpy
from helpers.node_process import free_domain
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from std_srvs.srv import Trigger

from cpr_ros.middleware.late_clients import LateClients

#: What rclpy says of a client that has been found too late.
LOST = "failed to send response (timeout): client will not receive response"


@pytest.fixture(params=[SingleThreadedExecutor, EventsExecutor])
def asked(request):
    """A node with a service, what waits for late clients, and a way to ask in so many seconds."""
    context = Context()
    rclpy.init(context=context, domain_id=free_domain())
    node = rclpy.create_node("asked", context=context)

    def answer(asked_for, response):
        response.message = "here"
        return response

    service = node.create_service(Trigger, "~/service", answer)
    client = node.create_client(Trigger, "~/service")
    late = LateClients(node, time.monotonic)
    executor = request.param(context=context)
    executor.add_node(node)

    def ask(seconds):
        assert client.wait_for_service(20.0)
        future, end = client.call_async(Trigger.Request()), time.monotonic() + seconds
        while not future.done() and time.monotonic() < end:
            executor.spin_once(timeout_sec=0.01)
            late.look(time.monotonic())
        return future.result().message if future.done() else None

    yield service, late, ask
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)


def found_late(service, tries, text=LOST):
    """Let a service not find its client so often, as rclpy tells it; when it was tried."""
    send, tried = service.send_response, []

    def send_response(response, header):
        tried.append(time.monotonic())
        if len(tried) <= tries:
            warnings.warn(text, RuntimeWarning, stacklevel=1)
        else:
            send(response, header)

    service.send_response = send_response
    return tried


@pytest.mark.parametrize("tries", [0, 1, 3])
def test_a_response_comes_as_soon_as_its_client_is_found(asked, tries):
    service, late, ask = asked
    tried = found_late(service, tries)
    late.watch()
    late.watch()  # once is enough
    assert ask(20.0) == "here"
    assert len(tried) == tries + 1
    pauses = [later - earlier for earlier, later in pairwise(tried)]
    assert all(pause >= 0.1 * 3**number for number, pause in enumerate(pauses))
    assert late.due == float("inf")


def test_one_that_is_not_found_is_told_and_forgotten(asked, monkeypatch):
    service, late, ask = asked
    monkeypatch.setattr("cpr_ros.middleware.late_clients._AGAIN_AFTER", (0.01, 0.02))
    tried = found_late(service, 10)
    late.watch()
    assert ask(0.5) is None
    assert len(tried) == 3
    assert late.due == float("inf")


def test_other_warnings_are_not_ours(asked):
    service, late, ask = asked
    found_late(service, 1, "something else")
    late.watch()
    with pytest.warns(RuntimeWarning, match="something else"):
        assert ask(0.5) is None
    assert late.due == float("inf")


class Clock:
    """A clock, and services without ROS on it whose clients are never found."""

    def __init__(self, services):
        self.now, self.tried = 0.0, []
        self.services = [SimpleNamespace(srv_name=f"/{number}") for number in range(services)]
        for service in self.services:
            service.send_response = partial(self.send, service.srv_name)

    def send(self, name, response, header):
        self.tried.append((name, self.now))
        self.now += 0.1  # rmw waits
        warnings.warn(LOST, RuntimeWarning, stacklevel=1)

    def answered_in_vain(self):
        """What waits for the clients, of which none was found the first time."""
        late = LateClients(self, lambda: self.now)
        late.watch()
        for service in self.services:
            service.send_response(None, None)
        del self.tried[:]
        return late

    def get_logger(self):
        return SimpleNamespace(warning=lambda text: None)


def test_clients_that_are_not_found_leave_the_node_its_time():
    """Responses for twenty of them held it up for half a second in a row."""
    clock = Clock(20)
    late = clock.answered_in_vain()
    while late.due < float("inf"):
        clock.now = max(clock.now, late.due)
        before = len(clock.tried)
        late.look(clock.now)
        assert len(clock.tried) - before <= 1
    assert len(clock.tried) == 20 * 4
    times = [time for _, time in clock.tried]
    assert min(later - earlier for earlier, later in pairwise(times)) >= 0.3 - 1e-9


def test_one_that_cannot_be_sent_at_all_loses_no_other():
    clock = Clock(2)
    late = clock.answered_in_vain()

    def broken(response, header):
        raise RuntimeError("a broken service")

    late._late[0].send = partial(broken, None, None)
    clock.now = 1.0
    with pytest.raises(RuntimeError, match="broken"):
        late.look(clock.now)
    clock.now = late.due
    late.look(clock.now)
    assert [name for name, _ in clock.tried] == ["/1"]

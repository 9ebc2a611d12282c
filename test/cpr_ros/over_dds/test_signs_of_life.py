# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A supervisor notices that the node is dead or stuck, from the stream alone."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from cpr_msgs.msg import StabilityMetrics
from helpers.node_process import TIMEOUT, Client, NodeProcess, free_domain
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import LivelinessPolicy, QoSProfile

from cpr_ros.interface.streams import promised

LONGEST = Duration(seconds=0.2)


class Supervisor:
    """Hears the stream, and when it does not come."""

    def __init__(self, client):
        self.client, self.events, self.heard, self.plain = client, [], [], []
        node = client.node

        def alive(status):
            self.events.append(("alive" if status.alive_count else "not alive", time.monotonic()))

        def late(_):
            self.events.append(("late", time.monotonic()))

        def incompatible(_):
            self.events.append(("incompatible", time.monotonic()))

        callbacks = SubscriptionEventCallbacks(
            deadline=late, liveliness=alive, incompatible_qos=incompatible
        )
        strict = QoSProfile(
            depth=10,
            deadline=LONGEST,
            liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
            liveliness_lease_duration=LONGEST,
        )
        topic = "/cpr_node/stability"
        node.create_subscription(
            StabilityMetrics,
            topic,
            lambda _: self.heard.append(time.monotonic()),
            strict,
            event_callbacks=callbacks,
        )
        node.create_subscription(StabilityMetrics, topic, self.plain.append, 10)

    def check_promise(self):
        """What the node itself offers: late and not alive, both together within the longest silence."""
        (offered,) = self.client.node.get_publishers_info_by_topic("/cpr_node/stability")
        profile = offered.qos_profile
        assert profile.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC
        parts = profile.deadline, profile.liveliness_lease_duration
        assert sum(part.nanoseconds for part in parts) <= LONGEST.nanoseconds

    def until_heard(self, count=10):
        before, others = len(self.heard), len(self.plain)
        self.client.spin_until(
            lambda: len(self.heard) >= before + count and len(self.plain) >= others + count
        )

    def until_noticed(self, since):
        """How long it takes to notice that the node is not there any more [s]."""
        self.events.clear()
        kinds = ("late", "not alive")
        self.client.spin_until(lambda: {*kinds} <= {kind for kind, _ in self.events})
        return {
            kind: min(when for event, when in self.events if event == kind) - since
            for kind in kinds
        }


@pytest.fixture
def node(tmp_path):
    domain = free_domain()
    process = NodeProcess(tmp_path / "node.log", domain, ["-p", "robot:=rfrfr"])
    try:
        process.wait_for_log("ready")
        client = Client(domain)
        yield process, Supervisor(client)
        client.close()
    finally:
        process.process.kill()
        process.process.wait()


def started_from_the_docs(client):
    """The program of docs/node.md that watches a node."""
    page = Path(__file__).parents[3].joinpath("docs/node.md").read_text(encoding="utf-8")
    (program,) = (
        block
        for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL)
        if "liveliness" in block
    )
    return subprocess.Popen(
        [sys.executable, "-c", program],
        env=os.environ | {"ROS_DOMAIN_ID": str(client.context.get_domain_id())},
        stdout=subprocess.PIPE,
        text=True,
    )


def test_a_stopped_and_a_killed_node_are_noticed(node):
    process, supervisor = node
    supervisor.until_heard()
    supervisor.check_promise()
    process.process.send_signal(signal.SIGSTOP)
    noticed = {"stopped": supervisor.until_noticed(time.monotonic())}
    supervisor.events.clear()
    process.process.send_signal(signal.SIGCONT)
    supervisor.until_heard()
    assert "alive" in {kind for kind, _ in supervisor.events}
    watcher = started_from_the_docs(supervisor.client)
    assert "action 0 stable" in watcher.stdout.readline()
    process.process.kill()
    noticed["killed"] = supervisor.until_noticed(time.monotonic())
    said, _ = watcher.communicate(timeout=TIMEOUT)
    assert said.strip() == "the node is dead, stuck or not active: stop the motors"
    assert watcher.returncode == 0
    for how, times in noticed.items():
        told = ", ".join(f"{kind} after {seconds:.3f} s" for kind, seconds in times.items())
        print(f"{how}: {told}")
    assert "incompatible" not in {kind for kind, _ in supervisor.events}


def test_a_process_that_lives_and_says_nothing_is_noticed():
    """Its threads of DDS go on when its own is stuck; they are no sign of life."""
    client = Client(free_domain())
    try:
        supervisor = Supervisor(client)
        stream = client.node.create_publisher(
            StabilityMetrics, "/cpr_node/stability", promised(20.0)
        )
        saying = client.node.create_timer(0.05, lambda: stream.publish(StabilityMetrics()))
        supervisor.until_heard()
        client.node.destroy_timer(saying)
        times = supervisor.until_noticed(time.monotonic())
    finally:
        client.close()
    print(", ".join(f"{kind} after {seconds:.3f} s" for kind, seconds in times.items()))


@pytest.mark.parametrize(("rate", "longest"), [(20.0, 0.1), (1000.0, 0.1), (10.0, 0.2), (1.0, 2.0)])
def test_the_promise_follows_the_rate(rate, longest):
    profile = promised(rate)
    assert profile.deadline == Duration(seconds=longest)
    assert profile.liveliness_lease_duration == Duration(seconds=longest)
    assert profile.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC

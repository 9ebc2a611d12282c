# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a running node in a real browser, over real DDS."""

import re
import signal
import subprocess
import sys

import numpy as np
import pytest
from helpers.browser import Looker
from helpers.node_process import TIMEOUT, Client, NodeProcess, free_domain
from sensor_msgs.msg import JointState

import cpr_core
from cpr_ros.own_domain import private_environment


class ViewProcess:
    """A running cpr_view."""

    def __init__(self, domain):
        environment = private_environment() | {"ROS_DOMAIN_ID": str(domain)}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "cpr_ros.cpr_view", "--port", "0"],
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        )
        self.address = re.search(r"http://\S+", self.process.stdout.readline())[0]

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        assert self.process.wait(TIMEOUT) == 0
        self.process.stdout.close()


def started(tmp_path_factory, domain):
    process = NodeProcess(
        tmp_path_factory.mktemp("node") / "node.log",
        domain,
        ["-p", "robot:=rfrfr", "-p", "max_speed:=4", "-p", "start_from:=home"],
    )
    process.wait_for_log("ready")
    return process


@pytest.fixture(scope="module")
def domain():
    return free_domain()


@pytest.fixture(scope="module")
def view(domain, browser):
    """The page is there before the node is."""
    view = ViewProcess(domain)
    yield view
    view.stop()


@pytest.fixture(scope="module")
def looker(view, browser):
    looker = Looker(browser, view.address, "take control")
    yield looker
    looker.page.close()


@pytest.fixture(scope="module")
def client(domain):
    client = Client(domain)
    yield client
    client.close()


def heard(client, looker, kind, topic, good):
    """The next message for which something holds."""
    received = []
    subscription = client.node.create_subscription(kind, topic, received.append, 10)

    def spun():
        client.executor.spin_once(timeout_sec=0.05)
        return any(good(message) for message in received)

    looker.until(spun)
    client.node.destroy_subscription(subscription)
    return next(message for message in received if good(message))


def test_a_node_is_shown_moved_lost_and_found_again(view, looker, client, domain, tmp_path_factory):
    assert "waiting for cpr_node" in looker.text()
    node = started(tmp_path_factory, domain)
    try:
        looker.page.get_by_text("cpr_node is there").wait_for()
        looker.page.get_by_text("motor2").first.wait_for()
        looker.until(lambda: looker.visible("/robot/legs"))
        robot = cpr_core.load_robot("rfrfr")
        home = cpr_core.solve_home(robot)
        looker.until(
            lambda: np.allclose(
                looker.position("/platform"), home.platform_position, rtol=0, atol=1e-9
            )
        )
        looker.page.get_by_text("NONE").wait_for()
        looker.page.get_by_text("setpoints may also come from: nobody").wait_for()

        # Without control nothing is sent.
        topic = "/cpr_node/motor_setpoint"
        thumb = looker.page.get_by_role("slider").first
        thumb.focus()
        thumb.press("ArrowRight")
        looker.page.get_by_text("nothing was sent").wait_for()
        assert client.node.count_publishers(topic) == 0

        # With control the node goes there, and the page shows where it is.
        looker.press("take control")
        looker.page.get_by_text("give control back").wait_for()
        for _ in range(30):
            thumb.press("ArrowRight")
        looker.page.get_by_text("sent: motor1").wait_for()
        moved = heard(
            client,
            looker,
            JointState,
            "/joint_states",
            lambda message: message.position[0] > home.motors[0] + 0.05,
        )
        assert moved.position[1] == home.motors[1]
        looker.until(lambda: not np.allclose(looker.position("/platform"), home.platform_position))
        looker.picture("node")
        looker.press("give control back")
        looker.page.get_by_text("take control").wait_for()

        # Who else may move it is named.
        other = client.node.create_publisher(JointState, topic, 10)
        looker.page.get_by_text(client.node.get_name()).wait_for()
        client.node.destroy_publisher(other)

        node.stop(signal.SIGKILL)
        looker.page.get_by_text("cpr_node is gone").wait_for()
        looker.page.get_by_text("nothing is known of the robot").wait_for()
        looker.picture("node_gone")
    finally:
        if node.process.poll() is None:
            node.stop()
    node = started(tmp_path_factory, domain)
    try:
        looker.page.get_by_text("cpr_node is back").wait_for()
        looker.until(
            lambda: np.allclose(
                looker.position("/platform"), home.platform_position, rtol=0, atol=1e-9
            )
        )
        looker.picture("node_back")
        assert looker.complaints == []
    finally:
        assert node.stop() == 0

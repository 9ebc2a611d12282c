# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Two who command the same motors, found over real DDS."""

import subprocess
import sys
import time

import pytest
import rclpy
from helpers.node_process import TIMEOUT, free_domain
from rclpy.context import Context
from std_msgs.msg import Float64MultiArray

from cpr_ros.middleware.other_commanders import OtherCommanders
from cpr_ros.process.own_domain import private_environment


@pytest.fixture
def nodes():
    """One that commands a controller by its topic, and another one."""
    context, domain = Context(), free_domain()
    rclpy.init(context=context, domain_id=domain)
    remapped = ["--ros-args", "-r", "~/commands:=/controller/commands"]
    node = rclpy.create_node("commanding", context=context, cli_args=remapped)
    other = rclpy.create_node("other", context=context)
    yield node, other
    node.destroy_node()
    other.destroy_node()
    rclpy.shutdown(context=context)


def counted(node, count):
    """Wait until as many publishers are found."""
    end = time.monotonic() + TIMEOUT
    while node.count_publishers("/controller/commands") != count:
        assert time.monotonic() < end
        time.sleep(0.01)


def test_others_are_told_by_name_once_they_do_not_just_make_room(nodes):
    node, other = nodes
    node.create_publisher(Float64MultiArray, "~/commands", 1)
    commanders = OtherCommanders(node, "~/commands")
    counted(node, 1)
    assert [commanders.look(now) for now in (0.0, 100.0)] == ["", ""]
    second = other.create_publisher(Float64MultiArray, "/controller/commands", 1)
    counted(node, 2)
    told = "/controller/commands has 1 more publisher (/other): others command the motors too"
    assert [commanders.look(now) for now in (200.0, 201.9, 202.0, 300.0)] == ["", "", told, told]
    other.create_publisher(Float64MultiArray, "/controller/commands", 1)
    counted(node, 3)
    assert commanders.look(301.0) == told.replace("1 more publisher", "2 more publishers")
    other.destroy_publisher(second)
    counted(node, 2)
    for publisher in list(other.publishers):
        other.destroy_publisher(publisher)
    counted(node, 1)
    assert commanders.look(302.0) == ""
    other.create_publisher(Float64MultiArray, "/controller/commands", 1)
    counted(node, 2)
    assert [commanders.look(now) for now in (303.0, 304.9, 305.0)] == ["", "", told]


def test_one_of_the_same_name_is_told_too(nodes):
    node, other = nodes
    node.create_publisher(Float64MultiArray, "~/commands", 1)
    twin = rclpy.create_node("commanding", context=other.context)
    twin.create_publisher(Float64MultiArray, "/controller/commands", 1)
    counted(node, 2)
    commanders = OtherCommanders(node, "~/commands")
    assert commanders.look(0.0) == ""
    assert "1 more publisher (a node of the same name): others" in commanders.look(2.0)
    twin.destroy_node()


def test_a_process_that_was_killed_before_is_not_found():
    """Who is told of others at once relies on it: DDS shows them for 20 s to who knew them."""
    program = (
        "import cpr_ros, rclpy, time; from std_msgs.msg import Float64MultiArray; rclpy.init(); "
        "node = rclpy.create_node('before'); "
        "publisher = node.create_publisher(Float64MultiArray, '/controller/commands', 1); "
        "print('up', flush=True); time.sleep(60)"
    )
    domain, context = free_domain(), Context()
    environment = private_environment() | {"ROS_DOMAIN_ID": str(domain)}
    with subprocess.Popen(
        [sys.executable, "-c", program], env=environment, stdout=subprocess.PIPE
    ) as before:
        assert before.stdout.readline() == b"up\n"
        before.kill()
    rclpy.init(context=context, domain_id=domain)
    node = rclpy.create_node("commanding", context=context)
    end = time.monotonic() + 1.5
    while time.monotonic() < end:
        assert node.count_publishers("/controller/commands") == 0
        time.sleep(0.05)
    node.destroy_node()
    rclpy.shutdown(context=context)

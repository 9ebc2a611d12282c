# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Two who command the same motors, found over real DDS."""

import time

import pytest
import rclpy
from helpers.node_process import TIMEOUT, free_domain
from rclpy.context import Context
from std_msgs.msg import Float64MultiArray

from cpr_ros.middleware.other_commanders import OtherCommanders


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


def test_others_are_told_once_they_are_not_a_process_that_was_killed(nodes):
    node, other = nodes
    node.create_publisher(Float64MultiArray, "~/commands", 1)
    commanders = OtherCommanders(node, "~/commands")
    counted(node, 1)
    assert [commanders.look(now) for now in (0.0, 100.0)] == ["", ""]
    second = other.create_publisher(Float64MultiArray, "/controller/commands", 1)
    counted(node, 2)
    told = "/controller/commands has 1 more publisher: others command the motors too"
    assert [commanders.look(now) for now in (200.0, 224.0, 225.0, 300.0)] == ["", "", told, told]
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
    assert [commanders.look(now) for now in (303.0, 327.0, 328.0)] == ["", "", told]

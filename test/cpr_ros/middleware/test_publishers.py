# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Publishers of a topic with a name of its own, found over real DDS."""

import time

import pytest
import rclpy
from helpers.node_process import TIMEOUT, free_domain
from rclpy.context import Context
from std_msgs.msg import String

from cpr_ros.middleware.publishers import other_publishers, own_publishers


@pytest.fixture(params=["", "/arm/joints"])
def nodes(request):
    """One that may remap a name, and another one."""
    remapped = ["--ros-args", "-r", f"measured:={request.param}"] if request.param else []
    context, domain = Context(), free_domain()
    rclpy.init(context=context, domain_id=domain)
    node = rclpy.create_node("listening", context=context, cli_args=remapped)
    other = rclpy.create_node("saying", context=context)
    yield node, other, request.param or "/measured"
    node.destroy_node()
    other.destroy_node()
    rclpy.shutdown(context=context)


def test_own_and_other_publishers_are_told_apart_whatever_the_topic_is_called(nodes):
    node, other, topic = nodes
    assert (own_publishers(node, "measured"), other_publishers(node, "measured")) == (0, 0)
    node.create_publisher(String, "measured", 1)
    other.create_publisher(String, topic, 1)
    other.create_publisher(String, "/elsewhere", 1)
    end = time.monotonic() + TIMEOUT
    while (own_publishers(node, "measured"), other_publishers(node, "measured")) != (1, 1):
        assert time.monotonic() < end
        time.sleep(0.01)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Names of frames as parameters give them."""

import pytest
import rclpy
from helpers.node_process import free_domain
from rclpy.context import Context
from rclpy.parameter import Parameter

from cpr_core import CprError
from cpr_ros.settings.declared_parameters import declare


@pytest.fixture(scope="module")
def context():
    context = Context()
    rclpy.init(context=context, domain_id=free_domain())
    yield context
    rclpy.shutdown(context=context)


def declared(context, name, value):
    node = rclpy.create_node(
        "robot", context=context, parameter_overrides=[Parameter(name, value=value)]
    )
    try:
        return declare(node)
    finally:
        node.destroy_node()


@pytest.mark.parametrize("name", ["frame_prefix", "base_frame", "platform_frame", "tracker_frame"])
def test_a_slash_in_front_is_none_of_tf2(context, name):
    assert getattr(declared(context, name, "left/arm"), name) == "left/arm"
    with pytest.raises(CprError, match=f"{name}: frames of tf2 do not begin with /, got '/left/'"):
        declared(context, name, "/left/")


@pytest.mark.parametrize("name", ["base_frame", "platform_frame"])
def test_a_frame_without_a_name_is_none_of_tf2(context, name):
    """The transform of the platform would reach nobody."""
    with pytest.raises(CprError, match=f"{name}: expected the name of a frame"):
        declared(context, name, "")

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Frames where tf2_ros is not installed; it is not among the wheels."""

import pytest
import rclpy
from geometry_msgs.msg import PoseStamped
from helpers.node_process import free_domain

from cpr_ros.messages import transforms
from cpr_ros.messages.transforms import Transforms

NAMES = ("left/base", "left/platform", "left/tracker")


@pytest.fixture
def node():
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=free_domain())
    made = rclpy.create_node("frames", context=context)
    yield made
    made.destroy_node()
    rclpy.shutdown(context=context)


def test_without_tf2_frames_have_their_names_and_others_are_not_known(node, monkeypatch):
    monkeypatch.setattr(transforms, "tf2_ros", None)
    alone = Transforms(node, *NAMES)
    before = node.get_publisher_names_and_types_by_node("frames", "/")
    alone.send(PoseStamped())
    assert not alone.available
    assert (alone.frames.base, alone.frames.platform, alone.frames.tracker) == NAMES
    assert alone.frames.rotation_to_base("camera") is None
    assert alone.rotation_to_base("left/base") is None
    assert node.get_publisher_names_and_types_by_node("frames", "/") == before

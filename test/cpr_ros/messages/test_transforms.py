# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Frames where tf2_ros is not installed; it is not among the wheels."""

from geometry_msgs.msg import PoseStamped

from cpr_ros.messages import transforms
from cpr_ros.messages.transforms import Transforms

NAMES = ("left/base", "left/platform", "left/tracker")


def test_without_tf2_frames_have_their_names_and_others_are_not_known(bare_node, monkeypatch):
    monkeypatch.setattr(transforms, "tf2_ros", None)
    alone = Transforms(bare_node, *NAMES)
    before = bare_node.get_publisher_names_and_types_by_node("bare", "/")
    alone.send(PoseStamped())
    assert not alone.available
    assert (alone.frames.base, alone.frames.platform, alone.frames.tracker) == NAMES
    assert alone.frames.rotation_to_base("camera") is None
    assert alone.rotation_to_base("left/base") is None
    assert bare_node.get_publisher_names_and_types_by_node("bare", "/") == before

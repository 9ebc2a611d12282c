# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Frames that the node sends and looks up, with tf2_ros and without."""

import numpy as np
import pytest
import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, TransformStamped, WrenchStamped
from helpers.drive import robot
from helpers.node_process import free_domain
from helpers.plain_tf2 import TF2_ROS
from numpy.testing import assert_allclose

from cpr_core import solve_home
from cpr_core.lie import quaternion_from_rotation, rotation_exp
from cpr_ros.messages import transforms
from cpr_ros.messages.conversions import platform_pose, with_wrench
from cpr_ros.messages.transforms import Transforms

NAMES = ("left/base", "left/platform", "left/tracker")
QUARTER = rotation_exp([0.0, 0.0, 0.5 * np.pi])


@pytest.fixture
def node():
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=free_domain())
    made = rclpy.create_node("frames", context=context)
    yield made
    made.destroy_node()
    rclpy.shutdown(context=context)


@pytest.fixture
def known(node, monkeypatch):
    """Frames of a node, all of them heard."""
    monkeypatch.setattr(transforms, "tf2_ros", TF2_ROS)
    return Transforms(node, *NAMES)


def told(known, parent, child, rotation, stamp=None):
    """Somebody tells where a frame is: at all times (no stamp), or at one."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    turn = message.transform.rotation
    turn.w, turn.x, turn.y, turn.z = quaternion_from_rotation(np.array(rotation)).tolist()
    if stamp is None:
        known._buffer.set_transform_static(message, "test")
    else:
        message.header.stamp = Time(sec=stamp)
        known._buffer.set_transform(message, "test")


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


def test_the_platform_is_sent_by_its_name_with_prefix_and_the_stamp_of_its_pose(known):
    home = solve_home(robot("six_rfs"))
    pose = platform_pose(home, known.frames, Time(sec=5, nanosec=7))
    known.send(pose)
    (sent,) = known._broadcaster.sent
    assert known.available
    assert (sent.header.frame_id, sent.child_frame_id) == ("left/base", "left/platform")
    assert sent.header.stamp == Time(sec=5, nanosec=7)
    moved = sent.transform.translation
    assert_allclose([moved.x, moved.y, moved.z], home.platform_position, rtol=0.0, atol=1e-15)
    found = known.rotation_to_base("left/platform")
    assert_allclose(found, home.platform_rotation, rtol=0.0, atol=1e-12)


def test_a_static_frame_turns_vectors_into_the_base_frame_of_this_robot(known):
    """The world stands between: base and camera are told in it, and another robot's base."""
    told(known, "world", "left/base", QUARTER)
    told(known, "world", "right/base", QUARTER.T)
    told(known, "world", "camera", np.eye(3))
    assert_allclose(
        known.rotation_to_base("camera") @ [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], atol=1e-12
    )
    assert_allclose(known.rotation_to_base("world"), QUARTER.T, atol=1e-12)
    assert_allclose(known.rotation_to_base("right/base"), QUARTER.T @ QUARTER.T, atol=1e-12)
    assert_allclose(known.rotation_to_base("left/base"), np.eye(3), atol=1e-12)


def test_of_a_moving_frame_the_newest_counts(known):
    told(known, "left/base", "gripper", np.eye(3), stamp=1)
    told(known, "left/base", "gripper", QUARTER, stamp=3)
    told(known, "left/base", "gripper", QUARTER.T, stamp=2)  # late
    assert_allclose(known.rotation_to_base("gripper"), QUARTER, atol=1e-12)


def test_frames_that_are_not_known_or_of_another_tree_are_none(known):
    assert known.rotation_to_base("camera") is None
    told(known, "elsewhere", "camera", np.eye(3))
    assert known.rotation_to_base("camera") is None
    told(known, "left/base", "gripper", np.eye(3))
    assert known.rotation_to_base("camera") is None


def test_a_wrench_in_a_frame_of_others_acts_in_its_directions(known):
    told(known, "left/base", "gripper", QUARTER)
    message = WrenchStamped()
    message.header.frame_id = "gripper"
    message.wrench.force.x, message.wrench.torque.z = 2.0, 0.1
    loads = with_wrench(robot("six_rfs").default_loads, message, known.frames)
    assert_allclose(loads.wrench_world, [0.0, 0.0, 0.1, 0.0, 2.0, 0.0], atol=1e-12)

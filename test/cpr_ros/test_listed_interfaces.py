# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What an active node publishes, hears and offers is what docs/node.md lists, and nothing else."""

import re
import signal
from pathlib import Path

import pytest
import rclpy
from helpers.node_process import free_domain
from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.lifecycle import LifecycleNode
from rclpy.signals import SignalHandlerOptions

from cpr_ros.interface.joint_trajectory_action import FollowJointTrajectory
from cpr_ros.node import CprNode
from cpr_ros.process.stop_signal import StopSignal

PAGE = (Path(__file__).parents[2] / "docs/node.md").read_text()
#: Of tf2_ros, where it is installed: told in the row of the platform pose.
TF = {"/tf", "/tf_static"}


@pytest.fixture(scope="module")
def node(tmp_path_factory):
    """A configured and active node, in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_HOME", str(tmp_path_factory.mktemp("ros")))
        taken_over = {
            number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)
        }
        arguments = ["--ros-args", "-p", "robot:=rfrfr", "-p", "start_from:=home"]
        rclpy.init(
            args=arguments,
            domain_id=free_domain(),
            signal_handler_options=SignalHandlerOptions.NO,
        )
        node = CprNode(StopSignal())
        try:
            assert node.start()
            assert node.robot.active_session() is not None
            yield node
        finally:
            node.destroy_node()
            rclpy.shutdown()
            for number, handler in taken_over.items():
                signal.signal(number, handler)


def listed(heading, node):
    """Names and types in the rows of a table, which is found by the line above it."""
    _, found, rest = PAGE.partition(f"\n{heading}\n")
    assert found, heading
    table = re.search(r"(?:^\|.*\n)+", rest, re.MULTILINE)[0]
    rows = {}
    for names, types in re.findall(r"^\| (`.*?) \| (.*?`) \|", table, re.MULTILINE):
        if not names.endswith("..."):  # those of every managed node
            kinds = re.findall(r"(?:action )?`(\S+)`", types)
            rows |= zip(re.findall(r"`(\S+)`", names), kinds, strict=True)
    own = node.get_fully_qualified_name()
    return {_whole(name, own): kind for name, kind in rows.items()}


def _whole(name, own):
    """A name from the root on."""
    if name.startswith("~/"):
        return f"{own}{name[1:]}"
    return name if name.startswith("/") else f"{own.rpartition('/')[0]}/{name}"


def graph(node):
    """What ROS knows of a node: publishers, subscriptions, services and actions, with their types."""
    asked = node.get_name(), node.get_namespace()
    found = (
        node.get_publisher_names_and_types_by_node(*asked),
        node.get_subscriber_names_and_types_by_node(*asked),
        node.get_service_names_and_types_by_node(*asked),
        get_action_server_names_and_types_by_node(node, *asked),
    )
    return [
        {name: kind.replace("/msg/", "/") for name, [kind] in part if "/_action/" not in name}
        for part in found
    ]


@pytest.fixture(scope="module")
def found(node):
    """What the node has more than any managed node."""
    bare = LifecycleNode("bare")
    own, parts = node.get_fully_qualified_name(), []
    for part, usual in zip(graph(node), graph(bare), strict=True):
        others = {name.replace(bare.get_fully_qualified_name(), own) for name in usual}
        assert others <= set(part)
        parts.append({name: kind for name, kind in part.items() if name not in others | TF})
    bare.destroy_node()
    return parts


def test_the_page_lists_every_publisher(node, found):
    published, *_ = found
    assert published == listed("Published; reliable, depth 10:\n", node)


def test_the_page_lists_every_subscription(node, found):
    _, heard, *_ = found
    assert heard == listed("Taken; the newest setpoint of any topic wins:\n", node)


def test_the_page_lists_every_service_and_action(node, found):
    *_, services, actions = found
    assert services and actions
    rows = listed("## Services and action\n", node)
    if FollowJointTrajectory is None:
        [name] = [name for name, kind in rows.items() if kind.startswith("control_msgs/")]
        del rows[name]
    assert services | actions == rows

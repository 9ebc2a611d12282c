# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Who publishes to a topic that a node listens to: others, or the node itself."""

from __future__ import annotations

from rclpy.node import Node

__all__ = ["other_publisher_names", "other_publishers", "own_publishers", "own_topic"]


def own_publishers(node: Node, name: str) -> int:
    """How many publishers of the node have a topic by its name, which may be remapped."""
    topic = node.resolve_topic_name(name)
    return sum(publisher.topic_name == topic for publisher in node.publishers)


def own_topic(node: Node, name: str) -> str:
    """Topic that a name means, if the node itself publishes to it, else empty.

    What it believes would pass for what is measured, and what it commands for what is asked of it.
    """
    return str(node.resolve_topic_name(name)) if own_publishers(node, name) else ""


def other_publishers(node: Node, name: str) -> int:
    """How many others the node has found; rclpy counts without remapping the name."""
    found: int = node.count_publishers(node.resolve_topic_name(name))
    return found - own_publishers(node, name)


def other_publisher_names(node: Node, name: str) -> list[str]:
    """Full names of the nodes of all others that the node has found, each once."""
    topic = node.resolve_topic_name(name)
    own = node.get_fully_qualified_name()
    names = {
        f"{found.node_namespace.rstrip('/')}/{found.node_name}"
        for found in node.get_publishers_info_by_topic(topic)
    }
    return sorted(names - {own})

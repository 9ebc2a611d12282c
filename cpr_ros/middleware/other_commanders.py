# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether others command the motors that a node commands: a robot has one master."""

from __future__ import annotations

from rclpy.node import Node

from .publishers import other_publisher_names, other_publishers

__all__ = ["OtherCommanders"]

#: One that makes room for this node in good order is gone by then [s]. Whoever is found was alive when
#: it was found: DDS shows a process that was killed for 20 s more, but never to nodes that come later.
_MAKING_ROOM = 2.0


class OtherCommanders:
    """Looks now and then for other publishers of a topic of commands."""

    def __init__(self, node: Node, name: str) -> None:
        """Look at a topic.

        Args:
            node: Who commands.
            name: Of the topic, which may be remapped.
        """
        self._node, self._name = node, name
        self._since: float | None = None

    def look(self, now: float) -> str:
        """What is to be said of them; empty: there are none, or they may be about to leave.

        Args:
            now: Steady time [s].
        """
        found = other_publishers(self._node, self._name)
        if not found:
            self._since = None
            return ""
        if self._since is None:
            self._since = now
        if now - self._since < _MAKING_ROOM:
            return ""
        topic = self._node.resolve_topic_name(self._name)
        names = other_publisher_names(self._node, self._name)
        who = ", ".join(names) or "a node of the same name"
        return (
            f"{topic} has {found} more publisher{'s' * (found > 1)} ({who}): others command the "
            "motors too"
        )

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Transitions of the life cycle that are not possible now: rclpy raises, and never answers."""

from __future__ import annotations

from typing import Any

from rclpy.lifecycle import LifecycleNode

__all__ = ["answer_impossible_transitions"]


def answer_impossible_transitions(node: LifecycleNode) -> None:
    """Answer with no where a transition is not possible now."""
    service = node._service_change_state
    change = service.callback

    def callback(request: Any, response: Any) -> Any:
        try:
            return change(request, response)
        except Exception as error:
            node.get_logger().warning(f"change_state: {error}")
            response.success = False
            return response

    service.callback = callback

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The side of somebody who uses an action: goals out, feedback and results in."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from action_msgs.msg import GoalStatusArray
from rclpy.action import ActionClient
from rclpy.qos import QoSProfile, qos_profile_action_status_default

from helpers.driver import EVERY_MESSAGE
from helpers.node_process import TIMEOUT, Client


class GoalClient:
    """A client of one action."""

    def __init__(self, client: Client, kind: Any, name: str) -> None:
        self.client, self.kind = client, kind
        self.feedback: list[Any] = []
        every_message = QoSProfile(depth=EVERY_MESSAGE)
        self._action = ActionClient(client.node, kind, name, feedback_sub_qos_profile=every_message)
        self._statuses: dict[bytes, int] = {}
        self._told = client.node.create_subscription(
            GoalStatusArray, f"{name}/_action/status", self._hear, qos_profile_action_status_default
        )
        assert self._action.wait_for_server(TIMEOUT), f"no action {name}"

    def _hear(self, message: GoalStatusArray) -> None:
        for goal in message.status_list:
            self._statuses[bytes(goal.goal_info.goal_id.uuid)] = goal.status

    def close(self) -> None:
        self.client.node.destroy_subscription(self._told)
        self._action.destroy()

    def until_status(self, handle: Any, status: int) -> None:
        """Wait until a goal is said to be in a status.

        ``handle.status`` of rclpy does not tell: it stays unknown where the message of
        statuses overtakes the answer that accepts the goal.
        """
        self.client.spin_until(lambda: self.status(handle) == status)

    def status(self, handle: Any) -> int | None:
        """What was last said of a goal."""
        return self._statuses.get(bytes(handle.goal_id.uuid))

    def send(self, **fields: Any) -> Any:
        """A goal that is on its way."""
        self.feedback.clear()
        sent = self._action.send_goal_async(
            self.kind.Goal(**fields),
            feedback_callback=lambda message: self.feedback.append(message.feedback),
        )
        self.client.spin_until(sent.done)
        assert sent.result().accepted
        return sent.result()

    def result(self, handle: Any, timeout: float = 120.0) -> Any:
        """Status and result."""
        answer = handle.get_result_async()
        self.client.spin_until(answer.done, timeout)
        return SimpleNamespace(status=answer.result().status, result=answer.result().result)

    def cancel(self, handle: Any) -> int:
        """How many goals are being cancelled."""
        answer = handle.cancel_goal_async()
        self.client.spin_until(answer.done)
        return len(answer.result().goals_canceling)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Requests that take long, answered one at a time: whatever else has come goes first."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile

__all__ = ["SERVICE_QOS", "WaitingRequests"]

#: A burst of requests waits in line; the default of ten would drop the others without a word.
SERVICE_QOS = QoSProfile(depth=1000)
#: So many wait here; a longer burst is answered as it comes.
_MOST = 1000
#: While requests keep coming one is answered that often all the same [s].
_SELDOM = 0.1

#: Fills a response, and cannot raise.
_Answer = Callable[[Any, Any], Any]


class WaitingRequests:
    """The line of those that wait.

    rclpy calls back in the order in which messages came: what stops the robot would wait for all
    requests before it. So a callback only puts a request in line, and the node answers the first
    whenever rclpy has called back for something else, or for nothing.

    Attributes:
        due: Steady time of the next answer [s]: at once, or infinite while nobody waits.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        """Nobody waits yet.

        Args:
            clock: Steady time [s].
        """
        self._clock, self.due = clock, math.inf
        self._unsent: dict[int, Any] = {}
        self._line: deque[Callable[[], None]] = deque()
        self._came, self._last = False, -math.inf

    def create_service(self, node: Node, kind: Any, name: str, answer: _Answer) -> None:
        """Offer a service whose requests wait in line.

        Args:
            node: The node.
            kind: Type of the service.
            name: Its name.
            answer: Fills a response, and cannot raise.
        """
        service = node.create_service(kind, name, self._take, qos_profile=SERVICE_QOS)
        send = service.send_response

        def send_response(response: Any, header: Any) -> None:
            request = self._unsent.pop(id(response), None)
            if request is None:
                send(response, header)
                return
            self._line.append(lambda: service.send_response(answer(request, response), header))
            self._came, self.due = True, -math.inf
            if len(self._line) > _MOST:
                self._answer_first()

        service.send_response = send_response

    def _take(self, request: Any, response: Any) -> Any:
        """What rclpy calls back: it tells afterwards, with the response, whom that is for."""
        self._unsent[id(response)] = request
        return response

    def look(self, now: float) -> None:
        """Answer the first in line at a steady time [s], if nobody has joined it since the last look."""
        joined, self._came = self._came, False
        if self._line and (not joined or now >= self._last + _SELDOM):
            self._answer_first()

    def _answer_first(self) -> None:
        try:
            self._line.popleft()()
        finally:
            self._last = self._clock()
            self.due = -math.inf if self._line else math.inf

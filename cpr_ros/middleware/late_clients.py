# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Responses of services for clients that DDS finds late."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from rclpy.node import Node

__all__ = ["LateClients"]

#: What rclpy warns of where the request is there, but not yet where the response goes to: rmw_fastrtps
#: has waited for 100 ms and drops it (issue 842 of ros2/rmw_fastrtps). Not so of a client that is gone.
_NOT_SENT = "failed to send response"
#: When it is sent again, after the time before [s]: each time may hold the node up for 100 ms.
_AGAIN_AFTER = (0.1, 0.3, 0.9, 2.7)
#: Between two tries, whichever response they are for: so much of its time the node has for all else [s].
_BETWEEN = 0.2


@dataclass
class _Late:
    """A response that was not sent yet.

    Attributes:
        send: Sends it.
        service: Name of the service.
        pauses: How long to wait before each further try [s].
        due: Steady time of the next try [s].
    """

    send: Callable[[], None]
    service: str
    pauses: Iterator[float]
    due: float = -math.inf


class LateClients:
    """Keeps responses that could not be sent, and sends them again.

    Attributes:
        due: Steady time of the next try [s]; infinite while all are sent.
    """

    def __init__(self, node: Node, clock: Callable[[], float]) -> None:
        """Keep none yet.

        Args:
            node: Whose services they are.
            clock: Steady time [s].
        """
        self._node, self._clock, self.due = node, clock, math.inf
        self._watched: list[Any] = []
        self._late: list[_Late] = []
        self._next = -math.inf

    def watch(self) -> None:
        """See to all services that the node has by now."""
        for service in self._node.services:
            if service not in self._watched:
                self._watched.append(service)
                service.send_response = self._keeping(service.srv_name, service.send_response)

    def look(self, now: float) -> None:
        """Send one that is due at a steady time [s]: the node does not wait for many in a row."""
        if now < self.due:
            return
        late = min(self._late, key=lambda late: late.due)
        self._late.remove(late)
        try:
            self._try(late)
        finally:
            self._next = self._clock() + _BETWEEN
            self._find_due()

    def _keeping(
        self, service: str, send: Callable[[Any, Any], None]
    ) -> Callable[[Any, Any], None]:
        def send_response(response: Any, header: Any) -> None:
            self._try(_Late(lambda: send(response, header), service, iter(_AGAIN_AFTER)))
            self._find_due()

        return send_response

    def _try(self, late: _Late) -> None:
        if _sent(late.send):
            return
        pause = next(late.pauses, None)
        if pause is not None:
            late.due = self._clock() + pause
            self._late.append(late)
            return
        self._node.get_logger().warning(
            f"a client of {late.service} gets no answer: DDS has not found it in "
            f"{sum(_AGAIN_AFTER):g} s"
        )

    def _find_due(self) -> None:
        first = min((late.due for late in self._late), default=math.inf)
        self.due = max(first, self._next)


def _sent(send: Callable[[], None]) -> bool:
    """Whether it was; rclpy tells by a warning, and would not notice if that were made an error."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.filterwarnings("always", _NOT_SENT, RuntimeWarning)
        send()
    others = [warning for warning in heard if not str(warning.message).startswith(_NOT_SENT)]
    for warning in others:
        warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    return len(others) == len(heard)

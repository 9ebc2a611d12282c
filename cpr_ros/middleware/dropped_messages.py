# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Count of messages that were dropped, and when to say so. No ROS here."""

from __future__ import annotations

from collections import Counter

__all__ = ["DroppedMessages"]


class DroppedMessages:
    """Dropped messages by topic; one line in the log per topic and second at most.

    Attributes:
        counts: Number of dropped messages by topic.
    """

    def __init__(self, quiet: float = 1.0) -> None:
        """Say something about a topic every ``quiet`` seconds at most."""
        self.quiet = quiet
        self.counts: Counter[str] = Counter()
        self._said: dict[str, tuple[float, int]] = {}
        self._looked: Counter[str] = Counter()

    def add(self, topic: str, problem: str, now: float) -> str:
        """Count a message; the line to log, empty for silence."""
        self.counts[topic] += 1
        when, count = self._said.get(topic, (float("-inf"), 0))
        if now - when < self.quiet:
            return ""
        new = self.counts[topic] - count
        self._said[topic] = now, self.counts[topic]
        others = f" (and {new - 1} more since the last such line)" if new > 1 else ""
        return f"{topic}: dropped: {problem:.500}{others}"

    def newest(self) -> dict[str, int]:
        """How many were dropped since this was asked last, by topic."""
        new = self.counts - self._looked
        self._looked = self.counts.copy()
        return dict(new)

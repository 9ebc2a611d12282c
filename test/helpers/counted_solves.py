# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How often a follower asks for an equilibrium."""

from cpr_ros.following import steps


class Solves:
    """How often `attempt` is asked, and how long it is allowed to take instead of as it is."""

    def __init__(self, monkeypatch, module, time_limit=None):
        self.count, self._attempt, self.time_limit = 0, module.attempt, time_limit
        monkeypatch.setattr(module, "attempt", self)

    def __call__(self, current, goal, fraction, loads, time_limit=steps.LONGEST_SOLVE):
        self.count += 1
        limit = time_limit if self.time_limit is None else self.time_limit
        return self._attempt(current, goal, fraction, loads, limit)

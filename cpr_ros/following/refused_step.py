# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A step that was refused: asked for again it would be again, and take its time. No ROS here."""

from __future__ import annotations

import math
from collections.abc import Hashable
from typing import NamedTuple

from cpr_core import Loads
from cpr_core.model.assessment import Assessment

from .steps import Undecided
from .supervision import Refusal

__all__ = ["RefusedStep", "Step"]

#: A step that was not decided is asked for again after this many times as long as that took.
_PATIENCE = 10.0


class Step(NamedTuple):
    """What is asked of a step; the same twice has the same answer.

    Attributes:
        current: Where it begins.
        loads: That act where it ends.
        destination: Of the goal; None: no other step is the same.
        factor: Part of their speed that motors and platform may have.
        settings: Thresholds and speeds that count; None: none do.
        watched: Measures that count.
    """

    current: Assessment
    loads: Loads
    destination: Hashable | None
    factor: float = 1.0
    settings: object = None
    watched: tuple[str, ...] = ()


class RefusedStep:
    """The last step that was refused.

    A halted robot is asked for the same in every tick, and so is one that does not bear its wrench or is
    measured where it cannot be. The answer may take longer than a tick: a pose beyond a limit is walked
    towards. What was not decided is asked for again, but not all the time.
    """

    def __init__(self) -> None:
        """None yet."""
        self._step: Step | None = None
        self._refusal: Refusal | None = None
        self._until = -math.inf

    def again(self, step: Step, now: float) -> Refusal | None:
        """Why a step is refused that was refused before; None: it has to be tried.

        Args:
            step: What is asked.
            now: Steady time [s].
        """
        last = self._step
        if last is None or step.destination is None or now >= self._until:
            return None
        same = (
            step.current is last.current
            and step.loads is last.loads
            and step.settings is last.settings
            and step.factor == last.factor
            and step.watched == last.watched
            and step.destination == last.destination
        )
        return self._refusal if same else None

    def take(self, step: Step, refusal: Refusal, now: float, took: float = 0.0) -> None:
        """Remember a step that was refused.

        Args:
            step: What was asked.
            refusal: Why it was refused.
            now: Steady time [s].
            took: How long it took to tell [s]; for so long, ten times, what was not decided is not asked
                for again.
        """
        self._step, self._refusal = step, refusal
        self._until = now + _PATIENCE * took if isinstance(refusal, Undecided) else math.inf

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How near a robot is to what it must not come near: one bar for every measure, with its thresholds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from ..errors import distinct
from ..model.assessment import DEFAULT_THRESHOLDS, MEASURES, Assessment, Threshold
from ..model.equilibrium import Equilibrium

__all__ = ["Bar", "bar", "bars"]


@dataclass(frozen=True)
class Bar:
    """A measure as a bar.

    Attributes:
        name: What it is called.
        value: The measure; falls towards what it warns of.
        threshold: Where it warns and stops.
        filled: How much of the bar is filled, in [0, 1]: nothing at the stop, half at the warning.
        level: ``fine``, ``slow`` below the warning or ``stop`` below the stop.
    """

    name: str
    value: float
    threshold: Threshold
    filled: float
    level: Literal["fine", "slow", "stop"]

    @property
    def text(self) -> str:
        """The measure and its thresholds in words."""
        limits = self.threshold.warning, self.threshold.stop
        value, warning, stop = distinct(self.value, *limits, fewest=3)
        return f"{self.name} {value} (slow {warning}, stop {stop})"


def bars(equilibrium: Equilibrium) -> tuple[Bar, ...]:
    """Bars of an equilibrium: of all measures the robot has."""
    assessment = Assessment(equilibrium)
    values = {name: assessment.value(name) for name in MEASURES}
    return tuple(
        bar(name, value, DEFAULT_THRESHOLDS[name])
        for name, value in values.items()
        if not math.isinf(value)  # no such limit, nothing that can move, or no inverse problem
    )


def bar(measure: str, value: float, threshold: Threshold) -> Bar:
    """The bar of a measure; a NaN is a stop."""
    name, level = measure.replace("_", " "), threshold.level(value)
    if not level > 0.0:
        return Bar(name, value, threshold, 0.0, "stop")
    filled = 1.0 / (1.0 + 1.0 / level)  # also of an infinity
    return Bar(name, value, threshold, filled, "fine" if level >= 1.0 else "slow")

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measurements that a robot could not have been at, if its limits are what the description says."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import first_and_others
from ..model.equilibrium import Equilibrium
from ..solving.limits import limit_error, limits_of, margins
from .compared import ComparedRow

__all__ = ["BEYOND", "limit_doubts"]

#: How far beyond a limit is no noise of measurements: in natural units, or relative to the limit.
BEYOND = 0.02


def limit_doubts(rows: Sequence[ComparedRow], found: Sequence[Equilibrium]) -> list[str]:
    """At which rows motors or rods are beyond limits, in a line; none where they are all within.

    Args:
        rows: How rows were compared.
        found: Their equilibria, of the robot that was found, which has limits.
    """
    left = [margins(each) for each in found]
    beyond = [row for row, margin in enumerate(left) if min(margin, default=0.0) < -BEYOND]
    if not beyond:
        return []
    beyond.sort(key=lambda row: float(left[row].min()))
    worst = found[beyond[0]]
    problem = limit_error(worst, limits_of(worst.robot)[int(np.argmin(left[beyond[0]]))])
    labels = first_and_others([rows[row].measurement.label for row in beyond])
    return [
        f"{labels}: measured all the same where the robot found could not be: {problem}; limits, units, "
        "or other numbers of the description may be wrong"
    ]

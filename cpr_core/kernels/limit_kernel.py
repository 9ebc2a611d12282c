# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether limits are kept along a way, from their margins: looked at in every step of a control loop."""

from __future__ import annotations

from .kernel_decorators import kernel

__all__ = ["ROUNDING", "grazed", "steps_within_limits"]

#: Overshoot within the accuracy of a solution, of the margins.
ROUNDING = 1e-9
#: Steps that change a margin by less are not divided to find out whether its limit is passed within.
_SMALLEST_GRAZE = 1e-3


@kernel
def grazed(before, after):
    """Whether a limit may be passed, and be kept again, between two sets of margins, (K,)."""
    for limit in range(before.shape[0]):
        change = abs(after[limit] - before[limit])
        near = min(abs(before[limit]), abs(after[limit])) < change
        if near and change > _SMALLEST_GRAZE:
            return True
    return False


@kernel
def steps_within_limits(along):
    """After how many steps a limit does not hold, or was grazed: of margins along a way, (T + 1, K)."""
    for step in range(along.shape[0] - 1):
        before, after = along[step], along[step + 1]
        for margin in after:
            if margin < -ROUNDING:
                return step
        if grazed(before, after):
            return step
    return along.shape[0] - 1

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether something may happen within a step, and be undone, that its ends do not show.

What must not change its sign unseen is known at the ends of steps: the margin of stability, the distance
from an inverse singularity, the margins of limits. A third value beside a step tells how steep they are
and how much they are bent. They may come as near to zero as the parabola through both ends does that is
bent so much towards it; and as two straight lines do that are as steep: singular values turn sharply.
"""

from __future__ import annotations

from collections.abc import Iterable

__all__ = ["may_hide", "may_hide_in_one_step"]

#: How much more values may be bent within a step, and how much steeper they may be, than three of them
#: tell.
_BENT_MORE, _STEEPER = 2.0, 1.25
#: Values are known so well.
_ROUNDING = 1e-9
#: Second derivative per longest steps squared that is not expected to be passed; steepest ones are where
#: branches turn, which are walked in small steps anyway.
_STEEP = 100.0


def may_hide(
    places: tuple[float, float, float],
    values: tuple[Iterable[float], Iterable[float], Iterable[float]],
) -> bool:
    """Whether a value may have been on the other side of zero between the second and the third place.

    Args:
        places: Where values are known, along the way in any unit; the first one before the second or
            behind the third.
        values: What is watched there, as many at each place.
    """
    other, first, last = places
    behind = other > last
    step, across = last - first, (first if behind else last) - other
    aside = (last if behind else first) - other
    for of_other, of_first, of_last in zip(*values, strict=True):
        if of_first * of_last < 0.0:
            continue  # that shows
        slope = (of_last - of_first) / step
        slope_aside = ((of_last if behind else of_first) - of_other) / aside
        bend = _BENT_MORE * abs((slope - slope_aside) * 2.0 * step**2 / across)
        fall = _STEEPER * max(abs(slope), abs(slope_aside)) * step
        steep = (
            abs(of_first + of_last) < fall - 2.0 * _ROUNDING
        )  # two straight lines meet beyond zero
        if steep or _bent(of_first, of_last, bend):
            return True
    return False


def may_hide_in_one_step(before: float, after: float, length: float) -> bool:
    """The same where nothing is known but a value at both ends of a step.

    Args:
        before: What is watched at its begin.
        after: What is watched at its end.
        length: Of the step, in longest steps.
    """
    return _bent(before, after, _STEEP * length**2)


def _bent(before: float, after: float, bend: float) -> bool:
    """Whether a value that is bent by so much per step squared passes zero between two of one sign."""
    change = abs(after - before)
    if change >= 0.5 * bend:
        return False  # it falls all along the step or rises: it is lowest at an end
    return 0.5 * abs(before + after) - bend / 8.0 - change**2 / (2.0 * bend) < -_ROUNDING

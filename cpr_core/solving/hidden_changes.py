# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether something may happen within a step, and be undone, that its ends do not show.

What must not change its sign unseen is known at the ends of steps: the margin of stability, the distance
from an inverse singularity, the margins of limits. A third value beside a step tells how steep they are
and how much they are bent. They may come as near to zero as the parabola through both ends does that is
bent so much towards it; and as two straight lines do, one from either end, that are as steep as they are
seen to be: singular values turn sharply. But what leaves zero evenly does not turn back at once.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Flag, auto
from typing import NamedTuple

__all__ = [
    "Hidden",
    "Watched",
    "hidden_between",
    "hidden_in_halves",
    "may_hide",
    "may_hide_in_one_step",
]

#: How much more values may be bent within a step, and how much steeper they may be, than three of them
#: tell.
_BENT_MORE, _STEEPER = 2.0, 1.25
#: A value is at zero if it is smaller than this part of what it changes by.
_AT_ZERO = 1e-6
#: How well values are known.
_ROUNDING = 1e-9
#: Second derivative per longest steps squared that is not expected to be passed; steepest ones are where
#: branches turn, which are walked in small steps anyway.
_STEEP = 100.0


class Watched(NamedTuple):
    """What must not change its sign unseen within a step, dimensionless.

    Attributes:
        margins: Of limits that may be passed and kept again, and of stability.
        singularity: Distance from an inverse singularity, one number; none where it is not watched.
    """

    margins: tuple[float, ...]
    singularity: tuple[float, ...]


class Hidden(Flag):
    """What may have happened within a step, and been undone."""

    NOTHING = 0
    MARGIN = auto()
    SINGULARITY = auto()


def hidden_between(
    places: tuple[float, float, float], watched: tuple[Watched, Watched, Watched]
) -> Hidden:
    """What may have happened, and been undone, between the second and the third place, as `may_hide`."""
    first, second, third = watched
    found = Hidden.NOTHING
    if first.margins and may_hide(places, (first.margins, second.margins, third.margins)):
        found |= Hidden.MARGIN
    singularities = first.singularity, second.singularity, third.singularity
    return found | Hidden.SINGULARITY if may_hide(places, singularities) else found


def hidden_in_halves(first: Watched, middle: Watched, last: Watched) -> Hidden:
    """What may have happened, and been undone, in either half of a step, beside the other half."""
    in_first = hidden_between((1.0, 0.0, 0.5), (last, first, middle))
    return in_first | hidden_between((0.0, 0.5, 1.0), (first, middle, last))


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
    step, behind = last - first, other > last
    aside, across = (last if behind else first) - other, (first if behind else last) - other
    bends = _BENT_MORE * 2.0 * step**2 / abs(across)
    for of_other, of_first, of_last in zip(*values, strict=True):
        slope = (of_last - of_first) / step
        slope_aside = ((of_last if behind else of_first) - of_other) / aside
        bend = bends * abs(slope - slope_aside)
        fall = _STEEPER * max(abs(slope), abs(slope_aside)) * step
        if abs(of_first + of_last) >= max(fall, 0.5 * bend):
            continue  # far from zero, as most values are
        steep = _steep(of_first, of_last, fall)
        if of_first * of_last >= 0.0 and (steep or _bent(of_first, of_last, bend)):
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


def _steep(before: float, after: float, fall: float) -> bool:
    """Whether lines from values of one sign that fall by so much per step meet beyond zero."""
    if min(abs(before), abs(after)) < _AT_ZERO * fall:
        return False
    return abs(before + after) < fall - 2.0 * _ROUNDING

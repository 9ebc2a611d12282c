# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Loads when the description they partly come from changes."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import fields, replace
from operator import eq
from typing import Any

import numpy as np

from .loads import Loads, compared

__all__ = ["inheritance", "inherited_loads", "overridden_loads"]


def inherited_loads(loads: Loads, before: Loads, after: Loads) -> Loads:
    """Loads in force after their description has changed.

    What they have of the description follows it; what a request has put in its place stays.

    Args:
        loads: In force before.
        before: Of the description before.
        after: Of the description after.
    """
    if loads is before:
        return after
    return replace(
        loads,
        **{
            field.name: getattr(after, field.name)
            for field in fields(Loads)
            if _same(getattr(loads, field.name), getattr(before, field.name))
        },
    )


def overridden_loads(loads: Loads, before: Loads, after: Loads) -> tuple[str, ...]:
    """Names of what changes in the description and not in the loads in force, as above."""
    return tuple(
        field.name
        for field in fields(Loads)
        if not _same(getattr(before, field.name), getattr(after, field.name))
        and not _same(getattr(loads, field.name), getattr(before, field.name))
    )


def inheritance(loads: Loads, own: Loads) -> Hashable:
    """The same for all loads in force that change alike with the description.

    That is all but the wrench: what of it is not the description's does not change at all.

    Args:
        loads: In force.
        own: Of the description.
    """
    wrenches, others = compared(loads)
    return tuple(map(eq, wrenches, compared(own)[0])), others


def _same(first: Any, second: Any) -> bool:
    """Whether vectors, or forces on rods, are the same."""
    if first is second:
        return True
    if isinstance(first, np.ndarray):
        return bool(np.array_equal(first, second))
    return len(first) == len(second) and all(
        first_force.leg == second_force.leg
        and np.array_equal(first_force.at, second_force.at)
        and np.array_equal(first_force.force, second_force.force)
        for first_force, second_force in zip(first, second, strict=True)
    )

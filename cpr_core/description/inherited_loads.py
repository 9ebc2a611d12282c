# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Loads when the description they partly come from changes."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace

from .loads import Loads

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
    own = loads.differences(before)
    return replace(loads, **{name: getattr(after, name) for name in loads.parts if name not in own})


def overridden_loads(loads: Loads, before: Loads, after: Loads) -> tuple[str, ...]:
    """Names of what changes in the description and not in the loads in force, as above."""
    own = loads.differences(before)
    return tuple(name for name in before.differences(after) if name in own)


def inheritance(loads: Loads, own: Loads) -> Hashable:
    """The same for all loads in force that change alike with the description.

    That is all but the wrench: what of it is not the description's does not change at all.

    Args:
        loads: In force.
        own: Of the description.
    """
    others = dict(loads.parts)
    inherited = tuple(
        others.pop(name) == own.parts[name] for name in ("wrench_world", "wrench_body")
    )
    return inherited, tuple(others.values())

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where passive joints are at home, roughly, by their names."""

from __future__ import annotations

from typing import Any

from ..description_part import Part
from .chain import ChainJoint
from .leg_description import LegDescription

__all__ = ["rough_joints"]


def rough_joints(home: Part, legs: tuple[LegDescription, ...]) -> dict[str, float]:
    """Positions of passive joints by name [rad or m]; turns of universal joints have their own names.

    Args:
        home: What the description knows of home.
        legs: The legs.

    Raises:
        DescriptionError: No such joint, one with a motor, or not as many numbers as it has axes.
    """
    given: dict[str, Any] = home.get("joints", {})
    joints = {joint.name: joint for leg in legs for joint in leg.joints}
    part, found = home.part("joints"), {}
    for name, value in given.items():
        own = _own(joints, name)
        if not own:
            passive = [known for known, joint in joints.items() if joint.motor is None]
            expected = f"one of {', '.join(passive)}" if passive else "nothing: no joint is passive"
            raise part.fail(name, f"expected {expected}, got {name!r}")
        values = value if isinstance(value, list) else [value]
        if len(values) != len(own) or isinstance(value, list) != (own[0].name != name):
            several = (
                f"{len(own)} numbers, one for every axis" if own[0].name != name else "a number"
            )
            raise part.fail(name, f"expected {several}, got {value}")
        for joint, at in zip(own, values, strict=True):
            if at is None:
                continue
            if joint.motor is not None:
                raise part.fail(name, f"{joint.motor} moves it: give home.motors")
            found[joint.name] = float(at)
    return found


def _own(joints: dict[str, ChainJoint], name: str) -> list[ChainJoint]:
    """The joints a name stands for: one, or the turns of a universal joint; none: unknown."""
    if name in joints:
        return [joints[name]]
    turns: list[ChainJoint] = []
    while f"{name}[{len(turns)}]" in joints:
        turns.append(joints[f"{name}[{len(turns)}]"])
    return turns

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether strain modes can follow how the stiffness changes along a rod."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import DescriptionError
from .robot_description import RobotDescription

__all__ = ["check_jumps"]

#: A stiffness that changes by more than this factor within half the length of the shortest wave that
#: polynomial modes follow is a jump to them.
_JUMP = 1.1
#: Stations are written with rounding.
_ROUNDED = 1e-9


def check_jumps(description: RobotDescription) -> None:
    """Whether polynomial modes can follow how the stiffness changes along every rod.

    Raises:
        DescriptionError: They cannot: the answer would be centimetres wrong and look converged.
    """
    for number, leg in enumerate(description.legs):
        for rod, element in enumerate(leg.rods):
            modes, profile = max(element.modes.counts), element.rod.profile
            if element.modes.basis.breakpoints or profile.uniform:
                continue
            at, stiffness = profile.at, profile.stiffness
            for k in range(len(at) - 1):
                near = at[k + 1] - at[k] < 0.5 / modes - _ROUNDED
                if near and max(stiffness[k : k + 2]) > _JUMP * min(stiffness[k : k + 2]):
                    problem = (
                        f"the stiffness changes from {stiffness[k]:g} to {stiffness[k + 1]:g} between "
                        f"{at[k]:g} and {at[k + 1]:g}, a jump to {modes} polynomial modes: write two "
                        "rods in a chain"
                    )
                    field = f"{_profiled(description, number, rod)}.profile.at"
                    raise DescriptionError(description.source, field, problem)


def _profiled(description: RobotDescription, number: int, rod: int) -> str:
    """Where the profile of a rod of a leg is written."""
    content: Mapping[str, Any] = {} if description.written is None else description.written.content
    leg = content.get("legs", [{}] * (number + 1))[number]
    places = [place for place, element in enumerate(leg.get("chain", ())) if "rod" in element]
    if places and "profile" in (leg["chain"][places[rod]]["rod"] or {}):
        return f"legs[{number}].chain[{places[rod]}].rod"
    return f"legs[{number}].rod" if "profile" in leg.get("rod", {}) else "rod"

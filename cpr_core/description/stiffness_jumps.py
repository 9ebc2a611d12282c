# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether strain modes can follow how the stiffness changes along a rod."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import DescriptionError
from ..rods.quadrature import distinct_stations, rod_grid
from ..rods.rod import Profile
from ..rods.strain_basis import StrainBasis
from .robot_description import RobotDescription

__all__ = ["check_jumps"]

Floats = NDArray[np.float64]

#: A stiffness that changes by more than this factor within half the length of the shortest wave that
#: polynomial modes follow is a jump to them.
_JUMP = 1.1
#: What rounding in a file may do to the distance of two stations.
_ROUNDED = 1e-9
#: Relative error of the bending of a rod beyond which splines are refused.
_SPLINES_OFF = 0.025


def check_jumps(description: RobotDescription) -> None:
    """Whether strain modes can follow how the stiffness changes along every rod.

    Raises:
        DescriptionError: They cannot: the answer would be centimetres wrong and look converged.
    """
    for number, leg in enumerate(description.legs):
        for rod, element in enumerate(leg.rods):
            profile = element.rod.profile
            if profile.uniform:
                continue
            modes = max(element.modes.counts)
            basis = element.modes.basis
            find = _not_by_splines if basis.breakpoints else _not_by_polynomials
            if problem := find(basis, modes, profile):
                field = f"{_profiled(description, number, rod)}.profile.at"
                raise DescriptionError(description.source, field, problem)


def _not_by_polynomials(basis: StrainBasis, modes: int, profile: Profile) -> str:
    """What polynomial modes cannot follow, in words; empty: nothing."""
    at, stiffness = profile.at, profile.stiffness
    for k in range(len(at) - 1):
        near = at[k + 1] - at[k] < 0.5 / modes - _ROUNDED
        if near and max(stiffness[k : k + 2]) > _JUMP * min(stiffness[k : k + 2]):
            return (
                f"the stiffness changes from {stiffness[k]:g} to {stiffness[k + 1]:g} between "
                f"{at[k]:g} and {at[k + 1]:g}, a jump to {modes} polynomial modes: write two "
                "rods in a chain"
            )
    return ""


def _not_by_splines(basis: StrainBasis, modes: int, profile: Profile) -> str:
    """What modes with knots cannot follow, in words; empty: nothing."""
    off = _bent_wrongly(basis, modes, profile)
    if off <= _SPLINES_OFF:
        return ""
    return (
        f"the stiffness changes faster than {modes} modes with these knots follow: a rod that is "
        f"bent would be {100.0 * off:.2g} % off; put knots around where it changes, or write "
        "two rods in a chain"
    )


def _bent_wrongly(basis: StrainBasis, modes: int, profile: Profile) -> float:
    """How far from where it is a rod would be that is bent, of its largest deflection.

    By one moment, or by a force on its tip, whichever is less: a soft tip in a hinge bears little.
    The curvature is the moment over the stiffness; modes take of it what leaves the least energy.
    """
    stations = (*profile.at, *basis.breakpoints, *np.linspace(0.0, 1.0, 2 * modes))
    grid = rod_grid(8, distinct_stations(stations))
    sigma, weights = grid.nodes, grid.weights
    stiffness = np.interp(sigma, profile.at, profile.stiffness)
    functions = basis.values(sigma, modes)
    energy = functions.T @ ((weights * stiffness)[:, None] * functions)

    def off(moment: Floats) -> float:
        work = functions.T @ (weights * moment)
        taken = functions @ np.linalg.lstsq(energy, work, rcond=None)[0]
        return deflection(moment / stiffness - taken) / deflection(moment / stiffness)

    def deflection(curvature: Floats) -> float:
        turned = np.cumsum(weights * curvature)
        return float(np.abs(np.cumsum(weights * turned)).max())

    return min(off(np.ones_like(sigma)), off(1.0 - sigma))


def _profiled(description: RobotDescription, number: int, rod: int) -> str:
    """Where the profile of a rod of a leg is written."""
    content: Mapping[str, Any] = {} if description.written is None else description.written.content
    leg = content.get("legs", [{}] * (number + 1))[number]
    places = [place for place, element in enumerate(leg.get("chain", ())) if "rod" in element]
    if places and "profile" in (leg["chain"][places[rod]]["rod"] or {}):
        return f"legs[{number}].chain[{places[rod]}].rod"
    return f"legs[{number}].rod" if "profile" in leg.get("rod", {}) else "rod"

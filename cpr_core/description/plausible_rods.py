# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rods of a description that look like another unit: errors where none can be meant, else warnings.

The bounds leave room for every robot that is known to be built: rods of hydrogel and of diamond, of
micrometres and of tens of metres.
"""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from ..description_part import Part
from ..rods.rod import Rod
from .other_units import MILLIMETRES
from .robot_description import RobotDescription

__all__ = ["check_rod", "check_slender"]

#: Longer rods are doubted, and refused [m].
_LONG, _LONGEST = 10.0, 100.0
#: Half the thickness of a rod that is refused, over its own length.
_THICKEST = 0.5
#: Half the thickness of a rod that is doubted, over the length of the rods of a leg: a fitting in a
#: chain may be as thick as it is long.
_NOT_SLENDER = 0.09
#: Smaller and larger moduli are refused: no solid is as soft, or as stiff [Pa].
_SOFTEST, _STIFFEST = 1e4, 2e12
#: Smaller moduli are doubted, of rods that are not light [Pa].
_SOFT = 1e6
#: Shear modulus over Young's, below and above which it is doubted: metals have 0.4, glass and carbon
#: along their fibres down to 0.02, tubes of crosswise fibres 2; metals with the two exchanged are above
#: 2.5.
_SHEARS_EASILY, _SHEARS_HARDLY = 3e-3, 2.4
#: Smaller densities are doubted: the heaviest metal has less in g/cm^3 [kg/m^3].
_LIGHTEST = 30.0
#: Rods of a smaller density are light, and may be soft [kg/m^3].
_LIGHT = 2000.0
#: Strain that no material bears linearly: spring steel yields at 0.006, carbon fibre breaks at 0.015,
#: nitinol comes back from 0.08, rubbers go farther and stiffen. In per cent the first two are above it.
_YIELDED = 0.1
#: A rod that bends by more turns at rest is a coil.
_COIL = 2.0
#: At how many places along a rod its curvature at rest is looked at.
_STATIONS = 9


def check_rod(part: Part, rod: Rod, own: Collection[str]) -> None:
    """Whether length, thickness and material can be those of a rod.

    Args:
        part: The rod in the description.
        rod: What it says.
        own: Names of the fields that stand there: what looks wrong is told where it stands, once.

    Raises:
        DescriptionError: They cannot.
    """
    if rod.length > _LONGEST:
        raise part.fail("length", f"got {rod.length:g}: {MILLIMETRES}")
    if rod.length > _LONG and "length" in own:
        part.warn("length", f"{rod.length:g} m: {MILLIMETRES}?")
    if rod.section.needs_moduli:
        _check_moduli(part, rod, own)
    _check_bent_at_rest(part, rod, own)
    section = part.part("section")
    if max(_half_extents(rod)) > _THICKEST * rod.length:
        sizes = ", ".join(f"{name} {value}" for name, value in section.content.items())
        raise section.fail("", f"got {sizes} for a rod {rod.length:g} m long: {MILLIMETRES}")
    if 0.0 < rod.density < _LIGHTEST and "density" in own:
        part.warn("density", f"{rod.density:g}: looks like g/cm^3, expected kg/m^3")
    if _YIELDED < rod.yield_strain < math.inf and "yield_strain" in own:
        part.warn(
            "yield_strain",
            f"{rod.yield_strain:g}: looks like per cent or a stress, expected a ratio, 0.01 for 1 %",
        )
    if not _can_be_computed(rod):
        raise part.fail(
            "", "expected sizes and moduli of a rod: its stiffness is beyond all numbers"
        )


def _half_extents(rod: Rod) -> list[float]:
    """Half its thickness across both directions of bending [m]; NaN where it is not known."""
    bent = np.array([1.0, 0.0])
    return rod.section.bending_strain(bent, bent[::-1]).tolist()


def _check_moduli(part: Part, rod: Rod, own: Collection[str]) -> None:
    moduli = {"young_modulus": rod.young_modulus, "shear_modulus": rod.shear_modulus}
    for name, modulus in moduli.items():
        if modulus < _SOFTEST:
            raise part.fail(name, f"got {modulus:g}: looks like GPa, expected Pa")
        if modulus > _STIFFEST:
            raise part.fail(name, f"got {modulus:g}: no material is as stiff, expected Pa")
    light = 0.0 < rod.density < _LIGHT
    soft = [name for name, modulus in moduli.items() if modulus < _SOFT and not light]
    for name in soft:
        if name in own or "density" in own:
            part.warn(name, f"{moduli[name]:g}: looks like MPa, expected Pa")
    shears = rod.shear_modulus / rod.young_modulus
    doubtful = not _SHEARS_EASILY < shears < _SHEARS_HARDLY
    if doubtful and not soft and not moduli.keys().isdisjoint(own):
        part.warn(
            "shear_modulus" if "shear_modulus" in own else "young_modulus",
            f"the shear modulus {rod.shear_modulus:g} is {shears:.2g} of Young's, "
            f"{rod.young_modulus:g}, expected both in Pa: metals have 0.4 (or the other way round?)",
        )


def _check_bent_at_rest(part: Part, rod: Rod, own: Collection[str]) -> None:
    """Whether curvatures at rest are in 1/m: they coil no rod, though a strip may be twisted far."""
    bent = np.hypot(*rod.rest_curvature_at(np.linspace(0.0, 1.0, _STATIONS)).T[1:])
    turns = float(bent.max()) * rod.length / (2.0 * math.pi)
    if turns > _COIL and ("rest_curvature" in own or "length" in own):
        part.warn(
            "rest_curvature",
            f"{bent.max():g} 1/m coil a rod of {rod.length:g} m by {turns:.3g} turns: looks like "
            "degrees per metre, or a radius in millimetres, expected 1/m",
        )


def _can_be_computed(rod: Rod) -> bool:
    """Whether stiffness, its natural units and the weight are numbers a computer can work with."""
    try:
        scales = [
            rigidity * rod.length**power
            for rigidity in rod.rigidities
            for power in (-3, -2, -1, 0, 1)
        ]
        mass = rod.mass_per_length * rod.length
    except OverflowError:
        return False
    return all(1e-100 < scale < 1e100 for scale in scales) and mass < 1e100


def check_slender(part: Part, description: RobotDescription) -> None:
    """Whether all rods are thin beside their legs, to one side at least: a strip may be wide."""
    longest = max(leg.rod_length for leg in description.legs)
    for index, leg in enumerate(description.legs):
        for half in (min(_half_extents(element.rod)) for element in leg.rods):
            if half >= _NOT_SLENDER * longest:
                thick = f"a rod {2.0 * half:g} m thick, where legs have {longest:g} m of rods"
                part.warn(f"legs[{index}]", f"{thick}: {MILLIMETRES}?")
                return

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rods and their strain modes, from their parts of a description."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from ..description_part import Part
from ..rods.rod import DIRECTIONS, UNIFORM, Profile, Rod, StrainModes, strain_series
from ..rods.sections import SECTIONS
from ..rods.strain_basis import STRAIN_BASES
from .chain import ChainRod
from .description_schema import DEFAULT_BASIS
from .leg_description import LegDescription, described_motors
from .plausible_rods import check_rod

__all__ = [
    "check_fed",
    "described_modes",
    "described_rod",
    "described_tolerance",
    "lacking_modes",
]

_DEFAULT_MODES = 5


def described_rod(part: Part, own: Collection[str] | None = None) -> Rod:
    """A rod, of all legs or of one.

    Args:
        part: The rod in the description, with all its fields.
        own: Names of those that stand there and not where others are described; default all.
    """
    section_part = part.part("section")
    section = SECTIONS[section_part.get("shape")].from_description(section_part)
    material = _material(part) if section.needs_moduli else {}
    rest = part.get("rest_curvature", {})
    if part.planar and (rest.get("torsion") or rest.get("bending_2")):
        raise part.fail("rest_curvature", "a planar rod is curved about d3 only")
    rod = Rod(
        length=part.number("length"),
        section=section,
        profile=_profile(part.part("profile")) if "profile" in part else UNIFORM,
        rest_curvature=strain_series(rest),
        yield_strain=part.number("yield_strain", np.inf),
        **material,
    )
    if "yield_strain" in part and np.isnan(section.bending_strain(np.ones(1), np.ones(1))[0]):
        raise section_part.fail("", "missing field 'outer_radius': it has a yield_strain")
    check_rod(part, rod, part.content if own is None else own)
    return rod


def _material(part: Part) -> dict[str, float]:
    """What a section makes stiffness and mass of; read where it does, for what is read can be varied."""
    moduli = {name: part.number(name) for name in ("young_modulus", "shear_modulus")}
    return moduli | {"density": part.number("density", 0.0)}


def lacking_modes(element: ChainRod) -> str:
    """What a fed rod that is curved at rest lacks, in words; empty if nothing."""
    pairs = zip(DIRECTIONS, element.uncoils, element.modes.counts, strict=True)
    missing = ", ".join(name for name, uncoils, count in pairs if uncoils and not count)
    if not missing:
        return ""
    return (
        f"the rod fed by {element.motor} is curved at rest: expected strain modes of {missing} too"
    )


def check_fed(part: Part, legs: Sequence[LegDescription]) -> None:
    """Whether rods that motors feed have a length wherever these may go, and the modes they need.

    Raises:
        DescriptionError: One has none.
    """
    chosen = "tolerance" in part.part("strain")
    limits = {motor.name: motor.limits for motor in described_motors(legs)}
    for number, leg in enumerate(legs):
        for element in leg.rods:
            if element.motor is None:
                continue
            if (problem := lacking_modes(element)) and not chosen:
                raise part.fail(f"legs[{number}]", problem)
            for position in (limits[element.motor].lower, limits[element.motor].upper):
                if math.isfinite(position) and (length := element.length_at(position)) <= 0.0:
                    at = "" if length == position else f" at {position:g}"
                    problem = f"expected a positive length, got {length:g}{at} of {element.motor}"
                    chain = "chain" in part.content["legs"][number]
                    where = "chain" if chain else "motor.limits.position"
                    raise part.fail(f"legs[{number}].{where}", problem)


def _profile(part: Part) -> Profile:
    """How a rod varies along its length."""
    at = part.stations("at")
    factors = []
    for name in ("stiffness", "mass"):
        given = part.get(name, [1.0] * len(at))
        if len(given) != len(at):
            raise part.fail(name, f"expected {len(at)} numbers, one per station, got {len(given)}")
        factors.append(np.array(given, float))
    return Profile(at, *factors)


def described_modes(part: Part) -> StrainModes:
    """The strain modes."""
    basis = STRAIN_BASES[part.get("basis", DEFAULT_BASIS)].from_description(part)
    most = _DEFAULT_MODES if basis.modes is None else basis.modes
    default = dict.fromkeys(DIRECTIONS, most) | {"torsion": 0}
    if part.planar:
        default["bending_2"] = 0
    # 5.0 is a whole number in JSON
    torsion, bending_2, bending_3 = (int(part.get(name, default[name])) for name in DIRECTIONS)
    counts = (torsion, bending_2, bending_3)
    if part.planar and (torsion or bending_2):
        raise part.fail("", "a planar robot bends about d3 only: expected bending_3")
    if not any(counts):
        raise part.fail("", "expected at least one mode")
    if basis.modes is not None and any(count not in (0, most) for count in counts):
        problem = f"expected {most} or 0 modes with this degree and these knots, got {counts}"
        raise part.fail("", problem)
    return StrainModes(counts, basis)


def described_tolerance(part: Part) -> float:
    """The error of the platform position for which modes are to be chosen; infinite without [m].

    Args:
        part: The whole description.

    Raises:
        DescriptionError: There are numbers of modes too, or the basis has its own.
    """
    own = [leg.part("strain") for leg in part.parts("legs")]
    own += [rod.part("strain") for leg in part.parts("legs") for rod in leg.parts("chain")]
    for strain in own:
        if "tolerance" in strain:
            raise strain.fail(
                "tolerance", "expected it in the robot's strain: it is the platform's"
            )
    shared = part.part("strain")
    if "tolerance" not in shared:
        return float(np.inf)
    for strain in (shared, *own):
        for name in (*DIRECTIONS, "knots", "degree"):
            if name in strain:
                raise strain.fail(
                    name, "expected no number of modes: the robot's strain.tolerance chooses them"
                )
        if STRAIN_BASES[strain.get("basis", DEFAULT_BASIS)].from_description(strain).modes:
            raise strain.fail("basis", "expected one that has any number of modes: see tolerance")
    return shared.number("tolerance")

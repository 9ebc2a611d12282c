# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Cross-sections of rods: what they make of a material, about (d1, d2, d3).

A new section is one class, which reads its own part of a description, and its name in ``SECTIONS``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ..description_part import Described, Part, field

__all__ = [
    "SECTIONS",
    "AnnularSection",
    "CircularSection",
    "GivenSection",
    "RectangularSection",
    "Section",
]

Floats = NDArray[np.float64]

#: Sum of 1 / n^5 over odd n: (1 - 2^-5) zeta(5).
_ODD_FIFTH_POWERS = 31.0 / 32.0 * 1.0369277551433699


class Section(Described):
    """What a rod needs to know of its cross-section.

    Attributes:
        needs_moduli: Whether its stiffness follows from Young's and the shear modulus, its mass from the
            density.
    """

    needs_moduli: ClassVar[bool] = True

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """One whose fields are its numbers."""
        return cls(**{name: part.number(name) for name in cls.fields if name in part})

    def rigidities(self, young_modulus: float, shear_modulus: float) -> tuple[float, float, float]:
        """G J1, E J2, E J3 of Eq. (6) [N m^2]."""
        raise NotImplementedError

    def mass_per_length(self, density: float) -> float:
        """Mass per length, rho A [kg/m]."""
        raise NotImplementedError

    def bending_strain(self, bending_2: Floats, bending_3: Floats) -> Floats:
        """Largest strain across the section for curvatures about d2 and d3 [1/m]; dimensionless."""
        raise NotImplementedError

    @property
    def tapered(self) -> bool:
        """Whether its size changes along the rod."""
        return False

    def scale(self, sigma: Floats) -> Floats:
        """Size at s/l relative to the one where the rod begins, all lengths alike, (len(sigma),)."""
        return np.ones(len(sigma))


class _Solid(Section):
    """A section that is its area and second moments."""

    @property
    def area(self) -> float:
        """Area [m^2]."""
        raise NotImplementedError

    @property
    def second_moments(self) -> tuple[float, float, float]:
        """Torsion constant J_1 and second moments J_2, J_3 [m^4]."""
        raise NotImplementedError

    def rigidities(self, young_modulus: float, shear_modulus: float) -> tuple[float, float, float]:
        """G J1, E J2, E J3 [N m^2]."""
        torsion, bending_2, bending_3 = self.second_moments
        return shear_modulus * torsion, young_modulus * bending_2, young_modulus * bending_3

    def mass_per_length(self, density: float) -> float:
        """Density times area [kg/m]."""
        return density * self.area


@dataclass(frozen=True)
class CircularSection(_Solid):
    """Solid circle, the same all along or a cone.

    Attributes:
        radius: Radius where the rod begins [m].
        end_radius: Radius where it ends, linear between; None: the same [m].
    """

    radius: float
    end_radius: float | None = None
    fields: ClassVar[Mapping[str, Any]] = {
        "radius": {
            "if": {"type": "array", "minItems": 2},
            "then": {"items": {"$ref": "#/$defs/positive"}, "maxItems": 2},
            "else": {"$ref": "#/$defs/positive"},
            "description": "a number, or [where the rod begins, where it ends], linear between [m]",
        }
    }
    required = ("radius",)

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """One radius, or two."""
        radius = part.get("radius")
        return cls(*map(float, radius)) if isinstance(radius, list) else cls(float(radius))

    @property
    def tapered(self) -> bool:
        """Whether it is a cone."""
        return self.end_radius not in (None, self.radius)

    def scale(self, sigma: Floats) -> Floats:
        """Linear."""
        end = self.radius if self.end_radius is None else self.end_radius
        return 1.0 + (end / self.radius - 1.0) * sigma

    @property
    def area(self) -> float:
        """Area [m^2]."""
        return math.pi * self.radius**2

    @property
    def second_moments(self) -> tuple[float, float, float]:
        """J_1 = pi r^4 / 2, J_2 = J_3 = pi r^4 / 4."""
        bending = 0.25 * math.pi * self.radius**4
        return 2.0 * bending, bending, bending

    def bending_strain(self, bending_2: Floats, bending_3: Floats) -> Floats:
        """At the outer radius, where the rod begins."""
        return np.asarray(self.radius * np.hypot(bending_2, bending_3))


@dataclass(frozen=True)
class AnnularSection(_Solid):
    """Tube.

    Attributes:
        radius: Outer radius [m].
        inner_radius: Inner radius, smaller [m].
    """

    radius: float
    inner_radius: float
    fields: ClassVar[Mapping[str, Any]] = {
        "radius": field("positive", "outer [m]"),
        "inner_radius": field("positive", "[m]"),
    }
    required = ("radius", "inner_radius")

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """Both radii."""
        outer, inner = part.number("radius"), part.number("inner_radius")
        if inner >= outer:
            problem = f"expected less than the radius {outer}, got {inner}"
            raise part.fail("inner_radius", problem)
        return cls(outer, inner)

    @property
    def area(self) -> float:
        """Area [m^2]."""
        return math.pi * (self.radius**2 - self.inner_radius**2)

    @property
    def second_moments(self) -> tuple[float, float, float]:
        """Outer circle minus inner circle."""
        bending = 0.25 * math.pi * (self.radius**4 - self.inner_radius**4)
        return 2.0 * bending, bending, bending

    def bending_strain(self, bending_2: Floats, bending_3: Floats) -> Floats:
        """At the outer radius."""
        return np.asarray(self.radius * np.hypot(bending_2, bending_3))


@dataclass(frozen=True)
class RectangularSection(_Solid):
    """Solid rectangle (a strip).

    Attributes:
        width: Extent along d2 [m].
        height: Extent along d3 [m].
    """

    width: float
    height: float
    fields: ClassVar[Mapping[str, Any]] = {
        "width": field("positive", "along d2 [m]"),
        "height": field("positive", "along d3 [m]"),
    }
    required = ("width", "height")

    @property
    def area(self) -> float:
        """Area [m^2]."""
        return self.width * self.height

    @property
    def second_moments(self) -> tuple[float, float, float]:
        """J_2 = w h^3 / 12, J_3 = h w^3 / 12, and Saint-Venant's torsion constant as its series.

        Its terms tanh(n pi a / 2 b) / n^5, n odd, are taken from 1 / n^5, whose sum is known: what is
        left of them falls exponentially.
        """
        long, short = max(self.width, self.height), min(self.width, self.height)
        left = (
            2.0 / (math.exp(odd * math.pi * long / short) + 1.0) / odd**5
            for odd in range(1, 14, 2)
            if odd * long < 200.0 * short  # beyond there is nothing, but for an overflow
        )
        series = _ODD_FIFTH_POWERS - sum(left)
        torsion = long * short**3 / 3.0 * (1.0 - 192.0 / math.pi**5 * short / long * series)
        return torsion, self.width * self.height**3 / 12.0, self.height * self.width**3 / 12.0

    def bending_strain(self, bending_2: Floats, bending_3: Floats) -> Floats:
        """At a corner."""
        return np.asarray(
            0.5 * self.height * np.abs(bending_2) + 0.5 * self.width * np.abs(bending_3)
        )


@dataclass(frozen=True)
class GivenSection(Section):
    """Measured stiffnesses in place of a shape.

    Attributes:
        torsion: G J1 [N m^2].
        bending_2: E J2 [N m^2].
        bending_3: E J3 [N m^2].
        mass: Mass per length [kg/m].
        outer_radius: Distance of the outermost fibre from the centre line [m]; 0 if not known.
    """

    torsion: float
    bending_2: float
    bending_3: float
    mass: float = 0.0
    outer_radius: float = 0.0
    fields: ClassVar[Mapping[str, Any]] = {
        "torsion": field("positive", "G J1 [N m^2]"),
        "bending_2": field("positive", "E J2 [N m^2]"),
        "bending_3": field("positive", "E J3 [N m^2]"),
        "mass": field("not_negative", "per length [kg/m]; default 0"),
        "outer_radius": field(
            "positive", "distance of the outermost fibre [m]; strains are not known without it"
        ),
    }
    required = ("torsion", "bending_2", "bending_3")
    needs_moduli = False

    def rigidities(self, young_modulus: float, shear_modulus: float) -> tuple[float, float, float]:
        """As given; the moduli are not used."""
        return self.torsion, self.bending_2, self.bending_3

    def mass_per_length(self, density: float) -> float:
        """As given."""
        return self.mass

    def bending_strain(self, bending_2: Floats, bending_3: Floats) -> Floats:
        """At the outer radius; NaN without one."""
        return np.asarray((self.outer_radius or np.nan) * np.hypot(bending_2, bending_3))


#: Sections by the name used in descriptions.
SECTIONS: dict[str, type[Section]] = {
    "circular": CircularSection,
    "annular": AnnularSection,
    "rectangular": RectangularSection,
    "given": GivenSection,
}

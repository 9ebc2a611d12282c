# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shape functions of the assumed strain modes, on the normalised arc length sigma in [0, 1]."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, Self

import numpy as np
import scipy
from numpy.typing import NDArray

from ..description_part import Described, Part
from ..errors import CprError

__all__ = [
    "STRAIN_BASES",
    "BSplines",
    "Chebyshev",
    "DescribedBasis",
    "Legendre",
    "Monomials",
    "StrainBasis",
]


class StrainBasis(Protocol):
    """One row Phi_j of the strain function matrix, Eq. (4).

    A user's own basis needs only these two members. One that descriptions can name is a class made
    from ``DescribedBasis``, and its name in ``STRAIN_BASES``.
    """

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Interior sigma where the functions are not smooth; quadrature panels end there."""
        ...

    def values(self, sigma: NDArray[np.float64], modes: int) -> NDArray[np.float64]:
        """Values of the first ``modes`` functions, shape (len(sigma), modes)."""
        ...


class DescribedBasis(Described):
    """A basis with a name in descriptions."""

    @property
    def modes(self) -> int | None:
        """Number of functions where the basis itself says how many; None: as many as one likes."""
        return None

    def refined(self) -> DescribedBasis:
        """A basis of which the functions of this one are combinations, richer if this one is bounded."""
        return self

    def polynomials(self, modes: int) -> int:
        """Polynomials of how many coefficients are combinations of the first ``modes`` functions."""
        return modes

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Interior sigma where the functions are not smooth; none unless said otherwise."""
        return ()

    def values(self, sigma: NDArray[np.float64], modes: int) -> NDArray[np.float64]:
        """Values of the first ``modes`` functions, shape (len(sigma), modes)."""
        raise NotImplementedError

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """One without fields of its own."""
        return cls()


@dataclass(frozen=True)
class Legendre(DescribedBasis):
    """Legendre polynomials P_k(2 sigma - 1): orthogonal, the paper's choice."""

    def values(self, sigma: NDArray[np.float64], modes: int) -> NDArray[np.float64]:
        """Values of P_0 ... P_{modes-1}, shape (len(sigma), modes)."""
        return _polynomials(
            lambda k: ((2.0 * k - 1.0) / k, (k - 1.0) / k), 2.0 * sigma - 1.0, modes
        )


@dataclass(frozen=True)
class Chebyshev(DescribedBasis):
    """Chebyshev polynomials of the first kind T_k(2 sigma - 1)."""

    def values(self, sigma: NDArray[np.float64], modes: int) -> NDArray[np.float64]:
        """Values of T_0 ... T_{modes-1}, shape (len(sigma), modes)."""
        return _polynomials(lambda k: (2.0, 1.0), 2.0 * sigma - 1.0, modes)


@dataclass(frozen=True)
class Monomials(DescribedBasis):
    """Monomials sigma^k: simple, but ill-conditioned beyond about ten."""

    def values(self, sigma: NDArray[np.float64], modes: int) -> NDArray[np.float64]:
        """Values of 1, sigma, ..., sigma^(modes-1), shape (len(sigma), modes)."""
        return np.asarray(sigma[:, None] ** np.arange(modes))

    def refined(self) -> Legendre:
        """The same space for as many functions, with functions that stay far from each other."""
        return Legendre()


@dataclass(frozen=True)
class BSplines(DescribedBasis):
    """Clamped B-splines of a degree, with given interior knots.

    Attributes:
        degree: Polynomial degree.
        knots: Interior knots in (0, 1), increasing; there are ``len(knots) + degree + 1`` modes.
    """

    degree: int = 3
    knots: tuple[float, ...] = (0.5,)
    fields: ClassVar[Mapping[str, Any]] = {
        "degree": {
            "type": "integer",
            "minimum": 0,
            "maximum": 9,
            "description": "polynomial degree; default 3",
        },
        "knots": {
            "type": "array",
            "items": {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1},
            "description": "interior knots s/l, increasing; default [0.5]",
        },
    }

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """Degree and knots."""
        knots = tuple(float(knot) for knot in part.get("knots", (0.5,)))
        if list(knots) != sorted(set(knots)):
            raise part.fail("knots", f"expected increasing numbers, got {list(knots)}")
        return cls(int(part.get("degree", 3)), knots)

    @property
    def modes(self) -> int:
        """Number of B-splines."""
        return len(self.knots) + self.degree + 1

    def polynomials(self, modes: int) -> int:
        """Those up to the degree; none where there are no modes."""
        return min(modes, self.degree + 1)

    def refined(self) -> BSplines:
        """With a knot in the middle of every interval."""
        ends = np.array([0.0, *self.knots, 1.0])
        return replace(self, knots=tuple(sorted([*self.knots, *(0.5 * (ends[1:] + ends[:-1]))])))

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The interior knots."""
        return self.knots

    def values(self, sigma: NDArray[np.float64], modes: int) -> NDArray[np.float64]:
        """Values of all B-splines, shape (len(sigma), modes)."""
        if modes == 0:
            return np.zeros((len(sigma), 0))
        if modes != self.modes:
            raise CprError(
                f"a B-spline basis of degree {self.degree} with {len(self.knots)} interior knots "
                f"has {self.modes} modes, not {modes}"
            )
        ends = self.degree + 1
        knots = np.concatenate([np.zeros(ends), self.knots, np.ones(ends)])
        inside = np.clip(sigma, 0.0, 1.0)
        design = scipy.interpolate.BSpline.design_matrix(inside, knots, self.degree)
        return design.toarray()


def _polynomials(
    factors: Callable[[int], tuple[float, float]], argument: NDArray[np.float64], modes: int
) -> NDArray[np.float64]:
    """Values of 1, x and whatever follows by ``p_k = a_k x p_{k-1} - b_k p_{k-2}``."""
    # At a single place, where the literal procedure asks, with numbers: arrays take five times as long.
    single = len(argument) == 1
    at: Any = argument.item() if single else argument
    rows = [1.0 if single else np.ones(len(argument)), at]
    for k in range(2, modes):
        by_last, by_before = factors(k)
        rows.append(by_last * at * rows[-1] - by_before * rows[-2])
    return np.ascontiguousarray(np.array(rows[:modes], float).reshape(modes, len(argument)).T)


#: Bases by the name used in descriptions.
STRAIN_BASES: dict[str, type[DescribedBasis]] = {
    "legendre": Legendre,
    "chebyshev": Chebyshev,
    "monomials": Monomials,
    "bsplines": BSplines,
}

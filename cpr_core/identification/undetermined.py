# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What measurements tell of parameters, and what to call changes that none of them sees."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

__all__ = [
    "Knowledge",
    "hidden_parameters",
    "knowledge",
    "parameter_sizes",
    "unseen_directions",
    "unseen_in_words",
]

Floats = NDArray[np.float64]

#: Singular values below this times the largest are those of rounding.
_UNSEEN = 1e-7
#: Standard deviations by which what is compared has to change where parameters change by their sizes.
#: Less leaves them uncertain by a thousand sizes: no robot differs so much from what is described, and
#: noise alone would say how much. Rounding of equilibria, where nothing else is seen, is some 1e-8 for
#: positions to a millimetre.
_SHOWN = 1e-3
#: Coefficients below this are rounding: what is kept would follow the parameters that are found.
_ROUNDED = 1e-9
#: Coefficient of a direction above which a parameter is in it, whatever else is known of it; and one
#: below which it is not, as far as directions are known at all.
_IN, _NOTHING = 1e-3, 1e-5


@dataclass(frozen=True, eq=False)
class Knowledge:
    """What measurements tell of parameters in natural units, to first order.

    Attributes:
        unseen: Directions in which nothing that is compared changes, orthonormal rows (K, P).
        sizes: How far parameters may be from what is described, (P,).
        spread: Times its transpose the covariance of what is seen, (P, P - K).
    """

    unseen: Floats
    sizes: Floats
    spread: Floats

    def covariance(self, variance: float = 1.0) -> Floats:
        """Covariance of the parameters, (P, P); infinite where they are hidden, and zero beside it.

        Args:
            variance: Of residuals in standard deviations.
        """
        found: Floats = variance * self.spread @ self.spread.T
        deviations = np.sqrt(np.diag(found))
        for column in np.flatnonzero(hidden_parameters(self.unseen, self.sizes, deviations)):
            found[column] = found[:, column] = 0.0
            found[column, column] = np.inf
        return found


def knowledge(rates: Floats, sizes: Floats) -> Knowledge:
    """What is told by rates of what is compared; arguments as in :func:`unseen_directions`."""
    unseen = unseen_directions(rates, sizes)
    seen = scipy.linalg.null_space(unseen) if len(unseen) else np.eye(len(sizes))
    spread = np.zeros_like(seen)
    if seen.size:
        upper = scipy.linalg.qr(rates @ seen, mode="r")[0][: seen.shape[1]]
        spread = seen @ scipy.linalg.inv(upper)
    return Knowledge(unseen, sizes, spread)


def unseen_directions(rates: Floats, sizes: Floats | float = 1.0) -> Floats:
    """Directions in which nothing that is compared changes, orthonormal rows (K, P).

    Args:
        rates: Derivatives of what is compared, in standard deviations, by parameters in natural units,
            (M, P).
        sizes: How far parameters may be from what is described, in natural units, (P,).
    """
    _, some, rows = scipy.linalg.svd(rates, full_matrices=True)
    values = np.zeros(len(rows))
    values[: len(some)] = some
    shown = values * np.linalg.norm(rows * sizes, axis=1)
    seen = (values > _UNSEEN * values.max(initial=0.0)) & (shown > _SHOWN)
    found: Floats = np.where(np.abs(rows[~seen]) < _ROUNDED, 0.0, rows[~seen])
    return found


def parameter_sizes(values: Floats, scales: Floats) -> Floats:
    """Natural units of parameters, or their values where these are larger, in natural units, (P,)."""
    found: Floats = np.maximum(1.0, np.abs(values / scales))
    return found


def hidden_parameters(directions: Floats, sizes: Floats, deviations: Floats) -> NDArray[np.bool_]:
    """Which parameters are not determined as they are in a direction that nothing shows, (P,).

    A small part of one counts where the direction may go so far that the parameter moves by more than
    it is uncertain otherwise: a force of a thousandth of its natural unit may be known as its ratio to
    Young's modulus only.

    Args:
        directions: Orthonormal rows (K, P).
        sizes: How far parameters may be from what is described, in natural units, (P,).
        deviations: Standard deviations of the parameters without the directions, in natural units, (P,).
    """
    parts = np.abs(directions)
    farthest = np.divide(sizes, parts, out=np.full_like(parts, np.inf), where=parts > _NOTHING)
    moved = parts * farthest.min(axis=1, initial=np.inf)[:, None]
    found = (parts > _IN) | ((parts > _NOTHING) & (moved > deviations))
    return np.asarray(found.any(axis=0))


def unseen_in_words(
    directions: Floats,
    hidden: NDArray[np.bool_],
    scales: Floats,
    paths: Sequence[str],
    values: Floats,
) -> tuple[str, ...]:
    """What directions mean, one line each.

    Args:
        directions: Changes of the parameters that nothing shows, in natural units, rows (K, P).
        hidden: Which parameters they leave undetermined, (P,).
        scales: The natural units, (P,).
        paths: Names of the parameters.
        values: Of the parameters.
    """
    if not len(directions):
        return ()
    # As few parameters as possible in each: one is only in the first line, another in the second ...
    _, upper, order = scipy.linalg.qr(directions, mode="economic", pivoting=True)
    count = len(directions)
    rows = np.zeros((count, len(paths)))
    rows[:, order] = scipy.linalg.solve_triangular(upper[:, :count], upper)
    slight = np.abs(directions).max(axis=0) <= _IN
    rows[np.abs(rows) < np.where(hidden, np.where(slight, _NOTHING, _IN), np.inf)] = 0.0
    return tuple(_in_words(row * scales, paths, values) for row in rows)


def _place(path: str) -> bool:
    """Whether a parameter is a place, a turn or a zero: sums and differences of these mean something.

    Where they are as large as each other those look like products and ratios, to first order.
    """
    return re.search(r"(position|rotation_vector|offset)(\[[0-9,*]+\])*\Z", path) is not None


def _in_words(change: Floats, paths: Sequence[str], values: Floats) -> str:
    """A direction in words."""
    places = np.flatnonzero(change)
    if len(places) == 1:
        return f"{paths[places[0]]} is not determined"
    first = places[0]
    if len(places) == 2 and values[places].all() and not any(map(_place, np.take(paths, places))):
        last = places[1]
        relative = change[places] / values[places]
        power = relative[0] / relative[1]
        if abs(power - 1.0) < 0.01:
            return f"{paths[first]} and {paths[last]} are determined only as their ratio"
        if abs(power + 1.0) < 0.01:
            return f"{paths[first]} and {paths[last]} are determined only as their product"
    size = np.abs(change[places]).max()
    terms = ", ".join(f"{paths[place]} by {change[place] / size:+.3g}" for place in places)
    return f"not determined, as nothing shows it when these change together: {terms}"

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Continuous Kirchhoff rods and their variations, integrated along the arc length.

The equations, with the order of a state, are in ``rod_equations``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853

from ..validation import cached_property
from .rod_equations import COLUMNS, EFFORT, FIRST, LENGTH, SIZE, runge_kutta_steps

__all__ = [
    "EIGHTH_ORDER",
    "STEPS",
    "RodProperties",
    "RodTables",
    "RodTrajectory",
    "Start",
    "Tableau",
    "UniformProperties",
    "force",
    "frame",
    "integrate",
    "integrate_part",
    "length_variation",
    "moment",
    "position",
    "transition",
    "transitions",
    "uniform",
]

Floats = NDArray[np.float64]
#: Position [m], frame, internal moment [N m] and force [N], in the world: (3,), (3, 3), (3,), (3,).
Start = tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike]


class Tableau(NamedTuple):
    """Explicit Runge-Kutta method: inner weights (S, S) and outer weights (S,)."""

    inner: Floats
    outer: Floats


#: Dormand and Prince.
EIGHTH_ORDER = Tableau(
    np.ascontiguousarray(DOP853.A[: DOP853.n_stages, : DOP853.n_stages]),
    np.ascontiguousarray(DOP853.B),
)

#: Steps along a rod. Halving them changes no tip by more than 1e-12 lengths on the paper's paths.
STEPS = 64


@dataclass(frozen=True, eq=False)
class RodProperties:
    """A rod along sigma = s/l; every function takes (K,) and gives (K, 3).

    Attributes:
        compliance: Inverse of H_a = diag(G J1, E J2, E J3) [1/(N m^2)].
        rest_curvature: Strain at rest (torsion, bending about d2, d3) [1/m].
        force: Force per length, fixed in the world [N/m].
    """

    compliance: Callable[[Floats], Floats]
    rest_curvature: Callable[[Floats], Floats]
    force: Callable[[Floats], Floats]

    def tables(self, begin: float, end: float, steps: int, tableau: Tableau) -> RodTables:
        """What the integrator needs of the part from ``begin`` to ``end`` (sigma)."""
        step = (end - begin) / steps
        inner = tableau.inner.sum(axis=1)
        sigma = begin + step * (np.arange(steps)[:, None] + inner)

        def sampled(function: Callable[[Floats], Floats]) -> Floats:
            return np.ascontiguousarray(function(sigma.ravel())).reshape(*sigma.shape, 3)

        properties = (self.compliance, self.rest_curvature, self.force)
        compliance, rest, force_per_length = map(sampled, properties)
        return RodTables(begin, step, compliance, rest, force_per_length, tableau)


class RodTables(NamedTuple):
    """Properties of a part of a rod, at all stages of all steps."""

    begin: float
    step: float
    compliance: Floats
    rest_curvature: Floats
    force: Floats
    tableau: Tableau


class UniformProperties(RodProperties):
    """A rod that is the same all along; no function has to be asked everywhere."""

    def tables(self, begin: float, end: float, steps: int, tableau: Tableau) -> RodTables:
        """What the integrator needs of the part from ``begin`` to ``end`` (sigma)."""
        compliance, rest, force_per_length = self._everywhere
        shape = steps, len(tableau.outer), 3
        return RodTables(
            begin,
            (end - begin) / steps,
            np.full(shape, compliance),
            np.full(shape, rest),
            np.full(shape, force_per_length),
            tableau,
        )

    @cached_property
    def _everywhere(self) -> tuple[Floats, Floats, Floats]:
        begin = np.zeros(1)
        return self.compliance(begin)[0], self.rest_curvature(begin)[0], self.force(begin)[0]


def uniform(rigidities: ArrayLike, distributed: ArrayLike) -> RodProperties:
    """A rod that is the same all along, straight at rest.

    Args:
        rigidities: H_a, (3,) [N m^2].
        distributed: Force per length, fixed in the world, (3,) [N/m].
    """
    compliance, force = 1.0 / np.array(rigidities, float), np.array(distributed, float)
    return UniformProperties(
        lambda sigma: np.full((len(sigma), 3), compliance),
        lambda sigma: np.zeros((len(sigma), 3)),
        lambda sigma: np.full((len(sigma), 3), force),
    )


@dataclass(frozen=True, eq=False)
class RodTrajectory:
    """An integrated rod, or a part of one.

    Attributes:
        properties: The rod.
        length: Length l [m]; negative from the tip to the base.
        tables: The part and its steps.
        states: Node by node position, frame (rows), moment, force, effort (c) and the columns of the
            variations, in the world, (steps + 1, 175).
    """

    properties: RodProperties
    length: float
    tables: RodTables
    states: Floats = field(repr=False)

    @property
    def part_length(self) -> float:
        """Length of the part [m]."""
        return abs(self.length * self.tables.step) * (len(self.states) - 1)

    def at(self, fraction: float) -> Floats:
        """State a fraction of the part from the start, (175,), by one step from the node before."""
        place = fraction * (len(self.states) - 1)
        node = min(int(place), len(self.states) - 1)
        rest = place - node
        if rest == 0.0:
            return self.states[node]
        begin = self.tables.begin + node * self.tables.step
        end = begin + rest * self.tables.step
        tables = self.properties.tables(begin, end, 1, self.tables.tableau)
        return _integrated(self.states[node], self.length, tables, position(self.states[0]))[1]


def position(state: Floats) -> Floats:
    """Position in the world, (3,) [m]."""
    return state[:3]


def frame(state: Floats) -> Floats:
    """Cross-section frame in the world, (3, 3); columns d1 (tangent), d2, d3."""
    return state[3:12].reshape(3, 3)


def moment(state: Floats) -> Floats:
    """Internal moment in the world, (..., 3) [N m], of states (..., 175)."""
    return state[..., 12:15]


def force(state: Floats) -> Floats:
    """Internal force in the world, (3,) [N]."""
    return state[15:18]


def transition(state: Floats) -> Floats:
    """Transition matrix of (b) for (dp, dtheta, dm, dn) from the start of the rod, (12, 12)."""
    return transitions(state[None])[0]


def transitions(states: Floats) -> Floats:
    """The same of many states, (..., 175): (..., 12, 12)."""
    matrices = np.zeros((*states.shape[:-1], 12, 12))
    matrices[..., range(3), range(3)] = 1.0
    columns = states[..., FIRST:].reshape(*states.shape[:-1], 13, COLUMNS)
    matrices[..., 3:] = columns[..., :12, :9]
    return matrices


class LengthVariation(NamedTuple):
    """What a change of the length does, and the effort that feeds the rod."""

    column: Floats  # of (dp, dtheta, dm, dn), (12,)
    effort: float  # [N]
    row: Floats  # of the effort by (dtheta, dm, dn) at the start, (9,)
    stiffness: float  # of the effort by the length [N/m]


def length_variation(state: Floats) -> LengthVariation:
    """Variation of the length from the start of the rod to a state; the position there is held."""
    columns = state[FIRST:].reshape(13, COLUMNS)
    return LengthVariation(
        columns[:12, LENGTH], float(state[EFFORT]), columns[12, :9], float(columns[12, LENGTH])
    )


def integrate(
    start: Start,
    length: float,
    rigidities: ArrayLike,
    distributed: ArrayLike,
    steps: int = STEPS,
) -> RodTrajectory:
    """Integrate a uniform rod, straight at rest, and its variations.

    Args:
        start: State at the start.
        length: Arc length [m]; negative from the tip to the base.
        rigidities: H_a, (3,) [N m^2].
        distributed: Force per length, fixed in the world, (3,) [N/m].
        steps: Number of steps.
    """
    properties = uniform(rigidities, distributed)
    return integrate_part(
        start, properties, length, properties.tables(0.0, 1.0, steps, EIGHTH_ORDER)
    )


def integrate_part(
    start: Start,
    properties: RodProperties,
    length: float,
    tables: RodTables,
    origin: ArrayLike | None = None,
) -> RodTrajectory:
    """Integrate a part of a rod and its variations, (a) to (c).

    Args:
        start: State at the start of the part.
        properties: The rod.
        length: Length l of the whole rod [m].
        tables: Its properties on the part.
        origin: p_0 of (c), (3,) [m]; default the start.
    """
    first = np.zeros(SIZE)
    first[:EFFORT] = np.concatenate([np.ravel(part) for part in start])
    first[FIRST:].reshape(13, COLUMNS)[3:12, :9] = np.eye(9)
    place = first[:3] if origin is None else np.array(origin, float)
    return RodTrajectory(properties, length, tables, _integrated(first, length, tables, place))


def _integrated(first: Floats, length: float, tables: RodTables, origin: Floats) -> Floats:
    _, step, compliance, rest, force_per_length, tableau = tables
    states = np.empty((len(compliance) + 1, len(first)))
    states[0] = first
    runge_kutta_steps(
        states, step, length, compliance, rest, force_per_length, np.array(origin), *tableau
    )
    return states

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Continuous Kirchhoff rods and their variations, integrated along the arc length.

The rods obey, in the world frame, with the tangent t = R e_1, the compliance W = R H_a^-1 R^T and the
curvature k = W m + R kappa_rest,

    p' = t,   R' = k^ R,   m' = -t x n,   n' = -fbar                                     (a)

where (m, n) is the wrench the part beyond s exerts on the part before it. Small variations, with
dtheta the rotation in the world, obey

    dp' = dtheta x t,   dtheta' = W (dm - dtheta x m),
    dm' = -(dtheta x t) x n - t x dn,   dn' = 0                                          (b)

Stiffness, rest curvature and force per length are functions of sigma = s/l. So the length l of a rod
that is fed by a motor is one more variation: all slopes by sigma are l times those above, and dl adds
the slopes themselves. The effort that feeds the rod is the integral of

    g' = -(m . W m / 2 + m . R kappa_rest + n . t) - fbar . (p - p_0)                    (c)

by sigma: what the energy of the rod, its turns R(sigma) held, gains with l.

All are integrated together by an explicit Runge-Kutta method with fixed steps, so the variations are
exact up to the error of the integrator.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853

from ..numba_fence import njit

__all__ = [
    "EIGHTH_ORDER",
    "STEPS",
    "RodProperties",
    "RodTrajectory",
    "Start",
    "Tableau",
    "force",
    "frame",
    "integrate",
    "integrate_part",
    "length_variation",
    "moment",
    "position",
    "transition",
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

#: A state: p, R by rows, m, n, g; then what the variations do to dp, dtheta, dm, dn and dg, row by row.
_EFFORT, _FIRST = 18, 19
#: Variations: dtheta, dm, dn at the start, and dl; two more fill the registers.
_COLUMNS, _LENGTH = 12, 9


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _slope(state, length, compliance, rest, force, origin, slope):
    """Right-hand sides of (a), (b) and (c) by sigma."""
    r = state[3:12]
    mx, my, mz = state[12], state[13], state[14]
    nx, ny, nz = state[15], state[16], state[17]
    tx, ty, tz = r[0], r[3], r[6]
    wxx = wxy = wxz = wyy = wyz = wzz = 0.0
    ox = oy = oz = 0.0  # curvature at rest, in the world
    for j in range(3):
        a, b, c = r[j], r[3 + j], r[6 + j]
        wxx += compliance[j] * a * a
        wxy += compliance[j] * a * b
        wxz += compliance[j] * a * c
        wyy += compliance[j] * b * b
        wyz += compliance[j] * b * c
        wzz += compliance[j] * c * c
        ox += rest[j] * a
        oy += rest[j] * b
        oz += rest[j] * c
    ex = wxx * mx + wxy * my + wxz * mz
    ey = wxy * mx + wyy * my + wyz * mz
    ez = wxz * mx + wyz * my + wzz * mz
    kx, ky, kz = ex + ox, ey + oy, ez + oz
    slope[0], slope[1], slope[2] = length * tx, length * ty, length * tz
    for j in range(3):
        a, b, c = r[j], r[3 + j], r[6 + j]
        slope[3 + j] = length * (ky * c - kz * b)
        slope[6 + j] = length * (kz * a - kx * c)
        slope[9 + j] = length * (kx * b - ky * a)
    sx, sy, sz = ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx
    slope[12], slope[13], slope[14] = length * sx, length * sy, length * sz
    for j in range(3):
        slope[15 + j] = -length * force[j]
    slope[_EFFORT] = (
        -(0.5 * (mx * ex + my * ey + mz * ez) + mx * ox + my * oy + mz * oz)
        - (nx * tx + ny * ty + nz * tz)
        - force[0] * (state[0] - origin[0])
        - force[1] * (state[1] - origin[1])
        - force[2] * (state[2] - origin[2])
    )
    v = state[_FIRST:].reshape(13, _COLUMNS)
    d = slope[_FIRST:].reshape(13, _COLUMNS)
    for i in range(_COLUMNS):
        ax, ay, az = v[3, i], v[4, i], v[5, i]
        # dm - dtheta x m
        bx = v[6, i] - (ay * mz - az * my)
        by = v[7, i] - (az * mx - ax * mz)
        bz = v[8, i] - (ax * my - ay * mx)
        fx, fy, fz = v[9, i], v[10, i], v[11, i]
        # dtheta x t
        vx = ay * tz - az * ty
        vy = az * tx - ax * tz
        vz = ax * ty - ay * tx
        d[0, i], d[1, i], d[2, i] = length * vx, length * vy, length * vz
        d[3, i] = length * (wxx * bx + wxy * by + wxz * bz)
        d[4, i] = length * (wxy * bx + wyy * by + wyz * bz)
        d[5, i] = length * (wxz * bx + wyz * by + wzz * bz)
        d[6, i] = length * (ny * vz - nz * vy + (fy * tz - fz * ty))
        d[7, i] = length * (nz * vx - nx * vz + (fz * tx - fx * tz))
        d[8, i] = length * (nx * vy - ny * vx + (fx * ty - fy * tx))
        d[9, i] = d[10, i] = d[11, i] = 0.0
        d[12, i] = (
            -(bx * kx + by * ky + bz * kz)
            - (fx * tx + fy * ty + fz * tz)
            - (nx * vx + ny * vy + nz * vz)
            - (force[0] * v[0, i] + force[1] * v[1, i] + force[2] * v[2, i])
        )
    d[0, _LENGTH] += tx
    d[1, _LENGTH] += ty
    d[2, _LENGTH] += tz
    d[3, _LENGTH] += kx
    d[4, _LENGTH] += ky
    d[5, _LENGTH] += kz
    d[6, _LENGTH] += sx
    d[7, _LENGTH] += sy
    d[8, _LENGTH] += sz
    for j in range(3):
        d[9 + j, _LENGTH] -= force[j]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _steps(states, step, length, compliance, rest, force, origin, nodes, weights):
    """Runge-Kutta steps of one size in sigma from ``states[0]`` into the rows after it."""
    stages, size = len(weights), states.shape[1]
    slopes = np.empty((stages, size))
    inner = np.empty(size)
    for k in range(len(states) - 1):
        for stage in range(stages):
            for i in range(size):
                inner[i] = states[k, i]
            for earlier in range(stage):
                factor = step * nodes[stage, earlier]
                if factor != 0.0:
                    for i in range(size):
                        inner[i] += factor * slopes[earlier, i]
            _slope(
                inner,
                length,
                compliance[k, stage],
                rest[k, stage],
                force[k, stage],
                origin,
                slopes[stage],
            )
        for i in range(size):
            states[k + 1, i] = states[k, i]
        for stage in range(stages):
            factor = step * weights[stage]
            for i in range(size):
                states[k + 1, i] += factor * slopes[stage, i]


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
        values = (
            np.ascontiguousarray(function(sigma.ravel())).reshape(*sigma.shape, 3)
            for function in (self.compliance, self.rest_curvature, self.force)
        )
        return RodTables(begin, step, *values, tableau)


class RodTables(NamedTuple):
    """Properties of a part of a rod, at all stages of all steps."""

    begin: float
    step: float
    compliance: Floats
    rest_curvature: Floats
    force: Floats
    tableau: Tableau


def uniform(rigidities: ArrayLike, distributed: ArrayLike) -> RodProperties:
    """A rod that is the same all along, straight at rest.

    Args:
        rigidities: H_a, (3,) [N m^2].
        distributed: Force per length, fixed in the world, (3,) [N/m].
    """
    compliance, force = 1.0 / np.array(rigidities, float), np.array(distributed, float)
    return RodProperties(
        lambda sigma: np.tile(compliance, (len(sigma), 1)),
        lambda sigma: np.zeros((len(sigma), 3)),
        lambda sigma: np.tile(force, (len(sigma), 1)),
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
    """Internal moment in the world, (3,) [N m]."""
    return state[12:15]


def force(state: Floats) -> Floats:
    """Internal force in the world, (3,) [N]."""
    return state[15:18]


def transition(state: Floats) -> Floats:
    """Transition matrix of (b) for (dp, dtheta, dm, dn) from the start of the rod, (12, 12)."""
    matrix = np.eye(12)
    matrix[:, 3:] = state[_FIRST:].reshape(13, _COLUMNS)[:12, :9]
    return matrix


class LengthVariation(NamedTuple):
    """What a change of the length does, and the effort that feeds the rod."""

    column: Floats  # of (dp, dtheta, dm, dn), (12,)
    effort: float  # [N]
    row: Floats  # of the effort by (dtheta, dm, dn) at the start, (9,)
    stiffness: float  # of the effort by the length [N/m]


def length_variation(state: Floats) -> LengthVariation:
    """Variation of the length from the start of the rod to a state; the position there is held."""
    columns = state[_FIRST:].reshape(13, _COLUMNS)
    return LengthVariation(
        columns[:12, _LENGTH], float(state[_EFFORT]), columns[12, :9], float(columns[12, _LENGTH])
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
    first = np.zeros(_FIRST + 13 * _COLUMNS)
    first[:_EFFORT] = np.concatenate([np.ravel(part) for part in start])
    first[_FIRST:].reshape(13, _COLUMNS)[3:12, :9] = np.eye(9)
    place = first[:3] if origin is None else np.array(origin, float)
    return RodTrajectory(properties, length, tables, _integrated(first, length, tables, place))


def _integrated(first: Floats, length: float, tables: RodTables, origin: Floats) -> Floats:
    _, step, compliance, rest, force_per_length, tableau = tables
    states = np.empty((len(compliance) + 1, len(first)))
    states[0] = first
    _steps(
        states, step, length, compliance, rest, force_per_length, np.array(origin), *tableau
    )
    return states

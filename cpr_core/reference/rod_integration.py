# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Continuous Kirchhoff rods and their variations, integrated along the arc length.

The rods obey, in the world frame, with the tangent t = R e_1 and the curvature k = R H_a^-1 R^T m,

    p' = t,   R' = k^ R,   m' = -t x n,   n' = -fbar                                     (a)

where (m, n) is the wrench the part beyond s exerts on the part before it. Small variations, with
dtheta the rotation in the world, obey

    dp' = dtheta x t,   dtheta' = R H_a^-1 R^T (dm - dtheta x m),
    dm' = -(dtheta x t) x n - t x dn,   dn' = 0                                          (b)

Both are integrated together by the eighth-order Runge-Kutta pair of Dormand and Prince with fixed
steps, so the variations are exact up to the error of the integrator.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853

from ..description.leg_description import LegDescription
from ..numba_fence import njit

__all__ = [
    "STEPS",
    "RodTrajectory",
    "force",
    "frame",
    "integrate",
    "integrate_rod",
    "moment",
    "position",
    "transition",
]

Floats = NDArray[np.float64]

_NODES = np.ascontiguousarray(DOP853.A[: DOP853.n_stages, : DOP853.n_stages])
_WEIGHTS = np.ascontiguousarray(DOP853.B)

#: Steps along a rod. Halving them changes no tip by more than 1e-12 lengths on the paper's paths.
STEPS = 64


@njit(cache=True, nogil=True)
def _slope(state, compliance, distributed, slope):
    """Right-hand sides of (a) and (b); see ``integrate`` for the order of the state."""
    r = state[3:12]
    mx, my, mz = state[12], state[13], state[14]
    nx, ny, nz = state[15], state[16], state[17]
    tx, ty, tz = r[0], r[3], r[6]
    kx = ky = kz = 0.0
    # W = R H_a^-1 R^T, the compliance in the world.
    wxx = wxy = wxz = wyy = wyz = wzz = 0.0
    for j in range(3):
        a, b, c = r[j], r[3 + j], r[6 + j]
        wxx += compliance[j] * a * a
        wxy += compliance[j] * a * b
        wxz += compliance[j] * a * c
        wyy += compliance[j] * b * b
        wyz += compliance[j] * b * c
        wzz += compliance[j] * c * c
    kx = wxx * mx + wxy * my + wxz * mz
    ky = wxy * mx + wyy * my + wyz * mz
    kz = wxz * mx + wyz * my + wzz * mz
    slope[0], slope[1], slope[2] = tx, ty, tz
    for j in range(3):
        a, b, c = r[j], r[3 + j], r[6 + j]
        slope[3 + j] = ky * c - kz * b
        slope[6 + j] = kz * a - kx * c
        slope[9 + j] = kx * b - ky * a
    slope[12] = ny * tz - nz * ty
    slope[13] = nz * tx - nx * tz
    slope[14] = nx * ty - ny * tx
    for j in range(3):
        slope[15 + j] = -distributed[j]
    # Columns: what a unit variation of dtheta, dm, dn at the start does to dp, dtheta, dm.
    for column in range(9):
        o = 18 + 9 * column
        ax, ay, az = state[o + 3], state[o + 4], state[o + 5]
        # dm - dtheta x m
        bx = state[o + 6] - (ay * mz - az * my)
        by = state[o + 7] - (az * mx - ax * mz)
        bz = state[o + 8] - (ax * my - ay * mx)
        # dtheta x t
        vx = ay * tz - az * ty
        vy = az * tx - ax * tz
        vz = ax * ty - ay * tx
        slope[o], slope[o + 1], slope[o + 2] = vx, vy, vz
        slope[o + 3] = wxx * bx + wxy * by + wxz * bz
        slope[o + 4] = wxy * bx + wyy * by + wyz * bz
        slope[o + 5] = wxz * bx + wyz * by + wzz * bz
        fx = 1.0 if column == 6 else 0.0
        fy = 1.0 if column == 7 else 0.0
        fz = 1.0 if column == 8 else 0.0
        slope[o + 6] = ny * vz - nz * vy + (fy * tz - fz * ty)
        slope[o + 7] = nz * vx - nx * vz + (fz * tx - fx * tz)
        slope[o + 8] = nx * vy - ny * vx + (fx * ty - fy * tx)


@njit(cache=True, nogil=True)
def _steps(states, step, compliance, distributed, nodes, weights):
    """Runge-Kutta steps of one size from ``states[0]`` into the rows after it."""
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
            _slope(inner, compliance, distributed, slopes[stage])
        for i in range(size):
            states[k + 1, i] = states[k, i]
        for stage in range(stages):
            factor = step * weights[stage]
            for i in range(size):
                states[k + 1, i] += factor * slopes[stage, i]


@dataclass(frozen=True, eq=False)
class RodTrajectory:
    """A rod and its variations, along equal steps from one of its ends.

    Attributes:
        step: Arc length of a step, negative from the tip to the base [m].
        rigidities: H_a, (3,) [N m^2].
        distributed: Force per length in the world, (3,) [N/m].
        states: Position, frame (rows), moment, force and the columns of the variations, in the world,
            (steps + 1, 99).
    """

    step: float
    rigidities: Floats
    distributed: Floats
    states: Floats = field(repr=False)

    def at(self, fraction: float) -> Floats:
        """State a fraction of the length from the start, (99,), by one step from the node before."""
        place = fraction * (len(self.states) - 1)
        node = min(int(place), len(self.states) - 1)
        rest = place - node
        if rest == 0.0:
            return self.states[node]
        states = np.empty((2, 99))
        states[0] = self.states[node]
        _steps(states, rest * self.step, 1.0 / self.rigidities, self.distributed, _NODES, _WEIGHTS)
        return states[1]


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
    matrix[:9, 3:] = state[18:].reshape(9, 9).T
    return matrix


def integrate(
    start: tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike],
    length: float,
    rigidities: Floats,
    distributed: ArrayLike,
    steps: int = STEPS,
) -> RodTrajectory:
    """Integrate a rod and its variations, (a) and (b).

    Args:
        start: Position [m], frame, internal moment [N m] and internal force [N] at the start, in the
            world, (3,), (3, 3), (3,), (3,).
        length: Arc length [m]; negative from the tip to the base.
        rigidities: H_a, (3,) [N m^2].
        distributed: Force per length, fixed in the world, (3,) [N/m].
        steps: Number of steps.
    """
    states = np.empty((steps + 1, 99))
    states[0, :18] = np.concatenate([np.ravel(part) for part in start])
    states[0, 18:] = np.vstack([np.zeros((3, 9)), np.eye(9)[:6]]).T.ravel()
    force_per_length = np.array(distributed, float)
    _steps(states, length / steps, 1.0 / rigidities, force_per_length, _NODES, _WEIGHTS)
    return RodTrajectory(length / steps, rigidities, force_per_length, states)


def integrate_rod(
    leg: LegDescription,
    base_pose: tuple[ArrayLike, ArrayLike],
    base_moment: ArrayLike,
    base_force: ArrayLike,
    distributed: ArrayLike,
    steps: int = STEPS,
) -> RodTrajectory:
    """Integrate a leg from its base to its tip.

    Args:
        leg: The leg; its rod is uniform and straight at rest.
        base_pose: Position (3,) [m] and frame (3, 3) of the base in the world.
        base_moment: Moment the rod exerts on the base, about the base point, (3,) [N m].
        base_force: Force the rod exerts on the base, (3,) [N].
        distributed: Force per length, fixed in the world, (3,) [N/m].
        steps: Number of steps.
    """
    start = (*base_pose, base_moment, base_force)
    return integrate(start, leg.rod.length, leg.rod.rigidities, distributed, steps)

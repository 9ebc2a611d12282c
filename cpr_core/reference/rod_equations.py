# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Equations of continuous Kirchhoff rods and of their variations, compiled with their integrator.

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

import numpy as np

from .reference_decorators import in_order

__all__ = ["COLUMNS", "EFFORT", "FIRST", "LENGTH", "SIZE", "runge_kutta_steps"]

#: A state: p, R by rows, m, n, g; then what the variations do to dp, dtheta, dm, dn and dg, row by row.
EFFORT, FIRST = 18, 19
#: Variations: dtheta, dm, dn at the start, and dl; two more fill the registers.
COLUMNS, LENGTH = 12, 9
#: Numbers of a state.
SIZE = FIRST + 13 * COLUMNS


@in_order
def _slope(state, length, compliance, rest, force, origin, slope):
    """Right-hand sides of (a), (b) and (c) by sigma.

    Long, as every component is a number of its own, for the registers.
    """
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
    slope[EFFORT] = (
        -(0.5 * (mx * ex + my * ey + mz * ez) + mx * ox + my * oy + mz * oz)
        - (nx * tx + ny * ty + nz * tz)
        - force[0] * (state[0] - origin[0])
        - force[1] * (state[1] - origin[1])
        - force[2] * (state[2] - origin[2])
    )
    v = state[FIRST:].reshape(13, COLUMNS)
    d = slope[FIRST:].reshape(13, COLUMNS)
    for i in range(COLUMNS):
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
    d[0, LENGTH] += tx
    d[1, LENGTH] += ty
    d[2, LENGTH] += tz
    d[3, LENGTH] += kx
    d[4, LENGTH] += ky
    d[5, LENGTH] += kz
    d[6, LENGTH] += sx
    d[7, LENGTH] += sy
    d[8, LENGTH] += sz
    for j in range(3):
        d[9 + j, LENGTH] -= force[j]


@in_order
def runge_kutta_steps(states, step, length, compliance, rest, force, origin, nodes, weights):
    """Runge-Kutta steps of one size in sigma from ``states[0]`` into the rows after it.

    It takes what the slope depends on, and the method's two tables.
    """
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

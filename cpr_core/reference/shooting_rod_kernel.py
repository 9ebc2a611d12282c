# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One rod from base to tip, with its variations by the base wrench and the motor.

Kirchhoff rods as in ``rod_integration``, but of circular stiffness: with E J_2 = E J_3 the equation of
the tangent, t' = m x t / E J, needs neither frames nor the torsion, which leaves p, t, m (9 numbers, in
the plane x, y, angle, m) to integrate. Their variations by the base moment, the base force and the motor
are integrated together with them, so the Jacobian is exact.
"""

from __future__ import annotations

import math

from .reference_decorators import reference, reference_part
from .shooting_algebra import add_cross, turn

__all__ = ["COLUMNS", "FIRST", "PLANAR_COLUMNS", "PLANAR_FIRST", "integrate", "start_rod"]

#: Columns of the variations: three by the base moment, three by the base force, the motor, a filler;
#: in the plane by moment, force and motor. Before them are p, t and m, or x, y, angle and m.
COLUMNS, FIRST = 8, 9
PLANAR_COLUMNS, PLANAR_FIRST = 4, 4


@reference_part
def start_rod(robot, number, motor, wrench, tangent, rod):
    """A rod at its base, and how that varies with the base wrench and the motor."""
    axis = robot.motor_axis[number]
    turn(axis * motor, robot.base_tangent[number].copy().reshape(3, 1), tangent)
    rod[:] = 0.0
    if robot.planar:
        rod[0], rod[1] = robot.base_position[number, 0], robot.base_position[number, 1]
        rod[2] = math.atan2(tangent[1, 0], tangent[0, 0])
        rod[3] = wrench[2]
        rod[PLANAR_FIRST + 3 * PLANAR_COLUMNS] = 1.0
        rod[PLANAR_FIRST + 2 * PLANAR_COLUMNS + 3] = axis[2]
    else:
        for i in range(3):
            rod[i] = robot.base_position[number, i]
            rod[3 + i] = tangent[i, 0]
            rod[6 + i] = wrench[i]
            rod[FIRST + (6 + i) * COLUMNS + i] = 1.0
        add_cross(1.0, axis, tangent[:, 0], rod[FIRST + 3 * COLUMNS + 6 :: COLUMNS][:3])


@reference_part
def integrate(robot, number, force, state, inner, slopes):
    """One rod from base to tip, in place."""
    size = PLANAR_FIRST * (1 + PLANAR_COLUMNS) if robot.planar else FIRST * (1 + COLUMNS)
    stages = robot.weights.shape[0]
    step = robot.length[number] / robot.steps
    compliance = 1.0 / robot.stiffness[number]
    fx, fy, fz = robot.distributed[number]
    for k in range(robot.steps):
        for stage in range(stages):
            for i in range(size):
                inner[i] = state[i]
            for earlier in range(stage):
                factor = step * robot.nodes[stage, earlier]
                if factor != 0.0:
                    for i in range(size):
                        inner[i] += factor * slopes[earlier, i]
            s = step * (k + robot.abscissae[stage])
            nx, ny = force[0] - fx * s, force[1] - fy * s
            if robot.planar:
                _planar_slope(inner, compliance, nx, ny, slopes[stage])
            else:
                _spatial_slope(inner, compliance, nx, ny, force[2] - fz * s, slopes[stage])
        for stage in range(stages):
            factor = step * robot.weights[stage]
            if factor != 0.0:
                for i in range(size):
                    state[i] += factor * slopes[stage, i]


@reference
def _spatial_slope(y, compliance, nx, ny, nz, slope):
    """Slopes p' = t, t' = m x t / E J, m' = n x t, and their variations in columns."""
    tx, ty, tz, mx, my, mz = y[3], y[4], y[5], y[6], y[7], y[8]
    slope[0], slope[1], slope[2] = tx, ty, tz
    slope[3] = compliance * (my * tz - mz * ty)
    slope[4] = compliance * (mz * tx - mx * tz)
    slope[5] = compliance * (mx * ty - my * tx)
    slope[6] = ny * tz - nz * ty
    slope[7] = nz * tx - nx * tz
    slope[8] = nx * ty - ny * tx
    for c in range(FIRST, FIRST + COLUMNS):
        ax, ay, az = y[c + 3 * COLUMNS], y[c + 4 * COLUMNS], y[c + 5 * COLUMNS]  # dt
        bx, by, bz = y[c + 6 * COLUMNS], y[c + 7 * COLUMNS], y[c + 8 * COLUMNS]  # dm
        slope[c] = ax
        slope[c + COLUMNS] = ay
        slope[c + 2 * COLUMNS] = az
        slope[c + 3 * COLUMNS] = compliance * (by * tz - bz * ty + my * az - mz * ay)
        slope[c + 4 * COLUMNS] = compliance * (bz * tx - bx * tz + mz * ax - mx * az)
        slope[c + 5 * COLUMNS] = compliance * (bx * ty - by * tx + mx * ay - my * ax)
        slope[c + 6 * COLUMNS] = ny * az - nz * ay
        slope[c + 7 * COLUMNS] = nz * ax - nx * az
        slope[c + 8 * COLUMNS] = nx * ay - ny * ax
    x, y_row, z = FIRST + 6 * COLUMNS, FIRST + 7 * COLUMNS, FIRST + 8 * COLUMNS
    slope[y_row + 3] -= tz
    slope[z + 3] += ty
    slope[x + 4] += tz
    slope[z + 4] -= tx
    slope[x + 5] -= ty
    slope[y_row + 5] += tx


@reference
def _planar_slope(y, compliance, nx, ny, slope):
    """Slopes of x, y, angle and moment; columns by the moment, two of the force, the motor."""
    c, s = math.cos(y[2]), math.sin(y[2])
    slope[0], slope[1] = c, s
    slope[2] = compliance * y[3]
    slope[3] = nx * s - ny * c
    along = nx * c + ny * s
    for column in range(4, 8):
        turn = y[column + 8]
        slope[column] = -s * turn
        slope[column + 4] = c * turn
        slope[column + 8] = compliance * y[column + 12]
        slope[column + 12] = along * turn
    slope[17] += s
    slope[18] -= c

"""The tangent on the admissible motions, leg by leg, and what follows from it to first order.

Held by its tip joint, a leg has the motions u of its constraints' range, which platform and motor
prescribe, and the motions y of their null space, which are its own. With the constraints L u + P x = 0,
u = U x, U = -L^-1 P. On an orthonormal basis of (u, y) the reduced Hessian H_r couples a leg's y to
platform and motor x only, whose metric is 1 + U^T U: nothing as large as the robot is put together.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import compiled
from .condensation_kernel import lu_factor, lu_solve
from .pencil_kernel import eliminate_legs, smallest_eigenvalue

__all__ = ["first_order_into"]

#: A constraint that a leg can meet by its own motions only so badly, relative to its other ones, is left
#: to the dense method (a straight leg).
_SMALLEST_CONSTRAINT = 1e-4
#: Elastic stiffness of an admissible motion, relative to the largest, that counts as none.
_SMALLEST_STIFFNESS = 1e-10
_SMALLEST_PIVOT = 1e-14


@compiled
def first_order_into(
    robot, tangent, state, rotation, motions, spans, eigenvalues,
    platform_by_motors, compliance, efforts_by_motors, efforts_by_wrench,
):  # fmt: skip
    """Stability and first-order behaviour at an equilibrium.

    Args:
        robot: RobotArrays.
        tangent: Of the model, (N, N).
        state: (N,).
        rotation: Platform rotation, (3, 3).
        motions: Unit motions as columns, (N, N).
        spans: First and last row of every unit motion that is not zero, (N, 2).
        eigenvalues: Result, (3,): smallest eigenvalue of H_r with the motors held and with the motors
            free [J], and the one relative to the elastic stiffness, motors held; NaN where the dense
            method has to tell.
        platform_by_motors: Result, ``dSigma_p/dq_a``, body twists, (b, n).
        compliance: Result, ``dSigma_p/dw_p``, motors held, in body coordinates, (b, b).
        efforts_by_motors: Result, ``dtau_a/dq_a``, (n, n).
        efforts_by_wrench: Result, ``dtau_a/dw_p``, motors held, (n, b).

    Returns:
        Whether the matrices are there; if not, the dense method has to tell.
    """
    for i in range(3):
        eigenvalues[i] = math.nan
    count, width = robot.legs.shape[0], robot.platform_axes.shape[0]
    most = 0
    for number in range(count):
        leg = robot.legs[number]
        own = leg.multiplier_index - _first_of(leg)
        own -= robot.position_axes.shape[0] + leg.orientation_count
        if own < 0:
            return False
        most = max(most, own)
    extent = most + 1
    blocks = np.zeros((count, extent, extent + width))
    masses, elastic = np.zeros(blocks.shape), np.zeros(blocks.shape)
    corner, corner_mass, corner_elastic = (
        np.zeros((width, width)), np.zeros((width, width)), np.zeros((width, width)),
    )  # fmt: skip
    held, free = np.empty(count, np.int64), np.empty(count, np.int64)
    inner, unit = robot.platform_index, robot.unit
    for i in range(width):
        corner_mass[i, i] = 1.0
        for j in range(i, width):
            value = 0.5 * (tangent[inner + i, inner + j] + tangent[inner + j, inner + i])
            corner[i, j] = unit[inner + i] * value * unit[inner + j]
    elastic_only, stretch = True, 1.0
    for number in range(count):
        leg = robot.legs[number]
        if _first_of(leg) != leg.strain_index:
            elastic_only = False  # a passive base coordinate stores no energy
        rank = _reduce_leg(
            robot, number, tangent, state, motions, spans, blocks[number], masses[number],
            elastic[number], corner, corner_mass, corner_elastic,
        )  # fmt: skip
        if rank < 0:
            return False
        held[number] = leg.multiplier_index - _first_of(leg) - rank
        free[number] = held[number]
        if _motor_of(robot, leg) >= 0:  # its motion may undo a large one of the platform
            stretch = max(stretch, masses[number, free[number], free[number]])
            free[number] += 1

    scale = robot.energy_unit
    eigenvalues[0] = smallest_eigenvalue(blocks, masses, corner, corner_mass, held, scale, 1.0)
    eigenvalues[1] = smallest_eigenvalue(blocks, masses, corner, corner_mass, free, scale, stretch)
    if elastic_only and _definite(elastic, corner_elastic, held):
        eigenvalues[2] = smallest_eigenvalue(
            blocks, elastic, corner, corner_elastic, held, 1.0, 1.0
        )
    return _respond(
        robot, tangent, rotation, blocks, masses, corner, corner_mass, held, free,
        platform_by_motors, compliance, efforts_by_motors, efforts_by_wrench,
    )  # fmt: skip


@compiled
def _first_of(leg):
    """State index of the first coordinate of a leg: a passive one of its base, or its first strain."""
    return leg.multiplier_index - leg.strain_count - _passive_of(leg)


@compiled
def _passive_of(leg):
    """Number of passive base coordinates of a leg."""
    passive = 0
    if 0 <= leg.rotation_index < leg.multiplier_index:
        passive += 1
    if 0 <= leg.translation_index < leg.multiplier_index:
        passive += 1
    return passive


@compiled
def _motor_of(robot, leg):
    """State index of the motor of a leg; -1: none."""
    return max(
        leg.rotation_index if leg.rotation_index >= robot.motor_index else -1,
        leg.translation_index if leg.translation_index >= robot.motor_index else -1,
    )


@compiled
def _reduce_leg(
    robot, number, tangent, state, motions, spans, block, mass, elastic,
    corner, corner_mass, corner_elastic,
):  # fmt: skip
    """Reduce one leg: its block and what it adds to the corner.

    Returns:
        Number of its constraints; -1 where they do not hold it by its own motions.
    """
    leg, unit = robot.legs[number], robot.unit
    start, rank = _first_of(leg), robot.position_axes.shape[0] + leg.orientation_count
    size = leg.multiplier_index - start
    motor, width, inner = _motor_of(robot, leg), corner.shape[0], robot.platform_index
    beside = width + 1  # platform, then the motor

    # In unit motions: Hessian, elastic stiffness, coupling, constraints.
    hessian, stiffness = np.zeros((size, size)), np.zeros((size, size))
    coupling, slopes = np.zeros((size, beside)), np.zeros((rank, size))
    prescribed, half = np.zeros((rank, beside)), np.zeros((size, size))
    shift, ratio = size - leg.strain_count, 1.0
    if leg.extensible:
        ratio = leg.length / state[leg.translation_index]
    for j in range(size):
        low, high = spans[start + j, 0] - start, spans[start + j, 1] - start
        for k in range(low, high):
            weight = motions[start + k, start + j]
            for i in range(size):
                entry = tangent[start + i, start + k] + tangent[start + k, start + i]
                half[i, j] += 0.5 * entry * weight
            for i in range(rank):
                row = leg.multiplier_index + i
                slopes[i, j] += unit[row] * tangent[row, start + k] * weight
            for i in range(width):
                entry = tangent[inner + i, start + k] + tangent[start + k, inner + i]
                coupling[j, i] += 0.5 * weight * entry * unit[inner + i]
            if motor >= 0:
                entry = tangent[motor, start + k] + tangent[start + k, motor]
                coupling[j, width] += 0.5 * weight * entry * unit[motor]
    _turn_both(half, motions, spans, start, hessian)
    for i in range(size):
        for j in range(size):
            half[i, j] = 0.0
    for j in range(shift, size):
        for k in range(spans[start + j, 0] - start, spans[start + j, 1] - start):
            weight = ratio * motions[start + k, start + j]
            for i in range(shift, size):
                half[i, j] += robot.stiffness[number, i - shift, k - shift] * weight
    _turn_both(half, motions, spans, start, stiffness)
    for i in range(rank):
        row = leg.multiplier_index + i
        for j in range(width):
            prescribed[i, j] = unit[row] * tangent[row, inner + j] * unit[inner + j]
        if motor >= 0:
            prescribed[i, width] = unit[row] * tangent[row, motor] * unit[motor]

    if not _split(slopes, prescribed, hessian, stiffness, coupling):
        return -1
    _prescribe(slopes, prescribed)

    # Products with U, in place of the platform's and the motor's own columns.
    total, total_elastic = np.zeros((size, beside)), np.zeros((size, beside))
    for i in range(size):
        for j in range(beside):
            total[i, j] = coupling[i, j]
        for k in range(rank):
            weight, weight_elastic, source = hessian[i, k], stiffness[i, k], prescribed[k]
            for j in range(beside):
                total[i, j] += weight * source[j]
                total_elastic[i, j] += weight_elastic * source[j]
    own, first = size - rank, block.shape[0]
    for i in range(own):
        mass[i, i] = 1.0
        for j in range(i, own):
            block[i, j] = hessian[rank + i, rank + j]
            elastic[i, j] = stiffness[rank + i, rank + j]
        for j in range(width):
            block[i, first + j] = total[rank + i, j]
            elastic[i, first + j] = total_elastic[rank + i, j]
        block[i, own] = total[rank + i, width]
    for i in range(beside):
        for j in range(beside):
            value, value_elastic, metric = 0.0, 0.0, 0.0
            for k in range(rank):
                u = prescribed[k, i]
                value += u * total[k, j] + coupling[k, i] * prescribed[k, j]
                value_elastic += u * total_elastic[k, j]
                metric += u * prescribed[k, j]
            if j < width:
                if j >= i:
                    corner[i, j] += value
                    corner_elastic[i, j] += value_elastic
                    corner_mass[i, j] += metric
                elif i == width and motor >= 0:
                    entry = tangent[motor, inner + j] + tangent[inner + j, motor]
                    value += 0.5 * unit[motor] * entry * unit[inner + j]
                    block[own, first + j] = value
                    mass[own, first + j] = metric
            elif i == width and motor >= 0:
                block[own, own] = value + unit[motor] * tangent[motor, motor] * unit[motor]
                mass[own, own] = 1.0 + metric
    return rank


@compiled
def _turn_both(half, motions, spans, start, result):
    """``result = motions^T half``."""
    size = half.shape[0]
    for i in range(size):
        for k in range(spans[start + i, 0] - start, spans[start + i, 1] - start):
            weight, source = motions[start + k, start + i], half[k]
            for j in range(size):
                result[i, j] += weight * source[j]


@compiled
def _split(slopes, prescribed, hessian, stiffness, coupling):
    """Reflect so that the first coordinates span the range of the constraints, the others the rest.

    Rows of constraints are exchanged; ``slopes`` becomes lower triangular. Returns whether all
    constraints can be met.
    """
    rank, size = slopes.shape
    vector, product = np.empty(size), np.empty(size)
    first_length = 0.0
    for k in range(rank):
        best, row = -1.0, k
        for i in range(k, rank):
            total = 0.0
            for j in range(k, size):
                total += slopes[i, j] * slopes[i, j]
            if total > best:
                best, row = total, i
        length = math.sqrt(best)
        if k == 0:
            first_length = length
        if not length > _SMALLEST_CONSTRAINT * first_length:
            return False
        for j in range(size):
            slopes[k, j], slopes[row, j] = slopes[row, j], slopes[k, j]
        for j in range(prescribed.shape[1]):
            prescribed[k, j], prescribed[row, j] = prescribed[row, j], prescribed[k, j]
        for j in range(k):
            vector[j] = 0.0
        for j in range(k, size):
            vector[j] = slopes[k, j]
        beta = 1.0 / (best + length * abs(vector[k]))
        vector[k] += length if vector[k] >= 0.0 else -length
        for i in range(k, rank):
            target, total = slopes[i], 0.0
            for j in range(k, size):
                total += target[j] * vector[j]
            total *= beta
            for j in range(k, size):
                target[j] -= total * vector[j]
        for j in range(coupling.shape[1]):
            total = 0.0
            for i in range(k, size):
                total += vector[i] * coupling[i, j]
            total *= beta
            for i in range(k, size):
                coupling[i, j] -= total * vector[i]
        _reflect(hessian, vector, beta, product)
        _reflect(stiffness, vector, beta, product)
    return True


@compiled
def _reflect(matrix, vector, beta, product):
    """``(1 - beta v v^T) matrix (1 - beta v v^T)`` of a symmetric matrix, in place."""
    size = matrix.shape[0]
    for j in range(size):
        product[j] = 0.0
    for i in range(size):
        source, weight = matrix[i], beta * vector[i]
        for j in range(size):
            product[j] += weight * source[j]
    inner = 0.0
    for j in range(size):
        inner += product[j] * vector[j]
    inner *= 0.5 * beta
    for j in range(size):
        product[j] -= inner * vector[j]
    for i in range(size):
        target, one, two = matrix[i], vector[i], product[i]
        for j in range(size):
            target[j] -= one * product[j] + two * vector[j]


@compiled
def _prescribe(slopes, prescribed):
    """``prescribed = -L^-1 prescribed`` with the lower triangle L of ``slopes``, in place."""
    for i in range(slopes.shape[0]):
        for j in range(prescribed.shape[1]):
            total = -prescribed[i, j]
            for k in range(i):
                total -= slopes[i, k] * prescribed[k, j]
            prescribed[i, j] = total / slopes[i, i]


@compiled
def _definite(elastic, corner, sizes):
    """Whether every admissible motion with the motors held costs elastic energy."""
    factors, left, nothing = np.empty(elastic.shape), np.empty(corner.shape), np.zeros(corner.shape)
    negative = eliminate_legs(
        elastic, elastic, corner, nothing, sizes, sizes, 0.0, 1e-300, factors, left
    )
    if negative > 0:
        return False
    largest = 0.0
    for i in range(corner.shape[0]):
        largest = max(largest, corner[i, i])
    pivots = np.empty(corner.shape[0], np.int64)
    for i in range(corner.shape[0]):
        for j in range(i):
            left[i, j] = left[j, i]
    return lu_factor(left, corner.shape[0], pivots, _SMALLEST_STIFFNESS * largest)


@compiled
def _respond(
    robot, tangent, rotation, blocks, masses, corner, corner_mass, held, free,
    platform_by_motors, compliance, efforts_by_motors, efforts_by_wrench,
):  # fmt: skip
    """Matrices of the kinemato-static model, from what the legs leave of platform and motors."""
    width, first, unit, inner = corner.shape[0], blocks.shape[1], robot.unit, robot.platform_index
    motors, scale = unit.shape[0] - robot.motor_index, robot.energy_unit
    factors, left = np.empty(blocks.shape), np.empty((width, width))
    eliminate_legs(blocks, masses, corner, corner_mass, free, held, 0.0, 1e-300, factors, left)
    # Body twists in the units of the state; non-conservative loads make the corner unsymmetric.
    turn, stiffness = np.empty((width, width)), np.empty((width, width))
    for i in range(width):
        for j in range(width):
            one, two = robot.platform_axes[i], robot.platform_axes[j]
            same = (one < 3) == (two < 3)
            turn[i, j] = unit[inner + i] * rotation[one % 3, two % 3] if same else 0.0
            value = left[min(i, j), max(i, j)]
            odd = tangent[inner + i, inner + j] - tangent[inner + j, inner + i]
            stiffness[i, j] = (value + 0.5 * unit[inner + i] * odd * unit[inner + j]) / scale
    pivots = np.empty(width, np.int64)
    if not lu_factor(stiffness, width, pivots, _SMALLEST_PIVOT):
        return False
    column, inverse = np.empty(width), np.empty((width, width))
    for j in range(width):
        for i in range(width):
            column[i] = 1.0 if i == j else 0.0
        lu_solve(stiffness, width, pivots, column)
        for i in range(width):
            inverse[i, j] = column[i] / scale
    body = np.empty((width, width))
    for i in range(width):
        for j in range(width):
            total = 0.0
            for k in range(width):
                total += turn[k, i] * inverse[k, j]
            body[i, j] = total
    for i in range(width):
        for j in range(width):
            total = 0.0
            for k in range(width):
                total += body[i, k] * turn[k, j]
            compliance[i, j] = total
    loads = np.zeros((motors, width))  # forces of the motors' motions on the platform, in units
    own = np.zeros(motors)
    for number in range(held.shape[0]):
        motor = _motor_of(robot, robot.legs[number])
        if motor >= 0:
            row = factors[number, held[number]]
            own[motor - robot.motor_index] = row[held[number]]
            for i in range(width):
                loads[motor - robot.motor_index, i] = row[first + i]
    for m in range(motors):
        motor_unit = unit[robot.motor_index + m]
        for j in range(width):
            column[j] = 0.0
            for k in range(width):
                column[j] += loads[m, k] * inverse[k, j]
        for i in range(width):
            total, back = 0.0, 0.0
            for k in range(width):
                total -= body[i, k] * loads[m, k]
                back += column[k] * turn[k, i]
            platform_by_motors[i, m] = total / motor_unit
            efforts_by_wrench[m, i] = back / motor_unit
        for n in range(motors):
            total = own[m] if m == n else 0.0
            for j in range(width):
                total -= column[j] * loads[n, j]
            efforts_by_motors[m, n] = total / (motor_unit * unit[robot.motor_index + n])
    return True

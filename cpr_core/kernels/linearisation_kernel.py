# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""First-order behaviour of an equilibrium from its condensed tangent: nothing is evaluated again."""

from __future__ import annotations

import math

from .delayed_pencil_kernel import compliance_of_platform, gather_pencil
from .kernel_decorators import inlined, kernel
from .kernel_records import fed_length
from .lanes import broadcast, highest, load, lower, store
from .lu_kernel import lu_factor, lu_solve
from .pencil_kernel import Measure, eliminate_pencil, is_diagonal
from .recall_kernel import recall_pencil
from .record_layout import ROTATION
from .slots import COMPONENTS
from .smallest_eigenvalue_kernel import smallest_eigenvalue
from .twist_layout import FIRST_LINEAR

__all__ = ["FREE", "LOCKED", "MARGIN", "linearise"]

#: Of the eigenvalues: which is smallest of what.
MARGIN, LOCKED, FREE = 0, 1, 2

#: Elastic stiffness this large hides all other; what is left of the platform's then is this part of the
#: largest at least, or some motion counts as one without stiffness.
_ALL_ELASTIC, _SMALLEST_STIFFNESS = 1e10, 1e-9
_SMALLEST_PIVOT = 1e-14
#: What the condensation has left of platform and motors, dimensionless: entries beyond this (a leg
#: nearly straight) hide too many digits of others. A margin needs fewer.
_LARGEST_BORDER, _OF_MARGIN = 1e4, 5e6
#: Where the search for the margin begins, and that with motors free where legs are straight.
_MARGIN_ABOVE, _BELOW_MOTORS = 0.5, -0.1


@kernel
def linearise(prepared, kept, record, all_of_it, evaluated, eigenvalues, response):
    """Stability and first-order behaviour of an equilibrium.

    Args:
        prepared: PreparedRobot.
        kept: Factors of its tangent (``keep``).
        record: The solution, see `record_layout`.
        all_of_it: Whether more is asked for than the margin, which is to be known before motors move.
        evaluated: Whether its tangent is in the workspace: then legs may be straight.
        eigenvalues: Result, (3,): smallest eigenvalue of H_r with the motors held relative to the
            elastic stiffness (MARGIN), in itself (LOCKED) [J], and with the motors free (FREE) [J]; NaN
            where the dense method has to tell, or nobody asked.
        response: Result, if all is asked for, (b + n, n + b): ``[dSigma_p/dq_a, dSigma_p/dw_p;
            dtau_a/dq_a, dtau_a/dw_p]`` at motors and wrench held in turn, body twists and wrenches.

    Returns:
        Whether K is known, without which nothing is, and whether the response is there.
    """
    robot, pencil = prepared.robot, prepared.pencil
    eigenvalues[:] = math.nan
    if evaluated:
        known = gather_pencil(robot, prepared.work, pencil)
    else:
        known = recall_pencil(robot, kept, pencil, _LARGEST_BORDER if all_of_it else _OF_MARGIN)
    if not known:
        return False, False
    # Constants would be compiled for once each.
    held, released = robot.motor_index < 0, robot.motor_index >= 0
    unguided = held
    _put_elastic(robot, record, pencil.elastic)
    diagonal = is_diagonal(pencil.elastic)
    stored = Measure(pencil.elastic, diagonal, pencil.springs, 0.0, held)
    if _definite(robot.slots, pencil, stored):
        eigenvalues[MARGIN] = smallest_eigenvalue(pencil, stored, _MARGIN_ABOVE, unguided)
    if not all_of_it:
        return True, False
    orthogonal, guided = is_diagonal(pencil.gram), math.isfinite(eigenvalues[MARGIN])
    motions = Measure(pencil.gram, orthogonal, pencil.weights, 1.0, held)
    # The softest motion is nearly the same in both measures.
    eigenvalues[LOCKED] = robot.energy_unit * smallest_eigenvalue(pencil, motions, 0.0, guided)
    if robot.one_slot_a_motor:
        motions = Measure(pencil.gram, orthogonal, pencil.weights, 1.0, released)
        # A motor that feeds a straight rod has no stiffness of its own: its pivot at zero is rounding.
        low = _BELOW_MOTORS if pencil.delayed_count[0] > 0 else 0.0
        smallest = smallest_eigenvalue(pencil, motions, low, unguided)
        eigenvalues[FREE] = robot.energy_unit * smallest
    return True, _respond(robot, record, response, pencil)


@inlined
def _put_elastic(robot, record, elastic):
    """Elastic stiffness of the legs as long as they are, dimensionless."""
    per_energy = 1.0 / robot.energy_unit
    for number in range(elastic.shape[0]):
        for i in range(robot.slots.strain_count):
            unit = per_energy * load(robot.units, (number, i))
            for j in range(i, robot.slots.strain_count):
                stiffness = load(robot.elastic, (number, i, j))
                store(elastic, (number, i, j), unit * load(robot.units, (number, j)) * stiffness)
        if robot.extensible == 0:
            continue
        numbers = elastic["lane"]
        for r in range(robot.rods.shape[1]):
            rod = robot.rods[number, r]
            first, last = rod.component_start[0], rod.component_start[COMPONENTS]
            for lane in range(robot.slot_index.shape[2]):
                if rod.extensible[lane] == 0.0:
                    continue
                ratio = rod.length[lane] / fed_length(robot, number, r, lane, record)
                for i in range(first, last):
                    for j in range(i, last):
                        numbers[number, i, j, lane] *= ratio


@inlined
def _definite(slots, pencil, stored):
    """Whether every admissible motion with the motors held costs elastic energy.

    Of the platform, and of passive joints with the tip of their leg held.
    """
    left, weights = pencil.left, pencil.weights
    if eliminate_pencil(pencil, stored, -_ALL_ELASTIC) != 0:
        return False
    smallest, largest = math.inf, 0.0
    for i in range(left.shape[0]):
        smallest, largest = min(smallest, left[i, i]), max(largest, left[i, i])
    if pencil.delayed_count[0] > 0:
        compliance = compliance_of_platform(pencil)  # none: straight legs hold it
        smallest = 1.0 / compliance if compliance > 0.0 else math.inf
    softest = broadcast(weights, math.inf)
    for number in range(weights.shape[0]):
        for i in range(slots.first_passive, slots.inner_count):
            lacking = largest * (1.0 - load(weights, (number, i)))
            softest = lower(softest, lacking + 1.0 / load(pencil.inverse, (number, i)))
    return min(smallest, -highest(-softest)) > _SMALLEST_STIFFNESS * largest


@inlined
def _respond(robot, record, response, pencil):
    """Matrices of the kinemato-static model, from what the legs leave of platform and motors."""
    width, unit, scale = robot.slots.platform_count, robot.unit, robot.energy_unit
    motors = unit.shape[0] - robot.motor_index
    answering = width + pencil.delayed_count[0]  # platform and delayed slots
    condensed, column = pencil.condensed, pencil.part
    if not _invert_answering(answering, pencil):
        return False
    compliance, turn, turned = pencil.compliance, pencil.turn, pencil.turned_compliance
    _turn_into_world(robot, record, answering, pencil)
    for i in range(width):
        for j in range(width):
            value = 0.0
            for k in range(width):
                value += turned[i, k] * turn[k, j]
            response[i, motors + j] = value / scale
    for m in range(motors):
        motor_unit, row = unit[robot.motor_index + m], condensed[answering + m]
        for j in range(answering):
            value = 0.0
            for k in range(answering):
                value += row[k] * compliance[j, k]
            column[j] = value
        for i in range(width):
            moved, pushed = 0.0, 0.0
            for k in range(answering):
                moved -= turned[i, k] * row[k]
            for k in range(width):
                pushed += column[k] * turn[k, i]
            response[i, m] = moved / motor_unit
            response[width + m, motors + i] = pushed / motor_unit
        for n in range(motors):
            value, other = row[answering + n], condensed[answering + n]
            for j in range(answering):
                value -= column[j] * other[j]
            own = abs(row[answering + n])
            if m == n and own > max(_LARGEST_BORDER, _LARGEST_BORDER * abs(value)):
                return False  # the digits of a motor that feeds a rod which is hardly bent
            response[width + m, n] = scale * value / (motor_unit * unit[robot.motor_index + n])
    return True


@inlined
def _invert_answering(answering, pencil):
    """Compliance of platform and delayed slots, kept by columns as rows; whether there is one."""
    condensed, pivots = pencil.condensed, pencil.pivots
    stiffness, compliance = pencil.stiffness, pencil.compliance
    for i in range(answering):
        for j in range(answering):
            stiffness[i, j] = condensed[i, j]
    if not lu_factor(stiffness, answering, pivots, _SMALLEST_PIVOT):
        return False
    for j in range(answering):
        for i in range(answering):
            compliance[j, i] = 1.0 if i == j else 0.0
        lu_solve(stiffness, answering, pivots, compliance[j])
    return True


@inlined
def _turn_into_world(robot, record, answering, pencil):
    """World twists, dimensionless, of body twists in the units of the state; and of the compliance."""
    unit, inner, width = robot.unit, robot.platform_index, robot.slots.platform_count
    rotation = unit.shape[0] + ROTATION
    compliance, turn, turned = pencil.compliance, pencil.turn, pencil.turned_compliance
    for i in range(width):
        for j in range(width):
            row_axis, column_axis = robot.platform_axes[i], robot.platform_axes[j]
            turn[i, j] = 0.0
            if (row_axis < FIRST_LINEAR) == (column_axis < FIRST_LINEAR):
                entry = record[rotation + 3 * (row_axis % 3) + column_axis % 3]
                turn[i, j] = unit[inner + i] * entry
    for i in range(width):
        for j in range(answering):
            value = 0.0
            for k in range(width):
                value += turn[k, i] * compliance[j, k]
            turned[i, j] = value

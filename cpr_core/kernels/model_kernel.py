# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The geometrico-static model, Eq. (32), and its exact tangent for the whole robot."""

from __future__ import annotations

from .kernel_decorators import inlined, part
from .lane_vectors import (
    add,
    axial,
    cross_matrix,
    dot,
    less_trace,
    load_matrix,
    load_vector,
    matrix_vector,
    negated,
    outer,
    store_matrix,
    store_vector,
    subtract,
)
from .lanes import get
from .leg_kernel import evaluate_group
from .twist_layout import ANGULAR, LINEAR

__all__ = ["evaluate", "evaluate_inlined", "evaluate_residual", "tangent_into"]


@part
def evaluate(robot, loads, state, platform_rotation, platform_position, residual, work):
    """Residual and tangent of the model at any state, in equilibrium or not.

    The equations are the derivatives of the Lagrangian ``U + Psi . lambda`` (Eq. (49)) by the state:
    balance of passive and strain coordinates, constraints Psi, balance of the platform in the world
    frame at its origin, and in the motor rows the efforts tau_a the motors have to give.

    Args:
        robot: RobotArrays.
        loads: LoadArrays.
        state: Shape (N,); the platform entries are not read.
        platform_rotation: R_p in the world, (3, 3).
        platform_position: p_p in the world, (3,).
        residual: Result, (N,).
        work: Workspace; on return it has the tangent, by slots of the legs (``tangent_into``): its
            derivative by the state, the platform moved by small world rotations and translations.

    Returns:
        Potential energy without the work of motors and of non-conservative loads [J].
    """
    return evaluate_inlined(
        robot, loads, state, platform_rotation, platform_position, residual, work, True
    )


@part
def evaluate_residual(robot, loads, state, platform_rotation, platform_position, residual, work):
    """``evaluate`` without a tangent, in half the time."""
    return evaluate_inlined(
        robot, loads, state, platform_rotation, platform_position, residual, work, False
    )


@inlined
def evaluate_inlined(
    robot, loads, state, platform_rotation, platform_position, residual, work, tangent
):
    """``evaluate`` as a part of what calls it, with a tangent or without, which is a constant."""
    platform_residual, platform_tangent = work.platform_residual, work.platform_tangent
    for i in range(6):
        platform_residual[i] = 0.0
        for j in range(6):
            platform_tangent[i, j] = 0.0
    loaded = loads.on_rods[0] > 0.0
    energy = 0.0
    for number in range(robot.groups.shape[0]):
        energy += evaluate_group(
            robot,
            loads,
            loaded,
            number,
            state,
            platform_rotation,
            platform_position,
            work,
            tangent,
        )
    energy += _add_platform_loads(
        loads, platform_rotation, platform_position, platform_residual, platform_tangent
    )
    for row in range(robot.platform_axes.shape[0]):
        residual[robot.platform_index + row] = platform_residual[robot.platform_axes[row]]
    first_motor = robot.slots.first_motor
    for i in range(robot.motor_index, robot.unit.shape[0]):
        residual[i] = 0.0
    for number in range(robot.groups.shape[0]):
        index, motors = robot.slot_index[number], robot.motor_slot_index[number]
        for lane in range(index.shape[1]):
            for slot in range(index.shape[0]):
                i = index[slot, lane]
                if i >= 0:
                    residual[i] = get(work.residuals, (number, slot), lane)
            for m in range(motors.shape[0]):
                i = motors[m, lane]
                if i >= 0:
                    ratio = get(robot.motor_ratio, (number, m), lane)
                    effort = get(work.residuals, (number, first_motor + m), lane)
                    residual[i] += ratio * effort
    return energy


@part
def tangent_into(robot, work, tangent):
    """The tangent by states, (N, N), from the slots; entries that are always zero are not written."""
    inner, platform = robot.slots.inner_count, robot.platform_index
    axes = robot.platform_axes
    for row in range(axes.shape[0]):
        for column in range(axes.shape[0]):
            value = work.platform_tangent[axes[row], axes[column]]
            tangent[platform + row, platform + column] = value
    for number in range(robot.groups.shape[0]):
        for lane in range(robot.slot_index.shape[2]):
            _clear_motors(robot, number, lane, tangent)
    for number in range(robot.groups.shape[0]):
        index = robot.slot_index[number]
        for lane in range(index.shape[1]):
            _motors_into(robot, number, lane, work, tangent)
            for slot in range(inner):
                i = index[slot, lane]
                if i < 0:
                    continue
                for other in range(slot, inner):
                    j = index[other, lane]
                    if j >= 0:
                        value = get(work.blocks, (number, slot, other), lane)
                        tangent[i, j] = tangent[j, i] = value
                for column in range(axes.shape[0]):
                    value = get(work.blocks, (number, slot, inner + column), lane)
                    tangent[i, platform + column] = tangent[platform + column, i] = value


@inlined
def _clear_motors(robot, number, lane, tangent):
    """Zero what ``_motors_into`` adds to: one motor may be in several slots."""
    motors = robot.motor_slot_index[number]
    for m in range(robot.slots.motor_count):
        i = motors[m, lane]
        if i < 0:
            continue
        for slot in range(robot.slots.first_motor + m + 1):
            j = _coordinate_of(robot, number, slot, lane)
            if j >= 0:
                tangent[i, j] = tangent[j, i] = 0.0


@inlined
def _motors_into(robot, number, lane, work, tangent):
    """Rows and columns of the motors of a leg."""
    slots, motors = robot.slots, robot.motor_slot_index[number]
    for m in range(slots.motor_count):
        i, column = motors[m, lane], slots.first_motor + m
        if i < 0:
            continue
        ratio = get(robot.motor_ratio, (number, m), lane)
        for slot in range(column + 1):
            j = _coordinate_of(robot, number, slot, lane)
            if j < 0:
                continue
            share = ratio
            if slot >= slots.first_motor:
                share *= get(robot.motor_ratio, (number, slot - slots.first_motor), lane)
            value = share * get(work.blocks, (number, slot, column), lane)
            tangent[i, j] += value
            if slot != column:  # one motor in both slots: twice on the diagonal
                tangent[j, i] += value


@inlined
def _coordinate_of(robot, number, slot, lane):
    """State index of what a leg has in a slot; negative: nothing."""
    slots = robot.slots
    if slot < slots.inner_count:
        return robot.slot_index[number, slot, lane]
    if slot < slots.first_motor:
        return robot.platform_index + slot - slots.first_platform
    return robot.motor_slot_index[number, slot - slots.first_motor, lane]


@inlined
def _add_platform_loads(loads, rotation, position, residual, tangent):
    """Weight and wrench of the platform; returns their potential [J]."""
    given, frame = loads.platform[0], load_matrix(rotation, ())
    weight, force_world = load_vector(given.weight, ()), load_vector(given.force_world, ())
    lever = matrix_vector(frame, load_vector(given.center_of_mass, ()))
    moment_body = matrix_vector(frame, load_vector(given.moment_body, ()))
    force_body = matrix_vector(frame, load_vector(given.force_body, ()))
    field = outer(lever, weight)

    moment = add(add(load_vector(given.moment_world, ()), moment_body), axial(field))
    force = add(add(force_world, force_body), weight)
    _subtract_from_vector(residual[ANGULAR], moment)
    _subtract_from_vector(residual[LINEAR], force)
    # Small rotations turn following loads: -(omega x m), -(omega x f).
    _subtract_from_matrix(
        tangent[ANGULAR, ANGULAR], subtract(less_trace(field), cross_matrix(moment_body))
    )
    _subtract_from_matrix(tangent[LINEAR, ANGULAR], negated(cross_matrix(force_body)))
    origin = load_vector(position, ())
    return -dot(force_world, origin) - dot(weight, add(origin, lever))


@inlined
def _subtract_from_vector(array, vector):
    store_vector(array, (), subtract(load_vector(array, ()), vector))


@inlined
def _subtract_from_matrix(array, matrix):
    store_matrix(array, (), subtract(load_matrix(array, ()), matrix))

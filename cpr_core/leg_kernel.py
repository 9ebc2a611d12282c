# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Energy, static balance, constraint and exact tangent of a group of legs, in one pass along the rods.

The world frame and small world rotations are used throughout. Every leg coordinate that turns
cross-sections has a density omega_a(s) and a rotation field Theta_a(s) = int_0^s omega_a. All loads
and multipliers enter through two fields only (docs/derivations.md):

    gradient   -int omega_a . m ds,        m(s) = int_s^l t x n - c
    Hessian    -int Theta_a . Q omega_b ds + (a <-> b),   Q(s) = int_s^l (t n^T - t.n 1) - S

with the tangent t = R e1, the internal force n(s), and c, S from the moment multipliers.

Results go to the slots of `kernel_arrays`: `blocks` (upper triangle, slots of the leg, platform, motor),
`residuals`, and what all legs do to the platform. Slots a leg lacks hold numbers without meaning.
"""

from __future__ import annotations

from .compiled import inlined
from .lanes import broadcast, load, put, store, total
from .rod_kernel import integrate_arms, integrate_frames, turn_base
from .stiffness_kernel import strain_block

__all__ = ["evaluate_group"]

# Vectors and matrices in the workspace.
_CHORD, _BASE, _FORCE, _LEVER, _MOMENT, _BASE_MOMENT, _TURN, _POINT, _SPREAD = (
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
    9,
)
_FRAME, _ALIGNMENT, _BASE_MATRIX, _MOMENTS, _IMAGE = 0, 1, 2, 3, 4
# What is integrated with the shape functions.
_DENSITY, _SWEPT, _TIP_TURN, _TURNING = 0, 1, 4, 7


@inlined
def evaluate_group(
    robot, loads, loaded, number, state, platform_rotation, platform_position, work
):  # fmt: skip
    """Add a group of legs to the model and return its potential energy.

    Args:
        robot: RobotArrays.
        loads: LoadArrays.
        loaded: Whether any rod carries a load.
        number: Number of the group.
        state: Global state, (N,).
        platform_rotation: R_p in the world, (3, 3).
        platform_position: p_p in the world, (3,).
        work: Workspace; `blocks` and `residuals` of the group are set, `platform_residual` and
            `platform_tangent` are added to.

    Returns:
        Elastic energy and potential of the rods' loads [J].
    """
    _gather(robot, number, state, work)
    length = _base(robot, number, state, work)
    integrate_frames(robot, number, work.squares[_FRAME], work)
    integrate_arms(robot, length, _CHORD, work)
    if loaded:
        _gather_loads(robot, loads, number, work)
    _constraints(robot, number, length, platform_rotation, platform_position, work)
    _internal_loads(robot, number, length, loaded, work)
    energy = _balance(robot, number, length, loaded, work)
    _fields(robot, number, work)
    _coordinates(robot, number, work)
    strain_block(robot, number, length, work)
    _base_coordinates(robot, number, length, loaded, work)
    return energy


@inlined
def _gather(robot, number, state, work):
    """The state by slots; zero where a leg lacks a slot."""
    index = robot.slot_index[number]
    for slot in range(index.shape[0]):
        for lane in range(index.shape[1]):
            i = index[slot, lane]
            put(work.strain, slot, lane, state[i] if i >= 0 else 0.0)


@inlined
def _gather_loads(robot, loads, number, work):
    """Loads of the rods by lanes, and those on the whole rod."""
    width, nodes = robot.slot_index.shape[2], loads.point.shape[2]
    for lane in range(width):
        leg = number * width + lane
        for i in range(3):
            for k in range(nodes):
                there = leg < loads.point.shape[0]
                put(work.rod_loads, (0, i, k), lane, loads.point[leg, i, k] if there else 0.0)
                put(work.rod_loads, (1, i, k), lane, loads.distributed[leg, i, k] if there else 0.0)


@inlined
def _base(robot, number, state, work):
    """Base points and frames; returns the rod lengths."""
    group = robot.groups[number]
    small = work.small
    turn_base(group, state, work.squares[_FRAME], small)
    length = load(group.length, ())
    for i in range(3):
        store(small, (_BASE, i), load(group.base_position, i))
    if robot.shifted:
        for lane in range(group.shift_index.shape[0]):
            i = group.shift_index[lane]
            put(small, (_TURN, 0), lane, state[i] if i >= 0 else 0.0)
        shift, extensible = load(small, (_TURN, 0)), load(group.extensible, ())
        length = length + extensible * (shift - length)
        for i in range(3):
            moved = load(group.base_position, i) + load(group.translation_axis, i) * shift
            store(small, (_BASE, i), moved)
    return length


@inlined
def _constraints(robot, number, length, platform_rotation, platform_position, work):
    """Constraints, what their multipliers do to rod tips and platform, and the couplings."""
    group, small, blocks = robot.groups[number], work.small, work.blocks
    residuals, strain = work.residuals, work.strain
    frame, alignment = work.squares[_FRAME], work.squares[_ALIGNMENT]
    moments, image = work.squares[_MOMENTS], work.squares[_IMAGE]
    strains, count = robot.function.shape[0], robot.position_axes.shape[0]
    inner, axes = robot.slot_index.shape[1], robot.platform_axes
    zero = broadcast(small, 0.0)
    for i in range(3):
        store(small, (_FORCE, i), zero)
        store(small, (_MOMENT, i), zero)
        lever = platform_rotation[i, 0] * load(group.tip_position, 0)
        lever += platform_rotation[i, 1] * load(group.tip_position, 1)
        lever += platform_rotation[i, 2] * load(group.tip_position, 2)
        store(small, (_LEVER, i), lever)
        for j in range(3):
            store(alignment, (i, j), zero)
    for row in range(count):
        i = robot.position_axes[row]
        store(small, (_FORCE, i), load(strain, strains + row))
        gap = load(small, (_LEVER, i)) + platform_position[i] - load(small, (_BASE, i))
        store(residuals, (number, strains + row), gap - length * load(small, (_CHORD, i)))
    for row in range(robot.orientation_count):
        slot = strains + count + row
        for i in range(3):
            for j in range(3):
                value = platform_rotation[i, 0] * load(group.orientation, (row, 0, j))
                value += platform_rotation[i, 1] * load(group.orientation, (row, 1, j))
                value += platform_rotation[i, 2] * load(group.orientation, (row, 2, j))
                store(image, (i, j), value)
        value, mx, my, mz = zero, zero, zero, zero
        for j in range(3):
            l0, l1, l2 = load(frame, (0, j)), load(frame, (1, j)), load(frame, (2, j))
            g0, g1, g2 = load(image, (0, j)), load(image, (1, j)), load(image, (2, j))
            value += l0 * g0 + l1 * g1 + l2 * g2
            mx += l1 * g2 - l2 * g1
            my += l2 * g0 - l0 * g2
            mz += l0 * g1 - l1 * g0
        store(moments, (row, 0), mx)
        store(moments, (row, 1), my)
        store(moments, (row, 2), mz)
        store(residuals, (number, slot), value)
        multiple = load(strain, slot)
        for i in range(3):
            store(
                small, (_MOMENT, i), load(small, (_MOMENT, i)) + multiple * load(moments, (row, i))
            )
            for j in range(3):
                value = load(alignment, (i, j))  # N = sum_k mu_k sum_j (R_l e_j) (G_k e_j)^T
                for n in range(3):
                    value += multiple * load(frame, (i, n)) * load(image, (j, n))
                store(alignment, (i, j), value)

    # What the legs do to the platform. Missing legs have neither force nor moment.
    dot, trace = zero, zero
    for i in range(3):
        j, n = (i + 1) % 3, (i + 2) % 3
        force = load(small, (_FORCE, i))
        work.platform_residual[3 + i] += total(force)
        torque = load(small, (_LEVER, j)) * load(small, (_FORCE, n))
        torque -= load(small, (_LEVER, n)) * load(small, (_FORCE, j))
        work.platform_residual[i] += total(torque - load(small, (_MOMENT, i)))
        dot += load(small, (_LEVER, i)) * force
        trace += load(alignment, (i, i))
    rest = total(dot + trace)
    for i in range(3):
        for j in range(3):
            value = load(small, (_LEVER, i)) * load(small, (_FORCE, j)) + load(alignment, (j, i))
            work.platform_tangent[i, j] += total(value)
        work.platform_tangent[i, i] -= rest

    for column in range(axes.shape[0]):
        axis = axes[column]
        for row in range(count):
            i = robot.position_axes[row]
            j, n = (i + 1) % 3, (i + 2) % 3
            value = zero
            if axis == 3 + i:
                value = broadcast(small, 1.0)
            elif axis == j:
                value = load(small, (_LEVER, n))
            elif axis == n:
                value = -load(small, (_LEVER, j))
            store(blocks, (number, strains + row, inner + column), value)
        if axis < 3:
            for row in range(robot.orientation_count):
                value = -load(moments, (row, axis))
                store(blocks, (number, strains + count + row, inner + column), value)


@inlined
def _internal_loads(robot, number, length, loaded, work):
    """The matrices ``int_s^l t n^T`` at nodes and base, and the moment at the base."""
    small, arm, matrix, frames = work.small, work.arm, work.matrix, work.frames
    base_matrix, nodes = work.squares[_BASE_MATRIX], robot.weights.shape[0]
    for j in range(3):
        force = load(small, (_FORCE, j))
        for i in range(3):
            store(base_matrix, (i, j), length * load(small, (_CHORD, i)) * force)
            for k in range(nodes):
                store(matrix, (i, j, k), load(arm, (i, k)) * force)
    if loaded:
        value = work.density
        for j in range(3):
            for i in range(3):
                for node in range(nodes):
                    carried = load(work.rod_loads, (0, j, node))
                    carried += length * load(work.rod_loads, (1, j, node))
                    store(value, (i, node), length * load(frames, (0, i, node)) * carried)
                whole = _beyond(robot, value, i, work.projected, i)
                store(base_matrix, (i, j), load(base_matrix, (i, j)) + whole)
                for k in range(nodes):
                    there = load(matrix, (i, j, k)) + load(work.projected, (i, k))
                    store(matrix, (i, j, k), there)
    for i in range(3):
        j, n = (i + 1) % 3, (i + 2) % 3
        value = load(base_matrix, (j, n)) - load(base_matrix, (n, j)) - load(small, (_MOMENT, i))
        store(small, (_BASE_MOMENT, i), value)


@inlined
def _beyond(robot, values, row, result, target):
    """Integrals of a row of values from every node to the tip; returns that from the base."""
    integration, weights, panel = robot.integration, robot.weights, robot.panel_nodes
    whole = broadcast(values, 0.0)
    for j in range(weights.shape[0]):
        whole += weights[j] * load(values, (row, j))
    rest = whole
    for first in range(0, weights.shape[0], panel):
        for k in range(first, first + panel):
            value = rest
            for j in range(first, first + panel):
                value -= integration[j, k] * load(values, (row, j))
            store(result, (target, k), value)
        for j in range(first, first + panel):
            rest -= weights[j] * load(values, (row, j))
    return whole


@inlined
def _balance(robot, number, length, loaded, work):
    """What does not come from fields along the rods: elastic forces, base coordinates, energy."""
    group, small, strain, residuals = robot.groups[number], work.small, work.strain, work.residuals
    strains, motor = robot.function.shape[0], work.residuals.shape[1] - 1
    passive = robot.slot_index.shape[1] - 1
    zero = broadcast(small, 0.0)
    nominal, exists = load(group.length, ()), load(group.exists, ())
    ratio = nominal / length
    stored, relaxed = zero, zero
    for slot in range(strains):
        value = zero
        for other in range(strains):
            value += load(robot.elastic, (number, slot, other)) * load(strain, other)
        store(work.stretched, slot, value)
        amplitude, rest = load(strain, slot), load(robot.rest_moment, (number, slot))
        stored += value * amplitude
        relaxed += amplitude * rest
        store(residuals, (number, slot), ratio * value - rest)
    energy = 0.5 * load(group.rest_energy, ()) / ratio - relaxed + 0.5 * ratio * stored

    turn = zero
    for i in range(3):
        turn -= load(group.rotation_axis, i) * load(small, (_BASE_MOMENT, i))
    shift = zero
    if robot.shifted or loaded:
        # Loads on the whole rod: their potential, and its derivative by the shift.
        extensible = load(group.extensible, ())
        length_force = zero
        for i in range(3):
            direct, spread, whole_point, whole_spread = zero, zero, zero, zero
            force, chord = load(small, (_FORCE, i)), load(small, (_CHORD, i))
            if loaded:
                last = robot.weights.shape[0]
                for k in range(last):
                    weighted = robot.weights[k] * load(work.frames, (0, i, k))
                    direct += weighted * load(work.rod_loads, (0, i, k))
                    spread += weighted * load(work.rod_loads, (1, i, k))
                whole_point = load(work.rod_loads, (0, i, last))
                whole_spread = load(work.rod_loads, (1, i, last))
            base = load(small, (_BASE, i))
            length_force += force * chord + direct + 2.0 * length * spread
            # The rod of an extensible leg comes out of its base point: no potential is counted there.
            energy -= length * direct + length * length * spread + base * whole_point
            energy -= (1.0 - extensible) * base * length * whole_spread
            shift -= load(group.translation_axis, i) * (force + whole_point + length * whole_spread)
        length_force += 0.5 * ratio / length * stored - 0.5 * load(group.rest_energy, ()) / nominal
        shift -= extensible * length_force
    turn_motor, shift_motor = load(group.turn_motor, ()), load(group.shift_motor, ())
    store(residuals, (number, motor), turn_motor * turn + shift_motor * shift)
    if robot.passive:
        value = load(group.turn_passive, ()) * turn + load(group.shift_passive, ()) * shift
        store(residuals, (number, passive), value)
    return total(exists * energy)


@inlined
def _fields(robot, number, work):
    """Q at nodes and base, and all that is integrated along the rods with shape functions."""
    group, small, frames, arm = robot.groups[number], work.small, work.frames, work.arm
    matrix, turned, sources = work.matrix, work.turned, work.sources
    alignment, base_matrix = work.squares[_ALIGNMENT], work.squares[_BASE_MATRIX]
    nominal = load(group.length, ())
    start = _first_component(robot)
    n00, n01, n02 = load(alignment, (0, 0)), load(alignment, (0, 1)), load(alignment, (0, 2))
    n10, n11, n12 = load(alignment, (1, 0)), load(alignment, (1, 1)), load(alignment, (1, 2))
    n20, n21, n22 = load(alignment, (2, 0)), load(alignment, (2, 1)), load(alignment, (2, 2))
    trace = n00 + n11 + n22
    mx, my, mz = load(small, (_MOMENT, 0)), load(small, (_MOMENT, 1)), load(small, (_MOMENT, 2))
    x, y, z = (
        load(group.rotation_axis, 0), load(group.rotation_axis, 1), load(group.rotation_axis, 2),
    )  # fmt: skip
    for k in range(robot.weights.shape[0]):
        scale = robot.weights[k] * nominal
        q00, q01, q02 = load(matrix, (0, 0, k)), load(matrix, (0, 1, k)), load(matrix, (0, 2, k))
        q10, q11, q12 = load(matrix, (1, 0, k)), load(matrix, (1, 1, k)), load(matrix, (1, 2, k))
        q20, q21, q22 = load(matrix, (2, 0, k)), load(matrix, (2, 1, k)), load(matrix, (2, 2, k))
        # Internal moment, and Q = matrix - tr(matrix) 1 - (N - tr(N) 1).
        m0, m1, m2 = q12 - q21 - mx, q20 - q02 - my, q01 - q10 - mz
        diagonal = q00 + q11 + q22 - trace
        q00, q01, q02 = q00 - diagonal - n00, q01 - n01, q02 - n02
        q10, q11, q12 = q10 - n10, q11 - diagonal - n11, q12 - n12
        q20, q21, q22 = q20 - n20, q21 - n21, q22 - diagonal - n22
        ax, ay, az = load(arm, (0, k)), load(arm, (1, k)), load(arm, (2, k))
        for c in range(start, 3):
            dx, dy, dz = load(frames, (c, 0, k)), load(frames, (c, 1, k)), load(frames, (c, 2, k))
            dx, dy, dz = scale * dx, scale * dy, scale * dz
            tx = q00 * dx + q01 * dy + q02 * dz
            ty = q10 * dx + q11 * dy + q12 * dz
            tz = q20 * dx + q21 * dy + q22 * dz
            store(turned, (c, 0, k), tx)
            store(turned, (c, 1, k), ty)
            store(turned, (c, 2, k), tz)
            store(sources, (c, _DENSITY, k), dx * m0 + dy * m1 + dz * m2)
            store(sources, (c, _SWEPT, k), dy * az - dz * ay)
            store(sources, (c, _SWEPT + 1, k), dz * ax - dx * az)
            store(sources, (c, _SWEPT + 2, k), dx * ay - dy * ax)
            store(sources, (c, _TIP_TURN, k), dx)
            store(sources, (c, _TIP_TURN + 1, k), dy)
            store(sources, (c, _TIP_TURN + 2, k), dz)
            store(sources, (c, _TURNING, k), x * tx + y * ty + z * tz)
    diagonal = load(base_matrix, (0, 0)) + load(base_matrix, (1, 1)) + load(base_matrix, (2, 2))
    diagonal -= trace
    for i in range(3):
        store(base_matrix, (i, i), load(base_matrix, (i, i)) - diagonal)
        for j in range(3):
            store(base_matrix, (i, j), load(base_matrix, (i, j)) - load(alignment, (i, j)))


@inlined
def _first_component(robot):
    """The first strain component any leg has."""
    first = 0
    while first < 2 and robot.component_start[first + 1] == robot.component_start[first]:
        first += 1
    return first


@inlined
def _coordinates(robot, number, work):
    """Integrals of all fields with the shape functions: balance, tip Jacobian, couplings."""
    group, blocks, residuals = robot.groups[number], work.blocks, work.residuals
    sources, functions = work.sources, robot.functions
    strains, count = robot.function.shape[0], robot.position_axes.shape[0]
    inner, motor = robot.slot_index.shape[1], work.blocks.shape[1] - 1
    turn_motor, turn_passive = load(group.turn_motor, ()), load(group.turn_passive, ())
    nodes = robot.weights.shape[0]
    zero = broadcast(sources, 0.0)
    for c in range(3):
        for slot in range(robot.component_start[c], robot.component_start[c + 1]):
            f = robot.function[slot]
            s0, s1, s2, s3, s4 = zero, zero, zero, zero, zero
            for k in range(nodes):
                value = load(functions, (number, f, k))
                s0 += value * load(sources, (c, _DENSITY, k))
                s1 += value * load(sources, (c, _SWEPT, k))
                s2 += value * load(sources, (c, _SWEPT + 1, k))
                s3 += value * load(sources, (c, _SWEPT + 2, k))
                s4 += value * load(sources, (c, _TURNING, k))
            store(residuals, (number, slot), load(residuals, (number, slot)) - s0)
            for row in range(count):
                i = robot.position_axes[row]
                swept = s1 if i == 0 else (s2 if i == 1 else s3)
                store(blocks, (number, slot, strains + row), -swept)
            store(blocks, (number, slot, motor), -(turn_motor * s4))
            if robot.passive:
                store(blocks, (number, slot, inner - 1), -(turn_passive * s4))
            if robot.orientation_count > 0:
                s1, s2, s3 = zero, zero, zero
                for k in range(nodes):
                    value = load(functions, (number, f, k))
                    s1 += value * load(sources, (c, _TIP_TURN, k))
                    s2 += value * load(sources, (c, _TIP_TURN + 1, k))
                    s3 += value * load(sources, (c, _TIP_TURN + 2, k))
                _couple_orientation(robot, number, slot, s1, s2, s3, work)


@inlined
def _couple_orientation(robot, number, slot, x, y, z, work):
    """Entries of a coordinate that turns the tip by (x, y, z): joint rows, platform rotation."""
    moments, alignment = work.squares[_MOMENTS], work.squares[_ALIGNMENT]
    first = robot.function.shape[0] + robot.position_axes.shape[0]
    inner = robot.slot_index.shape[1]
    for row in range(robot.orientation_count):
        value = x * load(moments, (row, 0)) + y * load(moments, (row, 1))
        _set(work.blocks, number, slot, first + row, value + z * load(moments, (row, 2)))
    trace = load(alignment, (0, 0)) + load(alignment, (1, 1)) + load(alignment, (2, 2))
    for column in range(robot.platform_axes.shape[0]):
        j = robot.platform_axes[column]
        if j < 3:
            # Theta^T (tr(N) 1 - N^T)
            own = x if j == 0 else (y if j == 1 else z)
            value = trace * own - x * load(alignment, (j, 0)) - y * load(alignment, (j, 1))
            value -= z * load(alignment, (j, 2))
            _set(work.blocks, number, slot, inner + column, value)


@inlined
def _set(blocks, number, i, j, value):
    """Set an entry of the upper triangle."""
    store(blocks, (number, min(i, j), max(i, j)), value)


@inlined
def _base_coordinates(robot, number, length, loaded, work):
    """Rows and columns of the coordinates of the base: the motor, and the passive one."""
    group, small, blocks = robot.groups[number], work.small, work.blocks
    base_matrix = work.squares[_BASE_MATRIX]
    strains, count = robot.function.shape[0], robot.position_axes.shape[0]
    passive, motor = robot.slot_index.shape[1] - 1, work.blocks.shape[1] - 1
    turn_motor, turn_passive = load(group.turn_motor, ()), load(group.turn_passive, ())
    shift_motor, extensible = load(group.shift_motor, ()), load(group.extensible, ())
    x, y, z = (
        load(group.rotation_axis, 0), load(group.rotation_axis, 1), load(group.rotation_axis, 2),
    )  # fmt: skip
    zero = broadcast(small, 0.0)
    turning = zero
    for i in range(3):
        row = x * load(base_matrix, (i, 0)) + y * load(base_matrix, (i, 1))
        row += z * load(base_matrix, (i, 2))
        turning -= load(group.rotation_axis, i) * row
    store(blocks, (number, motor, motor), turn_motor * turning)
    if robot.passive:
        store(blocks, (number, passive, passive), turn_passive * turning)
    for row in range(count):
        i = robot.position_axes[row]
        j, n = (i + 1) % 3, (i + 2) % 3
        moved = load(group.rotation_axis, j) * load(small, (_CHORD, n))
        moved -= load(group.rotation_axis, n) * load(small, (_CHORD, j))
        moved = length * moved
        by_motor = turn_motor * moved
        if robot.shifted:
            by_motor += shift_motor * load(group.translation_axis, i)
            by_motor += extensible * load(small, (_CHORD, i))
        store(blocks, (number, strains + row, motor), -by_motor)
        if robot.passive:
            by_passive = turn_passive * moved
            by_passive += load(group.shift_passive, ()) * load(group.translation_axis, i)
            store(blocks, (number, strains + row, passive), -by_passive)
    if robot.orientation_count > 0:
        _couple_orientation(
            robot, number, motor, turn_motor * x, turn_motor * y, turn_motor * z, work
        )  # fmt: skip
        if robot.passive:
            _couple_orientation(
                robot, number, passive, turn_passive * x, turn_passive * y, turn_passive * z, work
            )  # fmt: skip
    if robot.extensible:
        _extension(robot, number, length, loaded, work)


@inlined
def _extension(robot, number, length, loaded, work):
    """Couplings of a rod length as motor: ``p(l) = p_0 + l int t dsigma``."""
    group, small, blocks, frames = robot.groups[number], work.small, work.blocks, work.frames
    rate, sources = work.density, work.sources
    nodes, motor = robot.weights.shape[0], work.blocks.shape[1] - 1
    passive = robot.slot_index.shape[1] - 1
    extensible, nominal = load(group.extensible, ()), load(group.length, ())
    zero = broadcast(small, 0.0)
    # Derivative of the internal moment by the length, int_s^1 t x (f + point + 2 l distributed).
    turning, length_rate = zero, zero
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for j in range(nodes):
            first, second = load(small, (_FORCE, a)), load(small, (_FORCE, b))
            if loaded:
                twice = 2.0 * length
                first += load(work.rod_loads, (0, a, j)) + twice * load(work.rod_loads, (1, a, j))
                second += load(work.rod_loads, (0, b, j)) + twice * load(work.rod_loads, (1, b, j))
                spread = load(work.rod_loads, (1, i, j))
                length_rate += 2.0 * robot.weights[j] * load(frames, (0, i, j)) * spread
            value = load(frames, (0, a, j)) * second - load(frames, (0, b, j)) * first
            store(work.projected, (i, j), value)
        base_rate = _beyond(robot, work.projected, i, rate, i)
        turning -= load(group.rotation_axis, i) * base_rate
    stored = zero
    for c in range(3):
        for slot in range(robot.component_start[c], robot.component_start[c + 1]):
            f = robot.function[slot]
            stretched = load(work.stretched, slot)
            stored += stretched * load(work.strain, slot)
            value = nominal / (length * length) * stretched
            for k in range(nodes):
                # The frames times nominal length and weight are the tip turns of the modes.
                turn = load(sources, (c, _TIP_TURN, k)) * load(rate, (0, k))
                turn += load(sources, (c, _TIP_TURN + 1, k)) * load(rate, (1, k))
                turn += load(sources, (c, _TIP_TURN + 2, k)) * load(rate, (2, k))
                value += load(robot.functions, (number, f, k)) * turn
            before = load(blocks, (number, slot, motor))
            store(blocks, (number, slot, motor), before - extensible * value)
    stiffening = nominal / (length * length * length) * stored - length_rate
    before = load(blocks, (number, motor, motor))
    store(blocks, (number, motor, motor), before + extensible * stiffening)
    if robot.passive:
        store(blocks, (number, passive, motor), extensible * turning)

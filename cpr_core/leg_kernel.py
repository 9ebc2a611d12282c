"""Energy, static balance, constraint and exact tangent of one leg, in one pass along the rod.

The world frame and small world rotations are used throughout. Every leg coordinate that turns
cross-sections has a density omega_a(s) and a rotation field Theta_a(s) = int_0^s omega_a. All loads
and multipliers enter through two fields only (docs/derivations.md):

    gradient   -int omega_a . m ds,        m(s) = int_s^l t x n - c
    Hessian    -int Theta_a . Q omega_b ds + (a <-> b),   Q(s) = int_s^l (t n^T - t.n 1) - S

with the tangent t = R e1, the internal force n(s), and c, S from the moment multipliers.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import compiled
from .lie import multiply, rotate, rotation_exp_into

__all__ = ["evaluate_leg", "rotation_steps"]

_ALPHA_2 = math.sqrt(15.0) / 3.0
_ALPHA_3 = 10.0 / 3.0


@compiled
def rotation_steps(curvature, lengths, vectors):
    """Rotation vectors over steps of ``R' = R kappa^``: Magnus expansion of order six.

    Args:
        curvature: Body curvature at the three Gauss points of G steps, [component, point, step].
        lengths: Lengths of the steps, (G,).
        vectors: Result, (3, G), such that ``R(end) = R(start) exp(vector^)``.
    """
    for step in range(lengths.shape[0]):
        h = lengths[step]
        a1, a2, a3 = h * curvature[0, 1, step], h * curvature[1, 1, step], h * curvature[2, 1, step]
        p1, p2, p3 = h * curvature[0, 0, step], h * curvature[1, 0, step], h * curvature[2, 0, step]
        q1, q2, q3 = h * curvature[0, 2, step], h * curvature[1, 2, step], h * curvature[2, 2, step]
        b1, b2, b3 = _ALPHA_2 * (q1 - p1), _ALPHA_2 * (q2 - p2), _ALPHA_2 * (q3 - p3)
        c1 = _ALPHA_3 * (q1 - 2.0 * a1 + p1)
        c2 = _ALPHA_3 * (q2 - 2.0 * a2 + p2)
        c3 = _ALPHA_3 * (q3 - 2.0 * a3 + p3)
        # f = a x b;  s = a x (f - 2 c) / 60 - b
        f1, f2, f3 = a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1
        g1, g2, g3 = f1 - 2.0 * c1, f2 - 2.0 * c2, f3 - 2.0 * c3
        s1 = (a2 * g3 - a3 * g2) / 60.0 - b1
        s2 = (a3 * g1 - a1 * g3) / 60.0 - b2
        s3 = (a1 * g2 - a2 * g1) / 60.0 - b3
        u1, u2, u3 = 20.0 * a1 + c1 + f1, 20.0 * a2 + c2 + f2, 20.0 * a3 + c3 + f3
        vectors[0, step] = a1 + c1 / 12.0 - (u2 * s3 - u3 * s2) / 240.0
        vectors[1, step] = a2 + c2 / 12.0 - (u3 * s1 - u1 * s3) / 240.0
        vectors[2, step] = a3 + c3 / 12.0 - (u1 * s2 - u2 * s1) / 240.0


@compiled
def _integrate_rotation(
    leg, direction, step_values, steps, step_node, state, rotation, curvature, vectors, work, frames
):  # fmt: skip
    """Frames at the nodes and at the tip.

    Args:
        leg: LEG record.
        direction: Strain component of every coordinate, (M,).
        step_values: Shape functions at the Gauss points of the steps, (M, 3, G).
        steps: Step lengths in sigma, (G,).
        step_node: Node at the end of every step or -1, (G,).
        state: Global state.
        rotation: On entry the base frame, on return the tip frame, (3, 3).
        curvature: Work space, (3, 3, G).
        vectors: Work space, (3, G).
        work: Work space, (2, 3, 3).
        frames: Result [direction, component, node]: the vectors d1, d2, d3 at the nodes.
    """
    increment, product = work[0], work[1]
    for i in range(3):
        for point in range(3):
            for step in range(steps.shape[0]):
                curvature[i, point, step] = 0.0
    # Strain coordinates are curvatures at the nominal length: the rotation does not see the length.
    for mode in range(leg.strain_count):
        amplitude = leg.length * state[leg.strain_index + mode]
        i = direction[mode]
        for point in range(3):
            for step in range(steps.shape[0]):
                curvature[i, point, step] += amplitude * step_values[mode, point, step]
    rotation_steps(curvature, steps, vectors)
    for step in range(steps.shape[0]):
        rotation_exp_into(vectors[0, step], vectors[1, step], vectors[2, step], increment)
        multiply(rotation, increment, product)
        node = step_node[step]
        for i in range(3):
            for c in range(3):
                rotation[i, c] = product[i, c]
                if node >= 0:
                    frames[c, i, node] = product[i, c]


@compiled
def evaluate_leg(
    robot, loads, number, state, platform_rotation, platform_position,
    residual, tangent, platform_residual, platform_tangent, slot, work,
):  # fmt: skip
    """Add one leg to the model and return its potential energy.

    Args:
        robot: RobotArrays.
        loads: LoadArrays.
        number: Number of the leg.
        state: Global state, shape (N,).
        platform_rotation: R_p in the world, (3, 3).
        platform_position: p_p in the world, (3,).
        residual: Global residual (N,): rows of this leg are set, its motor row too.
        tangent: Global tangent (N, N): entries of this leg are set.
        platform_residual: Residual of the whole platform twist (6,), added to.
        platform_tangent: Its tangent (6, 6), added to.
        slot: State index of each component of the platform twist, -1 where held, (6,).
        work: Workspace.

    Returns:
        Elastic energy and potential of the rod's loads [J].
    """
    leg = robot.legs[number]
    weights, integration = robot.weights, robot.integration
    values, direction = robot.values[number], robot.direction[number]
    stiffness, rest_moment = robot.stiffness[number], robot.rest_moment[number]
    distributed, point = loads.distributed[number], loads.point[number]
    position_axes = robot.position_axes
    nodes, count, first = weights.shape[0], leg.strain_count, leg.strain_index
    multiplier, turn, shift = leg.multiplier_index, leg.rotation_index, leg.translation_index
    position_count, orientation_count = position_axes.shape[0], leg.orientation_count
    moments = multiplier + position_count
    nominal, axis = leg.length, leg.rotation_axis
    extensible = leg.extensible == 1

    frames, arm, internal_moment = work.fields[0], work.fields[1, 0], work.fields[1, 1]
    density, projected = work.fields[2], work.fields[3, 0]
    densities, integrals = work.densities, work.integrals
    matrix, turned, swept = work.fields[4], work.fields[5], work.fields[6]
    base, chord, lever, force = work.vectors[0], work.vectors[1], work.vectors[2], work.vectors[3]
    moment, base_moment, tip_turn = work.vectors[4], work.vectors[5], work.vectors[6]
    rotation, joint, alignment = work.matrices[0], work.matrices[1], work.matrices[2]
    moment_vectors, base_matrix, image = work.matrices[3], work.matrices[4], work.matrices[5]
    elastic, geometric = work.elastic, work.modes

    # Base.
    length = nominal
    for i in range(3):
        base[i] = leg.base_position[i]
        force[i] = 0.0
        moment[i] = 0.0
        for j in range(3):
            rotation[i, j] = leg.base_rotation[i, j]
            alignment[i, j] = 0.0  # N = sum_k mu_k sum_j (R_l e_j) (G_k e_j)^T
    if turn >= 0:
        angle = state[turn]
        rotation_exp_into(angle * axis[0], angle * axis[1], angle * axis[2], image)
        multiply(image, leg.base_rotation, rotation)
    if shift >= 0:
        if extensible:
            length = state[shift]
        else:
            for i in range(3):
                base[i] += leg.translation_axis[i] * state[shift]

    # Frames, and lever arms to the tip: arm(s) = p(l) - p(s).
    _integrate_rotation(
        leg, direction, robot.step_values[number], robot.steps, robot.step_node,
        state, rotation, work.curvature, work.vectors_of_steps, work.matrices[5:7], frames,
    )  # fmt: skip
    # Densities omega_a and rotation fields Theta_a of the strain coordinates, and the way p(s) - p(0)
    # along the rod, all in one product with the integration matrix.
    for mode in range(count):
        c = direction[mode]
        for i in range(3):
            for k in range(nodes):
                densities[3 * mode + i, k] = nominal * values[mode, k] * frames[c, i, k]
    way = densities.shape[0] - 3
    for i in range(3):
        for k in range(nodes):
            densities[way + i, k] = length * frames[0, i, k]
    np.dot(densities, integration, integrals)
    for i in range(3):
        total = 0.0
        for j in range(nodes):
            total += weights[j] * frames[0, i, j]
        chord[i] = total
        for k in range(nodes):
            arm[i, k] = length * total - integrals[way + i, k]

    # Constraints; the multipliers as force on the tip, moment vector and its matrix.
    rotate(platform_rotation, leg.tip_position, lever)
    for row in range(position_count):
        i = position_axes[row]
        force[i] = state[multiplier + row]
        residual[multiplier + row] = platform_position[i] + lever[i] - base[i] - length * chord[i]
    if orientation_count > 0:
        multiply(platform_rotation, leg.joint_rotation, joint)
        for row in range(orientation_count):
            multiply(joint, leg.orientation[row], image)
            value = 0.0
            for j in range(3):
                moment_vectors[row, j] = 0.0
            for j in range(3):
                l0, l1, l2 = rotation[0, j], rotation[1, j], rotation[2, j]
                g0, g1, g2 = image[0, j], image[1, j], image[2, j]
                value += l0 * g0 + l1 * g1 + l2 * g2
                moment_vectors[row, 0] += l1 * g2 - l2 * g1
                moment_vectors[row, 1] += l2 * g0 - l0 * g2
                moment_vectors[row, 2] += l0 * g1 - l1 * g0
            residual[moments + row] = value
            multiple = state[moments + row]
            for i in range(3):
                moment[i] += multiple * moment_vectors[row, i]
                for j in range(3):
                    for n in range(3):
                        alignment[i, j] += multiple * rotation[i, n] * image[j, n]
    trace = alignment[0, 0] + alignment[1, 1] + alignment[2, 2]

    # Platform rows: force and moment of this leg.
    for i in range(3):
        j, n = (i + 1) % 3, (i + 2) % 3
        platform_residual[3 + i] += force[i]
        platform_residual[i] += lever[j] * force[n] - lever[n] * force[j] - moment[i]

    # Internal moment m(s) and its matrix int_s^l t n^T at the nodes, and at the base.
    loaded = False
    for i in range(3):
        if distributed[i, nodes] != 0.0 or point[i, nodes] != 0.0:
            loaded = True
    for i in range(3):
        for j in range(3):
            base_matrix[i, j] = length * chord[i] * force[j]
            for k in range(nodes):
                matrix[i, j, k] = arm[i, k] * force[j]
    if loaded:
        for i in range(3):
            for j in range(3):
                for node in range(nodes):
                    carried = point[j, node] + length * distributed[j, node]
                    value = length * frames[0, i, node] * carried
                    base_matrix[i, j] += weights[node] * value
                    for k in range(nodes):
                        matrix[i, j, k] += (weights[node] - integration[node, k]) * value
    for i in range(3):
        j, n = (i + 1) % 3, (i + 2) % 3
        base_moment[i] = base_matrix[j, n] - base_matrix[n, j] - moment[i]
        for k in range(nodes):
            internal_moment[i, k] = matrix[j, n, k] - matrix[n, j, k] - moment[i]

    # Balance of the strain coordinates.
    ratio = nominal / length
    energy = 0.5 * leg.rest_energy / ratio
    stored = 0.0
    for mode in range(count):
        total = 0.0
        for other in range(count):
            total += stiffness[mode, other] * state[first + other]
        elastic[mode] = total
        stored += total * state[first + mode]
        energy -= state[first + mode] * rest_moment[mode]
    energy += 0.5 * ratio * stored
    for c in range(3):
        for k in range(nodes):
            density[c, 0, k] = (nominal * weights[k]) * (
                frames[c, 0, k] * internal_moment[0, k]
                + frames[c, 1, k] * internal_moment[1, k]
                + frames[c, 2, k] * internal_moment[2, k]
            )
    for mode in range(count):
        c = direction[mode]
        total = 0.0
        for k in range(nodes):
            total += values[mode, k] * density[c, 0, k]
        residual[first + mode] = ratio * elastic[mode] - rest_moment[mode] - total

    # Balance of the base coordinates, and the potential of the loads.
    length_force = 0.0  # minus d/dl of the potential of multipliers and loads
    length_rate = 0.0
    for i in range(3):
        direct, spread = 0.0, 0.0
        if loaded:
            for k in range(nodes):
                weighted = weights[k] * frames[0, i, k]
                direct += weighted * point[i, k]
                spread += weighted * distributed[i, k]
        length_force += force[i] * chord[i] + direct + 2.0 * length * spread
        length_rate += 2.0 * spread
        energy -= length * direct + length * length * spread + base[i] * point[i, nodes]
        # The rod of an extensible leg comes out of its base point: no potential is counted there.
        if not extensible:
            energy -= base[i] * length * distributed[i, nodes]
    if turn >= 0:
        residual[turn] = -(
            axis[0] * base_moment[0] + axis[1] * base_moment[1] + axis[2] * base_moment[2]
        )
    if shift >= 0:
        total = 0.0
        if extensible:
            total = length_force + 0.5 * ratio / length * stored - 0.5 * leg.rest_energy / nominal
        else:
            for i in range(3):
                carried = force[i] + point[i, nodes] + length * distributed[i, nodes]
                total += leg.translation_axis[i] * carried
        residual[shift] = -total

    # From here on the tangent. Platform block and its coupling to the multipliers.
    dot = lever[0] * force[0] + lever[1] * force[1] + lever[2] * force[2]
    for i in range(3):
        for j in range(3):
            platform_tangent[i, j] += lever[i] * force[j] + alignment[j, i]
        platform_tangent[i, i] -= dot + trace
    for row in range(position_count):
        i = position_axes[row]
        j, n = (i + 1) % 3, (i + 2) % 3
        _couple(tangent, slot[3 + i], multiplier + row, 1.0)
        # Written although it is zero: with roll, pitch, yaw as unknowns the three columns are mixed.
        _couple(tangent, slot[i], multiplier + row, 0.0)
        _couple(tangent, slot[j], multiplier + row, lever[n])
        _couple(tangent, slot[n], multiplier + row, -lever[j])
    for row in range(orientation_count):
        for i in range(3):
            _couple(tangent, slot[i], moments + row, -moment_vectors[row, i])

    # Q = matrix - tr(matrix) 1 - (N - tr(N) 1), in place of the matrix.
    for k in range(nodes):
        diagonal = matrix[0, 0, k] + matrix[1, 1, k] + matrix[2, 2, k] - trace
        for i in range(3):
            matrix[i, i, k] -= diagonal
    diagonal = base_matrix[0, 0] + base_matrix[1, 1] + base_matrix[2, 2] - trace
    for i in range(3):
        base_matrix[i, i] -= diagonal
        for j in range(3):
            base_matrix[i, j] -= alignment[i, j]
            if orientation_count > 0:
                for k in range(nodes):
                    matrix[i, j, k] -= alignment[i, j]

    torsion, bending = False, False
    for mode in range(count):
        torsion = torsion or direction[mode] == 0
        bending = bending or direction[mode] == 1
    start = 0 if torsion else (1 if bending else 2)
    for c in range(start, 3):
        for i in range(3):
            j, n = (i + 1) % 3, (i + 2) % 3
            for k in range(nodes):
                scale = nominal * weights[k]
                # weight * l0 * Q d_c, and weight * l0 * d_c x arm
                turned[c, i, k] = scale * (
                    matrix[i, 0, k] * frames[c, 0, k]
                    + matrix[i, 1, k] * frames[c, 1, k]
                    + matrix[i, 2, k] * frames[c, 2, k]
                )
                swept[c, i, k] = scale * (frames[c, j, k] * arm[n, k] - frames[c, n, k] * arm[j, k])

    for mode in range(count):
        c = direction[mode]
        # Constraint Jacobian: minus the motion of the tip.
        for row in range(position_count):
            i = position_axes[row]
            total = 0.0
            for k in range(nodes):
                total += values[mode, k] * swept[c, i, k]
            tangent[first + mode, multiplier + row] = -total
            tangent[multiplier + row, first + mode] = -total
        # Geometric stiffness: int Theta_a . Q omega_b.
        for d in range(start, 3):
            for k in range(nodes):
                projected[d, k] = (
                    integrals[3 * mode, k] * turned[d, 0, k]
                    + integrals[3 * mode + 1, k] * turned[d, 1, k]
                    + integrals[3 * mode + 2, k] * turned[d, 2, k]
                )
        for other in range(count):
            d = direction[other]
            total = 0.0
            for k in range(nodes):
                total += projected[d, k] * values[other, k]
            geometric[mode, other] = total
        if orientation_count > 0:
            for i in range(3):
                total = 0.0
                for k in range(nodes):
                    total += weights[k] * values[mode, k] * frames[c, i, k]
                tip_turn[i] = nominal * total
            _couple_orientation(
                tangent, slot, first + mode, tip_turn, moments,
                orientation_count, moment_vectors, alignment, trace,
            )  # fmt: skip
        if turn >= 0:
            total = 0.0
            for k in range(nodes):
                total += values[mode, k] * (
                    axis[0] * turned[c, 0, k]
                    + axis[1] * turned[c, 1, k]
                    + axis[2] * turned[c, 2, k]
                )
            tangent[turn, first + mode] = -total
            tangent[first + mode, turn] = -total
    for mode in range(count):
        for other in range(count):
            tangent[first + mode, first + other] = (
                ratio * stiffness[mode, other] - geometric[mode, other] - geometric[other, mode]
            )

    # Base coordinates.
    if turn >= 0:
        total = 0.0
        for i in range(3):
            for j in range(3):
                total += axis[i] * base_matrix[i, j] * axis[j]
        tangent[turn, turn] = -total
        for row in range(position_count):
            i = position_axes[row]
            j, n = (i + 1) % 3, (i + 2) % 3
            moved = length * (axis[j] * chord[n] - axis[n] * chord[j])
            _couple(tangent, turn, multiplier + row, -moved)
        if orientation_count > 0:
            _couple_orientation(
                tangent, slot, turn, axis, moments,
                orientation_count, moment_vectors, alignment, trace,
            )  # fmt: skip
    if shift >= 0:
        if extensible:
            tangent[shift, shift] = nominal / length**3 * stored - length_rate
            _extension_tangent(
                leg, direction, values, weights, integration, distributed, point, position_axes,
                shift, length, chord, force, frames, elastic, loaded, work.fields[7, 0], tangent,
            )  # fmt: skip
        else:
            for row in range(position_count):
                moved = leg.translation_axis[position_axes[row]]
                _couple(tangent, shift, multiplier + row, -moved)
    return energy


@compiled
def _couple(tangent, i, j, value):
    """Set a symmetric pair of entries; nothing where an index is -1."""
    if i >= 0 and j >= 0:
        tangent[i, j] = value
        tangent[j, i] = value


@compiled
def _couple_orientation(
    tangent, slot, index, turned, row, count, moment_vectors, alignment, trace
):  # fmt: skip
    """Entries of a coordinate that turns the tip by ``turned``: joint rows, platform rotation."""
    for k in range(count):
        _couple(
            tangent,
            index,
            row + k,
            turned[0] * moment_vectors[k, 0]
            + turned[1] * moment_vectors[k, 1]
            + turned[2] * moment_vectors[k, 2],
        )
    for j in range(3):
        # Theta^T (tr(N) 1 - N^T)
        value = trace * turned[j]
        for i in range(3):
            value -= turned[i] * alignment[j, i]
        _couple(tangent, index, slot[j], value)


@compiled
def _extension_tangent(
    leg, direction, values, weights, integration, distributed, point, position_axes,
    shift, length, chord, force, frames, elastic, loaded, rate, tangent,
):  # fmt: skip
    """Couplings of a rod length as coordinate: p(l) = p_0 + l int t dsigma."""
    nodes, nominal = weights.shape[0], leg.length
    for row in range(position_axes.shape[0]):
        _couple(tangent, shift, leg.multiplier_index + row, -chord[position_axes[row]])
    # Derivative of the internal moment by the length, int_s^1 t x (f + point + 2 l distributed).
    turning = 0.0
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for k in range(nodes):
            rate[i, k] = 0.0
        base_rate = 0.0
        for j in range(nodes):
            first, second = force[a], force[b]
            if loaded:
                first += point[a, j] + 2.0 * length * distributed[a, j]
                second += point[b, j] + 2.0 * length * distributed[b, j]
            value = frames[0, a, j] * second - frames[0, b, j] * first
            base_rate += weights[j] * value
            for k in range(nodes):
                rate[i, k] += (weights[j] - integration[j, k]) * value
        turning -= leg.rotation_axis[i] * base_rate
    _couple(tangent, shift, leg.rotation_index, turning)
    for mode in range(leg.strain_count):
        c = direction[mode]
        total = nominal / (length * length) * elastic[mode]
        for k in range(nodes):
            total += (nominal * weights[k] * values[mode, k]) * (
                frames[c, 0, k] * rate[0, k]
                + frames[c, 1, k] * rate[1, k]
                + frames[c, 2, k] * rate[2, k]
            )
        _couple(tangent, shift, leg.strain_index + mode, -total)

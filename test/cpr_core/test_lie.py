# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rotations: exponential, logarithm, group axioms, quaternions."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from cpr_core import lie
from cpr_core.errors import CprError, InvalidQuaternion, InvalidRequest, NonFiniteInput
from cpr_core.kernels.rotation_matrices import multiply, rotation_log_into

settings.register_profile("lie", deadline=None, derandomize=True, max_examples=100)
FAST = settings(settings.get_profile("lie"))

components = st.floats(-1.0, 1.0, allow_subnormal=False)
directions = (
    st.tuples(components, components, components)
    .map(np.array)
    .filter(lambda v: np.linalg.norm(v) > 1e-3)
    .map(lambda v: v / np.linalg.norm(v))
)
quaternions = (
    st.tuples(components, components, components, components)
    .map(np.array)
    .filter(lambda q: np.linalg.norm(q) > 1e-3)
    .map(lambda q: q / np.linalg.norm(q))
)
rotations = quaternions.map(lie.rotation_from_quaternion)
SMALL = [0.0, 1e-300, 1e-160, 1e-100, 1e-16, 1e-12, 1e-8, 1e-4, 0.01]
#: Both sides of the change from series to closed form, at a squared angle of 0.1.
AT_THE_BRANCH = [math.sqrt(0.1) * (1.0 - 1e-12), math.sqrt(0.1) * (1.0 + 1e-12)]
#: A quarter of a turn, where an arc sine has no digits, and both sides of it.
QUARTER = [0.5 * math.pi, 0.5 * math.pi - 1e-7, 0.5 * math.pi + 1e-7]
LARGE = [0.5, 1.0, 2.0, 3.0, math.pi - 1e-3, math.pi - 1e-7, math.pi - 1e-12]
AXES = [
    np.array([1.0, 0.0, 0.0]),
    np.array([0.0, 1.0, 0.0]),
    np.array([0.0, 0.0, -1.0]),
    np.array([2.0, -3.0, 6.0]) / 7.0,
    np.array([-1.0, 1e-9, 0.0]),
]


def product(left, right):
    result = np.full((3, 3), np.nan)
    multiply(left, right, result)
    return result


@given(directions, st.floats(0.0, 3.2))
@FAST
def test_exp_is_the_matrix_exponential(direction, angle):
    # No larger angles: there expm itself is off by 1e-13.
    vector = angle * direction
    assert_allclose(lie.rotation_exp(vector), expm(lie.skew(vector)), rtol=0.0, atol=1e-14)


@given(directions, st.floats(0.0, 20.0))
@FAST
def test_exp_of_several_turns_agrees_with_scipy(direction, angle):
    expected = Rotation.from_rotvec(angle * direction).as_matrix()
    assert_allclose(lie.rotation_exp(angle * direction), expected, rtol=0.0, atol=5e-15)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("angle", SMALL + AT_THE_BRANCH + LARGE)
def test_exp_agrees_with_scipy_to_the_last_digits(axis, angle):
    expected = Rotation.from_rotvec(angle * axis).as_matrix()
    assert_allclose(lie.rotation_exp(angle * axis), expected, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("angle", [*SMALL, *AT_THE_BRANCH, *QUARTER, *LARGE])
def test_log_of_the_kernels_is_the_log(axis, angle):
    rotation, found = lie.rotation_exp(angle * axis), np.full(3, np.nan)
    rotation_log_into(rotation, found)
    assert_allclose(found, lie.rotation_log(rotation), rtol=0.0, atol=1e-15 + 2e-15 * angle)


def test_exp_of_many_is_exp_of_each():
    vectors = np.array([[a * axis for axis in AXES] for a in SMALL + AT_THE_BRANCH + LARGE])
    expected = [[lie.rotation_exp(vector) for vector in row] for row in vectors]
    assert_allclose(lie.rotations_exp(vectors), expected, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("angle", SMALL + AT_THE_BRANCH + LARGE)
def test_log_undoes_exp(axis, angle):
    vector = angle * axis
    found = lie.rotation_log(lie.rotation_exp(vector))
    # Small angles keep their relative precision: nothing is lost to 1 + angle^2.
    assert_allclose(found, vector, rtol=0.0, atol=4e-15 * angle)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("angle", [math.pi, math.pi + 1e-9, math.pi + 0.1, 3.0 * math.pi])
def test_log_beyond_pi_is_the_same_rotation_of_norm_at_most_pi(axis, angle):
    rotation = lie.rotation_exp(angle * axis)
    vector = lie.rotation_log(rotation)
    assert np.linalg.norm(vector) <= math.pi * (1.0 + 1e-15)
    assert_allclose(lie.rotation_exp(vector), rotation, rtol=0.0, atol=2e-15)


def test_log_of_many_is_log_of_each():
    vectors = [angle * axis for angle in [*SMALL, *QUARTER, *LARGE, math.pi, 5.0] for axis in AXES]
    matrices = np.array([lie.rotation_exp(vector) for vector in vectors]).reshape(-1, 5, 3, 3)
    each = np.array([lie.rotation_log(matrix) for matrix in matrices.reshape(-1, 3, 3)])
    assert_allclose(lie.rotations_log(matrices).reshape(-1, 3), each, rtol=4e-16, atol=1e-300)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("angle", [*SMALL, 9e-6, 1.1e-5, *QUARTER, *LARGE, 4.0, 6.0])
def test_turns_by_vectors_are_those_of_differences_and_vectors_by_turns_their_inverse(axis, angle):
    vector, step = angle * axis, 1e-5
    turns = lie.turns_by_vector(vector)
    for column, way in zip(turns.T, step * np.eye(3), strict=True):
        low, high = lie.rotation_exp(vector - way), lie.rotation_exp(vector + way)
        assert_allclose(column, lie.rotation_log(high @ low.T) / (2.0 * step), rtol=0.0, atol=1e-9)
    both = lie.vectors_by_turn(np.array([vector, vector])) @ turns
    assert_allclose(both, [np.eye(3)] * 2, rtol=0.0, atol=4e-14)


@given(rotations)
@FAST
def test_exp_undoes_log(rotation):
    assert_allclose(lie.rotation_exp(lie.rotation_log(rotation)), rotation, rtol=0.0, atol=2e-15)


@pytest.mark.parametrize("axis", AXES[:3])
def test_log_of_exact_half_turns(axis):
    half_turn = 2.0 * np.outer(axis, axis) - np.eye(3)
    vector = lie.rotation_log(half_turn)
    assert np.linalg.norm(vector) == pytest.approx(math.pi, abs=1e-15)
    assert abs(vector @ axis) == pytest.approx(math.pi, abs=1e-15)


@given(rotations, rotations)
@FAST
def test_the_turn_between_quaternions_is_that_between_rotations(first, last):
    """Whatever their signs and, to what is taken for a rotation, their lengths."""
    turn = lie.rotation_log(last @ first.T)
    quaternions = [lie.quaternion_from_rotation(rotation) for rotation in (first, last)]
    for sign, length in ((1.0, 1.0), (-1.0, 1.0), (1.0, 1.0005)):
        found = lie.turn_between(quaternions[0], sign * length * quaternions[1])
        assert_allclose(lie.rotation_exp(found) @ first, last, atol=1e-14)
        assert np.linalg.norm(found) <= np.pi + 1e-12
        if np.linalg.norm(turn) < 3.1:
            assert_allclose(found, turn, atol=1e-14)
    assert_allclose(lie.turn_between(quaternions[0], quaternions[0]), np.zeros(3), atol=0.0)


@pytest.mark.parametrize("angle", [1e-300, 1e-16, 1e-13, 1e-9])
def test_small_turns_between_quaternions_keep_their_digits(angle):
    axis = np.array([0.6, 0.0, -0.8])
    small = np.concatenate([[1.0], 0.5 * angle * axis])
    assert_allclose(lie.turn_between([1.0, 0, 0, 0], small), angle * axis, rtol=1e-14)


def test_log_of_the_identity_is_exactly_zero():
    assert np.array_equal(lie.rotation_log(np.eye(3)), np.zeros(3))


@given(directions, st.floats(-10.0, 10.0))
@FAST
def test_exp_is_a_rotation(direction, angle):
    rotation = lie.rotation_exp(angle * direction)
    assert_allclose(rotation.T @ rotation, np.eye(3), rtol=0.0, atol=4e-15)
    assert np.linalg.det(rotation) == pytest.approx(1.0, abs=4e-15)


@given(rotations, rotations, rotations)
@FAST
def test_group_axioms(a, b, c):
    identity = np.eye(3)
    assert_allclose(product(a, product(b, c)), product(product(a, b), c), rtol=0.0, atol=4e-15)
    assert np.array_equal(product(a, identity), a)
    assert np.array_equal(product(identity, a), a)
    inverse = lie.rotation_exp(-lie.rotation_log(a))
    assert_allclose(inverse, a.T, rtol=0.0, atol=4e-15)
    assert_allclose(product(a, inverse), identity, rtol=0.0, atol=4e-15)
    closed = product(a, b)
    assert_allclose(closed.T @ closed, identity, rtol=0.0, atol=4e-15)


@given(directions, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
@FAST
def test_rotations_about_one_axis_add(direction, first, second):
    assert_allclose(
        product(lie.rotation_exp(first * direction), lie.rotation_exp(second * direction)),
        lie.rotation_exp((first + second) * direction),
        rtol=0.0,
        atol=4e-15,
    )


@given(rotations, directions, st.floats(0.0, 3.0))
@FAST
def test_conjugation_turns_the_axis(rotation, direction, angle):
    vector = angle * direction
    assert_allclose(
        rotation @ lie.rotation_exp(vector) @ rotation.T,
        lie.rotation_exp(rotation @ vector),
        rtol=0.0,
        atol=1e-14,
    )


@given(directions, directions)
@FAST
def test_kernels_are_matrix_product_and_cross_product(first, second):
    matrix, other = np.outer(first, second) + np.eye(3), lie.skew(second)
    assert_allclose(product(matrix, other), matrix @ other, rtol=0.0, atol=1e-15)
    assert_allclose(lie.skew(first) @ second, np.cross(first, second), rtol=0.0, atol=1e-15)


@given(quaternions)
@FAST
def test_quaternion_round_trip(quaternion):
    found = lie.quaternion_from_rotation(lie.rotation_from_quaternion(quaternion))
    assert found[0] >= 0.0
    assert np.linalg.norm(found) == pytest.approx(1.0, abs=1e-15)
    assert abs(found @ quaternion) == pytest.approx(1.0, abs=4e-15)
    assert min(np.abs(found - quaternion).max(), np.abs(found + quaternion).max()) < 4e-15


@given(quaternions)
@FAST
def test_quaternions_agree_with_scipy(quaternion):
    w, x, y, z = quaternion
    reference = Rotation.from_quat([x, y, z, w])
    rotation = lie.rotation_from_quaternion(quaternion)
    assert_allclose(rotation, reference.as_matrix(), rtol=0.0, atol=2e-15)
    x, y, z, w = reference.as_quat(canonical=True)
    found = lie.quaternion_from_rotation(rotation)
    assert abs(found @ [w, x, y, z]) == pytest.approx(1.0, abs=2e-15)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("angle", [1e-12, 1e-6, 1.0, math.pi - 1e-6, math.pi])
def test_quaternion_keeps_half_the_angle_precisely(axis, angle):
    found = lie.quaternion_from_rotation(lie.rotation_exp(angle * axis))
    expected = np.array([math.cos(0.5 * angle), *(math.sin(0.5 * angle) * axis)])
    if angle == math.pi and found @ expected < 0.0:
        expected = -expected
    assert_allclose(found[1:], expected[1:], rtol=0.0, atol=2e-15 * angle)
    assert found[0] == pytest.approx(expected[0], abs=2e-15)


@pytest.mark.parametrize("norm", [1.0 - 9e-4, 1.0 + 9e-4])
def test_rounded_quaternions_are_normalised(norm):
    quaternion = np.array([0.5, -0.5, 0.5, 0.5])
    assert_allclose(
        lie.rotation_from_quaternion(norm * quaternion),
        lie.rotation_from_quaternion(quaternion),
        rtol=0.0,
        atol=1e-15,
    )


@pytest.mark.parametrize(
    "quaternion",
    [
        [0.0, 0.0, 0.0, 0.0],
        [1.0 + 2e-3, 0.0, 0.0, 0.0],
        [1.0 - 2e-3, 0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0, 0.0],
        [1e100, 0.0, 0.0, 0.0],
        [90.0, 0.0, 0.0, 1.0],
    ],
)
def test_quaternions_far_from_unit_length_are_refused(quaternion):
    with pytest.raises(InvalidQuaternion, match="expected unit length") as caught:
        lie.rotation_from_quaternion(quaternion)
    assert caught.value.code == "INVALID_QUATERNION"
    assert str(quaternion[0]) in str(caught.value)


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_quaternions_that_are_not_finite_are_refused(place, value):
    quaternion = [1.0, 0.0, 0.0, 0.0]
    quaternion[place] = value
    with pytest.raises(NonFiniteInput, match="finite") as caught:
        lie.rotation_from_quaternion(quaternion)
    assert caught.value.code == "NON_FINITE_INPUT"


@pytest.mark.parametrize("quaternion", [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0, 0.0], [], 1.0])
def test_quaternions_of_the_wrong_length_are_refused(quaternion):
    with pytest.raises(CprError, match="quaternion"):
        lie.rotation_from_quaternion(quaternion)


@FAST
@given(directions)
def test_directions_across_are_across(direction):
    rows = np.vstack([direction, lie.directions_across(direction)])
    assert_allclose(rows @ rows.T, np.eye(3), rtol=0.0, atol=1e-9)


def test_directions_across_change_smoothly():
    """Where descriptions have their axes, whichever way those are varied."""
    for axis in np.vstack([np.eye(3), -np.eye(3), [[0.6, 0.8, 0.0], [-0.8, 0.0, 0.6]]]):
        for way in np.vstack([np.eye(3), -np.eye(3)]):
            moved = axis + 1e-6 * way
            beside = lie.directions_across(moved / np.linalg.norm(moved))
            assert np.abs(beside - lie.directions_across(axis)).max() < 1e-5
    pole = np.array([0.48, -0.64, 0.6])
    rows = np.vstack([pole, lie.directions_across(pole)])
    assert_allclose(rows @ rows.T, np.eye(3), rtol=0.0, atol=1e-15)


def test_a_rounded_rotation_is_the_nearest_one():
    rotation = Rotation.from_euler("xyz", [0.3, -1.1, 2.2]).as_matrix()
    for digits, allowed in ((2, 0.01), (5, 1e-5), (16, 1e-15)):
        found = lie.nearest_rotation("turned", rotation.round(digits))
        assert_allclose(found.T @ found, np.eye(3), atol=1e-15)
        assert_allclose(found, rotation, atol=allowed)


@pytest.mark.parametrize(
    "matrix",
    [
        1.1 * np.eye(3),
        -np.eye(3),
        np.diag([1.0, 1.0, -1.0]),
        np.zeros((3, 3)),
        [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]],
        1e200 * np.eye(3),
    ],
)
def test_a_matrix_that_is_far_from_any_rotation_is_refused(matrix):
    with pytest.raises(InvalidRequest, match="turned: expected a rotation matrix"):
        lie.nearest_rotation("turned", matrix)


@FAST
@given(rotation=rotations, vector=st.tuples(directions, directions).map(np.concatenate))
def test_parts_of_a_twist_turn_each_by_itself(rotation, vector):
    turned = lie.turned(vector, rotation)
    assert_allclose(turned[:3], rotation @ vector[:3], atol=1e-15)
    assert_allclose(turned[3:], rotation @ vector[3:], atol=1e-15)
    assert_allclose(lie.turned(turned, rotation.T), vector, atol=1e-14)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Vectors and matrices as values: what numpy does with arrays, of lanes, of numbers, and of both."""

import numpy as np
import pytest
from helpers.kept_kernel import kept
from numba import njit
from numpy.testing import assert_allclose, assert_array_equal

from cpr_core.kernels import lane_vectors as lv
from cpr_core.kernels.lanes import WIDTH, empty_lanes, lanes_dtype, load, store

RNG = np.random.default_rng(2)
TIMES = 50

#: Kinds of the arguments and of the result (scalar, vector, matrix), and what numpy calls it.
OPERATIONS = {
    "add": ("vv", "v", np.add),
    "subtract": ("vv", "v", np.subtract),
    "add of matrices": ("mm", "m", np.add),
    "subtract of matrices": ("mm", "m", np.subtract),
    "scaled of a matrix": ("sm", "m", np.multiply),
    "negated": ("v", "v", np.negative),
    "scaled": ("sv", "v", np.multiply),
    "add_scaled": ("vsv", "v", lambda a, factor, b: a + factor * b),
    "subtract_scaled": ("vsv", "v", lambda a, factor, b: a - factor * b),
    "dot": ("vv", "s", np.dot),
    "cross": ("vv", "v", np.cross),
    "outer": ("vv", "m", np.outer),
    "transposed": ("m", "m", np.transpose),
    "matrix_vector": ("mv", "v", np.matmul),
    "matrix_product": ("mm", "m", np.matmul),
    "trace": ("m", "s", np.trace),
    "less_trace": ("m", "m", lambda a: a - np.trace(a) * np.eye(3)),
    "axial": (
        "m",
        "v",
        lambda a: np.array([np.cross(np.eye(3)[i], a[i]) for i in range(3)]).sum(0),
    ),
}
SHAPES = {"s": (), "v": (3,), "m": (3, 3)}


@njit
def load_scalar(array, index):
    return load(array, index)


@njit
def store_scalar(array, index, value):
    store(array, index, value)


@njit
def number_at(array, index):
    return array[index]


@njit
def set_number(array, index, value):
    array[index] = value


LOAD = {"v": lv.load_vector, "m": lv.load_matrix}
STORE = {"v": lv.store_vector, "m": lv.store_matrix}


def loaded_by(kind, of_lanes):
    return LOAD.get(kind, load_scalar if of_lanes else number_at)


def stored_by(kind, of_lanes):
    return STORE.get(kind, store_scalar if of_lanes else set_number)


def random_array(kind, of_lanes):
    """Random values, a row each time, and the same as numbers with the legs last."""
    shape = (TIMES, *SHAPES[kind])
    if not of_lanes:
        numbers = RNG.normal(size=shape)
        return numbers, np.broadcast_to(numbers[..., None], (*shape, WIDTH))
    lanes = empty_lanes(WIDTH, *shape)
    lanes["lane"] = RNG.normal(size=(*shape, WIDTH))
    return lanes, lanes["lane"]


def kernel_of(name, of_lanes, loads, save):
    """A kernel that calls an operation for every row."""
    own = "_".join(["of", *name.split(), *("lanes" if lanes else "numbers" for lanes in of_lanes)])
    count = len(loads)
    arrays = ", ".join(f"array{place}" for place in range(count))
    values = ", ".join(f"load{place}(array{place}, row)" for place in range(count))
    source = f"""
def {own}(result, {arrays}):
    for row in range(result.shape[0]):
        save(result, row, operation({values}))
"""
    called = {f"load{place}": load for place, load in enumerate(loads)}
    operation = getattr(lv, name.split()[0])
    return kept(own, source, __file__, operation=operation, save=save, **called)


def mixtures():
    """Every operation with lanes, with numbers, and with numbers before or after lanes."""
    for name, (kinds, _, _) in OPERATIONS.items():
        count = len(kinds)
        yield from ((name, count * (True,)), (name, count * (False,)))
        for numbers in range(1, count):
            yield name, numbers * (False,) + (count - numbers) * (True,)
            yield name, (count - numbers) * (True,) + numbers * (False,)


@pytest.mark.parametrize(("name", "of_lanes"), list(mixtures()))
def test_operations_are_those_of_numpy(name, of_lanes):
    kinds, kind, expected = OPERATIONS[name]
    given = [random_array(*pair) for pair in zip(kinds, of_lanes, strict=True)]
    result, found = random_array(kind, any(of_lanes))
    loads = [loaded_by(*pair) for pair in zip(kinds, of_lanes, strict=True)]
    apply = kernel_of(name, of_lanes, loads, stored_by(kind, any(of_lanes)))
    apply(result, *[array for array, _ in given])
    values = [
        [expected(*[numbers[row, ..., leg] for _, numbers in given]) for leg in range(WIDTH)]
        for row in range(TIMES)
    ]
    assert_allclose(found, np.moveaxis(values, 1, -1), rtol=0.0, atol=2e-14)


def test_the_matrices_of_the_derivations():
    """``n . (u x (v x arm)) = u . less_trace(arm n^T) v``, ``axial(u v^T) = u x v = u^ v``."""

    @njit
    def differences(n, u, v, arm):
        of_two = lv.outer(arm, n)
        turned = lv.dot(n, lv.cross(u, lv.cross(v, arm)))
        by_field = lv.dot(u, lv.matrix_vector(lv.less_trace(of_two), v))
        axis = lv.subtract(lv.axial(lv.outer(u, v)), lv.cross(u, v))
        image = lv.subtract(lv.matrix_vector(lv.cross_matrix(u), v), lv.cross(u, v))
        return turned - by_field, axis, image

    for n, u, v, arm in RNG.normal(size=(TIMES, 4, 3)):
        turned, axis, image = differences(tuple(n), tuple(u), tuple(v), tuple(arm))
        assert_allclose([turned, *axis, *image], 0.0, atol=1e-13)


def test_zero_unit_and_chosen_components():
    lanes = empty_lanes(WIDTH, 4, 3)
    lanes["lane"] = 1.0

    @njit
    def fill(lanes):
        lv.store_vector(lanes, 0, lv.zero_vector(lanes))
        lv.store_matrix(lanes[1:], (), lv.zero_matrix(load(lanes, (1, 0))))

    @njit
    def unit(axis):
        return lv.unit_vector(axis)

    @njit
    def component(vector, axis):
        return lv.component(vector, axis)

    fill(lanes)
    assert not lanes["lane"].any()
    for axis in range(-3, 6):
        chosen = 0 <= axis < 3
        assert_array_equal(unit(axis), np.eye(3)[axis] if chosen else np.zeros(3))
    assert [component((3.0, 4.0, 5.0), axis) for axis in range(3)] == [3.0, 4.0, 5.0]


def test_totals_are_over_the_legs():
    (matrices, numbers), (vectors, vector_numbers) = (
        random_array("m", True),
        random_array("v", True),
    )

    @njit
    def totals(matrices, vectors, row):
        matrix, vector = lv.load_matrix(matrices, row), lv.load_vector(vectors, row)
        return lv.total_matrix(matrix), lv.total_vector(vector)

    for row in range(TIMES):
        matrix, vector = totals(matrices, vectors, row)
        assert_allclose(matrix, numbers[row].sum(axis=-1), rtol=0.0, atol=1e-14)
        assert_allclose(vector, vector_numbers[row].sum(axis=-1), rtol=0.0, atol=1e-14)


def test_places_are_components_at_the_end_of_any_array():
    """At any number of indices, in parts of arrays, in records of lanes and of numbers."""
    lanes = empty_lanes(WIDTH, 2, 5, 3, 3)
    lanes["lane"] = RNG.normal(size=(2, 5, 3, 3, WIDTH))
    matrix = RNG.normal(size=(6, 6))
    kind = [("axis", "f8", (3, WIDTH)), ("turns", "f8", (2, 3, 3, WIDTH)), ("force", "f8", 3)]
    records = np.zeros(2, np.dtype(kind, align=True))
    for name, *_ in kind:
        records[name] = RNG.normal(size=records[name].shape)
    expected_lanes, expected = lanes["lane"][1, 3, 2].copy(), matrix.copy()

    @njit
    def copy(lanes, matrix, records, vectors, force):
        lv.store_vector(vectors, 0, lv.load_vector(lanes, (1, 3, 2)))
        lv.store_vector(vectors, 1, lv.load_vector(lanes[1], (3, 2)))
        lv.store_vector(vectors, 2, lv.load_vector(records[1].axis, ()))
        lv.store_matrix(vectors[3:], (), lv.load_matrix(records[0].turns, 1))
        lv.store_vector(force, (), lv.load_vector(records[1].force, ()))
        lv.store_matrix(matrix[:3, 3:], (), lv.load_matrix(matrix[3:, :3], ()))

    vectors, force = np.zeros((6, 3), lanes_dtype(WIDTH)), np.zeros(3)
    copy(lanes, matrix, records, vectors, force)
    assert_array_equal(vectors["lane"][:2], [expected_lanes, expected_lanes])
    assert_array_equal(vectors["lane"][2], records["axis"][1])
    assert_array_equal(vectors["lane"][3:], records["turns"][0, 1])
    assert_array_equal(force, records["force"][1])
    expected[:3, 3:] = expected[3:, :3]
    assert_array_equal(matrix, expected)


def test_numbers_are_written_into_all_lanes():
    lanes = empty_lanes(WIDTH, 3)

    @njit
    def fill(lanes):
        lv.store_vector(lanes, (), (1.0, 2.0, 3.0))

    fill(lanes)
    assert_array_equal(lanes["lane"], np.array([[1.0], [2.0], [3.0]]) * np.ones(WIDTH))

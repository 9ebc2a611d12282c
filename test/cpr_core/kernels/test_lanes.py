# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Lanes: what kernels do with them is what numpy does with every number on its own."""

import numpy as np
import pytest
from numba import njit
from numpy.testing import assert_array_equal

from cpr_core.kernels.lanes import (
    WIDTH,
    absolute,
    broadcast,
    empty_lanes,
    get,
    highest,
    load,
    lower,
    put,
    store,
    total,
    zeros_lanes,
)

RNG = np.random.default_rng(1)


def random_lanes(*shape):
    """Lanes of random numbers of either sign."""
    lanes = empty_lanes(WIDTH, *shape)
    lanes["lane"] = RNG.normal(size=(*shape, WIDTH))
    return lanes


OPERATIONS = {
    "sum": lambda a, b: a + b,
    "difference": lambda a, b: a - b,
    "product": lambda a, b: a * b,
    "quotient": lambda a, b: a / b,
    "lower": lambda a, b: lower(a, b),
    "by a number": lambda a, b: 3.0 * a + b * 0.5,
    "less a number": lambda a, b: a - 2.0 + (1.0 - b),
    "over a number": lambda a, b: a / 4.0 + 2.0 / b,
    "negative": lambda a, b: -a,
    "size": lambda a, b: absolute(a),
}
NUMPY = {**OPERATIONS, "lower": np.minimum, "size": lambda a, b: np.abs(a)}


@pytest.mark.parametrize("name", OPERATIONS)
def test_operations_are_those_of_every_number(name):
    operation = njit(OPERATIONS[name])

    @njit
    def apply(left, right, result):
        for i in range(left.shape[0]):
            store(result, i, operation(load(left, i), load(right, i)))

    first, second, result = random_lanes(5), random_lanes(5), empty_lanes(WIDTH, 5)
    apply(first, second, result)
    expected = NUMPY[name](first["lane"], second["lane"])
    np.testing.assert_allclose(result["lane"], expected, rtol=1e-14, atol=1e-15)


def test_places_have_any_number_of_indices_and_lanes_are_numbers():
    @njit
    def turn(lanes):
        for i in range(lanes.shape[0]):
            for j in range(lanes.shape[1]):
                for lane in range(WIDTH):
                    put(lanes, (i, j), lane, 10.0 * get(lanes, (i, j), lane) + lane)

    lanes = random_lanes(2, 3)
    before = lanes["lane"].copy()
    turn(lanes)
    np.testing.assert_allclose(lanes["lane"], 10.0 * before + np.arange(WIDTH), rtol=1e-14)


def test_numbers_spread_and_come_together():
    @njit
    def gather(lanes, numbers):
        value = load(lanes, 0)
        numbers[0], numbers[1] = total(value), highest(value)
        store(lanes, 0, broadcast(lanes, 7.0))

    lanes, numbers = random_lanes(1), np.empty(2)
    before = lanes["lane"][0].copy()
    gather(lanes, numbers)
    np.testing.assert_allclose(numbers, [before.sum(), before.max()], rtol=1e-14)
    assert_array_equal(lanes["lane"], np.full((1, WIDTH), 7.0))


def test_fields_of_records_are_lanes_too():
    records = np.zeros(2, np.dtype([("axis", "f8", (3, WIDTH)), ("length", "f8", (WIDTH,))]))
    records["axis"], records["length"] = RNG.normal(size=(2, 3, WIDTH)), RNG.normal(size=(2, WIDTH))

    @njit
    def scaled(records, result):
        for number in range(records.shape[0]):
            record = records[number]
            for i in range(3):
                store(result, (number, i), load(record.length, ()) * load(record.axis, i))

    result = empty_lanes(WIDTH, 2, 3)
    scaled(records, result)
    assert_array_equal(result["lane"], records["length"][:, None] * records["axis"])


def test_memory_is_aligned_and_zeros_are_zero():
    for shape in ((1,), (3, 5), (2, 1, 7)):
        lanes = zeros_lanes(WIDTH, *shape)
        assert lanes.shape == shape
        assert lanes.ctypes.data % 64 == 0
        assert not lanes["lane"].any()

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Values that kernels take from an address: the same numbers, and nothing is counted twice or lost."""

import sys
from typing import NamedTuple

import numpy as np
import pytest

from cpr_core.numba_fence import entry_point, njit
from cpr_core.numba_fence.borrowed_values import Borrowed, size_of, store


class Inner(NamedTuple):
    vector: np.ndarray
    factor: float


class Outer(NamedTuple):
    inner: Inner
    matrix: np.ndarray
    count: int


@njit
def bytes_of(values):
    return size_of(values)


@njit
def write(memory, values):
    store(memory, values)


def borrow(values):
    memory = np.empty(bytes_of(values), np.uint8)
    write(memory, values)
    return Borrowed(values, memory)


@pytest.fixture
def values():
    return Outer(Inner(np.arange(3.0), 2.5), np.arange(6.0).reshape(2, 3), 7)


def product(borrowed):
    inner = borrowed.inner
    total = inner.factor * borrowed.count
    for row in range(borrowed.matrix.shape[0]):
        for i in range(inner.vector.shape[0]):
            total += borrowed.matrix[row, i] * inner.vector[i]
    return total


@pytest.mark.parametrize("options", [{}, {"_nrt": False}], ids=["counted", "not counted"])
def test_kernels_see_the_values_and_return_what_they_borrowed(values, options):
    kernel, borrowed = njit(**options)(product), borrow(values)
    wanted = 2.5 * 7 + float((values.matrix @ values.inner.vector).sum())
    assert kernel(borrowed) == wanted
    held = [sys.getrefcount(array) for array in (values.matrix, values.inner.vector)]
    for _ in range(1000):
        assert kernel(borrowed) == wanted
    assert [sys.getrefcount(array) for array in (values.matrix, values.inner.vector)] == held


def test_what_is_written_later_is_seen(values):
    kernel, borrowed = njit(product), borrow(values)
    before = kernel(borrowed)
    values.matrix[1, 2] += 1.0
    assert kernel(borrowed) == before + values.inner.vector[2]


def test_it_keeps_the_arrays():
    borrowed = borrow(Outer(Inner(np.full(3, 2.0), 0.0), np.ones((2, 3)), 1))
    others = [np.zeros((2, 3)) for _ in range(100)]  # where freed memory would be used again
    assert njit(product)(borrowed) == 12.0
    assert len(others) == 100


def test_values_of_one_type_share_machine_code(values):
    kernel = njit(product)
    other = Outer(Inner(np.ones(5), 1.0), np.ones((4, 5)), 0)
    kernel(borrow(values)), kernel(borrow(other))
    assert len(kernel.signatures) == 1
    direct = entry_point(kernel, borrow(values))
    assert direct(borrow(other)) == kernel(borrow(other)) == 20.0
    kernel(borrow(Outer(Inner(np.ones(2), 1.0), np.asfortranarray(np.ones((3, 2))), 0)))
    assert len(kernel.signatures) == 2


def test_a_field_that_is_none_is_refused(values):
    with pytest.raises(Exception, match="nknown attribute"):
        njit(lambda borrowed: borrowed.nothing)(borrow(values))

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Vectors and matrices in three dimensions as values: what docs/derivations.md is written in.

A vector is a tuple of three lanes or of three numbers, a matrix a tuple of its three rows. They live in
registers: no memory has to be named for what is in between.

    moment = axial(load_matrix(field, node))
    store_vector(swept, node, cross(density, load_vector(arm, node)))

In memory the components of a vector are side by side in the last axis, those of a matrix in the last
two: ``load_vector(array, index)`` are ``array[(*index, 0)]`` to ``array[(*index, 2)]``. Whether they are
lanes or numbers is up to the array.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

from ..numba_fence.typing_extension import intrinsic, types
from .formulas import formula
from .kernel_decorators import inlined
from .lanes import broadcast, element_type, load_element, store_element, total

__all__ = [
    "add",
    "add_scaled",
    "axial",
    "component",
    "cross",
    "cross_matrix",
    "dot",
    "less_trace",
    "load_matrix",
    "load_vector",
    "matrix_product",
    "matrix_vector",
    "negated",
    "outer",
    "scaled",
    "store_matrix",
    "store_vector",
    "subtract",
    "subtract_scaled",
    "total_matrix",
    "total_vector",
    "trace",
    "transposed",
    "unit_vector",
    "zero_matrix",
    "zero_vector",
]


def _three(kind: Any) -> Any:
    return types.UniTuple(kind, 3)


@intrinsic
def load_vector(typing_context: Any, array: Any, index: Any) -> Any:
    """The vector at an index of an array of lanes or numbers."""
    vector = _three(element_type(array, index, 1))

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        parts = [load_element(context, builder, sig, values, (i,)) for i in range(3)]
        return context.make_tuple(builder, vector, parts)

    return vector(array, index), generate


@intrinsic
def store_vector(typing_context: Any, array: Any, index: Any, vector: Any) -> Any:
    """Write a vector."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        for i in range(3):
            part = builder.extract_value(values[2], i)
            store_element(context, builder, sig, values, part, (i,))
        return context.get_dummy_value()

    return types.void(array, index, vector), generate


@intrinsic
def load_matrix(typing_context: Any, array: Any, index: Any) -> Any:
    """The matrix at an index of an array of lanes or numbers."""
    row = _three(element_type(array, index, 2))
    matrix = _three(row)

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        rows = []
        for i in range(3):
            parts = [load_element(context, builder, sig, values, (i, j)) for j in range(3)]
            rows.append(context.make_tuple(builder, row, parts))
        return context.make_tuple(builder, matrix, rows)

    return matrix(array, index), generate


@intrinsic
def store_matrix(typing_context: Any, array: Any, index: Any, matrix: Any) -> Any:
    """Write a matrix."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        for i, j in product(range(3), range(3)):
            part = builder.extract_value(values[2], (i, j))
            store_element(context, builder, sig, values, part, (i, j))
        return context.get_dummy_value()

    return types.void(array, index, matrix), generate


@inlined
def zero_vector(like):
    """The vector zero, in as many lanes as an array or a value has."""
    zero = broadcast(like, 0.0)
    return zero, zero, zero


@inlined
def zero_matrix(like):
    """The matrix zero."""
    zero = zero_vector(like)
    return zero, zero, zero


@inlined
def unit_vector(axis):
    """``e_axis``, of numbers; zero where there is no such axis."""
    return (
        1.0 if axis == 0 else 0.0,
        1.0 if axis == 1 else 0.0,
        1.0 if axis == 2 else 0.0,
    )


@inlined
def component(a, axis):
    """A component of a vector whose number is not known before."""
    if axis == 0:
        return a[0]
    if axis == 1:
        return a[1]
    return a[2]


def _each(operation: Callable[..., Any], *arguments: Any) -> Any:
    """An operation on every component of vectors, or of matrices."""
    if isinstance(arguments[0], tuple):
        return tuple(_each(operation, *parts) for parts in zip(*arguments, strict=True))
    return operation(*arguments)


def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@formula
def add(a, b):
    """``a + b`` of vectors or matrices."""
    return _each(lambda x, y: x + y, a, b)


@formula
def subtract(a, b):
    """``a - b``."""
    return _each(lambda x, y: x - y, a, b)


@formula
def negated(a):
    """``-a``."""
    return _each(lambda x: -x, a)


@formula
def scaled(factor, a):
    """``factor a``."""
    return _each(lambda x: factor * x, a)


@formula
def add_scaled(a, factor, b):
    """``a + factor b``."""
    return _each(lambda x, y: x + factor * y, a, b)


@formula
def subtract_scaled(a, factor, b):
    """``a - factor b``."""
    return _each(lambda x, y: x - factor * y, a, b)


@formula
def dot(a, b):
    """``a . b``."""
    return _dot(a, b)


@formula
def cross(a, b):
    """``a x b``."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@formula
def outer(a, b):
    """``a b^T``."""
    return tuple(tuple(x * y for y in b) for x in a)


@formula
def transposed(a):
    """``A^T``."""
    return tuple(zip(*a, strict=True))


@formula
def matrix_vector(a, b):
    """``A b``."""
    return tuple(_dot(row, b) for row in a)


@formula
def matrix_product(a, b):
    """``A B``."""
    columns = tuple(zip(*b, strict=True))
    return tuple(tuple(_dot(row, column) for column in columns) for row in a)


@formula
def trace(a):
    """``tr(A)``."""
    return a[0][0] + a[1][1] + a[2][2]


@formula
def less_trace(a):
    """``A - tr(A) 1``; of ``arm n^T`` it is Q: ``n . (u x (v x arm)) = u . Q v``."""
    diagonal = a[0][0] + a[1][1] + a[2][2]
    return tuple(
        tuple(a[i][j] - diagonal if i == j else a[i][j] for j in range(3)) for i in range(3)
    )


@formula
def axial(a):
    """Twice the vector of the skew part with its sign turned: ``axial(u v^T) = u x v``."""
    return a[1][2] - a[2][1], a[2][0] - a[0][2], a[0][1] - a[1][0]


@inlined
def cross_matrix(a):
    """``a^``, such that ``a^ b = a x b``; of numbers."""
    return (0.0, -a[2], a[1]), (a[2], 0.0, -a[0]), (-a[1], a[0], 0.0)


@inlined
def total_vector(a):
    """Sum over all legs: a vector of numbers."""
    return total(a[0]), total(a[1]), total(a[2])


@inlined
def total_matrix(a):
    """Sum over all legs: a matrix of numbers."""
    return total_vector(a[0]), total_vector(a[1]), total_vector(a[2])

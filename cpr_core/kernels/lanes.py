# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A number per leg: the type the kernels calculate with.

Legs go through the same formulas. So a kernel is written once, for one leg, and works on `Lanes`: eight
numbers, one beside the other in a vector register. Memory of lanes is an array
of records (`lanes_dtype`), from which one place is loaded at a time:

    curvature = load(strain, mode) * load(functions, (mode, node))

Sums, products and quotients of lanes, and of lanes and numbers, are those of every leg on its own. Being
explicit vectors they need neither luck with the compiler's vectoriser nor sums in another order.
"""

from __future__ import annotations

import math
import operator
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..numba_fence.typing_extension import (
    AbstractTemplate,
    arrayobj,
    cgutils,
    infer_global,
    intrinsic,
    ir,
    lower_builtin,
    models,
    register_model,
    signature,
    types,
)

__all__ = [
    "WIDTH",
    "LanesType",
    "absolute",
    "broadcast",
    "element_type",
    "empty_lanes",
    "generate_operation",
    "get",
    "highest",
    "lanes_dtype",
    "load",
    "load_element",
    "lower",
    "put",
    "store",
    "store_element",
    "total",
    "zeros_lanes",
]

#: Legs side by side. Types carry their width, so that this is the only place where it is chosen: one for
#: all robots, for every other one would be compiled anew. Eight fill the widest registers; where those
#: are narrower, the compiler takes two or four of them.
WIDTH = 8

#: Vectors begin where cache lines do [bytes].
_ALIGNMENT = 64
_DOUBLE = ir.DoubleType()
_FLAGS = ("contract", "nsz")


@cache
def lanes_dtype(width: int) -> np.dtype[Any]:
    """Type of an array element that holds one number per leg, under the name ``lane``."""
    return np.dtype([("lane", "f8", (width,))])


def empty_lanes(width: int, *shape: int) -> NDArray[np.void]:
    """Memory of lanes, aligned; ``array["lane"]`` is its view as numbers, the legs last."""
    count = math.prod(shape) * width
    numbers = np.empty(count + _ALIGNMENT // 8)
    first = (-numbers.ctypes.data % _ALIGNMENT) // 8
    return numbers[first : first + count].view(lanes_dtype(width)).reshape(shape)


def zeros_lanes(width: int, *shape: int) -> NDArray[np.void]:
    """The same, zero."""
    lanes = empty_lanes(width, *shape)
    lanes["lane"] = 0.0
    return lanes


class LanesType(types.Type):
    """Numba's type of a number per leg."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"Lanes({width})")


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, lanes: LanesType) -> None:
        super().__init__(manager, lanes, ir.VectorType(_DOUBLE, lanes.width))


def _width(array: Any) -> int:
    """Lanes of an element of a record array, of the last axis of a field of a record, or of lanes."""
    if isinstance(array, LanesType):
        return array.width
    if isinstance(array, types.NestedArray):
        return int(array.shape[-1])
    return int(array.dtype.fields["lane"].type.shape[0])


def element_type(array: Any, index: Any, more: int) -> Any:
    """What an array has at an index and ``more`` indices of components: lanes, or a number."""
    given = more + (len(index) if isinstance(index, types.BaseTuple) else 1)
    if isinstance(array.dtype, types.Record) or array.ndim > given:
        return LanesType(_width(array))
    return types.float64


def _element(
    context: Any, builder: Any, sig: Any, values: Any, more: tuple[int, ...]
) -> tuple[Any, Any]:
    """Type of an element, and a pointer to it."""
    array, index = sig.args[:2]
    kind = element_type(array, index, len(more))
    given = (
        cgutils.unpack_tuple(builder, values[1], len(index))
        if isinstance(index, types.BaseTuple)
        else [values[1]]
    )
    constants = [context.get_constant(types.intp, i) for i in more]
    first_lane = [context.get_constant(types.intp, 0)] * (array.ndim - len(given) - len(more))
    view = arrayobj.make_array(array)(context, builder, values[0])
    indices = [*given, *constants, *first_lane]
    pointer = cgutils.get_item_pointer(context, builder, array, view, indices, wraparound=False)
    if isinstance(kind, LanesType):
        pointer = builder.bitcast(pointer, ir.VectorType(_DOUBLE, kind.width).as_pointer())
    return kind, pointer


def load_element(
    context: Any, builder: Any, sig: Any, values: Any, more: tuple[int, ...] = ()
) -> Any:
    """Generate the code that loads lanes or a number.

    For intrinsics on ``(array, index, ...)``; ``more`` are the indices of components.
    """
    _, pointer = _element(context, builder, sig, values, more)
    return builder.load(pointer, align=8)


def store_element(
    context: Any, builder: Any, sig: Any, values: Any, part: Any, more: tuple[int, ...] = ()
) -> None:
    """Generate the code that writes lanes or a number."""
    kind, pointer = _element(context, builder, sig, values, more)
    if isinstance(kind, LanesType):
        part = _spread(builder, part, kind.width)
    builder.store(part, pointer, align=8)


@intrinsic
def load(typing_context: Any, array: Any, index: Any) -> Any:
    """The lanes at an index of an array of lanes."""
    return element_type(array, index, 0)(array, index), load_element


@intrinsic
def store(typing_context: Any, array: Any, index: Any, value: Any) -> Any:
    """Write lanes, or one number for all of them."""
    kept = value if isinstance(value, LanesType) else types.float64

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        store_element(context, builder, sig, values, values[2])
        return context.get_dummy_value()

    return types.void(array, index, kept), generate


def _lane(context: Any, builder: Any, sig: Any, values: Any) -> Any:
    """Pointer to one lane at an index."""
    _, pointer = _element(context, builder, sig, values, ())
    return builder.gep(builder.bitcast(pointer, _DOUBLE.as_pointer()), [values[2]])


@intrinsic
def get(typing_context: Any, array: Any, index: Any, lane: Any) -> Any:
    """The number of one leg at an index of an array of lanes."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        return builder.load(_lane(context, builder, sig, values))

    return types.float64(array, index, types.intp), generate


@intrinsic
def put(typing_context: Any, array: Any, index: Any, lane: Any, value: Any) -> Any:
    """Write the number of one leg."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        builder.store(values[3], _lane(context, builder, sig, values))
        return context.get_dummy_value()

    return types.void(array, index, types.intp, types.float64), generate


@intrinsic
def broadcast(typing_context: Any, array: Any, value: Any) -> Any:
    """One number for all legs, in as many lanes as an array has, or a value of lanes."""
    width = _width(array)

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        return _spread(builder, values[1], width)

    return LanesType(width)(array, types.float64), generate


def _spread(builder: Any, value: Any, width: int) -> Any:
    """Lanes as they are, a number in all of them."""
    if isinstance(value.type, ir.VectorType):
        return value
    vector = ir.VectorType(_DOUBLE, width)
    nothing = ir.Constant(vector, ir.Undefined)
    single = builder.insert_element(nothing, value, ir.Constant(ir.IntType(32), 0))
    everywhere = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
    return builder.shuffle_vector(single, nothing, everywhere)


def generate_operation(builder: Any, instruction: str, left: Any, right: Any) -> Any:
    """Generate the code of an operation between lanes, numbers, or both."""
    for value in (left, right):
        if isinstance(value.type, ir.VectorType):
            width = value.type.count
            left, right = _spread(builder, left, width), _spread(builder, right, width)
    return getattr(builder, instruction)(left, right, flags=_FLAGS)


def _define(operation: Any, instruction: str) -> None:
    """An operation between lanes, and between lanes and numbers."""

    @infer_global(operation)
    class Operation(AbstractTemplate):
        def generic(self, args: Any, keywords: Any) -> Any:
            lanes = [arg for arg in args if isinstance(arg, LanesType)]
            others = [arg for arg in args if not isinstance(arg, LanesType)]
            if len(args) != 2 or not lanes or not all(isinstance(o, types.Number) for o in others):
                return None
            kept = [arg if isinstance(arg, LanesType) else types.float64 for arg in args]
            return signature(lanes[0], *kept)

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        return generate_operation(builder, instruction, *values)

    for pair in ((LanesType, LanesType), (LanesType, types.Float), (types.Float, LanesType)):
        lower_builtin(operation, *pair)(generate)


for _operation, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
    (operator.iadd, "fadd"),
    (operator.isub, "fsub"),
    (operator.imul, "fmul"),
    (operator.itruediv, "fdiv"),
):
    _define(_operation, _instruction)


@infer_global(operator.neg)
class _Negative(AbstractTemplate):
    def generic(self, args: Any, keywords: Any) -> Any:
        if len(args) == 1 and isinstance(args[0], LanesType):
            return signature(args[0], args[0])
        return None


@lower_builtin(operator.neg, LanesType)
def _negative(context: Any, builder: Any, sig: Any, values: Any) -> Any:
    return builder.fneg(values[0])


@intrinsic
def absolute(typing_context: Any, value: Any) -> Any:
    """Absolute values of lanes."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        negative = builder.fneg(values[0])
        above = builder.fcmp_ordered(">", values[0], negative)
        return builder.select(above, values[0], negative)

    return value(value), generate


def _select(comparison: str) -> Any:
    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        chosen = builder.fcmp_ordered(comparison, *values)
        return builder.select(chosen, values[0], values[1])

    return generate


@intrinsic
def lower(typing_context: Any, first: Any, second: Any) -> Any:
    """The lower of two lanes, leg by leg; the second where one is not a number."""
    return first(first, first), _select("<")


@intrinsic
def highest(typing_context: Any, value: Any) -> Any:
    """The highest number of all legs; not a number if one is not."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        numbers = [
            builder.extract_element(values[0], ir.Constant(ir.IntType(32), lane))
            for lane in range(sig.args[0].width)
        ]
        best = numbers[0]
        for number in numbers[1:]:
            above = builder.fcmp_ordered(">", number, best)
            above = builder.or_(above, builder.fcmp_unordered("uno", number, number))
            best = builder.select(above, number, best)
        return best

    return types.float64(value), generate


@intrinsic
def total(typing_context: Any, value: Any) -> Any:
    """The sum over all legs, by halves."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        numbers = [
            builder.extract_element(values[0], ir.Constant(ir.IntType(32), lane))
            for lane in range(sig.args[0].width)
        ]
        while len(numbers) > 1:
            half = len(numbers) // 2
            numbers = [
                builder.fadd(low, high)
                for low, high in zip(numbers[:half], numbers[half:], strict=True)
            ]
        return numbers[0]

    return types.float64(value), generate

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Formulas on tuples of lanes and numbers, written out where kernels call them.

A formula is a plain Python function of sums and products. It runs while the kernel that calls it is
compiled, on parts that stand for values and emit their instructions. So it is no function of its
own to compile, takes lanes and numbers alike, and may do all that Python does with tuples.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..numba_fence.typing_extension import intrinsic, types
from .lanes import LanesType, generate_operation

__all__ = ["formula"]


class _Part:
    """A number or lanes in a formula; without a builder only its type is asked for."""

    def __init__(self, kind: Any, builder: Any = None, value: Any = None) -> None:
        self.kind, self.builder, self.value = kind, builder, value

    def _with(self, other: _Part, instruction: str) -> _Part:
        kind = self.kind if isinstance(self.kind, LanesType) else other.kind
        if self.builder is None:
            return _Part(kind)
        value = generate_operation(self.builder, instruction, self.value, other.value)
        return _Part(kind, self.builder, value)

    def __add__(self, other: _Part) -> _Part:
        return self._with(other, "fadd")

    def __sub__(self, other: _Part) -> _Part:
        return self._with(other, "fsub")

    def __mul__(self, other: _Part) -> _Part:
        return self._with(other, "fmul")

    def __neg__(self) -> _Part:
        if self.builder is None:
            return self
        return _Part(self.kind, self.builder, self.builder.fneg(self.value))


def formula(function: Callable[..., Any]) -> Any:
    """Make a formula one that kernels can call; its arguments are parts and tuples of them."""

    def typed(*arguments: Any) -> Any:
        result = _type_of(function(*[_parts(kind) for kind in arguments]))

        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            given = [_parts(*pair, builder) for pair in zip(sig.args, values, strict=True)]
            return _value_of(context, builder, function(*given))

        return result(*arguments), generate

    def of_one(typing_context: Any, a: Any) -> Any:
        return typed(a)

    def of_two(typing_context: Any, a: Any, b: Any) -> Any:
        return typed(a, b)

    def of_three(typing_context: Any, a: Any, b: Any, c: Any) -> Any:
        return typed(a, b, c)

    # Numba reads the number of arguments off the function.
    by_count: tuple[Any, ...] = (of_one, of_two, of_three)
    define = by_count[function.__code__.co_argcount - 1]
    define.__name__, define.__doc__ = function.__name__, function.__doc__
    define.__module__, define.__qualname__ = function.__module__, function.__qualname__
    return intrinsic(define)


def _parts(kind: Any, value: Any = None, builder: Any = None) -> Any:
    """What stands for a value: a part, or a tuple of parts."""
    if not isinstance(kind, types.BaseTuple):
        return _Part(kind, builder, value)
    return tuple(
        _parts(component, builder.extract_value(value, i) if builder else None, builder)
        for i, component in enumerate(kind)
    )


def _type_of(parts: Any) -> Any:
    if isinstance(parts, _Part):
        return parts.kind
    return types.UniTuple(_type_of(parts[0]), len(parts))


def _value_of(context: Any, builder: Any, parts: Any) -> Any:
    if isinstance(parts, _Part):
        return parts.value
    values = [_value_of(context, builder, part) for part in parts]
    return context.make_tuple(builder, _type_of(parts), values)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Named tuples of arrays that are taken apart once, and handed to kernels by their address.

Kernels only borrow them: nobody counts references, what Python holds lives as long as it does.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import typeof
from numpy.typing import NDArray

from .typing_extension import (
    AttributeTemplate,
    NativeValue,
    cgutils,
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    models,
    register_model,
    types,
    unbox,
)

__all__ = ["Borrowed", "size_of", "store"]


class _BorrowedType(types.Type):
    """Numba's type of a Borrowed."""

    def __init__(self, values: Any) -> None:
        self.values = values
        super().__init__(f"Borrowed({values.name})")

    @property
    def key(self) -> Any:
        return self.values


register_model(_BorrowedType)(models.OpaqueModel)


class Borrowed:
    """A named tuple as kernels take it: its fields are attributes there.

    Attributes:
        values: The named tuple; it keeps the arrays.
        address: Where its parts are in memory.
    """

    __slots__ = ("_memory", "_numba_type_", "address", "values")

    def __init__(self, values: Any, memory: NDArray[np.uint8]) -> None:
        """Hand over a named tuple.

        Args:
            values: The named tuple.
            memory: Its parts, as ``store`` has written them: as many bytes as ``size_of`` says.
        """
        self.values, self._memory = values, memory
        self._numba_type_ = _type_of(values)
        self.address = memory.ctypes.data

    @property
    def kind(self) -> int:
        """The same number for all values of the same types."""
        return id(self._numba_type_)  # of one of ``_types``, which stay


#: Types by what they depend on: numba takes milliseconds to look at a hundred arrays.
_types: dict[Any, _BorrowedType] = {}
#: Flag of arrays that their type does not depend on: whether their memory is their own.
_OWNS_MEMORY = 0x4


def _type_of(values: Any) -> _BorrowedType:
    """The type of a named tuple, looked at once for all that are of the same types."""
    key = _looks(values)
    if key not in _types:
        _types[key] = _BorrowedType(typeof(values))
    return _types[key]


def _looks(value: Any) -> Any:
    """What the type of a value depends on."""
    if isinstance(value, tuple):
        return type(value), tuple([_looks(part) for part in value])
    if isinstance(value, np.ndarray):
        return value.dtype, value.ndim, value.flags.num & ~_OWNS_MEMORY
    return type(value)


@unbox(_BorrowedType)
def _unbox(kind: Any, instance: Any, c: Any) -> Any:
    address = c.pyapi.object_getattr_string(instance, "address")
    pointer = c.pyapi.long_as_voidptr(address)
    c.pyapi.decref(address)
    return NativeValue(pointer)


@infer_getattr
class _Attributes(AttributeTemplate):
    key = _BorrowedType

    def generic_resolve(self, kind: Any, name: str) -> Any:
        fields = kind.values.fields
        return kind.values.types[fields.index(name)] if name in fields else None


@lower_getattr_generic(_BorrowedType)
def _attribute(context: Any, builder: Any, kind: Any, pointer: Any, name: str) -> Any:
    whole = builder.bitcast(pointer, context.get_value_type(kind.values).as_pointer())
    index = kind.values.fields.index(name)
    value = builder.load(cgutils.gep_inbounds(builder, whole, 0, index))
    if context.enable_nrt:  # where functions count, who takes it gives it back
        context.nrt.incref(builder, kind.values.types[index], value)
    return value


@intrinsic
def size_of(typing_context: Any, values: Any) -> Any:
    """Bytes that a value takes; for kernels."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return context.get_constant(
            types.intp, context.get_abi_sizeof(context.get_value_type(sig.args[0]))
        )

    return types.intp(values), generate


@intrinsic
def store(typing_context: Any, memory: Any, values: Any) -> Any:
    """Write a value to memory; for kernels."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        array = context.make_array(sig.args[0])(context, builder, arguments[0])
        kind = context.get_value_type(sig.args[1])
        builder.store(arguments[1], builder.bitcast(array.data, kind.as_pointer()))
        return context.get_dummy_value()

    return types.none(memory, values), generate

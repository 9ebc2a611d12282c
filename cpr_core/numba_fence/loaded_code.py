# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Machine code on disk that is loaded without what only compiling needs.

Beside the machine code of a kernel numba keeps its bitcode, for kernels that will be made of it, and
parses it whenever it loads the code; before, it fills its tables of everything that can be compiled.
Where all is on disk nobody asks for either, and together they take as long as importing numba.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from numba import njit
from numba.core import codegen
from numba.core.caching import CompileResultCacheImpl
from numba.core.runtime import rtsys

from .kept_code import KeptCode

__all__ = ["load_alone"]

binding = codegen.ll  # llvmlite's, as numba brings it


class _Library(codegen.JITCodeLibrary):
    """Loaded machine code, whose bitcode is parsed when another function is made of it."""

    _unread: bytes | None = None

    def _get_module_for_linking(self) -> Any:
        if self._unread is not None:
            self._shared_module, self._unread = binding.parse_bitcode(self._unread), None
        return super()._get_module_for_linking()


class _Code(CompileResultCacheImpl):
    """What is kept of a compiled function: beside machine code and bitcode the names these define."""

    def reduce(self, result: Any) -> Any:
        (name, kind, code), *others = super().reduce(result)
        module = result.library._get_module_for_linking()
        defined = {
            value.name
            for values in (module.functions, module.global_variables)
            for value in values
            if not value.is_declaration
        }
        return (name, kind, (*code, defined)), *others

    def rebuild(self, target_context: Any, kept: Any) -> Any:
        (name, kind, (machine_code, bitcode, defined)), *others = kept
        target_context.codegen()._engine._defined_symbols.update(defined)
        code = (name, kind, (machine_code, _empty_bitcode()))
        result = super().rebuild(target_context, (code, *others))
        result.library.__class__ = _Library
        result.library._unread = bitcode
        return result


class _Cache(KeptCode):
    """Fills numba's tables only if a function is not on disk, and so will be compiled."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        rtsys.initialize(target_context)  # machine code refers to it
        with self._guard_against_spurious_io_errors():
            result = self._load_overload(sig, target_context)
        if result is None:
            target_context.refresh()
        return result


@cache
def _empty_bitcode() -> bytes:
    return binding.parse_assembly("").as_bitcode()


def load_alone(dispatcher: Any) -> None:
    """Keep and load a compiled function's machine code so, before it is called first."""
    dispatcher._cache.__class__ = _Cache
    dispatcher._cache._impl.__class__ = _Code


def _probe() -> None:
    pass


# What has another name in this version would be replaced without effect, or fail when it is used.
for _name in ("_impl", "load_overload", "_load_overload", "_guard_against_spurious_io_errors"):
    getattr(njit(cache=True)(_probe)._cache, _name)
for _name in ("_get_module_for_linking", "_unserialize", "serialize_using_object_code"):
    getattr(codegen.JITCodeLibrary, _name)

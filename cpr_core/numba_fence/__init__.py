# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The only place that imports numba.

Beyond what numba documents, kernels use private interfaces of it, which any version may take away. Those
that make kernels faster are optional here: without them everything works, more slowly, and one warning
says so.

    loop_hint        loops are left as they are written
    known_options    options of the compiler that its documentation does not name
    cache_stamp      machine code on disk is renewed when any kernel changes; without: none is kept there
    loaded_code      machine code is loaded alone; without: with all that compiling needs
    compile_events   whoever waits is told which kernel is compiled; without: nobody is told

There is no way without the extension of its types (``typing_extension``): lanes are a type of their own,
and so are robots that are taken apart once (``borrowed_values``). Without it the import says so.

Where no folder can be written to, machine code is not kept either; a warning says that too.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Any, TypeVar

import numba
from numba import njit, typeof

try:
    from . import loop_hint
except (ImportError, AttributeError):
    loop_hint = None  # type: ignore[assignment]
try:
    njit(cache=True)(lambda: None)
    _FOLDER = True
except RuntimeError:  # there is none that can be written to
    _FOLDER = False
try:
    from . import cache_stamp
except (ImportError, AttributeError, RuntimeError):
    cache_stamp = None  # type: ignore[assignment]
try:
    from . import loaded_code
except (ImportError, AttributeError, RuntimeError):
    loaded_code = None  # type: ignore[assignment]
try:
    from . import compile_events
except (ImportError, AttributeError):
    compile_events = None  # type: ignore[assignment]
try:
    from .known_options import KNOWN_OPTIONS
except (ImportError, AttributeError):
    KNOWN_OPTIONS = frozenset()

__all__ = [
    "MISSING",
    "REORDERED_SUMS",
    "VERSION",
    "Function",
    "compile_kernel",
    "entry_point",
    "hear_compilation",
    "njit",
]

Function = TypeVar("Function", bound=Callable[..., Any])

#: Of numba.
VERSION: str = numba.__version__

#: Sums may be reordered so that they vectorise; NaN and infinity keep their meaning.
REORDERED_SUMS = {"contract", "nsz", "reassoc"}

#: Options of the compiler that numba does not document.
_PRIVATE_OPTIONS = ("_nrt", "forceinline", "no_cpython_wrapper", "no_cfunc_wrapper")

#: What this numba lacks of the private interfaces.
MISSING = (
    *(("the lowering of its passes",) if loop_hint is None else ()),
    *(("the stamp of its cache",) if _FOLDER and cache_stamp is None else ()),
    *(("the loading of its cache",) if _FOLDER and loaded_code is None else ()),
    *(("events of compiling",) if compile_events is None else ()),
    *(f"the option {name}" for name in _PRIVATE_OPTIONS if name not in KNOWN_OPTIONS),
)


def compile_kernel(
    function: Callable[..., Any],
    stamp: tuple[str, int],
    fastmath: Any,
    *,
    inline: str = "never",
    unrolled: bool = False,
    **options: bool,
) -> Any:
    """A function that numba compiles on its first call, free of the GIL and kept on disk.

    Args:
        function: What to compile.
        stamp: Fingerprint of all sources it depends on, and their size; machine code on disk is used
            while it stays the same.
        fastmath: Liberties with sums, as for ``numba.njit``.
        inline: Whether it becomes a part of what calls it, as for ``numba.njit``.
        unrolled: Whether the compiler may unroll loops; else they are left as they are written.
        options: Private options; those that this numba does not know are left out.
    """
    known: dict[str, Any] = {name: options[name] for name in options.keys() & KNOWN_OPTIONS}
    if loop_hint is not None and not unrolled:
        known["pipeline_class"] = loop_hint.KernelCompiler
    dispatcher = njit(
        cache=cache_stamp is not None,
        nogil=True,
        error_model="numpy",
        fastmath=fastmath,
        inline=inline,
        **known,
    )(function)
    if cache_stamp is not None:
        cache_stamp.stamp_cache(dispatcher, stamp)
        if loaded_code is not None:
            loaded_code.load_alone(dispatcher)
    return dispatcher


def entry_point(dispatcher: Any, *arguments: Any) -> Callable[..., Any]:
    """The machine code of a kernel for arguments of these types.

    Called directly, it does not look at types: arguments have to be of the same types, numpy arrays of
    the same number of dimensions, order and kind of numbers.
    """
    return dispatcher.compile(tuple(typeof(argument) for argument in arguments))


def hear_compilation(
    begun: Callable[[Callable[..., Any]], None],
) -> AbstractContextManager[Any]:
    """Call ``begun`` with every function that numba begins to compile, in any thread."""
    return nullcontext() if compile_events is None else compile_events.hear_compilation(begun)


if MISSING:
    warnings.warn(
        f"numba {VERSION} lacks {', '.join(MISSING)}: everything works, but more slowly; "
        "versions without this warning are named in setup.py",
        RuntimeWarning,
        stacklevel=2,
    )
if not _FOLDER:
    warnings.warn(
        "compiled kernels can be kept nowhere, neither beside the package nor in the cache folder of "
        "the user: every process compiles them again, for a minute or two; NUMBA_CACHE_DIR names a "
        "folder that can be written to",
        RuntimeWarning,
        stacklevel=2,
    )

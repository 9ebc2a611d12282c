# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Checks of what users hand in, arrays that are not theirs to change, and what is found once."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from functools import wraps
from typing import Any, Self, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidRequest, NonFiniteInput

__all__ = [
    "ReadOnlyArrays",
    "cached_array",
    "cached_property",
    "checked_count",
    "checked_floats",
    "checked_matrix",
    "checked_number",
    "checked_time",
    "checked_vector",
    "checked_word",
    "kept_with_value",
    "read_only",
]

Array = TypeVar("Array", bound=NDArray[Any])
Found = TypeVar("Found")
Value = TypeVar("Value")
Word = TypeVar("Word", bound=str)

_FLOAT = np.dtype(np.float64)


def checked_count(name: str, value: object, least: int, most: int | None = None) -> int:
    """A whole number that is neither too small nor too large.

    Raises:
        InvalidRequest: No whole number, or one below ``least`` or above ``most``.
    """
    if not isinstance(value, int | np.integer) or isinstance(value, bool | np.timedelta64):
        raise InvalidRequest(name, f"expected a whole number, got {value!r:.200}")
    if value < least:
        raise InvalidRequest(name, f"expected at least {least}, got {value!s:.200}")
    if most is not None and value > most:
        raise InvalidRequest(name, f"expected at most {most}, got {value!s:.200}")
    return int(value)


def checked_number(name: str, value: object) -> float:
    """A finite number.

    Raises:
        InvalidRequest: No number.
        NonFiniteInput: A NaN or an infinity.
    """
    number = _number(name, value, "a number")
    if not math.isfinite(number):
        raise NonFiniteInput(name, f"expected a finite number, got {value}")
    return number


def checked_time(value: object, name: str = "time_limit") -> float:
    """A time limit; without end where none is given [s].

    Raises:
        InvalidRequest: No number, or a negative one.
    """
    if value is None:
        return math.inf
    expected = "a time of at least 0 s"
    time = _number(name, value, expected)
    if not time >= 0.0:
        raise InvalidRequest(name, f"expected {expected}, got {value!r:.200}")
    return time


def checked_floats(name: str, value: ArrayLike, expected: str) -> NDArray[np.float64]:
    """A float array of what is given, of any shape; what is masked is not given, whatever is below.

    Raises:
        InvalidRequest: Words, truth values, times or what is masked, which are no numbers.
    """
    try:
        if np.ma.is_masked(value):
            raise TypeError
        given = np.asarray(value)
        if given.dtype.kind in "SUbcMm":
            raise TypeError
        return given.astype(float)
    except (TypeError, ValueError, OverflowError):
        raise InvalidRequest(name, f"{expected}, got {value!r:.200}") from None


def checked_matrix(
    name: str, value: ArrayLike, rows: int | None, columns: int, meaning: str = ""
) -> NDArray[np.float64]:
    """A float matrix of a given shape; None: of any number of rows.

    Raises:
        InvalidRequest: Not numbers, or another shape.
        NonFiniteInput: A NaN or an infinity among them.
    """
    of = "rows of" if rows is None else f"a matrix of {rows} x"
    expected = f"expected {of} {_counted(columns, meaning)}"
    matrix = checked_floats(name, value, expected)
    if matrix.ndim != 2 or matrix.shape[1] != columns or rows not in (None, len(matrix)):
        raise InvalidRequest(name, f"{expected}, got an array of shape {matrix.shape}")
    wrong = np.flatnonzero(~np.isfinite(matrix).all(axis=1))
    if wrong.size:
        row = wrong[0]
        raise NonFiniteInput(name, f"{expected}, all finite, row {row} is {matrix[row].tolist()}")
    return matrix


def checked_vector(
    name: str, value: ArrayLike, size: int, meaning: str = ""
) -> NDArray[np.float64]:
    """A read-only float vector of a given length.

    Raises:
        InvalidRequest: Not numbers, or not ``size`` of them.
        NonFiniteInput: A NaN or an infinity among them.
    """
    if type(value) is np.ndarray and value.dtype is _FLOAT and value.shape == (size,):
        floats: NDArray[np.float64] = value.copy()
        if all(map(math.isfinite, floats.tolist())):  # faster than numpy on so few numbers
            return read_only(floats)  # at once, as nearly always: no words are wanted
    expected = f"expected {_counted(size, meaning)}"
    vector = checked_floats(name, value, expected)
    if vector.shape != (size,):
        count = vector.size if vector.ndim == 1 else f"an array of shape {vector.shape}"
        raise InvalidRequest(name, f"{expected}, got {count}")
    if not np.isfinite(vector).all():
        raise NonFiniteInput(name, f"{expected}, all finite, got {vector.tolist()}")
    return read_only(vector)


def checked_word(name: str, value: object, known: tuple[Word, ...]) -> Word:
    """One of the words that are known.

    Raises:
        InvalidRequest: Another, or no word.
    """
    if not isinstance(value, str) or value not in known:
        expected = " or ".join(filter(None, (", ".join(known[:-1]), known[-1])))
        raise InvalidRequest(name, f"expected {expected}, got {value!r:.80}")
    return value


def read_only(array: Array) -> Array:
    """The same array, which nobody can write to from now on."""
    array.setflags(write=False)
    return array


class cached_property(functools.cached_property[Value]):  # noqa: N801, TID251
    """That of Python 3.12 and later: threads do not wait for each other.

    Up to 3.11 it is found under a lock that all instances share: what is found in threads is found one
    after the other, and a process that is forked meanwhile waits for ever.
    """

    @overload
    def __get__(self, instance: None, owner: type[Any] | None = None) -> Self: ...

    @overload
    def __get__(self, instance: object, owner: type[Any] | None = None) -> Value: ...

    def __get__(self, instance: object | None, owner: type[Any] | None = None) -> Self | Value:
        """Find it, and keep it in the instance, which is asked first from then on.

        Of several threads all have what the first one keeps: that it is the same is asked by ``is``.
        """
        if instance is None:
            return self
        found: Value = self.func(instance)
        kept: Value = vars(instance).setdefault(str(self.attrname), found)
        return kept


def cached_array(find: Callable[[Any], Array]) -> cached_property[Array]:
    """A cached property with an array that nobody can write to."""

    @wraps(find)
    def found(owner: object) -> Array:
        return read_only(find(owner))

    return cached_property(found)


def kept_with_value(find: Callable[[Value], Found]) -> Callable[[Value], Found]:
    """Makes of a function of a value one that finds once, and keeps what it found with the value.

    As a cached property does, for what stands on a floor above the class of the value.
    """
    name = f"{find.__module__}.{find.__qualname__}"

    @wraps(find)
    def kept(value: Value) -> Found:
        known = vars(value)
        if name in known:
            found: Found = known[name]
            return found
        return known.setdefault(name, find(value))

    return kept


class ReadOnlyArrays:
    """A dataclass whose arrays nobody can write to: what is asked for again stays as it was."""

    def __post_init__(self) -> None:
        """Take them over, those in tuples as well, but for named ones: those go to kernels."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                read_only(value)
            elif type(value) is tuple:
                for part in value:
                    if isinstance(part, np.ndarray):
                        read_only(part)


def _number(name: str, value: object, expected: str) -> float:
    """Truth values and times are no numbers, nor are whole numbers beyond all floats."""
    if isinstance(value, bool | np.timedelta64) or not isinstance(
        value, int | float | np.integer | np.floating
    ):
        raise InvalidRequest(name, f"expected {expected}, got {value!r:.200}")
    try:
        return float(value)
    except OverflowError:
        raise InvalidRequest(name, f"expected {expected}, got {value!r:.200}") from None


def _counted(count: int, meaning: str) -> str:
    return f"{count} numbers" + (f" ({meaning})" if meaning else "")

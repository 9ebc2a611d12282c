# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Errors and warnings of the core, with the data a caller needs to act on them, and what they say."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

__all__ = [
    "CprError",
    "DescriptionError",
    "DescriptionWarning",
    "InvalidQuaternion",
    "InvalidRequest",
    "NonFiniteInput",
    "UnknownParameter",
    "distinct",
    "first_and_others",
    "rounded_seconds",
    "warnings_as_lines",
]

#: Digits that are enough for a person, and those that tell any two numbers apart.
_FEWEST, _ALL = 4, 17


class CprError(Exception):
    """Base class of all errors raised by cpr_core.

    Attributes:
        code: Stable name of the kind of error, e.g. for machine-readable output.
    """

    code = "FAILURE"

    def __reduce__(self) -> tuple[Any, ...]:
        """Made again without ``__init__``, which takes other arguments than the message."""
        return type(self).__new__, (type(self), *self.args), vars(self)


class DescriptionError(CprError):
    """A robot description cannot be used.

    Attributes:
        source: File, or other origin, of the description.
        field: Path of the offending field, such as ``legs[2].motor.axis``.
        problem: What was found and what was expected.
    """

    code = "INVALID_DESCRIPTION"

    def __init__(self, source: str, field: str, problem: str) -> None:
        """Name where the problem is and what was expected."""
        self.source = source
        self.field = field
        self.problem = problem
        super().__init__(f"{source}: {field}: {problem}" if field else f"{source}: {problem}")


class DescriptionWarning(UserWarning):
    """A description that can be used, but of which something looks like a mistake."""


class InvalidRequest(CprError):
    """An argument has the wrong length, name or combination.

    Attributes:
        argument: Name of the argument.
        problem: What was found and what was expected.
    """

    code = "INVALID_ROBOT_STATE"

    def __init__(self, argument: str, problem: str) -> None:
        """Name the argument and what was expected of it."""
        self.argument = argument
        self.problem = problem
        super().__init__(f"{argument}: {problem}")


class NonFiniteInput(InvalidRequest):
    """An argument holds a NaN or an infinity."""

    code = "NON_FINITE_INPUT"


class InvalidQuaternion(InvalidRequest):
    """A quaternion is too far from unit length to be a rotation."""

    code = "INVALID_QUATERNION"


class UnknownParameter(InvalidRequest):
    """A path names no number of the description.

    Attributes:
        path: The path.
        nearest: The path of the number that was meant: of the leg or motor that is named, or in no leg,
            and called most like it; empty: none is.
        known: Where that leg or motor is instead, or which there are; may be empty.
    """

    def __init__(self, path: str, nearest: str, known: str = "") -> None:
        """Keep the path, and name the nearest or what is known of it."""
        self.path, self.nearest, self.known = path, nearest, known
        meant = f"; did you mean {nearest}?" if nearest else f"; {known}" if known else ""
        super().__init__("parameters", f"the description has no number {path}{meant}")


def distinct(*numbers: float, fewest: int = _FEWEST) -> list[str]:
    """Numbers with few digits, or as many as it takes that different ones look different.

    Args:
        numbers: The numbers; zero has no sign.
        fewest: Digits that are enough where they tell them apart.
    """
    for digits in range(fewest, _ALL + 1):
        texts = [f"{number + 0.0:.{digits}g}" for number in numbers]
        if len(set(texts)) == len(set(numbers)):
            break
    return texts


def first_and_others(names: Sequence[str]) -> str:
    """The first of some names, and how many there are besides: ``leg1 (and 2 more)``."""
    more = len(names) - 1
    return f"{names[0]} (and {more} more)" if more else names[0]


def rounded_seconds(time: float) -> str:
    """A time to a nanosecond, as messages have it: sums of times are often not quite 0."""
    return f"{round(time, 9) + 0.0:g}"


@contextmanager
def warnings_as_lines(begin: str = "") -> Iterator[None]:
    """Say what users are warned of in a line of its own, without source code, as long as this lasts.

    Warnings about code (``RuntimeWarning``, ``DeprecationWarning``, ...) stay as Python has them.

    Args:
        begin: What comes before the text.
    """
    python = warnings.formatwarning

    def line_of(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        line: str | None = None,
    ) -> str:
        if issubclass(category, UserWarning):
            return f"{begin}{message}\n"
        return python(message, category, filename, lineno, line)

    warnings.formatwarning = line_of
    try:
        yield
    finally:
        warnings.formatwarning = python

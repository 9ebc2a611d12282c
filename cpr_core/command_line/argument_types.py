# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Texts of the command line as numbers and files; what is wrong with them is told before any work."""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Mapping
from contextlib import suppress
from itertools import combinations
from pathlib import Path

from ..errors import InvalidRequest

__all__ = [
    "check_files",
    "count",
    "finite",
    "length",
    "new_file",
    "not_negative",
    "number",
    "picture",
    "real",
]

_PI = re.compile(r"^([+-]?\d*\.?\d*)\*?pi(?:/(\d+\.?\d*))?$")
#: Whole numbers of more digits than any that is meant; Python does not even read 4300 of them.
_MOST_DIGITS = 40


def number(text: str) -> float:
    """A finite number, or a multiple of pi: ``0.3``, ``pi/8``, ``-2pi/3``."""
    match = _PI.match(text)
    try:
        if match is None:
            return finite(text)
        factor, divisor = match.groups()
        factor = f"{factor}1" if factor in ("", "+", "-") else factor
        return finite(str(float(factor) * math.pi / float(divisor or 1)))
    except (ValueError, ZeroDivisionError, argparse.ArgumentTypeError):
        raise argparse.ArgumentTypeError(f"expected a finite number, got {text!r:.100}") from None


def real(text: str) -> float:
    """Any number, or a multiple of pi; what is not finite is told by who knows what it is."""
    try:
        return number(text) if _PI.match(text) else float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a number, got {text!r:.100}") from None


def finite(text: str) -> float:
    """A finite number."""
    value = _value(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"expected a finite number, got {text!r:.100}")
    return value


def not_negative(text: str) -> float:
    """A finite number of at least 0."""
    value = finite(text)
    if value < 0.0:
        raise argparse.ArgumentTypeError(f"expected a number of at least 0, got {text:.100}")
    return value


def _value(text: str) -> float:
    """What a text is as a number; NaN if it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def length(text: str) -> float:
    """A length that is positive."""
    value = _value(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"expected a positive length in metres, got {text:.100}")
    return value


def count(text: str, least: int = 0, most: float = math.inf) -> int:
    """A whole number, not negative, within limits."""
    value = int(text) if text.isdecimal() and len(text) <= _MOST_DIGITS else -1
    if not least <= value <= most:
        limits = f"of at least {least}" if most == math.inf else f"from {least} to {most}"
        limits += f" with at most {_MOST_DIGITS} digits" if len(text) > _MOST_DIGITS else ""
        got = text if text.isdecimal() else repr(text)
        raise argparse.ArgumentTypeError(f"expected a whole number {limits}, got {got:.100}")
    return value


def new_file(text: str) -> Path:
    """A file that can be written."""
    file = Path(text)
    try:
        if file.is_dir():
            raise argparse.ArgumentTypeError(f"expected a file, {text!r} is a folder")
        if not file.parent.is_dir():
            raise argparse.ArgumentTypeError(
                f"expected a folder that exists, got {str(file.parent)!r}"
            )
        with suppress(FileNotFoundError):
            file.lstat()  # tells of names that no file can have
    except (OSError, ValueError) as error:
        raise argparse.ArgumentTypeError(
            f"expected the name of a file, got {text!r:.100}: {error!s:.100}"
        ) from None
    if not os.access(file if file.exists() else file.parent, os.W_OK):
        raise argparse.ArgumentTypeError(f"expected a file that can be written, got {text!r}")
    return file


def picture(text: str) -> Path:
    """A file that can be drawn to."""
    if Path(text).suffix.lower() not in (".png", ".svg", ".pdf"):
        raise argparse.ArgumentTypeError(
            f"expected a name ending in .png, .svg or .pdf, got {text!r}"
        )
    return new_file(text)


def check_files(read: Mapping[str, Path | None], written: Mapping[str, Path | None]) -> None:
    """Whether nothing that is written takes the place of what is read, or of something else written.

    Args:
        read: Files by what they are called on the command line.
        written: The same of files to write.

    Raises:
        InvalidRequest: Two names stand for one file.
    """
    pairs = [(own, other) for own in written.items() for other in read.items()]
    for (name, file), (other, place) in [*pairs, *combinations(written.items(), 2)]:
        if file is not None and place is not None and _same_file(file, place):
            lost = "would be overwritten" if other in read else "is to be written too"
            raise InvalidRequest(name, f"expected another file than {other}, {place}, which {lost}")


def _same_file(first: Path, second: Path) -> bool:
    """Whether two names stand for one file, there or not; what is no file, /dev/null, loses nothing."""
    try:
        if first.exists() and second.exists():
            return first.is_file() and first.samefile(second)
        return first.resolve() == second.resolve()
    except (OSError, ValueError, RuntimeError):  # such as links in a circle: opening them tells
        return False

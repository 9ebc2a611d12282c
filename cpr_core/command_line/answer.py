# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a command found: printed in any case, also where a file of it could not be written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..errors import InvalidRequest

__all__ = ["Answer", "written"]


@dataclass(frozen=True)
class Answer:
    """The answer of a command.

    Attributes:
        text: What to print.
        done: Whether it is what was asked for.
        problems: Why files could not be written, a line each.
    """

    text: str
    done: bool
    problems: tuple[str, ...] = ()


def written(write: Callable[[Path], object], file: Path | None) -> tuple[str, ...]:
    """Write a file, if there is to be one; returns what went wrong, in a line.

    What took hours to find is not lost because a disk is full.
    """
    if file is None:
        return ()
    try:
        write(file)
    except OSError as error:
        return (f"{file}: cannot be written: {error.strerror or error}",)
    except InvalidRequest as error:
        return (str(error),)
    return ()

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Paths in a description, such as ``legs[2].rod.length``, and the numbers they lead to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import reduce
from numbers import Real
from typing import Any

import numpy as np

__all__ = ["EVERY", "Key", "Place", "is_number", "numbers_in", "path_below", "path_of"]

Key = str | int
#: Keys that lead from the whole description to what is in it.
Place = tuple[Key, ...]
#: Stands for all entries of a list.
EVERY = "*"


def path_of(place: Place) -> str:
    """A place as a path."""
    return reduce(path_below, place, "")


def path_below(path: str, key: Key) -> str:
    """Path of a field or an entry of what is at a path; that of the whole is empty."""
    if isinstance(key, int) or key == EVERY:
        return f"{path}[{key}]"
    return f"{path}.{key}" if path else str(key)


def numbers_in(content: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """All numbers in what is at a path, with paths of their own."""
    if isinstance(content, Mapping):
        for name, value in content.items():
            yield from numbers_in(value, path_below(path, name))
    elif isinstance(content, np.ndarray):
        yield from numbers_in(content.tolist(), path)  # one without dimensions is a number
    elif isinstance(content, list | tuple):
        for number, value in enumerate(content):
            yield from numbers_in(value, path_below(path, number))
    elif is_number(content):
        yield path, content


def is_number(value: Any) -> bool:
    """Whether something is a number; a truth value is none."""
    return isinstance(value, Real) and not isinstance(value, bool)

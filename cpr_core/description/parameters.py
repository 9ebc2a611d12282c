# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers of a description by their path in it, as its author writes them.

``rod.young_modulus``, ``legs[2].chain[0].offset``, ``legs[0,1].chain[0].offset`` of two legs,
``legs[*].tip.position[2]`` of all: what can be written can be named, for it is looked up in the fields
themselves; a default counts as if it were written.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InvalidRequest, UnknownParameter
from ..validation import checked_number
from .description_paths import EVERY, Key, Place, is_number, numbers_in, path_of
from .meant_parameters import unknown_parameter
from .written_fields import WrittenFields

__all__ = [
    "Parameter",
    "changed_content",
    "checked_paths",
    "in_default",
    "named_parameter",
    "pair_of",
    "parameter_changes",
]

#: A field, and entries of what is in it: one, several, or all.
_FIELD = r"[^\s.\[\]]+(\[(\d+(,\d+)*|\*)\])*"
_PATH = re.compile(rf"{_FIELD}(\.{_FIELD})*\Z")
_KEY = re.compile(r"\[([\d,]+|\*)\]|([^\s.\[\]]+)")
#: Numbers below these fields are choices of the discretisation.
_DISCRETISATION = "strain"


@dataclass(frozen=True)
class Parameter:
    """A number of a description, or the same one in several places.

    Attributes:
        path: Its path, with ``[0,1]`` for these entries of a list, ``[*]`` for every one that has such a
            number.
        places: Where it is in the fields.
        values: What it is there, in SI units.
        sizes: How large it is there: of an entry of a vector how large the vector is.
    """

    path: str
    places: tuple[Place, ...]
    values: tuple[float, ...]
    sizes: tuple[float, ...]

    @property
    def value(self) -> float:
        """Its value.

        Raises:
            InvalidRequest: It differs from place to place.
        """
        if len(set(self.values)) > 1:
            several = ", ".join(f"{value:g}" for value in self.values)
            problem = f"{self.path} has no single value: {several}; name the places one by one"
            raise InvalidRequest("parameters", problem)
        return self.values[0]

    @property
    def size(self) -> float:
        """The largest of its sizes; 0 where all vanishes."""
        return max(self.sizes)


def checked_paths(paths: str | Sequence[str]) -> tuple[str, ...]:
    """Paths of parameters, none of them twice.

    Raises:
        InvalidRequest: No paths.
    """
    given = (paths,) if isinstance(paths, str) else paths
    if not isinstance(given, Sequence) or not all(isinstance(path, str) for path in given):
        raise InvalidRequest("parameters", f"expected paths such as rod.length, got {paths!r:.200}")
    if not given:
        raise InvalidRequest("parameters", "expected at least one path such as rod.length")
    if len(set(given)) < len(given):
        twice = next(path for number, path in enumerate(given) if path in given[:number])
        raise InvalidRequest("parameters", f"{twice} is named twice")
    return tuple(given)


def named_parameter(written: WrittenFields, path: str) -> Parameter:
    """The parameter a path names.

    Raises:
        UnknownParameter: There is no such number, or an entry that is named has none; tells
            what was meant.
        InvalidRequest: Not a path, an entry is named twice, or what is there cannot be changed.
    """
    if not isinstance(path, str) or not _PATH.match(path):
        raise InvalidRequest("parameters", f"expected a path such as rod.length, got {path!r:.200}")
    keys = [(name,) if name else _entries(path, index) for index, name in _KEY.findall(path)]
    found = list[tuple[Place, Any, float]]()
    for single in itertools.product(*keys):
        entries = list(_found(written, (), single))
        if not entries:
            raise _unknown(written, path_of(single))
        found += entries
    for place, value, _ in found:
        _check(path_of(place), value, place)
    places, values, sizes = zip(*found, strict=True)
    return Parameter(path, places, tuple(map(float, values)), sizes)


def _entries(path: str, index: str) -> tuple[Key, ...]:
    """Keys of what stands between brackets.

    Raises:
        InvalidRequest: A number stands there twice.
    """
    if index == EVERY:
        return (EVERY,)
    numbers = tuple(map(int, index.split(",")))
    for place, number in enumerate(numbers):
        if number in numbers[:place]:
            raise InvalidRequest("parameters", f"{path}: entry {number} is named twice")
    return numbers


def _check(path: str, value: Any, place: Place) -> None:
    """Whether what is at a path is a number that can be changed.

    Raises:
        InvalidRequest: It is not.
    """
    if _DISCRETISATION in place and place[0] != "home":
        raise InvalidRequest(
            "parameters", f"{path} says how many unknowns there are, not what the robot is like"
        )
    if not is_number(value):
        within = ""
        if isinstance(value, Mapping):
            within = f"; it has the fields {', '.join(map(str, value)) or 'none'}"
        elif isinstance(value, list | tuple | np.ndarray):
            within = f"; its entries are {path}[0] to {path}[{len(value) - 1}]"
        kind = "no number" if within else f"no number but {value!r:.60}"
        raise InvalidRequest("parameters", f"{path} is {kind}{within}")


def _found(
    written: WrittenFields, before: Place, keys: Sequence[Key]
) -> Iterator[tuple[Place, Any, float]]:
    """Places, values and sizes of what keys lead to; nothing where they lead nowhere."""
    if EVERY in keys:
        star = list(keys).index(EVERY)
        way = (*before, *keys[:star])
        entries = _at(written, way)
        if isinstance(entries, list | tuple | np.ndarray):
            for number in range(len(entries)):
                yield from _found(written, (*way, number), keys[star + 1 :])
        return
    place = (*before, *keys)
    value = _at(written, place)
    if value is None:
        return
    around = _at(written, place[:-1]) if isinstance(place[-1], int) else value
    numbers = isinstance(around, list | tuple | np.ndarray | int | float)
    entries = np.ravel(np.array(around, dtype=object)) if numbers else ()
    sizes = [abs(entry) for entry in entries if is_number(entry)]
    yield place, value, float(max(sizes, default=0.0))


def _at(written: WrittenFields, place: Place) -> Any:
    """What is at a place: as written, else as it was read; None where there is nothing."""
    value: Any = written.content
    for number, key in enumerate(place):
        value = _entry(value, key)
        if value is None:
            value = written.read.get(path_of(place[: number + 1]))
    if value is None and place:
        return None
    return value.item() if isinstance(value, np.generic) else value


def _entry(value: Any, key: Key) -> Any:
    """An entry of a list or field of a mapping; None where it has none."""
    if isinstance(key, str):
        return value.get(key) if isinstance(value, Mapping) else None
    whole = isinstance(value, list | tuple | np.ndarray)
    return value[key] if whole and key < len(value) else None


def changed_content(written: WrittenFields, values: Mapping[Place, float]) -> dict[str, Any]:
    """The fields with other numbers, a copy where they differ."""
    content: Any = dict(written.content)
    copied: dict[Place, Any] = {(): content}
    for place, value in values.items():
        for depth in range(1, len(place)):
            part = place[:depth]
            if part not in copied:
                present = _at(written, part)
                if is_number(present):
                    present = pair_of(written, path_of(part))
                copied[part] = _copy(present)
                copied[part[:-1]][part[-1]] = copied[part]
        copied[place[:-1]][place[-1]] = value
    return dict(content)


def pair_of(written: WrittenFields, path: str) -> list[float | None]:
    """A number that stands for both of a pair as the pair; None for one that has no such number."""
    return [written.read.get(f"{path}[{number}]") for number in range(2)]


def in_default(written: WrittenFields, place: Place) -> bool:
    """Whether a place is within something that is not written but has a default."""
    value: Any = written.content
    for key in place[:-1]:
        value = _entry(value, key)
    return value is None


def _copy(value: Any) -> Any:
    """A container of its own, what is in it shared: only ways to what is changed are copied."""
    if isinstance(value, Mapping):
        return dict(value)
    return value.tolist() if isinstance(value, np.ndarray) else list(value)


def parameter_changes(written: WrittenFields, values: Mapping[str, object]) -> dict[Place, float]:
    """New numbers by place.

    Raises:
        UnknownParameter: There is no such number.
        InvalidRequest: What is there or what is given is no number, or a place is given two, be it by a
            number that stands for a pair.
        NonFiniteInput: A NaN or an infinity.
    """
    if not isinstance(values, Mapping) or not values:
        raise InvalidRequest("parameters", f"expected values by path, got {values!r:.200}")
    changes: dict[Place, float] = {}
    for path, value in values.items():
        parameter = named_parameter(written, path)
        number = checked_number(f"parameters[{path!r}]", value)
        for place in parameter.places:
            if changes.setdefault(place, number) != number:
                raise InvalidRequest("parameters", f"{path_of(place)} is given two values")
    for place in [place for place in changes if place[:-1] in changes]:
        if changes.pop(place) != changes[place[:-1]]:
            raise InvalidRequest(
                "parameters",
                f"{path_of(place)} is given two values, one of them for both as "
                f"{path_of(place[:-1])}",
            )
    return changes


def _unknown(written: WrittenFields, path: str) -> UnknownParameter:
    """The error of a path that leads nowhere."""
    known: dict[str, None] = {}
    for name, value in written.read.items():
        known |= dict.fromkeys(path for path, _ in numbers_in(value, name))
    known |= dict.fromkeys(path for path, _ in numbers_in(written.content))
    changeable = [name for name in known if not name.startswith(f"{_DISCRETISATION}.")]
    return unknown_parameter(written, path, changeable)

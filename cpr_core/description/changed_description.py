# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Descriptions with other numbers: the fields are changed, checked and read again."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..description_part import Part
from ..errors import DescriptionError, DescriptionWarning, InvalidRequest
from .description_builder import described_robot
from .description_file import check_numbers
from .description_paths import Place, is_number, path_below
from .parameters import (
    Parameter,
    changed_content,
    checked_paths,
    in_default,
    named_parameter,
    pair_of,
    parameter_changes,
)
from .robot_description import RobotDescription
from .stiffness_jumps import check_jumps
from .tracker import Tracker
from .written_fields import WrittenFields

__all__ = [
    "between",
    "check_numbers_only",
    "named_parameters",
    "parameter_values",
    "schema_allows",
    "shifted",
    "shifted_together",
    "shifted_tracker",
    "with_parameters",
]

Floats = NDArray[np.float64]

#: As `Part.slack`: a direction that is varied alone takes along what has to be across it.
_FOLLOWING = 0.5


def named_parameters(
    description: RobotDescription, paths: str | Sequence[str]
) -> tuple[Parameter, ...]:
    """Numbers of a description by their paths.

    Raises:
        UnknownParameter: There is no such number.
        InvalidRequest: What is there is no number, or a path is given twice.
    """
    written = _written(description)
    return tuple(named_parameter(written, path) for path in checked_paths(paths))


def parameter_values(description: RobotDescription, paths: str | Sequence[str]) -> Floats:
    """What they are, (P,), in SI units.

    Raises:
        UnknownParameter: There is no such number.
        InvalidRequest: What is there is no number, or not the same in all of its legs.
    """
    return np.array([parameter.value for parameter in named_parameters(description, paths)])


def with_parameters(description: RobotDescription, values: Mapping[str, float]) -> RobotDescription:
    """The same robot with other numbers, checked as if they came from a file.

    Args:
        description: The robot. It keeps its strain modes.
        values: New numbers by their paths.

    Raises:
        UnknownParameter: There is no such number.
        InvalidRequest: What is there or what is given is no number.
        NonFiniteInput: A NaN or an infinity.
        DescriptionError: No robot has such a number.
    """
    written = _written(description)
    changes = parameter_changes(written, values)
    content = _content(description, changes)
    check_numbers(description.source, content, changes)
    text = "" if written.read_text == "" else None
    changed = described_robot(description.source, content, text).with_modes_of(description)
    if math.isinf(changed.tolerance):  # modes that one chooses are compared with more instead
        check_jumps(changed)
    return changed


def schema_allows(description: RobotDescription, path: str, value: float) -> bool:
    """Whether the schema has room for a number at a path, whatever the robot would be.

    Raises:
        UnknownParameter: There is no such number.
        InvalidRequest: What is there is no number.
    """
    changes = parameter_changes(_written(description), {path: value})
    try:
        check_numbers(description.source, _content(description, changes), changes)
    except DescriptionError:
        return False
    return True


def shifted(description: RobotDescription, parameter: Parameter, change: float) -> RobotDescription:
    """The same robot with a number changed a little, wherever it is; only for differences.

    It is not checked against the schema, and normals follow their tangents.

    Args:
        description: The robot.
        parameter: Of its numbers.
        change: What is added to it.

    Raises:
        DescriptionError: No robot is near this one in this number.
    """
    return shifted_together(description, ((parameter, change),))


def shifted_together(
    description: RobotDescription, changes: Sequence[tuple[Parameter, float]]
) -> RobotDescription:
    """The same with several numbers changed; what is in the same place adds up."""
    values: dict[Place, float] = {}
    for parameter, change in changes:
        for place, value in zip(parameter.places, parameter.values, strict=True):
            values[place] = values.get(place, value) + change
    return _quietly(description, _content(description, values))


def shifted_tracker(description: RobotDescription, parameter: Parameter, change: float) -> Tracker:
    """The tracker with one of its numbers changed a little; only for differences."""
    values = zip(parameter.places, parameter.values, strict=True)
    content = _content(description, {place: value + change for place, value in values})
    part = Part(description.source, "tracker", content["tracker"], description.planar)
    return Tracker.from_description(part)


def between(first: RobotDescription, last: RobotDescription, fraction: float) -> RobotDescription:
    """The robot part of the way from one to another that differs from it in numbers.

    Raises:
        InvalidRequest: They differ in more.
        DescriptionError: There is no robot there.
    """
    return _quietly(first, _Mixture(_written(first), _written(last), fraction).content())


def check_numbers_only(first: RobotDescription, last: RobotDescription) -> None:
    """Whether two robots differ in numbers of their descriptions only.

    Raises:
        InvalidRequest: They differ in more.
    """
    _Mixture(_written(first), _written(last), 0.5).content()


def _content(description: RobotDescription, changes: Mapping[Place, float]) -> dict[str, Any]:
    """The fields of a description with other numbers.

    Where one is an entry of a default, the others of that default are written too: as they are with all
    other changes made, for a default may follow them, as the centre of mass of a link does its end.
    """
    written = _written(description)
    last = {place: value for place, value in changes.items() if in_default(written, place)}
    if 0 < len(last) < len(changes):
        first = {place: value for place, value in changes.items() if place not in last}
        written = _written(_quietly(description, changed_content(written, first)))
        changes = last
    return changed_content(written, changes)


def _quietly(description: RobotDescription, content: dict[str, Any]) -> RobotDescription:
    """The robot of other fields; nobody wants to hear twice what looks like a mistake in it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DescriptionWarning)
        changed = described_robot(description.source, content, "", _FOLLOWING, description)
    return changed.with_modes_of(description)


@dataclass(frozen=True)
class _Mixture:
    """Fields part of the way from some to others; what only one has is a default of the other.

    Attributes:
        first: Where the way begins.
        last: Where it ends.
        fraction: Of the way.
    """

    first: WrittenFields
    last: WrittenFields
    fraction: float

    def content(self) -> dict[str, Any]:
        """The fields.

        Raises:
            InvalidRequest: They differ in more than numbers.
        """
        mixed: dict[str, Any] = self._mixed(self.first.content, self.last.content, "")
        return mixed

    def _mixed(self, first: Any, last: Any, path: str) -> Any:
        if first is last:  # changes share what they do not change
            return first
        first, last = _plain(first), _plain(last)
        if is_number(first) and is_number(last):
            between_them = (1.0 - self.fraction) * first + self.fraction * last
            return first if first == last else between_them
        if is_number(first) and isinstance(last, list):
            first = pair_of(self.first, path)
        elif is_number(last) and isinstance(first, list):
            last = pair_of(self.last, path)
        if isinstance(first, Mapping) and isinstance(last, Mapping):
            mixed = {}
            for name in dict.fromkeys((*first, *last)):
                entry = path_below(path, name)
                mine = first.get(name, self.first.read.get(entry))
                theirs = last.get(name, self.last.read.get(entry))
                mixed[name] = self._mixed(mine, theirs, entry)
            return mixed
        rows = isinstance(first, list) and isinstance(last, list)
        if rows and len(first) == len(last):
            pairs = enumerate(zip(first, last, strict=True))
            return [
                self._mixed(first_row, last_row, path_below(path, n))
                for n, (first_row, last_row) in pairs
            ]
        if first != last:
            problem = "expected one that differs in numbers of its description only"
            raise InvalidRequest("robot", f"{problem}, not in {path}")
        return first


def _plain(value: Any) -> Any:
    """Lists as lists, whatever they were read as."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value


def _written(description: RobotDescription) -> WrittenFields:
    """The fields of a description.

    Raises:
        InvalidRequest: It was made in other ways.
    """
    if description.written is None:
        raise InvalidRequest(
            "parameters", f"{description.name} was not read from a description as it is"
        )
    return description.written

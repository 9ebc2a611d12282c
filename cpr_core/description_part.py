# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A part of a description as its class reads it, and what a class says of its own fields."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from dataclasses import field as attribute
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from .errors import DescriptionError, DescriptionWarning

__all__ = ["EXACTLY_ACROSS", "Described", "Part", "Vector", "field", "triple"]

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]
#: Cosine of two directions that are across each other, up to rounding in a file.
EXACTLY_ACROSS = 1e-6


@dataclass(frozen=True)
class Part:
    """A part of a description that keeps to the schema; answers with values or names the field.

    Attributes:
        source: Where the description came from.
        path: The part in it, such as ``legs[2].motor``; empty: all of it.
        content: Its fields.
        planar: Whether the robot lives in the plane z = 0.
        read: What was read, by path, defaults among it; parts of one description share it and write
            to it.
        slack: Cosine by which a normal may miss being across its tangent. More than rounding where one
            of the two is changed alone, to see what it does: the other one then follows.
    """

    source: str
    path: str
    content: Mapping[str, Any]
    planar: bool
    read: dict[str, Any] = attribute(default_factory=dict, compare=False, repr=False)
    slack: float = EXACTLY_ACROSS

    def fail(self, name: str, problem: str) -> DescriptionError:
        """The error of a field, or of the whole part where it has no name; to be raised."""
        return DescriptionError(self.source, self.path_of(name), problem)

    def warn(self, name: str, problem: str) -> None:
        """Warn of a field, or of the whole part where it has no name."""
        text = f"{self.source}: {self.path_of(name)}: {problem}"
        warnings.warn(text, DescriptionWarning, stacklevel=2)

    def path_of(self, name: str) -> str:
        """Path of a field in the whole description."""
        return f"{self.path}.{name}" if self.path and name else self.path or name

    def __contains__(self, name: str) -> bool:
        return name in self.content

    def get(self, name: str, default: Any = None) -> Any:
        """What a field says, as it was read.

        Raises:
            DescriptionError: It is missing and has no default.
        """
        if name not in self.content and default is None:
            raise self.fail("", f"missing field {name!r}")
        value = self.content.get(name, default)
        self.read[self.path_of(name)] = value
        return value

    def part(self, name: str) -> Part:
        """A field with fields of its own; none where it is missing."""
        path, content = self.path_of(name), self.content.get(name, {})
        self.read[path] = content
        return self._below(path, content)

    def parts(self, name: str) -> tuple[Part, ...]:
        """A list of such fields; none where it is missing."""
        return tuple(
            self._below(self.path_of(f"{name}[{index}]"), content)
            for index, content in enumerate(self.content.get(name, ()))
        )

    def _below(self, path: str, content: Mapping[str, Any]) -> Part:
        """Another part of the description."""
        return Part(self.source, path, content, self.planar, self.read, self.slack)

    def number(self, name: str, default: float | None = None) -> float:
        """A number."""
        return float(self.get(name, default))

    def vector(self, name: str, default: Sequence[float] | None = None) -> Floats:
        """A vector, (3,); in the plane one without z."""
        return self.in_plane(name, self.get(name, default))

    def in_plane(self, name: str, value: Sequence[float]) -> Floats:
        """The vector a field stands for, (3,); in the plane one without z."""
        vector = np.array(value, float)
        if self.planar and vector[2] != 0.0:
            raise self.fail(name, f"expected z = 0 in a planar robot, got {value}")
        return vector

    def direction(self, name: str, default: Sequence[float] | None = None) -> Floats:
        """A unit vector, (3,)."""
        return self.direction_of(name, self.get(name, default))

    def direction_of(self, name: str, value: Sequence[float]) -> Floats:
        """The unit vector a field stands for, (3,)."""
        vector = np.array(value, float)
        largest = float(np.abs(vector).max())
        if largest < 1e-9:
            raise self.fail(name, f"expected a direction, got {value} of length zero")
        vector = vector / largest  # its square is finite now
        return vector / math.sqrt(vector @ vector)

    def shift_axis(self, name: str) -> Floats:
        """A unit vector along which something moves, (3,): in the plane one without z."""
        direction = self.direction(name)
        self.vector(name)
        return direction

    def turn_axis(self, name: str) -> Floats:
        """A unit vector about which something turns, (3,): in the plane +-z."""
        direction = self.direction(name)
        if self.planar and abs(direction[2]) < 1.0 - 1e-9:
            raise self.fail(name, f"expected +-z in a planar robot, got {self.content[name]}")
        return direction

    def frame(self, default: Floats | None = None) -> Floats:
        """Frame (d1, d2, d3 as columns), (3, 3), of the fields ``tangent`` and ``normal``.

        Args:
            default: d2 where none is given; in the plane it is z x tangent.
        """
        tangent = self.shift_axis("tangent")
        if self.planar:
            if "normal" in self:
                raise self.fail("normal", "a planar robot has none: d2 is z x tangent")
            normal = np.array([-tangent[1], tangent[0], 0.0])
        elif "normal" in self:
            normal = self.direction("normal")
            if abs(normal @ tangent) > self.slack:
                given = self.content["normal"]
                raise self.fail("normal", f"expected a direction across the tangent, got {given}")
        elif default is not None:
            normal = default
        else:
            raise self.fail(
                "", "missing field 'normal', direction of d2: how it is turned about its tangent"
            )
        normal = normal - (normal @ tangent) * tangent
        normal = normal / math.sqrt(normal @ normal)
        (a, b, c), (x, y, z) = tangent.tolist(), normal.tolist()
        return np.array([[a, x, b * z - c * y], [b, y, c * x - a * z], [c, z, a * y - b * x]])

    def stations(self, name: str) -> Floats:
        """Stations along a rod, increasing, the first 0 and the last 1."""
        at = self.get(name)
        stations = np.array(at, float)
        if stations[0] != 0.0 or stations[-1] != 1.0 or np.any(np.diff(stations) <= 0.0):
            raise self.fail(
                name, f"expected increasing numbers, the first 0 and the last 1, got {at}"
            )
        return stations


class Described:
    """A class with a name in descriptions: it says which fields it has there, and reads them.

    Attributes:
        fields: Its fields as JSON schema; those of the whole file are at ``#/$defs``.
        required: Those of them that have no default.
    """

    fields: ClassVar[Mapping[str, Any]] = {}
    required: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """The value its part of a description stands for.

        Raises:
            DescriptionError: Something a schema cannot say is wrong.
        """
        raise NotImplementedError


def field(kind: str, meaning: str) -> dict[str, str]:
    """Schema of a field: a name under ``#/$defs``, and what it means with its unit."""
    return {"$ref": f"#/$defs/{kind}", "description": meaning}


def triple(vector: Floats) -> Vector:
    """Three numbers that can be compared."""
    x, y, z = vector.tolist()
    return x, y, z

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One entry of the table of parameters, and how its values are written. No ROS here."""

from __future__ import annotations

from decimal import Decimal
from typing import NamedTuple

__all__ = ["DeclaredParameter"]


class DeclaredParameter(NamedTuple):
    """One parameter.

    Attributes:
        name: Its name.
        default: Its value if none is given; says its type too.
        unit: Unit; empty if it has none.
        meaning: What it is.
        limits: Smallest and largest value of a number.
        choices: The only values of a string; empty: any.
        live: Whether it may change at any time; else it is fixed at start.
    """

    name: str
    default: bool | int | float | str
    unit: str
    meaning: str
    limits: tuple[float, float] | None = None
    choices: tuple[str, ...] = ()
    live: bool = False

    @property
    def kind(self) -> str:
        """Its type, as ROS calls it."""
        names = {bool: "bool", int: "integer", float: "double", str: "string"}
        return names[type(self.default)]

    @property
    def values(self) -> str:
        """Which values it may have; empty: any of its type."""
        if self.limits is not None:
            return " to ".join(_plain(limit).removesuffix(".0") for limit in self.limits)
        return " or ".join(self.choices)

    @property
    def default_text(self) -> str:
        """Its default as it is written in a parameter file."""
        if isinstance(self.default, bool):
            return str(self.default).lower()
        if isinstance(self.default, float):
            return _plain(self.default)
        return str(self.default) or "''"


def _plain(number: float) -> str:
    """A number without an exponent: YAML takes 2e-05 for a word, and so do tools that read it."""
    return format(Decimal(repr(number)), "f")

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What launch/cpr.launch.py starts, from what it is given. Neither ROS nor launch here."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from .parameter_table import PARAMETERS, DeclaredParameter

__all__ = ["ARGUMENTS", "LaunchChoices", "misspelt"]

_DECLARED = {parameter.name: parameter for parameter in PARAMETERS}
_OWN = {
    "parameters": ("", "parameter file; default: the one of the robot, if it has one"),
    "name": ("cpr_node", "name of the node"),
    "namespace": ("", "namespace of the node"),
    "rviz": ("false", "whether to start rviz"),
}
#: Arguments of the launch file: default and meaning. A parameter that is not given is left to the
#: parameter file, or to the node.
ARGUMENTS = _OWN | {
    name: ("", f"{parameter.meaning} [{parameter.unit}]" if parameter.unit else parameter.meaning)
    for name, parameter in _DECLARED.items()
}


@dataclass(frozen=True)
class LaunchChoices:
    """What was chosen.

    Attributes:
        given: Arguments of the launch file; empty: not given.
        share: Folder of the files that come with the package.
    """

    given: Mapping[str, str]
    share: Path

    def parameters(self) -> list[str | dict[str, Any]]:
        """Parameter files and values for the node, later ones first in rank.

        Raises:
            ValueError: A value of the wrong type, or a file that is not there.
        """
        own = {
            name: _value(_DECLARED[name], text)
            for name, text in self.given.items()
            if name in _DECLARED and text
        }
        file = self._file()
        return [*([str(file)] if file else []), *([own] if own else [])]

    def fixed_frame(self) -> str:
        """The frame that a view stands in: the base frame of the node."""
        in_file = _values_in(self._file())
        names = ("frame_prefix", "base_frame")
        return "".join(
            self.given.get(name) or str(in_file.get(name, _DECLARED[name].default))
            for name in names
        )

    def wants_view(self) -> bool:
        """Whether rviz is to be started.

        Raises:
            ValueError: Neither yes nor no.
        """
        return _truth("rviz", self.given.get("rviz") or "false")

    def _file(self) -> Path | None:
        """The parameter file: the one that is given, else that of the robot, if it has one."""
        given = self.given.get("parameters")
        if given:
            file = Path(given).expanduser()
            if not file.is_file():
                raise ValueError(f"parameters: expected a parameter file, there is no {file}")
            return file
        robot = self.given.get("robot") or str(_DECLARED["robot"].default)
        file = self.share / "config" / "node" / f"{robot}.yaml"
        return file if file.is_file() else None


def misspelt(configurations: Iterable[str]) -> list[str]:
    """Names near those of arguments, one line each.

    Other names may be those of a launch file that includes ours: launch takes every name without a word.
    """
    lines = []
    for name in configurations:
        near = difflib.get_close_matches(name, ARGUMENTS, n=1, cutoff=0.75)
        if near and name not in ARGUMENTS:
            lines.append(f"unknown argument {name}: did you mean {near[0]}?")
    return lines


def _values_in(file: Path | None) -> dict[str, Any]:
    """All values in a parameter file, whatever node they are for."""
    values: dict[str, Any] = {}
    content = yaml.safe_load(file.read_text()) if file else None
    for section in content.values() if isinstance(content, dict) else ():
        if isinstance(section, dict) and isinstance(section.get("ros__parameters"), dict):
            values |= section["ros__parameters"]
    return values


def _value(parameter: DeclaredParameter, text: str) -> bool | int | float | str:
    """A parameter as its type wants it.

    Raises:
        ValueError: It cannot be.
    """
    if parameter.kind == "bool":
        return _truth(parameter.name, text)
    kind = type(parameter.default)
    try:
        return kind(text)
    except ValueError:
        expected = {int: "an integer", float: "a number"}[kind]
        raise ValueError(f"{parameter.name}: expected {expected}, got {text!r}") from None


def _truth(name: str, text: str) -> bool:
    truths = {"true": True, "1": True, "false": False, "0": False}
    if text.lower() not in truths:
        raise ValueError(f"{name}: expected true or false, got {text!r}")
    return truths[text.lower()]

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What launch/cpr.launch.py starts, from what it is given. Neither ROS nor launch here."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from .parameter_entry import DeclaredParameter
from .parameter_table import PARAMETERS

__all__ = ["ARGUMENTS", "LaunchChoices", "unknown"]

_DECLARED = {parameter.name: parameter for parameter in PARAMETERS}
_OWN = {
    "parameters": ("", "parameter file; default: the one of the robot, if it has one"),
    "name": ("cpr_node", "name of the node"),
    "namespace": ("", "namespace of the node"),
    "rviz": ("false", "whether to start rviz"),
    "use_sim_time": ("", "whether time is that of /clock, for the node and rviz"),
}
#: What launch and launch_ros keep beside arguments.
_OF_LAUNCH = ("global_params", "ros_namespace", "ros_remaps", "emulate_tty")
#: Names of topics in rviz/cpr.rviz begin with that of the node.
_NODE = "cpr_node/"
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
        if self.given.get("use_sim_time"):
            own["use_sim_time"] = _truth("use_sim_time", self.given["use_sim_time"])
        file = self._file()
        return [*([str(file)] if file else []), *([own] if own else [])]

    def fixed_frame(self) -> str:
        """The frame that a view stands in: the base frame of the node."""
        return self._text("frame_prefix") + self._text("base_frame")

    def wants_view(self) -> bool:
        """Whether rviz is to be started.

        Raises:
            ValueError: Neither yes nor no.
        """
        return _truth("rviz", self.given.get("rviz") or "false")

    def view_file(self) -> Path:
        """What rviz shows, for a node with the default name and without a prefix."""
        return self.share / "rviz" / "cpr.rviz"

    def view_remappings(self) -> list[tuple[str, str]]:
        """Topics of the node for a view that asks for those of ``cpr_node``."""
        name = self.given.get("name") or "cpr_node"
        topics = [
            text
            for text in _texts_in(yaml.safe_load(self.view_file().read_text()))
            if text.startswith(_NODE)
        ]
        return [(topic, f"{name}/{topic.removeprefix(_NODE)}") for topic in topics]

    def view_parameters(self) -> list[dict[str, bool]]:
        """Parameters of rviz: the time of the node."""
        text = self.given.get("use_sim_time") or str(
            _values_in(self._file()).get("use_sim_time", False)
        )
        return [{"use_sim_time": True}] if _truth("use_sim_time", text) else []

    def view_configuration(self) -> str:
        """What rviz shows, if not :meth:`view_file`, which has no prefix; empty: that file.

        The URDF has none, and RobotModel puts one and a / before the names of its links.
        """
        prefix = self._text("frame_prefix")
        if not prefix:
            return ""
        content = yaml.safe_load(self.view_file().read_text())
        for display in content["Visualization Manager"]["Displays"]:
            if display["Class"] == "rviz_default_plugins/RobotModel":
                display["TF Prefix"] = prefix.removesuffix("/")
        return yaml.safe_dump(content, sort_keys=False)

    def view_doubt(self) -> str:
        """What rviz will not show; empty: it shows everything."""
        prefix = self._text("frame_prefix")
        if not prefix or prefix.endswith("/"):
            return ""
        return (
            f"frame_prefix {prefix} does not end with /, which RobotModel of rviz puts behind it: "
            "motors and platform will not be seen"
        )

    def _text(self, name: str) -> str:
        """A parameter of the node as it is given, or in its file, or by default."""
        in_file = _values_in(self._file())
        return self.given.get(name) or str(in_file.get(name, _DECLARED[name].default))

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


def unknown(configurations: Iterable[str]) -> list[str]:
    """Names that are no arguments, one line each: launch takes every name without a word."""
    lines = []
    for name in configurations:
        if name in ARGUMENTS or name in _OF_LAUNCH or name.startswith("anon"):
            continue
        near = difflib.get_close_matches(name, ARGUMENTS, n=1, cutoff=0.75)
        # Those of a launch file that includes ours are here, too.
        meant = f"did you mean {near[0]}?" if near else "it changes nothing here"
        lines.append(f"unknown argument {name}: {meant}")
    return lines


def _texts_in(content: Any) -> Iterator[str]:
    """All texts in what a YAML file has."""
    if isinstance(content, str):
        yield content
    elif isinstance(content, dict):
        for value in content.values():
            yield from _texts_in(value)
    elif isinstance(content, list):
        for value in content:
            yield from _texts_in(value)


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

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What may be written behind ``cpr_node``. No ROS here: help does not wait for it."""

from __future__ import annotations

import difflib
import itertools
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .parameter_table import PARAMETERS, ROS_PARAMETERS

__all__ = ["closest", "files_of_others", "unknown_arguments", "usage"]

_HEAD = """\
usage: cpr_node [--help] [--ros-args [-p NAME:=VALUE] [--params-file FILE] [-r FROM:=TO] ...]

The ROS 2 node of a continuum parallel robot: follows setpoints, answers services, streams stability.

  cpr_node --ros-args -p robot:=rfrfr
  cpr_node --ros-args --params-file my_robot.yaml -r __ns:=/left

Parameters; those marked live may be changed while the node runs:
"""
_NAMES = tuple(parameter.name for parameter in PARAMETERS)
#: Twice as long as the longest one.
_LONGEST_NAME = 2 * max(map(len, _NAMES))
#: Options of ROS that stand for themselves when the marker before them is forgotten.
_ROS_OPTIONS = ("-p", "--param", "-r", "--remap", "--params-file", "--log-level", "-e", "--enclave")
#: All that ROS takes with a word behind it, and without one.
_WITH_VALUE = (*_ROS_OPTIONS, "--log-config-file", "--log-file-name")
_ALONE = re.compile("--(enable|disable)-(rosout|stdout|external-lib)-logs")


def usage() -> str:
    """What --help prints."""
    lines = [_HEAD]
    for parameter in PARAMETERS:
        unit = f" [{parameter.unit}]" if parameter.unit else ""
        values = f", {parameter.values}" if parameter.values else ""
        live = ", live" if parameter.live else ""
        default = f"default {parameter.default_text}"
        lines.append(f"  {parameter.name}  ({parameter.kind}{unit}{values}; {default}{live})")
        lines += textwrap.wrap(
            parameter.meaning, 76, initial_indent=" " * 6, subsequent_indent=" " * 6
        )
    return "\n".join(lines)


def unknown_arguments(arguments: list[str]) -> list[str]:
    """What is wrong with arguments of the node, one line each; empty if nothing is.

    Args:
        arguments: Without the name of the program.
    """
    own, of_ros = _separated(arguments)
    problems = [*_unknown(own, "--ros-args "), *_unknown(_left_by_ros(of_ros), "")]
    for name in _given_parameters(of_ros):
        if name not in (*_NAMES, *ROS_PARAMETERS) and not name.startswith("qos_overrides."):
            problems.append(f"unknown parameter {name}{closest(name)}")
    return problems


def _unknown(arguments: list[str], before: str) -> Iterator[str]:
    """What is said of arguments that nobody takes.

    Args:
        arguments: The arguments.
        before: What has to stand in front of what was meant.
    """
    skipped = False
    for argument, following in itertools.pairwise([*arguments, ""]):
        if skipped:
            skipped = False
            continue
        meant, skipped = _meant(argument, following)
        shown = f"{argument} {following}" if skipped else argument
        hint = f": did you mean {before}{meant}?" if meant else ""
        yield f"unknown argument {shown}{hint}"


def _left_by_ros(of_ros: list[str]) -> list[str]:
    """What ROS does not know of what is behind --ros-args."""
    left, taken = [], False
    for argument in of_ros:
        if taken:
            taken = False
        elif argument in _WITH_VALUE:
            taken = True
        elif not _ALONE.fullmatch(argument):
            left.append(argument)
    return left


def files_of_others(arguments: list[str], name: str) -> list[str]:
    """Parameter files with nothing in them for this node, one line each.

    Args:
        arguments: Without the name of the program.
        name: Full name of the node.
    """
    import yaml

    lines = []
    for option, value in itertools.pairwise(_separated(arguments)[1]):
        if option != "--params-file":
            continue
        try:
            content = yaml.safe_load(Path(value).read_text())
        except (OSError, ValueError, yaml.YAMLError):
            continue  # ROS has its own words for it
        sections = list(_sections(content)) if isinstance(content, dict) else []
        if not any(_matches(section, name) for section in sections):
            named = ", ".join(sections) or "nobody"
            lines.append(f"{value} has no parameters for {name}: they are for {named}")
    return lines


def _sections(content: dict[Any, Any]) -> Iterator[str]:
    """Names of the nodes of a parameter file, whose namespaces may be sections of their own."""
    for name, inside in content.items():
        nested = inside if isinstance(inside, dict) and "ros__parameters" not in inside else {}
        if nested:
            outer = str(name).rstrip("/")
            yield from (f"{outer}/{section.lstrip('/')}" for section in _sections(nested))
        else:
            yield str(name)


def _matches(section: str, name: str) -> bool:
    """Whether a section of a parameter file is for a node: * is a name, ** any number of them."""
    parts = [
        "(/[^/]+)*" if part == "**" else "/" + part.replace("*", "[^/]+")
        for part in section.strip("/").split("/")
    ]
    return re.fullmatch("".join(parts), name) is not None


def closest(name: str) -> str:
    """Which parameter was probably meant, to be put behind the name; empty if none is near."""
    if len(name) > _LONGEST_NAME:  # it takes long to compare, and none is like it
        return ""
    near = difflib.get_close_matches(name, _NAMES, n=1)
    return f": did you mean {near[0]}?" if near else ""


def _separated(arguments: list[str]) -> tuple[list[str], list[str]]:
    """Our own arguments, and those of ROS: from --ros-args to -- or the end."""
    own: list[str] = []
    of_ros: list[str] = []
    inside = False
    for argument in arguments:
        if argument == "--ros-args":
            inside = True
        elif inside and argument == "--":
            inside = False
        else:
            (of_ros if inside else own).append(argument)
    return own, of_ros


def _given_parameters(of_ros: list[str]) -> list[str]:
    """Names of the parameters that are given one by one to every node, or to ours by its name."""
    names = []
    for option, value in itertools.pairwise(of_ros):
        if option in ("-p", "--param") and ":=" in value:
            node, separator, name = value.partition(":=")[0].rpartition(":")
            if not separator or node.strip("/") == "cpr_node":
                names.append(name)
    return names


def _meant(argument: str, following: str) -> tuple[str, bool]:
    """What was probably meant for ROS, and whether the following argument is part of it."""
    if argument in _ROS_OPTIONS:
        return f"{argument} {following}".strip(), bool(following)
    word = argument.lstrip("-")
    name, assigned, value = word.partition(":=")
    if not assigned:
        name, assigned, value = word.partition("=")
    skipped = False
    if not assigned and argument.startswith("-"):
        value, skipped = following, bool(following) and not following.startswith("-")
    elif not assigned:
        name, value = "robot", word  # a name or a file alone
    near = difflib.get_close_matches(name, _NAMES, n=1)
    if near and value:
        return f"-p {near[0]}:={value}", skipped
    if ":=" in argument:
        return f"-r {argument}", False
    return "", False

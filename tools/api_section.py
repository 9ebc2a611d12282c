#!/usr/bin/env python3
# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Writes the public functions and values into docs/api.md from their docstrings; `--check`: current?"""

from __future__ import annotations

import enum
import inspect
import re
import sys
from typing import Any

from marked_section import ROOT, keep_current, row

sys.path.insert(0, str(ROOT))
import cpr_core
import cpr_core.workspace
from cpr_core.validation import cached_property


def section() -> str:
    """Public names: functions with arguments, values with attributes, errors with what they carry."""
    functions, values, errors = [], [], []
    for package in (cpr_core, cpr_core.workspace):
        for name in package.__all__:
            member = getattr(package, name)
            shown = f"{package.__name__.removeprefix('cpr_core.')}.{name}"
            shown = name if package is cpr_core else shown
            if inspect.isfunction(member):
                functions.append((shown, member))
            elif inspect.isclass(member) and issubclass(member, (Exception, Warning)):
                errors.append((shown, member))
            elif inspect.isclass(member):
                values.append((shown, member))
    lines = ["### Functions", ""]
    for name, function in functions:
        shown = f"{name}{_arguments(function)}{_result(function)}"
        lines += [f"**`{shown}`**  ", _first(function), ""]
        lines += _arguments_table(function)
    lines += ["### Values", ""]
    for name, kind in values:
        lines += [f"**`{name}`**  ", _first(kind), ""]
        lines += _members(kind) if issubclass(kind, enum.Enum) else _attributes(kind)
    lines += ["### Errors and warnings", ""]
    return "\n".join([*lines, *_errors_table(errors), "", *_data_table(errors)])


def _errors_table(errors: list[tuple[str, Any]]) -> list[str]:
    lines = [row("name", "kind of", "code", "meaning"), "|---|---|---|---|"]
    for name, error in errors:
        code = f"`{error.code}`" if hasattr(error, "code") else ""
        base = next(
            kind.__name__ for kind in error.__mro__[1:] if not kind.__name__.startswith("_")
        )
        lines.append(row(f"`{name}`", f"`{base}`", code, _first(error)))
    return lines


def _data_table(errors: list[tuple[str, Any]]) -> list[str]:
    """What errors carry, each where it is declared."""
    lines = ["What an error carries, every kind of it carries too:", ""]
    lines += [row("attribute", "meaning"), "|---|---|"]
    for name, error in errors:
        entries = _listed(error, "Attributes")
        lines += [row(f"`{name}.{attribute}`", meaning) for attribute, meaning in entries]
    return lines


def _arguments(function: Any) -> str:
    shown = []
    for name, argument in inspect.signature(function).parameters.items():
        if name in ("self", "cls"):
            continue
        if argument.kind is inspect.Parameter.KEYWORD_ONLY and "*" not in shown:
            shown.append("*")
        default = "" if argument.default is inspect.Parameter.empty else f"={argument.default!r}"
        shown.append(f"{name}{default}")
    return f"({', '.join(shown)})"


def _result(function: Any) -> str:
    """What kind of thing comes back."""
    kind = str(inspect.signature(function).return_annotation)
    kind = re.sub(r"\bFloats\b|\bIntegers\b|\bFlags\b|\w*Array\[[^\[\]]*\]", "array", kind)
    return f" -> {kind}"


def _returned(function: Any) -> str:
    """What comes back, in words, where there is more to say than its kind."""
    found = re.search(r"^Returns:\n((?:[ ]{4}.*\n?|\n)+)", _text(function), re.MULTILINE)
    return " ".join(found[1].split()) if found else ""


def _first(member: Any) -> str:
    """First paragraph of a docstring."""
    return " ".join(_text(member).split("\n\n")[0].split())


def _text(member: Any) -> str:
    """A docstring, names in it as pages have them: code, and with parentheses what is called."""
    text = re.sub(r":(?:func|meth):`([^`]+)`", r"``\1()``", inspect.getdoc(member) or "")
    return re.sub(r":\w+:`([^`]+)`", r"``\1``", text)


def _listed(member: Any, heading: str) -> list[tuple[str, str]]:
    """Entries under a heading of a docstring."""
    found = re.search(rf"^{heading}:\n((?:[ ]{{4}}.*\n?|\n)+)", _text(member), re.MULTILINE)
    entries: list[tuple[str, str]] = []
    for line in (found[1] if found else "").splitlines():
        begin = re.match(r"    (\w+(?:, \w+)*): (.*)", line)
        if begin:
            entries.append((begin[1], begin[2]))
        elif line.strip() and entries:
            entries[-1] = (entries[-1][0], f"{entries[-1][1]} {line.strip()}")
    return entries


def _arguments_table(function: Any) -> list[str]:
    entries = _listed(function, "Args")
    if returned := _returned(function):
        entries.append(("returns", returned))
    if raised := ", ".join(kinds for kinds, _ in _listed(function, "Raises")):
        names = dict.fromkeys(raised.split(", "))
        entries.append(("raises", ", ".join(f"`{name}`" for name in names)))
    if not entries:
        return []
    lines = [row("argument", "meaning"), "|---|---|"]
    return [*lines, *(row(_argument(name), meaning) for name, meaning in entries), ""]


def _argument(name: str) -> str:
    return name if name in ("returns", "raises") else f"`{name}`"


def _method(function: Any) -> str:
    """What a method does, with its arguments."""
    words = [_first(function)]
    words += [f"``{name}``: {meaning}" for name, meaning in _listed(function, "Args")]
    if returned := _returned(function):
        words.append(f"Returns: {returned}")
    return " ".join(words)


def _members(kind: type[enum.Enum]) -> list[str]:
    """Members of an enumeration, their numbers and what the comments behind them say."""
    said = dict(re.findall(r"^    (\w+) = .*?  # (.*)$", inspect.getsource(kind), re.MULTILINE))
    lines = [row("member", "value", "meaning"), "|---|---|---|"]
    for member in kind:
        lines.append(row(f"`{member.name}`", f"`{member.value}`", said.get(member.name, "")))
    return [*lines, ""]


def _attributes(kind: type) -> list[str]:
    """Attributes, properties and methods of a value and of what it is a kind of, in their order."""
    entries = dict(_listed(kind, "Attributes"))
    own = [base for base in reversed(kind.__mro__) if base.__module__.startswith("cpr_core")]
    members = {name: member for base in own for name, member in vars(base).items()}
    for name, member in members.items():
        if name.startswith("_") or name in entries:
            continue
        if isinstance(member, property):
            entries[name] = _first(member.fget)
        elif isinstance(member, cached_property):
            entries[name] = _first(member.func)
        elif inspect.isfunction(member) or isinstance(member, (classmethod, staticmethod)):
            function = member if inspect.isfunction(member) else member.__func__
            entries[f"{name}{_arguments(function)}{_result(function)}"] = _method(function)
    if not entries:
        return []
    lines = [row("attribute", "meaning"), "|---|---|"]
    return [*lines, *(row(f"`{name}`", meaning) for name, meaning in entries.items()), ""]


if __name__ == "__main__":
    sys.exit(keep_current("api_section.py", "docs/api.md", "api", section))

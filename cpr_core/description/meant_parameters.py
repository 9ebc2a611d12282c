# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a path that leads nowhere was meant to name: nothing of another leg or motor.

Names of legs and motors count from one, paths count from zero: as words ``motor1.offset`` is nearest to
the zero of another motor. So names are translated, and words are compared only with numbers of the part
that is named and with those of no leg.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ..errors import UnknownParameter
from .written_fields import WrittenFields

__all__ = ["unknown_parameter"]

_INDEX = re.compile(r"\[(?:\d+|\*)\]")
_LEG = re.compile(r"legs\[\d+\]")
#: How a path begins that means one leg or motor, be there one of that number or not.
_NUMBERED = re.compile(r"(legs\[|leg|motor)\d")
#: Words that are less alike than this are not taken for each other.
_ALIKE = 0.5


@dataclass(frozen=True)
class _Part:
    """A leg, a motor or an element of a chain.

    Attributes:
        path: Where it is.
        axis: Of one axis of a universal joint: which entries of its fields are its own.
    """

    path: str
    axis: str = ""

    def has(self, path: str) -> bool:
        """Whether a path leads to something of it."""
        return path.startswith(f"{self.path}.") and path.endswith(self.axis)


def unknown_parameter(
    written: WrittenFields, path: str, changeable: Sequence[str]
) -> UnknownParameter:
    """The error of a path that leads nowhere.

    Args:
        written: The fields.
        path: The path.
        changeable: Paths of all numbers that can be changed.
    """
    shared = [name for name in changeable if not _LEG.match(name)]
    in_legs = [name for name in changeable if _LEG.match(name)]
    parts_of = _parts_by_name(written)
    said, parts, rest = _named(parts_of, path)
    known = ""
    if said:
        texts = [f"{part.path}{rest}{part.axis}" for part in parts]
        nearest = _together([text for text in texts if text in in_legs])
        if not nearest and rest and len(parts) == 1:
            begin = f"{parts[0].path}."
            own = [name.removeprefix(begin) for name in in_legs if parts[0].has(name)]
            near = _nearest(f"{rest}{parts[0].axis}".removeprefix("."), own, shared)
            nearest = f"{begin}{near}" if near in own else near
        known = _whereabouts(parts_of, said)
    elif _NUMBERED.match(path):
        nearest, known = _nearest(path, shared), _all_legs(written)
    else:
        of_all = dict.fromkeys(_LEG.sub("legs[*]", name, count=1) for name in in_legs)
        nearest = _nearest(path, [*shared, *of_all])
        within = f"{path.rpartition('.')[0]}."
        beside = [name for name in shared if name.startswith(within)]
        known = f"there are {', '.join(beside)}" if beside else ""
    return UnknownParameter(path, nearest, "" if nearest else known)


def _parts_by_name(written: WrittenFields) -> dict[str, list[_Part]]:
    """What has a name, by name and by path; a motor may move several elements."""
    found: dict[str, dict[_Part, None]] = {}
    counted: dict[str, dict[str, None]] = {"leg": {}, "motor": {}, "": {}}
    for kind, name, part in _named_parts(written):
        found.setdefault(name, {})[part] = None
        found.setdefault(part.path, {})[_Part(part.path)] = None
        counted[kind][name] = None
    for kind in ("leg", "motor"):  # one may count them, whatever they are called
        for number, name in enumerate(counted[kind], start=1):
            found.setdefault(f"{kind}{number}", found[name])
    return {name: list(parts) for name, parts in found.items()}


def _named_parts(written: WrittenFields) -> Iterator[tuple[str, str, _Part]]:
    """Legs, motors, and joints and rods of chains: kind, empty for the last two, name and part."""
    read = written.read
    for number, leg in enumerate(written.content["legs"]):
        path = f"legs[{number}]"
        leg_name = str(read[f"{path}.name"])
        yield "leg", leg_name, _Part(path)
        if f"{path}.motor.name" in read:
            yield "motor", str(read[f"{path}.motor.name"]), _Part(f"{path}.motor")
        rods = 0
        for place, element in enumerate(leg.get("chain", ())):
            part = _Part(f"{path}.chain[{place}]")
            rods += "rod" in element
            name = f"{leg_name}.rod{rods}" if "rod" in element else part.path
            name = str(read.get(f"{part.path}.name", name))
            yield "", name, part
            motors = element.get("motor")
            if isinstance(motors, str):
                yield "motor", motors, part
            for axis, motor in enumerate(motors if isinstance(motors, list) else ()):
                own = _Part(part.path, f"[{axis}]")
                yield "", f"{name}[{axis}]", own
                if motor is not None:
                    yield "motor", str(motor), own


def _named(parts_of: dict[str, list[_Part]], path: str) -> tuple[list[str], list[_Part], str]:
    """Names that a path begins with, of a leg and of what is in it; their parts; the rest of it.

    There are no parts where one name is not in the other.
    """
    said, parts, rest = list[str](), list[_Part](), f".{path}"
    while len(said) < 2:
        leading = [
            name
            for name in parts_of
            if rest.startswith(f".{name}") and rest[len(name) + 1 :][:1] in ("", ".", "[")
        ]
        if not leading:
            break
        said.append(max(leading, key=len))
        parts = [
            part
            for part in parts_of[said[-1]]
            if not parts or any(f"{part.path}.".startswith(f"{outer.path}.") for outer in parts)
        ]
        rest = rest[len(said[-1]) + 1 :]
    return said, parts, rest


def _together(paths: Sequence[str]) -> str:
    """One path for several that differ in the leg only; empty where they differ in more."""
    after = {_LEG.sub("", path, count=1) for path in paths}
    if len(after) != 1 or len(paths) == 1:
        return paths[0] if len(paths) == 1 else ""
    numbers = ",".join(path[len("legs[") : path.index("]")] for path in paths)
    return f"legs[{numbers}]{after.pop()}"


def _nearest(path: str, *groups: Sequence[str]) -> str:
    """The path that is most like another one: first of those with its last field, group by group.

    Empty where only what stands before that field is alike, or where it tells apart what the other one
    does not: entries are not guessed.
    """
    last = path.rpartition(".")[2]
    groups = tuple([name for name in group if _alike(name, last)] for group in groups)
    called_so = [[name for name in group if name.rpartition(".")[2] == last] for group in groups]
    for among in (*called_so, *groups):
        for near in difflib.get_close_matches(path, among, n=1, cutoff=_ALIKE):
            alike = [name for name in among if _INDEX.sub("[]", name) == _INDEX.sub("[]", near)]
            same = _INDEX.findall(near) == _INDEX.findall(path)
            return near if same or len(alike) == 1 else ""
    return ""


def _alike(path: str, last: str) -> bool:
    """Whether the last field of a path is like a word."""
    return difflib.SequenceMatcher(None, path.rpartition(".")[2], last).ratio() >= _ALIKE


def _whereabouts(parts_of: dict[str, list[_Part]], names: Sequence[str]) -> str:
    """Where the parts of these names are; nothing of names that are paths."""
    told = []
    for name in names:
        paths = list(dict.fromkeys(part.path for part in parts_of[name]))
        if paths != [name]:
            told.append(f"{name} is {' and '.join(paths)}")
    return ", ".join(told)


def _all_legs(written: WrittenFields) -> str:
    """Which legs there are."""
    names = [str(name) for _, name, part in _named_parts(written) if _LEG.fullmatch(part.path)]
    if len(names) == 1:
        return f"legs[0] is the only leg, {names[0]}"
    return f"legs[0] to legs[{len(names) - 1}] are {names[0]} to {names[-1]}"

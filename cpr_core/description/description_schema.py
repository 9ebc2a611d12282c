# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The JSON schema of descriptions: the general part as a file, the rest as the classes declare it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import reduce
from importlib import resources
from operator import getitem
from typing import Any

from ..description_part import Described, field
from ..rods.rod import MOST_MODES
from ..rods.sections import SECTIONS
from ..rods.strain_basis import STRAIN_BASES
from .chain import ChainRod, Link
from .chain_joints import CHAIN_JOINTS
from .controlled_coordinates import CONTROLLED_COORDINATES
from .joints import JOINTS
from .motors import LEAD, MOTORS, Drive, Motor

__all__ = ["DEFAULT_BASIS", "description_schema", "without_references"]

#: Basis of the strain modes where none is named.
DEFAULT_BASIS = "legendre"

_NAME = field("name", "joint name in messages; default motor and the number of the leg")
_MODES = {
    "torsion": field("modes", "modes; default 0"),
    "bending_2": field("modes", "modes about d2; default 5, in the plane 0"),
    "bending_3": field("modes", "modes about d3; default 5"),
    "tolerance": {
        "type": "number",
        "minimum": 1e-9,
        "description": "of the robot's `strain`, in place of numbers of modes: largest error of the "
        "platform position [m], for which they are chosen",
    },
}


def description_schema() -> dict[str, Any]:
    """The schema with all motors, tip joints, sections and strain bases that have a name now.

    ``description.schema.json`` is the same for those of the library, for editors.
    """
    file = resources.files(__package__).joinpath("description.schema.json")
    schema: dict[str, Any] = json.loads(file.read_text("utf-8"))
    schema["properties"]["controlled"]["items"]["enum"] = list(CONTROLLED_COORDINATES)
    schema["$defs"] |= {
        "motor": _choice(
            "type", {name: _motor_fields(kind) for name, kind in MOTORS.items()}, MOTORS
        ),
        "tip": _choice("type", {name: kind.fields for name, kind in JOINTS.items()}, JOINTS),
        "section": _choice(
            "shape", {name: kind.fields for name, kind in SECTIONS.items()}, SECTIONS
        ),
        "strain": _strain(),
        "modes": {"type": "integer", "minimum": 0, "maximum": MOST_MODES},
        "chain_element": _chain_element(),
    }
    return schema


def without_references(schema: dict[str, Any]) -> dict[str, Any]:
    """The same with what is referred to in place of references: checked in two thirds of the time."""

    def resolved(part: Any) -> Any:
        if isinstance(part, list):
            return [resolved(each) for each in part]
        if not isinstance(part, dict):
            return part
        own = {key: resolved(value) for key, value in part.items() if key not in ("$defs", "$ref")}
        if "$ref" not in part:
            return own
        meant = resolved(reduce(getitem, part["$ref"].removeprefix("#/").split("/"), schema))
        return meant | own  # what is said beside a reference says what the thing is, more closely

    found: dict[str, Any] = resolved(schema)
    return found


def _chain_element() -> dict[str, Any]:
    """A joint, a link or a rod: the field that names it says which others there are."""
    joint = _choice(
        "joint", {name: kind.fields for name, kind in CHAIN_JOINTS.items()}, CHAIN_JOINTS
    )
    kinds = {"joint": joint} | {
        name: {"additionalProperties": False, "properties": fields}
        for name, fields in (("link", Link.fields), ("rod", ChainRod.fields))
    }
    return {
        "type": "object",
        "oneOf": [{"required": [name]} for name in kinds],
        "allOf": [{"if": {"required": [name]}, "then": kind} for name, kind in kinds.items()],
    }


def _motor_fields(kind: type[Motor]) -> Mapping[str, Any]:
    if not kind.actuated:
        return kind.fields
    drive = {name: value for name, value in Drive.fields.items() if name != "motor"}
    lead = {"lead": LEAD} if kind.unit == "m" else {}
    return {**kind.fields, "name": _NAME, **drive, **lead}


def _choice(
    key: str, fields: Mapping[str, Mapping[str, Any]], kinds: Mapping[str, type[Described]]
) -> dict[str, Any]:
    """Fields of which one, the key, says which others there are."""
    return {
        "type": "object",
        "required": [key],
        "properties": {key: {"enum": list(kinds)}},
        "allOf": [
            {
                "if": {"properties": {key: {"const": name}}, "required": [key]},
                "then": {
                    "properties": {key: True, **fields[name]},
                    "required": list(kind.required),
                    "additionalProperties": False,
                },
            }
            for name, kind in kinds.items()
        ],
    }


def _strain() -> dict[str, Any]:
    """Numbers of modes, and what a basis has beside them."""
    own = {name: kind.fields for name, kind in STRAIN_BASES.items()}
    every = {name: meaning for fields in own.values() for name, meaning in fields.items()}
    return {
        "type": "object",
        "additionalProperties": False,
        "properties": {
            "basis": {"enum": list(STRAIN_BASES), "description": f"default {DEFAULT_BASIS}"},
            **_MODES,
            **every,
        },
        "allOf": [
            {
                # A basis that is not named fits every `const`: only the default one may do so.
                "if": {
                    "properties": {"basis": {"const": name}},
                    "required": [] if name == DEFAULT_BASIS else ["basis"],
                },
                "then": {
                    "required": list(kind.required),
                    "properties": {
                        foreign: {"not": {}, "description": f"{name} has no such field"}
                        for foreign in every
                        if foreign not in kind.fields
                    },
                },
            }
            for name, kind in STRAIN_BASES.items()
        ],
    }

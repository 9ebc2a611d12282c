# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Values of stored maps as JSON, and whether what was stored is what there is now."""

from __future__ import annotations

import json
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any

import numpy as np

from ..description.motors import Drive
from ..model.robot import Robot, kept_with_robot

__all__ = ["as_json", "is_robot", "is_same", "plain_values", "robot_as_json"]

#: Of a description: where it came from, and what measures the robot. A map does not depend on them.
_BESIDE = ("source", "written", "tracker")
#: Beside the fields of the description: motors that the robot holds, if it holds any.
_HELD = "held_motors"
#: What maps of older versions called the fields of a ``Drive``, which they had beside those of what it
#: moves: of a leg, and of elements of a chain.
_OF_LEGS = {"motor_name": "motor", "offset": "zero", "limits": "limits"}
_OF_ELEMENTS = {name: name for name in ("motor", "ratio", "zero", "limits", "screw")}


def as_json(value: Any) -> str:
    """A dataclass with all that is in it; numbers are written to the last digit."""
    return json.dumps(plain_values(value))


@kept_with_robot
def robot_as_json(robot: Robot) -> str:
    """A robot as text, the same wherever its description came from."""
    described = plain_values(robot.description)
    content = {name: part for name, part in described.items() if name not in _BESIDE}
    return json.dumps(content | ({_HELD: robot.held_motors} if robot.held_motors else {}))


def is_robot(robot: Robot, stored: str) -> bool:
    """Whether a robot is the one that was stored."""
    content = json.loads(stored, object_hook=_with_drive)
    held = tuple(content.pop(_HELD, ()))
    return held == robot.held_motors and _same_fields(robot.description, content, _BESIDE)


def is_same(value: Any, stored: str) -> bool:
    """Whether a dataclass has in it what was stored."""
    return _same(value, json.loads(stored))


def _with_drive(stored: dict[str, Any]) -> dict[str, Any]:
    """What was stored, as it is now, of a leg or of an element of a chain that something may move."""
    kind, names = stored.get("type"), _OF_LEGS if "motor_name" in stored else _OF_ELEMENTS
    if kind in (None, Drive.__name__) or not {"motor_name", "zero"} & stored.keys():
        return stored
    drive = {new: stored.pop(old) for old, new in names.items() if old in stored}
    if drive.get("motor") is None:  # a passive base, or a rod of fixed length: limits of no motor
        drive.pop("limits", None)
    return stored | {"drive": {"type": Drive.__name__, **drive}}


def plain_values(value: Any) -> Any:
    """What JSON and YAML have of a value: dataclasses by their fields, arrays as lists."""
    if is_dataclass(value):
        parts = {field.name: plain_values(getattr(value, field.name)) for field in fields(value)}
        return {"type": type(value).__name__, **parts}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, dict):
        return {str(name): plain_values(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain_values(part) for part in value]
    return value


def _same(value: Any, stored: Any) -> bool:
    """As numbers: a zero with another sign is the same."""
    if is_dataclass(value):
        return _same_fields(value, stored)
    if isinstance(value, list | tuple) and isinstance(stored, list):
        return len(value) == len(stored) and all(map(_same, value, stored))
    if isinstance(value, dict) and isinstance(stored, dict):
        named = {str(name): part for name, part in value.items()}
        return named.keys() == stored.keys() and all(
            _same(part, stored[name]) for name, part in named.items()
        )
    return bool(plain_values(value) == stored)


def _same_fields(value: Any, stored: Any, beside: tuple[str, ...] = ()) -> bool:
    """What was not stored, as that version did not know it yet, has its default."""
    if not isinstance(stored, dict) or stored.get("type") != type(value).__name__:
        return False
    known = {field.name: field for field in fields(value) if field.name not in beside}
    if set(stored) - set(known) - {"type", *beside}:
        return False
    return all(
        _same(getattr(value, name), stored[name])
        if name in stored
        else _has_default(field, getattr(value, name))
        for name, field in known.items()
    )


def _has_default(field: Field[Any], value: Any) -> bool:
    if field.default_factory is not MISSING:
        return bool(plain_values(value) == plain_values(field.default_factory()))
    return field.default is not MISSING and bool(plain_values(value) == plain_values(field.default))

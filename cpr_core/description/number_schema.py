# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether the schema allows another number at a place, without going through all of a description.

What kept to the schema keeps to it with another number, if the parts of the schema that are about this
number allow it. Where that cannot be told from those the answer is no, and the whole has to be checked.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .description_paths import Key, Place

__all__ = ["surely_allowed"]

#: Keywords of the schema that say nothing of how large numbers below them are.
_STRUCTURE = {
    "$schema",
    "title",
    "description",
    "default",
    "type",
    "required",
    "enum",
    "const",
    "minItems",
    "maxItems",
    "then",
    "else",
}


def surely_allowed(validator: Any, content: Any, place: Place, value: float) -> bool:
    """Whether a number may be at a place, for all that can be told from the place alone.

    Args:
        validator: Validator of the whole schema.
        content: What kept to it before the number was there.
        place: Keys that lead to the number.
        value: The number.
    """
    schemas, instance = [validator.schema], content
    for key in place:
        below: list[Any] = []
        if not all(_descend(schema, instance, key, below) for schema in schemas):
            return False
        schemas, instance = below, instance[key]
    return bool(schemas) and all(
        validator.evolve(schema=schema).is_valid(value) for schema in schemas
    )


def _descend(schema: Any, instance: Any, key: Key, below: list[Any]) -> bool:
    """Add what a schema says of an entry; whether that is all it has to do with it."""
    if isinstance(schema, bool):
        return schema
    for keyword, part in schema.items():
        parts: list[Any] = []
        if keyword == "allOf":
            parts = part
        elif keyword == "if":
            holds = _holds(part, instance)
            if holds is None:
                return False
            parts = [schema.get("then" if holds else "else", True)]
        elif keyword == "properties":
            below += [part[key]] if key in part else []
        elif keyword == "additionalProperties":
            below += [] if key in schema.get("properties", ()) else [part]
        elif keyword == "items":
            below.append(part)
        elif keyword in ("anyOf", "oneOf"):
            if any(set(choice) != {"required"} for choice in part):
                # Where only one choice is a list, or has fields, as the instance does, it has to hold.
                parts = [choice for choice in part if _may_hold(choice, instance)]
                if len(parts) != 1:
                    return False
        elif keyword not in _STRUCTURE:
            return False
        if not all(_descend(other, instance, key, below) for other in parts):
            return False
    return True


def _may_hold(schema: Any, instance: Any) -> bool:
    """Whether a schema may be that of a list, or of something with fields, to go by its type."""
    kind = schema.get("type") if isinstance(schema, Mapping) else None
    own = "array" if isinstance(instance, list) else "object"
    return kind is None or own == kind or own in kind


def _holds(condition: Any, instance: Any) -> bool | None:
    """Whether a condition on names in a mapping holds; None where it is about something else."""
    fields = condition.get("properties", {})
    plain = all(set(field) == {"const"} for field in fields.values())
    known = set(condition) <= {"properties", "required"} and isinstance(instance, Mapping)
    if not plain or not known or any(isinstance(instance.get(name), float) for name in fields):
        return None
    return all(name in instance for name in condition.get("required", ())) and all(
        instance[name] == field["const"] for name, field in fields.items() if name in instance
    )

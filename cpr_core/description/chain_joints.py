# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Joints of chains by their names in descriptions: of one coordinate, or several of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

from ..description_part import Part, triple
from .chain import ChainJoint, DescribedJoint, Shift, Turn
from .motors import Drive

__all__ = ["CHAIN_JOINTS", "UniversalInChain"]


#: Fields of turns that a motor moves, and of passive ones.
_OF_MOTORS = tuple(name for name in Drive.fields if name != "motor")
_OF_SPRINGS = ("stiffness", "rest")


def _pair(items: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items, "minItems": 2, "maxItems": 2}


def _of_each_axis(schema: Mapping[str, Any]) -> dict[str, Any]:
    """What a joint has, once for both axes or a pair, in which an axis may have none."""
    kind = {name: value for name, value in schema.items() if name != "description"}
    # Both are turns.
    meaning = schema["description"].replace(" or m]", "]").replace(" or N/m]", "]")
    return {
        "anyOf": [kind, _pair({"anyOf": [kind, {"type": "null"}]})],
        "description": f"{meaning}; a pair: of either axis, null where it has none; "
        "one value is for those axes that can have it",
    }


class UniversalInChain(DescribedJoint):
    """Two turns about crossing axes, the second one turned by the first."""

    fields: ClassVar[Mapping[str, Any]] = {
        "name": ChainJoint.fields["name"],
        "axes": _pair({"$ref": "#/$defs/axis"})
        | {"description": "both axes in the frame before it"},
        "motor": _pair({"type": ["string", "null"], "minLength": 1})
        | {
            "description": "the motors that turn it, null: passive about that axis; default passive"
        },
        **{name: _of_each_axis(ChainJoint.fields[name]) for name in (*_OF_MOTORS, *_OF_SPRINGS)},
    }
    required = ("axes",)

    @classmethod
    def elements(cls, part: Part, name: str) -> tuple[ChainJoint, ...]:
        """Two joints."""
        if part.planar:
            raise part.fail("joint", "universal joints need a spatial robot")
        axes = [part.direction_of(f"axes[{i}]", axis) for i, axis in enumerate(part.get("axes"))]
        if abs(axes[0] @ axes[1]) > 0.999:
            problem = f"expected two directions that are not parallel, got {part.get('axes')}"
            raise part.fail("axes", problem)
        single = [part.path_of(name) for name in (*_OF_MOTORS, *_OF_SPRINGS)]
        turns = []
        for number, axis in enumerate(axes):
            own = replace(part, content=_about_axis(part.content, number), read={})
            turns.append(Turn.on_axis(triple(axis), own, f"{name}[{number}]"))
            for path, value in own.read.items():
                part.read[path] = value
                if path in single:
                    part.read[f"{path}[{number}]"] = value
        return tuple(turns)


def _about_axis(content: Mapping[str, Any], number: int) -> dict[str, Any]:
    """What the fields of a universal joint say of one of its axes.

    One value for both is only for the axis that can have it where the other one cannot.
    """
    motors = content.get("motor") or (None, None)
    foreign: tuple[str, ...] = ()
    if (motors[0] is None) != (motors[1] is None):
        foreign = _OF_MOTORS if motors[number] is None else _OF_SPRINGS
    own = {
        name: value[number] if isinstance(value, list) else value
        for name, value in content.items()
        if isinstance(value, list) or name not in foreign
    }
    return {name: value for name, value in own.items() if value is not None}


#: Joints of chains by the name used in descriptions.
CHAIN_JOINTS: dict[str, type[DescribedJoint]] = {
    "revolute": Turn,
    "prismatic": Shift,
    "universal": UniversalInChain,
}

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Descriptions of the same robot turned in the world, or with its platform's frame drawn turned."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np

from cpr_core.lie import quaternion_from_rotation, rotation_from_quaternion

__all__ = ["turned_in_world", "with_turned_platform"]

Content = dict[str, Any]


def turned_in_world(content: Content, turn: np.ndarray) -> Content:
    """All that is written in the world turned by a rotation about its origin, (3, 3)."""
    turned = deepcopy(content)
    for leg in turned["legs"]:
        _turn(leg["base"], ("position", "tangent", "normal"), turn)
        _turn(leg.get("motor", {}), ("axis",), turn)
    turned["gravity"] = _turned(turned.get("gravity", [0, 0, 0]), turn)
    loads, home = turned.get("loads", {}), turned["home"]
    _turn(loads, ("rod_force", "platform_force"), turn)
    for load in (*loads.get("points", ()), *loads.get("distributed", ())):
        _turn(load, ("force",), turn)
    _turn(home.get("platform", {}), ("position",), turn)
    if (quaternion := home.get("platform", {}).get("quaternion_wxyz")) is not None:
        rotation = turn @ rotation_from_quaternion(quaternion)
        home["platform"]["quaternion_wxyz"] = quaternion_from_rotation(rotation).tolist()
    if isinstance(home.get("bow"), list) and not isinstance(home["bow"][0], str):
        _turn(home, ("bow",), turn)
    return turned


def with_turned_platform(content: Content, turn: np.ndarray) -> Content:
    """What is written in the platform, as it is in axes that are turned against those of before."""
    turned = deepcopy(content)
    for leg in turned["legs"]:
        _turn(leg["tip"], ("position", "tangent", "normal", "axis"), turn)
    _turn(turned.get("platform", {}), ("center_of_mass",), turn)
    return turned


def _turn(part: Content, names: tuple[str, ...], turn: np.ndarray) -> None:
    for name in names:
        if name in part:
            part[name] = _turned(part[name], turn)


def _turned(vectors: Any, turn: np.ndarray) -> Any:
    return (np.array(vectors, float) @ turn.T).tolist()

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots whose legs are chains."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from cpr_core import load_robot
from cpr_core.description.chain import ChainRod, Turn
from cpr_core.description.description_file import shipped_robots

_DATA = Path(__file__).parents[1] / "data"

ROBOTS = {name: _DATA / f"{name}.yaml" for name in ("six_rus", "rfr_with_hubs")}

_NOWHERE = {"link": [0.0, 0.0, 0.0]}


def as_chains(name: str, links: bool) -> dict[str, Any]:
    """A shipped robot with its motors spelt as chains, and links of length zero about its rods."""
    described, content = (
        load_robot(name).description,
        yaml.safe_load(shipped_robots()[name].read_text()),
    )
    for leg, fields in zip(described.legs, content["legs"], strict=True):
        chain: list[dict[str, Any]] = []
        for element in leg.chain:
            moved = {} if element.motor is None else {"motor": element.motor}
            if isinstance(element, ChainRod):
                rod = {"rod": fields.pop("rod", {}), "strain": fields.pop("strain", {})} | moved
                chain += [_NOWHERE, rod, _NOWHERE] if links else [rod]
            else:
                joint = "revolute" if isinstance(element, Turn) else "prismatic"
                chain.append({"joint": joint, "axis": list(element.axis)} | moved)
        del fields["motor"]
        fields["chain"] = chain
        fields["base"]["tangent"] = leg.base_rotation[:, 0].tolist()
        if not described.planar:
            fields["base"]["normal"] = leg.base_rotation[:, 1].tolist()
    return content

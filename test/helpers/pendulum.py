# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots with a part that swings freely: what it stores costs no rod anything."""

from __future__ import annotations

from cpr_core import Robot, load_robot
from cpr_core.description.description_file import shipped_robots
from helpers.yaml_content import yaml_content

__all__ = ["pendulum", "with_hanging_links"]


def with_hanging_links(name: str, base: tuple[float, float], length: float) -> Robot:
    """A planar robot, three light links hung between its platform and a base: they hold nothing."""
    content = yaml_content(shipped_robots()[name].read_text())
    content["gravity"], content["rod"]["density"] = [0, -9.81, 0], 0
    for leg in content["legs"]:
        for element in leg.get("chain", ()):
            element.pop("mass", None)
    hinge, link = {"joint": "revolute", "axis": [0, 0, 1]}, {"link": [length, 0, 0], "mass": 1e-6}
    content["legs"].append(
        {
            "base": {"position": [*base, 0], "tangent": [0, -1, 0]},
            "chain": [hinge, link] * 3,
            "tip": {"type": "revolute", "position": [0, 0, 0]},
        }
    )
    return load_robot(content)


def pendulum() -> Robot:
    """Stable by its weight, without a margin: that counts by elastic stiffness."""
    down = [0, -1, 0]
    hinge = {"joint": "revolute", "axis": [0, 0, 1]}
    return load_robot(
        {
            "name": "pendulum",
            "space": "planar",
            "gravity": [0, -9.81, 0],
            "rod": {
                "length": 0.3,
                "section": {"shape": "circular", "radius": 0.001},
                "young_modulus": 210e9,
                "shear_modulus": 82e9,
            },
            "strain": {"bending_3": 4},
            "legs": [
                {
                    "base": {"position": [0, 0, 0], "tangent": down},
                    "chain": [
                        hinge | {"motor": "motor1"},
                        {"rod": {}},
                        hinge,
                        {"link": [0.1, 0, 0], "mass": 0.02},
                    ],
                    "tip": {"type": "fixed", "position": [0, 0, 0], "tangent": down},
                }
            ],
            "controlled": ["x"],
            "home": {"motors": [0.0], "platform": {"position": [0, -0.4, 0]}},
        }
    )

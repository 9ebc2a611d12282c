# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A platform that swings freely below a rod: what it stores costs no rod anything."""

from __future__ import annotations

from cpr_core import Robot, load_robot

__all__ = ["pendulum"]


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

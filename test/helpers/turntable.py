# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A straight rod that a motor turns about itself: the platform turns, all else stays."""

from __future__ import annotations

from cpr_core import Robot, load_robot

__all__ = ["turntable"]


def turntable() -> Robot:
    """One rod upright on its motor, clamped to the platform, without loads."""
    upright = [0, 0, 1]
    return load_robot(
        {
            "name": "turntable",
            "space": "spatial",
            "rod": {
                "length": 0.5,
                "section": {"shape": "circular", "radius": 0.001},
                "young_modulus": 210e9,
                "shear_modulus": 82e9,
            },
            "legs": [
                {
                    "base": {"position": [0, 0, 0], "tangent": upright, "normal": [1, 0, 0]},
                    "motor": {"type": "revolute", "axis": upright},
                    "tip": {
                        "type": "fixed",
                        "position": [0, 0, 0],
                        "tangent": upright,
                        "normal": [1, 0, 0],
                    },
                }
            ],
            "controlled": ["yaw"],
            "home": {
                "motors": [0.0],
                "platform": {"position": [0, 0, 0.5]},
                "strain": [{}],
            },
        }
    )

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The continuum Stewart-Gough robot of J. Till's examples, from the numbers in them.

github.com/JohnDTill/ContinuumRobotExamples, 01_Statics/02_CSG_Inverse_Kinematics: steel rods of 1 mm
radius that may turn about themselves in the base, in pairs on a circle of 0.087 m.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot, load_robot, solve_inverse

__all__ = ["inverse_lengths", "stewart_gough_of_till"]

RADIUS = 0.087
#: Angle between neighbours of different pairs [rad].
MAJOR = np.radians(100.0)
#: Ten degrees about y, scalar first.
TURN = (float(np.cos(np.radians(5.0))), 0.0, float(np.sin(np.radians(5.0))), 0.0)


def stewart_gough_of_till(modes: int = 12) -> Robot:
    """The robot, with so many strain modes per bending direction."""
    minor = np.radians(120.0) - MAJOR
    legs = []
    for number in range(6):
        whole, even = number + 1 - (number + 1) % 2, number - number % 2
        at_base = (-minor + whole * minor + even * MAJOR) / 2.0
        at_platform = (-MAJOR + whole * MAJOR + even * minor) / 2.0
        legs.append(
            {
                "base": {
                    "position": _on_circle(at_base),
                    "tangent": [0, 0, 1],
                    "normal": [1, 0, 0],
                },
                "motor": {"type": "extensible", "spin": True},
                "tip": {
                    "type": "fixed",
                    "position": _on_circle(at_platform),
                    "tangent": [0, 0, 1],
                    "normal": [1, 0, 0],
                },
            }
        )
    content: dict[str, Any] = {
        "name": "stewart_gough_of_till",
        "space": "spatial",
        "rod": {
            "length": 0.4,
            "section": {"shape": "circular", "radius": 0.001},
            "young_modulus": 200e9,
            "shear_modulus": 80e9,
            "density": 8000.0,
        },
        "strain": {"torsion": 2, "bending_2": modes, "bending_3": modes},
        "gravity": [0, 0, -9.81],
        "platform": {"mass": 0.1},
        "legs": legs,
        "controlled": ["x", "y", "z", "orientation"],
        "home": {"motors": [0.403] * 6, "platform": {"position": [0, 0, 0.4]}},
    }
    return load_robot(content)


def inverse_lengths() -> NDArray[np.float64]:
    """Lengths of the legs, (6,) [m], the platform at (0, 0, 0.4) m, turned by ten degrees about y."""
    return solve_inverse(stewart_gough_of_till(), [0.0, 0.0, 0.4, *TURN]).motors


def _on_circle(angle: float) -> list[float]:
    return [float(RADIUS * np.cos(angle)), float(RADIUS * np.sin(angle)), 0.0]

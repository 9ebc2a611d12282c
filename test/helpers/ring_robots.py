# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots of equal legs in a ring or a row, whose symmetry loads bring to the edge of breaking."""

import math

from cpr_core import Robot, load_robot

_MATERIAL = {"young_modulus": 2.1e11, "shear_modulus": 8.2e10, "density": 7800}
_SECTION = {"shape": "circular", "radius": 0.001}


def _ring(legs):
    """Cosine and sine of every leg's angle."""
    angles = [2.0 * math.pi * number / legs for number in range(legs)]
    return [(math.cos(angle), math.sin(angle)) for angle in angles]


def four_legs() -> Robot:
    """Four outward rods with ball joints: the platform is nearly free to turn about z."""
    legs = [
        {
            "base": {"position": [0.2 * c, 0.2 * s, 0.0], "tangent": [round(c), round(s), 0]},
            "motor": {"type": "revolute", "axis": [-round(s), round(c), 0]},
            "tip": {"type": "spherical", "position": [0.08 * c, 0.08 * s, 0.0]},
        }
        for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))
    ]
    return load_robot(
        {
            "name": "four_legs",
            "space": "spatial",
            "gravity": [0, 0, -9.81],
            "platform": {"mass": 0.05},
            "legs": legs,
            "rod": {"length": 0.7, "section": _SECTION, **_MATERIAL},
            "strain": {"torsion": 0, "bending_2": 6, "bending_3": 6},
            "controlled": ["x", "z", "roll", "pitch"],
            "home": {"motors": [5.3] * 4, "bow": "outward"},
        }
    )


def three_columns(wider: float = 0.0, mass: float = 0.8) -> Robot:
    """Three rods that lean inwards and collapse under their platform; one base a little farther out."""
    legs = [
        {
            "base": {
                "position": [0.2 * (1 + grown) * c, 0.2 * (1 + grown) * s, 0.0],
                "tangent": [-0.2 * c, -0.2 * s, 1.0],
                "normal": [-s, c, 0.0],
            },
            "motor": {"type": "revolute", "axis": [-s, c, 0.0]},
            "tip": {
                "type": "universal",
                "position": [0.1 * c, 0.1 * s, 0.0],
                "axis": [-s, c, 0.0],
                "axis_in_rod": [0, 0, 1],
            },
        }
        for (c, s), grown in zip(_ring(3), (0.0, wider, 0.0), strict=True)
    ]
    return load_robot(
        {
            "name": "three_columns",
            "space": "spatial",
            "gravity": [0, 0, -9.81],
            "platform": {"mass": mass},
            "legs": legs,
            "rod": {"length": 0.6, "section": _SECTION, **_MATERIAL},
            "strain": {"torsion": 2, "bending_2": 5, "bending_3": 5},
            "controlled": ["x", "y", "z"],
            "home": {"motors": [0.1] * 3, "bow": "outward"},
        }
    )


def two_columns(wider: float = 0.0) -> Robot:
    """Two upright rods clamped to a platform that is too heavy for them."""
    legs = [
        {
            "base": {"position": [0.15 * side * (1 + grown), 0, 0], "tangent": [0, 1, 0]},
            "motor": {"type": "revolute", "axis": [0, 0, side]},
            "tip": {"type": "fixed", "position": [0.1 * side, 0, 0], "tangent": [0, 1, 0]},
        }
        for side, grown in ((1, wider), (-1, 0.0))
    ]
    return load_robot(
        {
            "name": "two_columns",
            "space": "planar",
            "gravity": [0, -9.81, 0],
            "platform": {"mass": 2.0},
            "rod": {"length": 0.6, "section": _SECTION, **_MATERIAL},
            "strain": {"bending_3": 6},
            "legs": legs,
            "controlled": ["x", "y"],
            "home": {"motors": [0, 0], "bow": "outward"},
        }
    )


def three_swinging() -> Robot:
    """Three curved rods swung about upright axes; on the way up two inverse singular values vanish."""
    legs = [
        {
            "base": {
                "position": [0.12 * c, 0.12 * s, 0],
                "tangent": [c, s, 0],
                "normal": [0, 0, 1],
            },
            "chain": [
                {"joint": "revolute", "axis": [0, 0, 1], "motor": f"motor{number}"},
                {"link": [0.02, 0, 0], "mass": 0.02},
                {"rod": {}},
                {"link": [0.01, 0, 0], "mass": 0.003},
            ],
            "tip": {
                "type": "universal",
                "position": [0.05 * c, 0.05 * s, 0],
                "axis": [-s, c, 0],
                "axis_in_rod": [0, 1, 0],
            },
        }
        for number, (c, s) in enumerate(_ring(3), start=1)
    ]
    return load_robot(
        {
            "name": "three_swinging",
            "space": "spatial",
            "gravity": [0, 0, -9.81],
            "platform": {"mass": 0.2, "center_of_mass": [0, 0, 0.03]},
            "legs": legs,
            "rod": {
                "length": 0.35,
                "section": {"shape": "annular", "radius": 0.0015, "inner_radius": 0.0005},
                "young_modulus": 1.3e11,
                "shear_modulus": 5e9,
                "density": 1600,
                "rest_curvature": {"bending_3": [2.0]},
            },
            "strain": {"torsion": 3, "bending_2": 5, "bending_3": 5},
            "controlled": ["z", "roll", "pitch"],
            "home": {"motors": [1.0] * 3, "bow": "outward", "platform": {"position": [0, 0, 0.33]}},
        }
    )


def clamped_columns(section: dict) -> Robot:
    """Three straight columns clamped to the platform: only its turns about them twist them."""
    legs = [
        {
            "base": {
                "position": [0.2 * c, 0.2 * s, 0.0],
                "tangent": [0, 0, 1],
                "normal": [c, s, 0.0],
            },
            "motor": {"type": "revolute", "axis": [-s, c, 0.0]},
            "tip": {
                "type": "fixed",
                "position": [0.2 * c, 0.2 * s, 0.0],
                "tangent": [0, 0, 1],
                "normal": [c, s, 0.0],
            },
        }
        for c, s in _ring(3)
    ]
    return load_robot(
        {
            "name": "clamped_columns",
            "space": "spatial",
            "platform": {"mass": 0.0},
            "legs": legs,
            "rod": {"length": 0.8, "section": section, **_MATERIAL},
            "strain": {"torsion": 8, "bending_2": 8, "bending_3": 8},
            "controlled": ["z", "roll", "pitch"],
            "home": {"motors": [0.0] * 3, "platform": {"position": [0, 0, 0.8]}},
        }
    )


def hinged_tripod(tip: str) -> dict:
    """Three rods that lean inwards, two with ball joints, one with another; without loads or pose."""
    legs = [
        {
            "base": {
                "position": [0.2 * c, 0.2 * s, 0.0],
                "tangent": [-0.3 * c, -0.3 * s, 1.0],
                "normal": [-s, c, 0.0],
            },
            "motor": {"type": "revolute", "axis": [-s, c, 0.0]},
            "tip": {"type": "spherical", "position": [0.08 * c, 0.08 * s, 0.0]},
        }
        for c, s in _ring(3)
    ]
    across = legs[-1]["base"]["normal"]
    legs[-1]["tip"] |= {"type": tip, "axis": across, "axis_in_rod": [0, 1, 0]}
    return {
        "name": f"tripod with one {tip} tip",
        "space": "spatial",
        "legs": legs,
        "rod": {"length": 0.4, "section": {"shape": "circular", "radius": 0.0015}, **_MATERIAL},
        "strain": {"torsion": 3, "bending_2": 5, "bending_3": 5},
        "controlled": ["x", "y", "z"],
        "home": {"motors": [0, 0, 0], "bow": "outward"},
    }

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots of one rod of length 1 m, along x, on which the books have their numbers."""

from __future__ import annotations

from typing import Any, Literal

from cpr_core import Robot, load_robot

__all__ = ["End", "column", "spatial_cantilever"]

#: What holds an end of a column.
End = Literal["clamped", "hinged", "free"]

#: Strain modes a direction: tables have four to six digits.
MODES = 14


def column(base: End = "clamped", tip: End = "free", weight: float = 0.0) -> Robot:
    """A straight rod in the plane, E J = 1 N m^2.

    Args:
        base: What holds the base: clamped or hinged.
        tip: What holds the tip; unless it is free it slides along the rod.
        weight: Of the rod under a gravity of 1 m/s^2 against it [N].
    """
    chain: list[dict[str, Any]] = (
        [] if base == "clamped" else [{"joint": "revolute", "axis": [0, 0, 1]}]
    )
    legs: list[dict[str, Any]] = [
        {
            "base": {"position": [0, 0, 0], "tangent": [1, 0, 0]},
            "chain": [*chain, {"rod": {}}],
            "tip": _tip("revolute" if tip == "hinged" else "fixed"),
        }
    ]
    if tip != "free":
        guide = {
            "base": {"position": [1, 0, 0], "tangent": [1, 0, 0]},
            "chain": [{"joint": "prismatic", "axis": [1, 0, 0]}],
            "tip": _tip("fixed"),
        }
        legs.append(guide)
    return load_robot(
        _robot(True, legs, {"bending_3": 1.0, "bending_2": 1.0, "torsion": 1.0, "mass": weight})
        | {"gravity": [-1.0 if weight else 0.0, 0, 0], "strain": {"bending_3": MODES}}
    )


def spatial_cantilever(
    torsion: float, bending_2: float, bending_3: float, rest_bending: float = 0.0
) -> Robot:
    """A clamped rod in space, its tip free.

    Args:
        torsion: G J [N m^2].
        bending_2: E J about d2 [N m^2].
        bending_3: E J about d3 [N m^2].
        rest_bending: Curvature at rest about d3 [1/m].
    """
    leg = {
        "base": {"position": [0, 0, 0], "tangent": [1, 0, 0], "normal": [0, 1, 0]},
        "chain": [{"rod": {}}],
        "tip": _tip("fixed") | {"normal": [0, 1, 0]},
    }
    section = {"torsion": torsion, "bending_2": bending_2, "bending_3": bending_3, "mass": 0.0}
    content = _robot(False, [leg], section)
    if rest_bending:
        content["rod"] |= {"rest_curvature": {"bending_3": [rest_bending]}}
    return load_robot(
        content | {"strain": dict.fromkeys(("torsion", "bending_2", "bending_3"), MODES)}
    )


def _tip(kind: str) -> dict[str, Any]:
    tip: dict[str, Any] = {"type": kind, "position": [0, 0, 0]}
    return tip if kind == "revolute" else tip | {"tangent": [1, 0, 0]}


def _robot(planar: bool, legs: list[dict[str, Any]], section: dict[str, float]) -> dict[str, Any]:
    return {
        "name": "single_rod",
        "space": "planar" if planar else "spatial",
        "rod": {"length": 1.0, "section": {"shape": "given", **section}},
        "platform": {"mass": 0.0},
        "legs": legs,
        "controlled": [],
        "home": {"motors": [], "platform": {"position": [1.0, 0, 0]}},
    }

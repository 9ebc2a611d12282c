# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Drawings of robots with matplotlib; imported only by who draws."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..model.equilibrium import Equilibrium
from ..model.shape import leg_shapes

__all__ = ["draw_equilibrium", "set_equal_scale"]


def draw_equilibrium(
    axes: Any, equilibrium: Equilibrium, *, color: Any = "tab:blue", label: str | None = None
) -> None:
    """Draw legs, motors and platform.

    Args:
        axes: Matplotlib axes; three-dimensional for a spatial robot.
        equilibrium: What to draw.
        color: Colour of legs and platform.
        label: Entry of the legend.
    """
    robot = equilibrium.robot
    dimensions = 2 if robot.planar else 3
    for number, shape in enumerate(leg_shapes(equilibrium, 40)):
        axes.plot(
            *shape.position.T[:dimensions],
            color=color,
            linewidth=1.6,
            label=label if number == 0 else None,
        )
        axes.plot(*shape.position[:1].T[:dimensions], "o", color="black", markersize=4)
    tips = np.array([leg.joint.position for leg in robot.description.legs])
    corners = equilibrium.platform_position + tips @ equilibrium.platform_rotation.T
    if len(corners) > 2 and dimensions == 3:
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        order = np.argsort(np.arctan2(tips[:, 1], tips[:, 0]), kind="stable")
        axes.add_collection3d(
            Poly3DCollection([corners[order]], facecolor=color, edgecolor=color, alpha=0.35)
        )
    else:
        axes.plot(*corners.T[:dimensions], color=color, marker="o", markersize=4, linewidth=3.0)


def set_equal_scale(axes: Any) -> None:
    """The same scale along every axis, and labels in metres."""
    if not hasattr(axes, "get_zlim"):
        axes.set_aspect("equal", adjustable="datalim")
    else:
        limits = np.array([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()])
        axes.set_box_aspect(limits[:, 1] - limits[:, 0])
        axes.set_zlabel("z [m]")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Drawings of robots with matplotlib; imported only by who draws."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.equilibrium import Equilibrium
from ..model.shape import LegShape, leg_shapes
from .robot_lines import platform_outline

__all__ = ["draw_equilibrium", "set_equal_scale"]

Floats = NDArray[np.float64]


#: Links, and joints that no motor moves.
_RIGID, _PASSIVE = "0.35", "white"
#: What turns is round, what shifts or feeds is square.
_ROUND, _SQUARE = "o", "s"
#: d1, d2, d3.
_FRAME = ("#D62728", "#2CA02C", "#1F77B4")
#: Arrows of the length given, in the plane.
_FLAT_ARROW = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "width": 0.004}


def draw_equilibrium(
    axes: Any,
    equilibrium: Equilibrium,
    *,
    color: Any = "tab:blue",
    label: str | None = None,
    frame_size: float = 0.0,
) -> None:
    """Draw rods, links, joints (black: moved by motors) and platform.

    Args:
        axes: Matplotlib axes; three-dimensional for a spatial robot.
        equilibrium: What to draw.
        color: Colour of rods and platform.
        label: Entry of the legend.
        frame_size: Length of the axes d1, d2, d3 (red, green, blue) at every base [m]; 0: none.
    """
    robot = equilibrium.robot
    dimensions = 2 if robot.planar else 3
    for leg, shape in zip(robot.description.legs, leg_shapes(equilibrium, 40), strict=True):
        for piece in shape.rigid_pieces:
            axes.plot(*piece.T[:dimensions], color=_RIGID, linewidth=3.2, solid_capstyle="round")
        for rod in range(len(leg.rods)):
            points = shape.position[shape.rod == rod]
            axes.plot(*points.T[:dimensions], color=color, linewidth=1.6, label=label)
            label = None
        _draw_joints(axes, shape, dimensions)
        if frame_size:
            _draw_frame(axes, leg.base_position, leg.base_rotation, frame_size, dimensions)
    tips = np.array([leg.joint.position for leg in robot.description.legs])
    corners = equilibrium.platform_position + tips @ equilibrium.platform_rotation.T
    corners = corners[platform_outline(robot)]
    if len(corners) > 2 and dimensions == 3:
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        axes.add_collection3d(
            Poly3DCollection([corners], facecolor=color, edgecolor=color, alpha=0.35)
        )
    else:
        axes.plot(*corners.T[:dimensions], color=color, linewidth=3.0, zorder=1.5)


def _draw_joints(axes: Any, shape: LegShape, dimensions: int) -> None:
    """Marks of the base, where no joint is, and of all joints but clamped ones."""
    if not np.array_equal(shape.joints[0].position, shape.position[0]):
        axes.plot(*shape.position[:1].T[:dimensions], "+", color=_RIGID, markersize=6)
    for joint in shape.joints:
        if joint.kind == "fixed":
            continue
        axes.plot(
            *joint.position[:dimensions, None],
            marker=_SQUARE if joint.kind in ("prismatic", "feed") else _ROUND,
            color="black",
            markerfacecolor=_PASSIVE if joint.motor is None else "black",
            markersize=4,
            linestyle="none",
            zorder=3,
        )


def _draw_frame(
    axes: Any, position: Floats, rotation: Floats, size: float, dimensions: int
) -> None:
    """Arrows along d1, d2, d3, in the plane without d3."""
    for axis, color in zip(rotation.T[:dimensions], _FRAME, strict=False):
        axes.quiver(
            *position[:dimensions],
            *(size * axis[:dimensions]),
            color=color,
            linewidth=0.9,
            **(_FLAT_ARROW if dimensions == 2 else {"arrow_length_ratio": 0.3}),
        )
    if dimensions == 2:  # arrows are not among what the plane is scaled to
        axes.update_datalim((position + size * rotation.T)[:, :2])
        axes.autoscale_view()


def set_equal_scale(axes: Any) -> None:
    """The same scale along every axis, and labels in metres."""
    if not hasattr(axes, "get_zlim"):
        axes.set_aspect("equal", adjustable="datalim")
    else:
        limits = np.array([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()])
        axes.set_box_aspect(limits[:, 1] - limits[:, 0])
        axes.locator_params(nbins=4)  # more labels lie on each other
        axes.set_zlabel("z [m]")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")

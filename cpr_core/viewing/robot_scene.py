# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot in the scene of the page: every part is a node that is moved, never made again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..drawing.robot_lines import RobotLines, segments
from .sent import send_new

if TYPE_CHECKING:
    import viser

__all__ = ["LineNode", "RobotScene"]

Floats = NDArray[np.float64]

_DARK, _LIGHT, _GREY = (0.2, 0.2, 0.2), (0.85, 0.85, 0.85), (0.6, 0.6, 0.6)
#: What is farther away than this is not drawn: in lengths of the robot.
_FAR = 100.0


class LineNode:
    """Pieces of lines as one node of the scene; hidden where there are none."""

    def __init__(self, scene: viser.SceneApi, name: str, thickness: float) -> None:
        self._scene, self._name, self._thickness = scene, name, thickness
        self._handle: Any = None
        self._count = -1

    def show(self, pieces: Floats, colors: ArrayLike) -> None:
        """Draw pieces (N, 2, 3), all of one colour (3,), or with one at every end (N, 2, 3)."""
        if not len(pieces):
            if self._handle is not None:
                send_new(self._handle, visible=False)
            return
        shades = (255.0 * np.clip(colors, 0.0, 1.0)).astype(np.uint8)
        if self._handle is None or len(pieces) != self._count:
            self._handle = self._scene.add_line_segments(
                self._name, pieces, shades, thickness=self._thickness
            )
            self._count = len(pieces)
            return
        self._handle.points = pieces.astype(np.float32)
        if not np.array_equal(shades, self._handle.colors):
            self._handle.colors = shades
        send_new(self._handle, visible=True)


class RobotScene:
    """Legs, links, joints and platform of one robot below a name."""

    def __init__(self, scene: viser.SceneApi, name: str, size: float) -> None:
        """Nothing is shown yet.

        Args:
            scene: Of the page.
            name: Name of the nodes, such as ``/robot``.
            size: Length that lines are thick in proportion to [m].
        """
        self._scene, self._name, self._size = scene, name, size
        self._legs = LineNode(scene, f"{name}/legs", 0.008 * size)
        self._links = LineNode(scene, f"{name}/links", 0.016 * size)
        self._edge = LineNode(scene, f"{name}/edge", 0.012 * size)
        self._joints: Any = None

    def show(self, lines: RobotLines, color: ArrayLike | None = None) -> None:
        """Draw a robot.

        Args:
            lines: Its lines.
            color: Of the legs, red green blue in [0, 1]; None: by bending.
        """
        tones: Any = color if color is not None else _GREY
        if color is None and lines.shades:
            tones = segments(*lines.shades)
        self._legs.show(segments(*lines.rods), tones)
        self._links.show(lines.links, _DARK)
        self._edge.show(segments(lines.platform), _DARK)
        self._show_joints(lines)

    def show_ghost(self, lines: RobotLines | None) -> None:
        """Draw what was asked for in vain, in grey; None: nothing."""
        nothing = np.zeros((0, 2, 3))
        if lines is None or not _drawable(lines, _FAR * self._size):
            for node in (self._legs, self._links, self._edge):
                node.show(nothing, _GREY)
            return
        self._legs.show(segments(*lines.rods), _GREY)
        self._links.show(lines.links, _GREY)
        self._edge.show(segments(lines.platform), _GREY)

    def _show_joints(self, lines: RobotLines) -> None:
        if not len(lines.joints):
            return
        if self._joints is None or len(self._joints.points) != len(lines.joints):
            tones = np.where(lines.driven[:, None], _DARK, _LIGHT)
            self._joints = self._scene.add_point_cloud(
                f"{self._name}/joints",
                lines.joints,
                (255.0 * tones).astype(np.uint8),
                point_size=0.014 * self._size,
                point_shape="circle",
                precision="float32",
            )
        else:
            self._joints.points = lines.joints.astype(np.float32)


def _drawable(lines: RobotLines, far: float) -> bool:
    """Whether lines are near enough to be drawn in single precision."""
    parts = [*lines.rods, lines.links.reshape(-1, 3), lines.platform]
    whole = np.concatenate(parts)
    return bool(np.all(np.abs(whole) < far))

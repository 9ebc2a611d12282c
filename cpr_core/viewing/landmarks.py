# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What of a robot is made once: frames with names, the platform in its own frame, the camera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..drawing.robot_lines import platform_outline
from ..lie import quaternion_from_rotation
from ..model.robot import Robot
from .sent import put

if TYPE_CHECKING:
    import viser

__all__ = ["Landmarks", "PlatformNode", "aim_camera", "light"]

Floats = NDArray[np.float64]

_NOWHERE, _AS_IT_IS = np.zeros(3), np.eye(3)


def _add_frame(
    scene: viser.SceneApi,
    name: str,
    size: float,
    position: Floats = _NOWHERE,
    rotation: Floats = _AS_IT_IS,
    *,
    small: bool = False,
) -> Any:
    """A frame of a robot with rods of a size [m]; where it is and how it is turned in the one above."""
    length, radius = (0.06, 0.003) if small else (0.12, 0.004)
    return scene.add_frame(
        name,
        axes_length=length * size,
        axes_radius=radius * size,
        position=position,
        wxyz=quaternion_from_rotation(rotation),
    )


class Landmarks:
    """Frames of base, legs and tracker with their names."""

    def __init__(self, scene: viser.SceneApi, robot: Robot) -> None:
        size = robot.mean_length
        scene.world_axes.visible = False
        self._labels = []
        _add_frame(scene, "/base", size)
        self._labels.append(scene.add_label("/base/name", "base"))
        names: dict[tuple[float, ...], list[str]] = {}  # legs may share a base
        for leg in robot.description.legs:
            name = f"/base/{leg.name}"
            _add_frame(scene, name, size, leg.base_position, leg.base_rotation, small=True)
            place = tuple(np.round(leg.base_position, 6).tolist())
            names.setdefault(place, []).append(leg.name)
        for number, (place, legs) in enumerate(names.items()):
            label = scene.add_label(
                f"/base/names/{number}", ", ".join(legs), position=np.array(place)
            )
            self._labels.append(label)
        if (tracker := robot.description.tracker) is not None:
            _add_frame(scene, "/tracker", size, tracker.position, tracker.rotation)
            self._labels.append(scene.add_label("/tracker/name", "tracker"))

    def show_names(self, shown: bool) -> None:
        """Show or hide the names."""
        for label in self._labels:
            label.visible = shown


class PlatformNode:
    """The platform: its frame is moved, and what is on it goes with it, as the marker of a tracker."""

    def __init__(self, scene: viser.SceneApi, robot: Robot) -> None:
        size = robot.mean_length
        self._frame = _add_frame(scene, "/platform", size)
        self._label = scene.add_label("/platform/name", "platform")
        if (tracker := robot.description.tracker) is not None:
            place = tracker.marker_position, tracker.marker_rotation
            _add_frame(scene, "/platform/marker", size, *place, small=True)
        holds = np.array([leg.joint.position for leg in robot.description.legs])
        corners = holds[platform_outline(robot)]
        if len(corners) > 3 and np.linalg.matrix_rank(np.diff(corners, axis=0), tol=1e-9) > 1:
            fan = [(0, k, k + 1) for k in range(1, len(corners) - 2)]
            scene.add_mesh_simple(
                "/platform/plate",
                corners[:-1],
                np.array(fan),
                color=(0, 114, 178),
                opacity=0.45,
                side="double",
            )

    def show(self, position: Floats, quaternion: Floats) -> None:
        """Move it, within ``server.atomic()``: (3,) [m], w x y z."""
        put(self._frame, position, quaternion)

    def show_names(self, shown: bool) -> None:
        """Show or hide its name."""
        self._label.visible = shown


def aim_camera(server: viser.ViserServer, robot: Robot, points: Floats) -> None:
    """Look at a whole robot: from the front and a little above, a planar one from above its plane.

    Args:
        server: Of the page.
        robot: The robot.
        points: On its legs, (P, 3) [m].
    """
    low, high = points.min(axis=0), points.max(axis=0)
    up = np.array([0.0, 1.0, 0.0] if robot.planar else [0.0, 0.0, 1.0])
    high = high + 0.3 * robot.mean_length * up  # where the force is
    center, size = 0.5 * (low + high), max(float(np.linalg.norm(high - low)), robot.mean_length)
    way = np.array([0.0, 0.0, 1.1] if robot.planar else [0.55, -0.85, 0.35])
    right = np.cross(up, way) / np.linalg.norm(np.cross(up, way))
    center = center + 0.2 * size * right  # there is the panel
    server.scene.set_up_direction("+y" if robot.planar else "+z")
    server.initial_camera.position = center + size * way
    server.initial_camera.look_at = center
    server.initial_camera.up = up
    for client in server.get_clients().values():  # those who are there already
        client.camera.up_direction = up
        client.camera.position, client.camera.look_at = center + size * way, center


def light(server: viser.ViserServer) -> None:
    """Light the scene by lamps only: lines neither mirror surroundings nor cast shadows.

    Both take seconds of a processor where it does the work of a graphics card.

    Args:
        server: Of the page.
    """
    server.scene.configure_environment_map(hdri=None)
    server.scene.configure_default_lights(cast_shadow=False)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is dragged in the scene: the platform, and the arrow of the force on it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..description.controlled_coordinates import CONTROLLED_COORDINATES
from ..kernels.twist_layout import LINEAR
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from .sent import put, send_new

if TYPE_CHECKING:
    import viser

__all__ = ["ForceArrow", "Grip", "PlatformHandle"]

Floats = NDArray[np.float64]
#: Called with position and quaternion while it is dragged, and with None when it is let go.
Dragged = Callable[[tuple[Floats, Floats] | None], None]

#: Length of the arrow of the natural unit of force, in rod lengths.
_PER_FORCE = 0.2
_ANCHOR = 0.35


class Grip:
    """Who holds a handle: one that is held is not put elsewhere. Any thread may ask and tell."""

    def __init__(self) -> None:
        """Nobody does."""
        self._lock = threading.Lock()
        self._hands: set[int] = set()
        self._offered = True

    @property
    def held(self) -> bool:
        """Whether anybody does."""
        return bool(self._hands)

    def hear(self, client: int, phase: str) -> bool:
        """A browser begins, goes on, or ends; the page's server ends for one that is gone.

        Args:
            client: Its number.
            phase: ``start``, ``update`` or ``end``.

        Returns:
            Whether that counts: what comes of a hidden handle was on its way when it was hidden.
        """
        with self._lock:
            if phase == "end":
                self._hands.discard(client)
            elif self._offered:
                self._hands.add(client)
            return self._offered

    def offer(self, offered: bool) -> None:
        """Nobody can hold what is hidden: a browser does not tell the end of that."""
        with self._lock:
            self._offered = offered
            if not offered:
                self._hands.clear()


class PlatformHandle:
    """Arrows and rings on the platform; those that no controlled coordinate follows are left out."""

    def __init__(self, scene: viser.SceneApi, robot: Robot, dragged: Dragged) -> None:
        controlled = robot.description.controlled
        turns = any(CONTROLLED_COORDINATES[name].turns for name in controlled)
        axes = tuple(turns or name in controlled for name in "xyz")
        self._grip, self._dragged = Grip(), dragged
        self._gizmo: Any = None
        if not controlled:
            return
        self._gizmo = scene.add_transform_controls(
            "/handle",
            scale=0.3 * robot.mean_length,
            active_axes=(True, True, False) if robot.planar else axes,  # type: ignore[arg-type]
            disable_rotations=not turns,
            depth_test=False,
        )

        async def moved(event: Any) -> None:
            if not self._grip.hear(event.client_id, event.phase):
                return
            place = np.array(event.target.position), np.array(event.target.wxyz)
            dragged(place if event.phase == "update" else None)

        self._gizmo.on_update(moved)

    def show(self, equilibrium: Equilibrium) -> None:
        """Put it where the platform is, unless somebody holds it."""
        if self._gizmo is not None and not self._grip.held:
            put(self._gizmo, equilibrium.platform_position, equilibrium.platform_quaternion)

    def show_handles(self, shown: bool) -> None:
        """Show or hide it."""
        if self._gizmo is None:
            return
        self._gizmo.visible = shown
        self._grip.offer(shown)
        if not shown:
            self._dragged(None)


class ForceArrow:
    """The force on the platform as an arrow beside it, with a handle at its tip."""

    def __init__(
        self, scene: viser.SceneApi, robot: Robot, dragged: Callable[[Floats | None], None]
    ) -> None:
        size = robot.mean_length
        force = robot.kernel_arrays.energy_unit / size
        self._unit = force / (_PER_FORCE * size)  # N a metre of arrow
        self._anchor = _ANCHOR * size * (np.eye(3)[1] if robot.planar else np.eye(3)[2])
        self._origin = np.zeros(3)
        self._grip, self._dragged = Grip(), dragged
        self._arrow = scene.add_arrows(
            "/force/arrow",
            np.zeros((1, 2, 3)),
            (213, 94, 0),
            shaft_radius=0.008 * size,
            head_radius=0.02 * size,
            head_length=0.05 * size,
        )
        self._tip: Any = scene.add_transform_controls(
            "/force/tip",
            scale=0.12 * size,
            active_axes=(True, True, not robot.planar),
            disable_rotations=True,
            depth_test=False,
        )
        self._label = scene.add_label("/force/name", "")

        async def moved(event: Any) -> None:
            if not self._grip.hear(event.client_id, event.phase):
                return
            if event.phase == "update":
                dragged(self._unit * (np.array(event.target.position) - self._origin))
            else:
                dragged(None)

        self._tip.on_update(moved)

    def show(self, equilibrium: Equilibrium) -> None:
        """Draw the force that acts, and put the handle at the tip unless somebody holds it."""
        force = equilibrium.loads.wrench_world[LINEAR]
        if not self._grip.held:
            self._origin = equilibrium.platform_position + self._anchor
        tip = self._origin + force / self._unit
        shown = bool(force.any())
        send_new(self._arrow, visible=shown)
        if shown:
            self._arrow.points = np.array([[self._origin, tip]], np.float32)
        send_new(self._label, text=f"force {np.linalg.norm(force):.3g} N")
        self._label.position = tip
        if not self._grip.held:
            put(self._tip, tip)

    def show_handles(self, shown: bool) -> None:
        """Show or hide the handle."""
        self._tip.visible = self._label.visible = shown
        self._grip.offer(shown)
        if not shown:
            self._dragged(None)

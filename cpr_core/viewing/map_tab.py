# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The tab of a map: a NetCDF map laid into the scene, a click goes to a cell."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import CprError
from ..workspace.stored_values import robot_as_json
from .controls import Do
from .handled_robot import HandledRobot
from .map_layer import MapLayer, go_to_cell, read_layer
from .sent import send_new
from .status_panel import as_plain

if TYPE_CHECKING:
    import viser

__all__ = ["MapTab"]


class MapTab:
    """Takes a map from the browser, shows it, and hears clicks on it."""

    def __init__(self, scene: viser.SceneApi, gui: viser.GuiApi, do: Do) -> None:
        self._scene, self._gui, self._do = scene, gui, do
        self._layer: MapLayer | None = None
        self._cloud: Any = None
        self._told, self._refused = "A map as `cpr workspace --out` writes it.", ""
        upload: Any = gui.add_upload_button("open a map (.nc)")
        self._text = gui.add_markdown(self._told)
        self._shown: Any = gui.add_checkbox("show map", True, visible=False)

        async def opened(event: Any) -> None:
            file = event.target.value
            self._do("map", lambda handled: self._open_bytes(handled, file.name, file.content))

        async def switched(_: Any) -> None:
            self._do("show map", self.show)

        upload.on_upload(opened)
        self._shown.on_update(switched)

        def clicked(event: Any) -> None:
            ray = event.ray_origin, event.ray_direction
            self._do("cell", lambda handled: self._go_to_clicked(handled, *ray))

        self._clicked = clicked

    def open(self, handled: HandledRobot, file: str | Path) -> None:
        """Lay a map into the scene.

        Raises:
            InvalidRequest: No map of this robot.
        """
        layer = read_layer(handled.robot, file, handled.equilibrium.loads)
        self._cloud = self._scene.add_point_cloud(
            "/map",
            layer.points,
            layer.colors,
            point_size=0.5 * layer.size,
            point_shape="square",
            precision="float32",
            point_shading="flat",
        )
        if self._layer is None:
            self._scene.on_click()(self._clicked)
        self._layer, self._refused = layer, ""
        shape = " x ".join(str(count) for count in layer.found.grid.shape)
        blue = "stable" if layer.found.energy_criterion_applies else "index 0"
        self._told = as_plain(
            f"{len(layer.cells)} of {shape} cells are reached; a click goes to one. Blue: {blue}, "
            "yellow, purple, grey: index 1, 2, more; orange: beyond a limit."
        )
        self._shown.visible, self._shown.value = True, True
        self.show(handled)

    def show(self, handled: HandledRobot) -> None:
        """Show the map while it is one of the robot under the loads that act."""
        other = "" if self._layer is None else _other(handled, self._layer)
        text = (
            f"The map is of other {other}: it is shown when they are as they were."
            if other
            else self._told
        )
        if self._layer is not None:
            send_new(self._cloud, visible=self._shown.value and not other)
        send_new(self._text, content=f"{self._refused}{text}")

    def _open_bytes(self, handled: HandledRobot, name: str, content: bytes) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "map.nc"
            file.write_bytes(content)
            try:
                self.open(handled, file)
            except CprError as error:
                problem = str(error).replace(str(file), name)
                self._refused = f"**not a map of this robot**: {as_plain(problem)}\n\n"
                self.show(handled)  # the one before stays

    def _go_to_clicked(self, handled: HandledRobot, origin: Any, direction: Any) -> None:
        if self._layer is None or not self._shown.value or _other(handled, self._layer):
            return
        self._refused = ""
        cell = self._layer.nearest(origin, direction)
        if cell is not None:
            go_to_cell(handled, self._layer.found, cell)


def _other(handled: HandledRobot, layer: MapLayer) -> str:
    """What a map has that the robot has not now, in words; empty: nothing."""
    # Chosen again, its modes make another robot of the same content.
    if robot_as_json(layer.found.robot) != robot_as_json(handled.robot):
        return "strain modes"
    other = layer.found.loads.differences(handled.equilibrium.loads)
    return "loads than act now" if other else ""

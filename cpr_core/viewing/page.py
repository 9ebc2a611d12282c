# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a robot: what is drawn, and what is asked of it."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..drawing.robot_lines import equilibrium_lines
from ..errors import CprError, InvalidRequest
from ..model.equilibrium import Equilibrium, check_equilibrium
from ..model.robot import Robot
from ..solving.trace import Trace
from .background import Background
from .bars import bars
from .controls import Controls
from .dragged import ForceArrow, PlatformHandle
from .equilibria_tab import EquilibriaTab
from .handled_robot import HandledRobot
from .landmarks import Landmarks, PlatformNode, aim_camera, light
from .mailbox import Mailbox
from .map_tab import MapTab
from .record_tab import RecordTab
from .refused import ghost_lines
from .robot_scene import RobotScene
from .sent import send_new
from .server import address_of, close_server, open_server
from .status_panel import BarsPanel, status_text
from .way_tab import WayTab

if TYPE_CHECKING:
    import viser

__all__ = ["Page"]

#: Bars and numbers change at most so often [s].
_NUMBERS_EVERY = 0.1


class Page:
    """One robot on a page, for everybody who opens it.

    Attributes:
        server: The server; whoever adds to the page finds scene and GUI there.
    """

    def __init__(
        self,
        robot: Robot,
        start: Equilibrium | None,
        *,
        host: str,
        port: int,
        map_file: str | Path | None,
        way: Trace | None,
    ) -> None:
        """Open the page; it is there until it is closed or the process ends.

        Args:
            robot: The robot.
            start: Where to begin; None: home.
            host: Address to listen at.
            port: Port; 0: any that is free.
            map_file: A map of the robot, to begin with.
            way: A path to play, to begin with.

        Raises:
            MissingViewer: viser is not installed.
            InvalidRequest: The address cannot be had, or the map is none of this robot.
        """
        # Long, for it makes all that is on the page.
        self._handled = HandledRobot(robot, start)
        self.server: viser.ViserServer = open_server(robot.description.name, host, port)
        self._mailbox, self._numbers_drawn = Mailbox(self._failed), -1.0
        scene, gui, size = self.server.scene, self.server.gui, robot.mean_length
        rods = equilibrium_lines(self._handled.equilibrium).rods
        aim_camera(self.server, robot, np.concatenate(rods))
        light(self.server)
        self._landmarks = Landmarks(scene, robot)
        self._platform = PlatformNode(scene, robot)
        self._robot = RobotScene(scene, "/robot", size)
        self._ghost = RobotScene(scene, "/ghost", size)
        self._status = gui.add_markdown("")
        self._bars = BarsPanel(gui, bars(self._handled.equilibrium))
        tabs = gui.add_tab_group()
        with tabs.add_tab("robot"):
            self._controls = Controls(gui, self._handled, self.do)
            self._add_shown(gui)
        self._background = Background(self.do, self._failed)
        with tabs.add_tab("equilibria"):
            EquilibriaTab(gui, self.do, self._background)
        with tabs.add_tab("map"):
            self._maps = MapTab(scene, gui, self.do)
        with tabs.add_tab("way"):
            ways = WayTab(scene, gui, self.do, self._handled, self._background)
        with tabs.add_tab("record"):
            RecordTab(gui, self.do, robot.description.name, self._background)
        self._handle = PlatformHandle(scene, robot, self._dragged)
        self._force = ForceArrow(scene, robot, self._pushed)
        self._draw()
        try:
            if map_file is not None:
                self._maps.open(self._handled, map_file)
            if way is not None:
                ways.open(_way_of(robot, way))
        except InvalidRequest:
            self.close()
            raise

    @property
    def address(self) -> str:
        """Where the page is."""
        return address_of(self.server)

    @property
    def equilibrium(self) -> Equilibrium:
        """Where the robot is on the page."""
        return self._handled.equilibrium

    def do(self, name: str, action: Callable[[HandledRobot], Any]) -> None:
        """Have something done with the robot in the thread of the page, and show what came of it.

        Args:
            name: Takes the place of what waits under the same name.
            action: What to do.
        """
        self._mailbox.ask(name, lambda: self._act(action))

    def show(self, equilibrium: Equilibrium, words: str = "shown") -> None:
        """Show an equilibrium of the robot.

        Raises:
            InvalidRequest: No equilibrium, or one of another robot than the page shows now.
        """
        check_equilibrium(equilibrium)
        self._handled.check_shown(equilibrium)
        self.do("show", lambda handled: handled.take(equilibrium, words))

    def wait(self, timeout: float = 60.0) -> bool:
        """Wait until everything asked for is done; whether it was in time [s]."""
        return self._mailbox.wait(timeout)

    def close(self) -> None:
        """Close the page."""
        self._background.close()
        self._mailbox.close()
        close_server(self.server)

    def _act(self, action: Callable[[HandledRobot], Any]) -> None:
        try:
            action(self._handled)
        except CprError as error:
            self._handled.refuse(error)
        self._draw()

    def _draw(self) -> None:
        handled = self._handled
        current, refused = handled.equilibrium, handled.refused
        asked = None if refused is None else refused.asked
        # All that is computed first: kernels let go of the interpreter, and what is sent would take it.
        lines, text = equilibrium_lines(current), status_text(handled)
        ghost = None if asked is None else ghost_lines(current, asked)
        with self.server.atomic():
            self._robot.show(lines)
            self._platform.show(current.platform_position, current.platform_quaternion)
            self._ghost.show_ghost(ghost)
            self._handle.show(current)
            self._force.show(current)
            self._controls.show(handled)
            self._maps.show(handled)
            send_new(self._status, content=text)
        rest = self._numbers_drawn + _NUMBERS_EVERY - time.monotonic()
        self._mailbox.ask("numbers", self._draw_numbers, max(0.0, rest))

    def _draw_numbers(self) -> None:
        """After the scene, which nobody wants to wait for."""
        self._bars.show(bars(self._handled.equilibrium))
        self._controls.follow(self._handled)
        self._numbers_drawn = time.monotonic()

    def _failed(self, error: Exception) -> None:
        """Something of ours is wrong: say so on the page, and go on."""
        self._status.content = f"**the page failed**: {error!r:.300}"

    def _dragged(self, place: Any) -> None:
        if place is None:
            self.do("let go", lambda handled: handled.end_gesture())
        else:
            self.do("platform", lambda handled: handled.move_platform(*place))

    def _pushed(self, force: Any) -> None:
        if force is None:
            self.do("let go", lambda handled: handled.end_gesture())
        else:
            self.do("force", lambda handled: handled.push(force))

    def _add_shown(self, gui: viser.GuiApi) -> None:
        names: Any = gui.add_checkbox("names", True)
        handles: Any = gui.add_checkbox("handles", True)

        async def name(event: Any) -> None:
            self._landmarks.show_names(event.target.value)
            self._platform.show_names(event.target.value)

        async def handle(event: Any) -> None:
            self._handle.show_handles(event.target.value)
            self._force.show_handles(event.target.value)

        names.on_update(name)
        handles.on_update(handle)


def _way_of(robot: Robot, way: Trace) -> Trace:
    if not isinstance(way, Trace) or way.robot is not robot:
        raise InvalidRequest("way", f"expected a Trace of the same robot object, got {way!r:.200}")
    return way

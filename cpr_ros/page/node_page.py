# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a running node: what it publishes, setpoints of who has taken control. No ROS here."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpr_core import CprError, Robot
from cpr_core.drawing.robot_lines import RobotLines
from cpr_core.viewing.bars import Bar
from cpr_core.viewing.landmarks import Landmarks, PlatformNode, aim_camera
from cpr_core.viewing.motor_sliders import MotorSliders
from cpr_core.viewing.robot_scene import RobotScene
from cpr_core.viewing.sent import send_new
from cpr_core.viewing.server import address_of, close_server, open_server
from cpr_core.viewing.status_panel import BarsPanel, as_plain

from .page_control import PageControl
from .typed_motors import TypedMotors
from .watched_node import Seen

__all__ = ["NodePage"]

Floats = NDArray[np.float64]

_ACTIONS = {0: ("NONE", "green"), 1: ("SLOW", "yellow"), 2: ("HALT", "red")}
_SEEN = {
    "waiting": "waiting for {name}",
    "there": "{name} is there",
    "gone": "{name} is gone",
    "back": "{name} is back",
}


class NodePage:
    """Shows one node. Called from one thread; what somebody asks for on it is kept until it is taken."""

    def __init__(self, name: str, host: str, port: int) -> None:
        """Open the page.

        Args:
            name: Of the node.
            host: Address to listen at.
            port: Port; 0: any that is free.

        Raises:
            MissingViewer: viser is not installed.
            InvalidRequest: The address cannot be had.
        """
        self._name = name
        self._server = open_server(f"node {name}", host, port)
        gui = self._server.gui
        self._control = PageControl()
        self._robot: Robot | None = None
        self._presence = gui.add_markdown(_SEEN["waiting"].format(name=name))
        self._action_text = gui.add_markdown("")
        self._action_bar = gui.add_progress_bar(100.0, color="gray")
        self._words = gui.add_markdown("")
        self._others = gui.add_markdown("")
        # One is seen at a time. A single button whose words change would do the contrary of what was
        # read on it where two press it, or the node is gone meanwhile.
        self._take: Any = gui.add_button("take control")
        self._give: Any = gui.add_button("give control back", visible=False)
        self._plot: Any = None
        self._bars: Any = None
        self._parts: list[Any] = []
        self._aimed = self._controlled = False

        async def taken(_: Any) -> None:
            self._control.take()

        async def given_back(_: Any) -> None:
            self._control.give_back(pressed=True)

        async def closed(_: Any) -> None:
            if not self._server.get_clients():
                self._give_back("nobody has the page open")

        self._take.on_click(taken)
        self._give.on_click(given_back)
        self._server.on_client_disconnect(closed)

    @property
    def address(self) -> str:
        """Where the page is."""
        return address_of(self._server)

    @property
    def in_control(self) -> bool:
        """Whether setpoints are sent."""
        return self._control.taken

    def show_no_robot(self) -> None:
        """Nothing is known of the robot any more. Who was in control of it has no control of another."""
        self._give_back("another robot has come")
        if self._robot is not None:
            self._sliders.forget()
        self._robot = None
        for part in self._parts:
            part.remove()
        self._parts = []
        self._server.scene.reset()

    def show_robot(self, robot: Robot, motors: list[float]) -> None:
        """Which robot it is, where there was none."""
        scene, gui = self._server.scene, self._server.gui
        self._robot, self._aimed = robot, False
        self._landmarks = Landmarks(scene, robot)
        self._platform = PlatformNode(scene, robot)
        self._lines = RobotScene(scene, "/robot", robot.mean_length)
        folder = gui.add_folder("motors")
        self._parts = [folder]
        with folder:
            self._sliders = MotorSliders(gui, robot, motors, self._slid, self._typed_beside)
        TypedMotors(gui, folder, robot, motors, self._typed, self._refuse)

    def show_lines(self, lines: RobotLines) -> None:
        """Draw the robot as its markers have it."""
        if self._robot is None or not lines.rods:
            return
        if not self._aimed:
            aim_camera(self._server, self._robot, np.concatenate(lines.rods))
            self._aimed = True
        with self._server.atomic():
            self._lines.show(lines)

    def show_platform(self, position: Floats, quaternion: Floats) -> None:
        """Where the platform is: (3,) [m], w x y z."""
        if self._robot is not None:
            with self._server.atomic():
                self._platform.show(position, quaternion)

    def show_motors(self, motors: list[float]) -> None:
        """Where the motors are; sliders of who is in control are where they were sent."""
        if self._robot is None:
            return
        if self._controlled != self.in_control:
            self._controlled = self.in_control
            self._sliders.forget()  # moved before, they would be a step away from where nobody sent it
        self._sliders.show(motors)

    def show_stability(self, action: int, text: str, bars: Sequence[Bar], under_way: bool) -> None:
        """What a supervisor is told.

        Args:
            action: 0 none, 1 slow down, 2 halt.
            text: Why.
            bars: Measures with thresholds.
            under_way: Whether motors are to go where they were sent, at once or later.
        """
        if self._robot is not None and not under_way and not self._control.asks:
            self._sliders.rest()
        name, color = _ACTIONS[action]
        send_new(self._action_text, content=f"**action {name}**: {as_plain(text)}")
        send_new(self._action_bar, color=color)
        if self._bars is None:
            self._bars = BarsPanel(self._server.gui, bars)
        self._bars.show(bars)

    def show_presence(self, seen: Seen) -> None:
        """Whether the node is heard. One that is gone takes control with it."""
        send_new(self._presence, content=f"**{_SEEN[seen].format(name=as_plain(self._name))}**")
        if seen == "gone":
            send_new(self._action_bar, color="gray")
            send_new(self._action_text, content="nothing is known of the robot")
            if self._bars is not None:
                self._bars.show([])
            self._give_back("the node is gone")
        send_new(self._take, visible=not self.in_control)
        send_new(self._give, visible=self.in_control)

    def show_others(self, names: Sequence[str]) -> None:
        """Who else can send setpoints."""
        who = ", ".join(names) or "nobody"
        send_new(self._others, content=as_plain(f"setpoints may also come from: {who}"))

    def show_last_minute(self, columns: tuple[Floats, ...], names: tuple[str, ...]) -> None:
        """Plot numbers over time [s]."""
        if self._plot is None:
            tones = ("#0072B2", "#D55E00", "#009E73")
            series = (
                {"label": "s"},
                *(
                    {"label": name, "stroke": tone, "width": 2}
                    for name, tone in zip(names, tones, strict=False)
                ),
            )
            scales = {"x": {"time": False}}
            self._plot = self._server.gui.add_uplot(columns, series, scales=scales, aspect=2.0)  # type: ignore[arg-type]
        else:
            self._plot.data = columns

    def say(self, text: str) -> None:
        """Say something in words."""
        send_new(self._words, content=as_plain(text))

    def fail(self, error: Exception) -> None:
        """Say that something is wrong with what came, or with the page, which goes on."""
        self.say(f"the page failed: {error!r:.300}")

    def take_asked(self) -> dict[int, float]:
        """Motor positions that were asked for since, by number of the motor."""
        asked = self._control.take_asked()
        for number in asked:
            self._sliders.sent(number)
        return asked

    def close(self) -> None:
        """Close the page."""
        close_server(self._server)

    def _slid(self, number: int, position: float) -> None:
        if not np.isfinite(position):
            self.say(f"nothing was sent: expected a finite number, got {position}")
        elif self._control.ask(number, position):
            self._sliders.expect(number, position)
        else:
            self._sliders.done(number, position)
            self.say("nothing was sent: press `take control` first")

    def _typed_beside(self, motor: str) -> None:
        self.say(
            f"nothing was sent: {motor} goes where its slider is dragged, or the field `numbers` says"
        )

    def _typed(self, motors: list[float]) -> None:
        for number, position in enumerate(motors):
            self._slid(number, position)

    def _refuse(self, why: CprError) -> None:
        self.say(f"nothing was sent: {why}")

    def _give_back(self, why: str) -> None:
        if self._control.give_back():
            self.say(f"control was given back: {why}")

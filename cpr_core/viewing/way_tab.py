# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The tab of a way: a path is traced and played, with a slider for time."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import CprError
from ..model.equilibrium import Equilibrium
from ..solving.requests import pose_meaning
from ..solving.trace import Trace, trace
from .background import Background, Task
from .controls import Do
from .handled_robot import HandledRobot
from .robot_scene import LineNode
from .status_panel import as_plain
from .typed import numbers_as_text, typed_numbers

if TYPE_CHECKING:
    import viser

__all__ = ["WayTab", "frame_at"]

#: Points of a path that is traced here, and how long one takes to be played [s].
_POINTS, _PLAYED = 101, 4.0
_FRAME = 1.0 / 30.0


def frame_at(way: Trace, fraction: float) -> int:
    """Number of the equilibrium at a part of the time of a path, in [0, 1]; points are equally long."""
    last = len(way.equilibria) - 1
    return int(np.clip(round(fraction * last), 0, last))


class WayTab:
    """Where to, a button that traces, one that plays, and the slider."""

    def __init__(
        self,
        scene: viser.SceneApi,
        gui: viser.GuiApi,
        do: Do,
        handled: HandledRobot,
        background: Background,
    ) -> None:
        self._do, self._background = do, background
        self._way: Trace | None = None
        self._frame: Equilibrium | None = None
        self._other_loads = False
        self._line = LineNode(scene, "/way", 0.006 * handled.robot.mean_length)
        self._meanings = {"motors": handled.robot.motor_names}
        if handled.robot.description.controlled:
            self._meanings["pose"] = pose_meaning(handled.robot)
        self._given: Any = gui.add_dropdown("to", tuple(self._meanings))
        self._field: Any = gui.add_text("end", numbers_as_text(handled.equilibrium.motors))
        begin: Any = gui.add_button("trace from here")
        self._text = gui.add_markdown("A straight path along the branch, from where the robot is.")
        self._time: Any = gui.add_slider("time", 0.0, 1.0, 0.001, 0.0, disabled=True)
        self._play: Any = gui.add_button("play", disabled=True)

        async def chosen(_: Any) -> None:
            self._do("way field", self._fill)

        async def asked(_: Any) -> None:
            self._do("way", self._begin)

        async def moved(event: Any) -> None:
            if event.client_id is not None:
                at = event.target.value
                self._background.stop("play")
                self._do("time", lambda handled: self._go_to_time(handled, at))

        async def played(_: Any) -> None:
            self._background.start("play", self._playing)

        self._given.on_update(chosen)
        begin.on_click(asked)
        self._time.on_update(moved)
        self._play.on_click(played)

    def open(self, way: Trace) -> None:
        """Show a path, from its beginning."""
        self._background.stop("play")
        self._way = way
        places = way.platform_positions
        ends = np.stack([places[:-1], places[1:]], axis=1)
        self._line.show(ends, (0.0, 0.62, 0.45))
        lines = [
            f"{len(way.equilibria)} equilibria; " + ("the end is reached" if way.reached else "")
        ]
        lines += [f"{event.kind} at {event.fraction:.4f}: {event.message}" for event in way.events]
        self._text.content = "\n\n".join(as_plain(line) for line in lines)
        self._time.disabled = self._play.disabled = False
        self._time.value = 0.0

    def _fill(self, handled: HandledRobot) -> None:
        current = handled.equilibrium
        values = current.motors if self._given.value == "motors" else current.pose
        self._field.value = numbers_as_text(values)

    def _begin(self, handled: HandledRobot) -> None:
        kind, current = self._given.value, handled.equilibrium
        try:
            values = typed_numbers(kind, self._field.value, self._meanings[kind])
        except CprError as error:
            handled.refuse(error)
            return
        self._text.content = "tracing"

        def work(task: Task) -> None:
            try:
                found = trace(
                    current.robot,
                    motors=values if kind == "motors" else None,
                    pose=values if kind == "pose" else None,
                    start=current,
                    points=_POINTS,
                )
            except CprError as error:
                problem = as_plain(str(error))
                task.post("traced", lambda _: setattr(self._text, "content", problem))
            else:
                task.post("traced", lambda _: self.open(found))

        self._background.start("way", work)

    def _go_to_time(self, handled: HandledRobot, at: float) -> None:
        if self._way is None:
            return
        shown = self._way.equilibria[frame_at(self._way, at)]
        if shown.robot is not handled.robot:
            self._text.content = "the path is of other strain modes: trace it again"
            return
        current = handled.equilibrium
        if current is not self._frame:  # the robot was elsewhere before
            self._other_loads = bool(current.loads.differences(shown.loads))
        self._frame = shown
        under = ", under the loads it was traced with" if self._other_loads else ""
        handled.show(shown, f"on the path, time {at:.3f}{under}")

    def _playing(self, task: Task) -> None:
        begin = time.monotonic()
        while not task.stopped():
            at = min(1.0, (time.monotonic() - begin) / _PLAYED)

            def step(handled: HandledRobot, at: float = at) -> None:
                self._time.value = at
                self._go_to_time(handled, at)

            task.post("time", step)
            if at >= 1.0:
                return
            time.sleep(_FRAME)

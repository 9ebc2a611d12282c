# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What one moves the robot with: a slider for every motor, fields for numbers, switches and buttons."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..description.loads import WRENCH_NAMES
from ..errors import CprError
from ..model.robot import Robot
from ..rods.rod import MOST_MODES
from ..solving.requests import pose_meaning
from .handled_robot import HandledRobot
from .typed import numbers_as_text, typed_numbers

if TYPE_CHECKING:
    import viser

__all__ = ["Controls", "Do", "MotorSliders"]

#: Asks for something under a name; of one name only the newest counts.
Do = Callable[[str, Callable[[HandledRobot], Any]], None]

#: Way of a motor without a limit from where it is, in radians or rod lengths.
_REACH = {"rad": math.pi, "m": 0.5}
_STEPS = 2000
#: So long a slider is left where somebody has put it, until the robot is asked to go there [s].
_PATIENCE = 5.0


class MotorSliders:
    """A slider for every motor, within its limits."""

    def __init__(
        self,
        gui: viser.GuiApi,
        robot: Robot,
        motors: list[float],
        moved: Callable[[int, float], None],
    ) -> None:
        """Make them.

        Args:
            gui: Of the page.
            robot: The robot.
            motors: Where the motors are [rad or m].
            moved: Called with number and position when somebody moves a slider.
        """
        self._sliders: list[Any] = []
        #: Where each was put by us, and where its last request, which was done, wanted it.
        self._put, self._done = [*motors], [*motors]
        for number, (motor, at) in enumerate(zip(robot.description.motors, motors, strict=True)):
            reach = _REACH[motor.moves] * robot.motor_units[number]
            low = motor.limits.lower if math.isfinite(motor.limits.lower) else at - reach
            high = motor.limits.upper if math.isfinite(motor.limits.upper) else at + reach
            low, high = min(low, at), max(high, at)
            step = (high - low) / _STEPS if high > low else 1.0
            slider = gui.add_slider(f"{motor.name} [{motor.unit}]", low, high, step, at)
            slider.on_update(self._telling(number, moved))
            self._sliders.append(slider)

    @staticmethod
    def _telling(number: int, moved: Callable[[int, float], None]) -> Any:
        async def tell(event: Any) -> None:
            if event.client_id is not None:  # else the page itself has put it there
                moved(number, event.target.value)

        return tell

    def done(self, number: int, position: float) -> None:
        """What somebody asked for by a slider was done, or refused."""
        self._done[number] = position

    def show(self, motors: list[float], held: int | None = None) -> None:
        """Put them where the motors are; one that is held stays at what is asked.

        So does one that was moved while something else was done: its request is on the way, and put
        back it would take back what a hand has done meanwhile.
        """
        for number, (slider, at) in enumerate(zip(self._sliders, motors, strict=True)):
            if number == held or self._waits(number):
                continue
            if not slider.min <= at <= slider.max:
                slider.min, slider.max = min(slider.min, at), max(slider.max, at)
            self._put[number] = at
            if slider.value != at:
                slider.value = at

    def _waits(self, number: int) -> bool:
        """Whether a slider is where somebody has put it whose request was not done yet."""
        slider = self._sliders[number]
        known = slider.value in (self._put[number], self._done[number])
        return not known and time.time() - slider.update_timestamp < _PATIENCE


class Controls:
    """The tab that moves the robot."""

    def __init__(self, gui: viser.GuiApi, handled: HandledRobot, do: Do) -> None:
        self._held: int | None = None
        current, self._do = handled.equilibrium, do
        self._sliders = MotorSliders(gui, handled.robot, current.motors.tolist(), self._slid)
        buttons = gui.add_button_group("robot", ("home", "undo"))

        async def pressed(event: Any) -> None:
            action = HandledRobot.go_home if event.target.value == "home" else HandledRobot.undo
            self._do(event.target.value, self._free(action))

        buttons.on_click(pressed)
        self._gravity: Any = gui.add_checkbox("gravity", handled.has_gravity)

        async def switched(event: Any) -> None:
            on = event.target.value
            if event.client_id is not None:
                self._do("gravity", self._free(lambda handled: handled.switch_gravity(on)))

        self._gravity.on_update(switched)
        self._add_fields(gui, handled)
        self._add_modes(gui, handled)

    def show(self, handled: HandledRobot) -> None:
        """Show where the motors are and what acts."""
        current, refused = handled.equilibrium, handled.refused
        waits = refused is not None and refused.asked is not None
        self._sliders.show(current.motors.tolist(), self._held if waits else None)
        if self._gravity.value != handled.has_gravity:
            self._gravity.value = handled.has_gravity

    def follow(self, handled: HandledRobot) -> None:
        """Numbers in the field, unless somebody has typed there."""
        self._follow(handled)

    def _slid(self, number: int, position: float) -> None:
        def move(handled: HandledRobot) -> bool:
            self._held = number
            self._sliders.done(number, position)
            return handled.move_motor(number, position)

        self._do(handled_name(number), move)

    def _free(self, action: Callable[[HandledRobot], Any]) -> Callable[[HandledRobot], Any]:
        """The same by another hand than a slider's."""

        def act(handled: HandledRobot) -> Any:
            self._held = None
            return action(handled)

        return act

    def _add_fields(self, gui: viser.GuiApi, handled: HandledRobot) -> None:
        meanings = {"motors": handled.robot.motor_names, "wrench": WRENCH_NAMES}
        if handled.robot.description.controlled:
            meanings["pose"] = pose_meaning(handled.robot)
        given: Any = gui.add_dropdown("type", tuple(sorted(meanings)))
        field: Any = gui.add_text("numbers", "", hint="SI units, radians, between spaces")
        send = gui.add_button("go there")

        def current_numbers(handled: HandledRobot) -> str:
            now = handled.equilibrium
            values = {"motors": now.motors, "pose": now.pose, "wrench": now.loads.wrench_world}
            return numbers_as_text(values[given.value])

        filled = ""

        def fill(handled: HandledRobot) -> None:
            nonlocal filled
            field.value = filled = current_numbers(handled)

        def follow(handled: HandledRobot) -> None:
            if field.value == filled:  # nobody has typed there
                fill(handled)

        def act(handled: HandledRobot) -> None:
            kind, text = given.value, field.value
            self._held = None
            try:
                values = typed_numbers(kind, text, meanings[kind])
            except CprError as error:
                handled.refuse(error)
                return
            if kind == "wrench":
                done = handled.load(handled.equilibrium.loads.with_(wrench_world=values))
            else:
                done = (handled.move_motors if kind == "motors" else handled.move_pose)(values)
            if done:  # what was refused stays to be mended
                fill(handled)

        async def asked(_: Any) -> None:
            self._do("typed", act)

        async def chosen(_: Any) -> None:
            self._do("fill", fill)

        send.on_click(asked)
        given.on_update(chosen)
        fill(handled)
        self._follow = follow

    def _add_modes(self, gui: viser.GuiApi, handled: HandledRobot) -> None:
        counts = {count for rod in handled.robot.description.rods for count in rod.modes.counts}
        modes: Any = gui.add_text(
            "strain modes",
            str(max(counts)),
            hint=f"per direction, from 1 to {MOST_MODES}; Enter is not needed",
        )
        choose = gui.add_button("choose modes")

        def act(handled: HandledRobot) -> None:
            text = modes.value.strip()
            handled.choose_modes(int(text) if text.isdecimal() else text)

        async def asked(_: Any) -> None:
            self._do("modes", self._free(act))

        choose.on_click(asked)


def handled_name(number: int) -> str:
    """Name of the requests of a slider."""
    return f"motor {number}"

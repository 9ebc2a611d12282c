# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What one moves the robot with: a slider for every motor, fields for numbers, switches and buttons."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..description.loads import WRENCH_NAMES
from ..errors import CprError, InvalidRequest
from ..model.robot import Robot
from ..rods.rod import MOST_MODES
from ..solving.requests import pose_meaning
from .handled_robot import HandledRobot
from .motor_sliders import MotorSliders
from .sent import send_new
from .typed import numbers_as_text, typed_numbers

if TYPE_CHECKING:
    import viser

__all__ = ["Controls", "Do"]

#: Asks for something under a name; of one name only the newest counts.
Do = Callable[[str, Callable[[HandledRobot], Any]], None]


class Controls:
    """The tab that moves the robot."""

    def __init__(self, gui: viser.GuiApi, handled: HandledRobot, do: Do) -> None:
        self._held: int | None = None
        current, self._do = handled.equilibrium, do
        motors = current.motors.tolist()
        self._sliders = MotorSliders(gui, handled.robot, motors, self._slid, self._typed_beside)
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
        send_new(self._gravity, value=handled.has_gravity)
        if handled.robot is not self._shown_robot:
            self._show_modes(handled)

    def follow(self, handled: HandledRobot) -> None:
        """Numbers in the field, unless somebody has typed there."""
        self._follow(handled)

    def _slid(self, number: int, position: float) -> None:
        def move(handled: HandledRobot) -> bool:
            self._held = number
            self._sliders.done(number, position)
            return handled.move_motor(number, position)

        self._do(f"motor {number}", move)

    def _typed_beside(self, motor: str) -> None:
        words = "expected numbers in the field `numbers`: the box beside a slider only shows one"
        self._do("typed beside", lambda handled: handled.refuse(InvalidRequest(motor, words)))

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
        self._modes: Any = gui.add_text(
            "strain modes",
            "",
            hint=f"per direction, from 1 to {MOST_MODES}; Enter is not needed",
        )
        choose = gui.add_button("choose modes")
        self._show_modes(handled)

        def act(handled: HandledRobot) -> None:
            text = self._modes.value.strip()
            if text != _modes_as_text(handled.robot):
                handled.choose_modes(int(text) if text.isdecimal() else text)

        async def asked(_: Any) -> None:
            self._do("modes", self._free(act))

        choose.on_click(asked)

    def _show_modes(self, handled: HandledRobot) -> None:
        """The modes of the robot that is shown, whatever was typed."""
        self._shown_robot = handled.robot
        self._modes.value = _modes_as_text(handled.robot)


def _modes_as_text(robot: Robot) -> str:
    """Numbers of modes of the directions that have any; one if they are all the same."""
    counts = {rod.modes.counts for rod in robot.description.rods}
    single = {count for rod in counts for count in rod if count}
    if len(single) == 1:
        return str(*single)
    return "; ".join(" ".join(map(str, rod)) for rod in sorted(counts))

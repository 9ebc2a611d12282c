# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A field for positions of all motors, and a button that says which of them it sends. No ROS here."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from cpr_core import CprError, Robot
from cpr_core.viewing.typed import numbers_as_text, typed_numbers

if TYPE_CHECKING:
    import viser

__all__ = ["TypedMotors"]

#: What the button says of a text that is not one number of every motor.
_NOTHING_TO_SEND = "nothing to send"


class TypedMotors:
    """What is typed is sent with a button.

    A browser tells every 50 ms of what was done last: a button that is pressed right after the last
    key, or while the page is held up, goes out in place of the text. So the button says what it sends,
    and every text has one of its own: whoever presses it sends what was to be read there.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        folder: viser.GuiFolderHandle,
        robot: Robot,
        motors: list[float],
        asked: Callable[[list[float]], None],
        refused: Callable[[CprError], None],
    ) -> None:
        """Add them to a folder.

        Args:
            gui: Of the page.
            folder: Where they are added.
            robot: The robot.
            motors: What the field says at first [rad or m].
            asked: Called with the positions of all motors [rad or m].
            refused: Called with why nothing can be sent.
        """
        self._gui, self._folder, self._robot = gui, folder, robot
        self._asked, self._refused = asked, refused
        text = numbers_as_text(np.array(motors))
        hint = "of all motors, SI units, radians, between spaces"
        with folder:
            field: Any = gui.add_text("numbers", text, hint=hint)
        self._button = self._button_for(text)

        async def typed(_: Any) -> None:
            self._button.remove()
            self._button = self._button_for(field.value)

        field.on_update(typed)

    def _button_for(self, text: str) -> Any:
        """A button that sends what this text says, or tells why it sends nothing."""
        label, press = self._meaning(text)
        with self._folder:
            button: Any = self._gui.add_button(label)

        async def pressed(_: Any) -> None:
            press()

        button.on_click(pressed)
        return button

    def _meaning(self, text: str) -> tuple[str, Callable[[], None]]:
        """What the button of a text says and does."""
        try:
            values = typed_numbers("motors", text, self._robot.motor_names).tolist()
        except CprError as error:
            return _NOTHING_TO_SEND, partial(self._refused, error)
        shown = " ".join(f"{position + 0.0:.5g}" for position in values)
        return f"send {shown}", partial(self._asked, values)

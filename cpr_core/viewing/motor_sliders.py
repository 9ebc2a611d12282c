# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A slider for every motor, which hands move and keys do not."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from ..model.robot import Robot

if TYPE_CHECKING:
    import viser

__all__ = ["MotorSliders"]

#: Way of a motor without a limit from where it is, in radians or rod lengths.
_REACH = {"rad": math.pi, "m": 0.5}
_STEPS = 2000
#: No whole number of steps, else numbers that are typed would be some from the end, as those of hands.
#: More than half of one is left, so that a hand can come to the other end.
_LEFT = 1.0 - math.pi / 10.0
#: So long a slider is left where somebody has put it, until the robot is asked to go there [s].
_PATIENCE = 5.0
#: Updates of a hand that drags are not farther from each other [s].
_GESTURE = 0.5
#: So many steps from an end it is reached by keys.
_BESIDE = 25
#: What was typed is over after so long [s].
_SETTLED = 1.0
#: A motor may go on for so long to where it was sent before [s].
_SETTING_OFF = 0.5
#: More keys are not pressed between two messages of a browser.
_MOST_KEYS = 20
#: To half of this the browser rounds, and a step is much more [rad or m].
_ROUNDED, _FINEST = 1e-7, 2e-5


class MotorSliders:
    """A slider for every motor, within its limits.

    The box beside a slider shows a number. What is typed there is no request: every key is an update of
    its own, and who types 2.70 would ask for 2 first.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        robot: Robot,
        motors: list[float],
        moved: Callable[[int, float], None],
        typed: Callable[[str], None],
    ) -> None:
        """Make them.

        Args:
            gui: Of the page.
            robot: The robot.
            motors: Where the motors are [rad or m].
            moved: Called with number and position when somebody moves a slider.
            typed: Called with the name of a motor when somebody types beside its slider.
        """
        self._sliders: list[_MotorSlider] = []
        for number, (motor, at) in enumerate(zip(robot.description.motors, motors, strict=True)):
            reach = _REACH[motor.moves] * robot.motor_units[number]
            limits = lower, upper = motor.limits.lower, motor.limits.upper
            low = lower if math.isfinite(lower) else at - reach
            high = upper if math.isfinite(upper) else at + reach
            low, high = min(low, at), max(high, at)
            step = _step(high - low) if high > low else 1.0
            handle = gui.add_slider(f"{motor.name} [{motor.unit}]", low, high, step, at)
            slider = _MotorSlider(
                handle, limits, partial(moved, number), partial(typed, motor.name)
            )
            self._sliders.append(slider)

    def done(self, number: int, position: float) -> None:
        """What somebody asked for by a slider was done, or refused."""
        self._sliders[number].done = position

    def expect(self, number: int, position: float) -> None:
        """A motor was sent somewhere: its slider is there until it has come, and others move it on."""
        self._sliders[number].expect(position)

    def sent(self, number: int) -> None:
        """What a slider asked for is on its way to the robot only now."""
        self._sliders[number].sent_at = time.monotonic()

    def rest(self) -> None:
        """The robot goes nowhere: nobody expects motors any more that were sent somewhere before.

        Not where that was a moment ago: the robot may not have known it yet.
        """
        for slider in self._sliders:
            slider.rest()

    def forget(self) -> None:
        """Nobody has asked for where they are: `show` puts all of them where the motors are."""
        for slider in self._sliders:
            slider.forget()

    def show(self, motors: list[float], held: int | None = None) -> None:
        """Put them where the motors are; one that is held stays at what is asked.

        So does one that was moved while something else was done: its request is on the way, and put
        back it would take back what a hand has done meanwhile.
        """
        for number, (slider, at) in enumerate(zip(self._sliders, motors, strict=True)):
            if number != held and not slider.waits and not slider.expects(at):
                slider.put(at)


class _MotorSlider:
    """The slider of one motor.

    Attributes:
        handle: That of the page.
        done: Where its last request, which was done, wanted it.
        sent_at: When its motor was sent somewhere [s].
    """

    def __init__(
        self,
        handle: Any,
        limits: tuple[float, float],
        moved: Callable[[float], None],
        typed: Callable[[], None],
    ) -> None:
        self.handle, self._limits, self._moved, self._typed = handle, limits, moved, typed
        #: Where we have put it, and where a hand or we have put it last.
        self._put = self._last = self.done = handle.value
        #: How often the browser has said something, and whether the newest is a number that was typed.
        self._heard, self._typing = 0, False
        #: When a hand has moved it [s].
        self._dragged = -math.inf
        #: Where the motor was sent, and how near it has come since.
        self._sent: float | None = None
        self.sent_at, self._nearest = -math.inf, math.inf

        async def tell(event: Any) -> None:
            if event.client_id is not None:  # else the page itself has put it there
                await self._hear(event.target.value)

        handle.on_update(tell)

    async def _hear(self, position: float) -> None:
        """Take what a hand does, and put back what is typed."""
        if position == self._last:
            return
        self._heard += 1
        heard = self._heard
        self._typing = not self._by_hand(position)
        if not self._typing:
            self._dragged, self._last = time.monotonic(), position
            self._moved(position)
            return
        self._typed()
        await asyncio.sleep(_SETTLED)
        if heard == self._heard:
            self.done, self.handle.value = position, self._last

    def _by_hand(self, position: float) -> bool:
        """Whether a hand has brought it to a position.

        An end may be the first digit of a number: a hand comes there on its way, not by a jump.
        """
        handle, last = self.handle, self._last
        if not math.isfinite(position):
            return True  # whoever takes it says what is wrong with it
        if position in (handle.min, handle.max):
            on_its_way = time.monotonic() - self._dragged < _GESTURE
            return on_its_way or abs(position - last) <= _BESIDE * handle.step
        return by_hand(position, last, handle.min, handle.step)

    def forget(self) -> None:
        """Nobody has asked for where it is."""
        self.done, self._sent = self.handle.value, None
        self._heard += 1

    def expect(self, position: float) -> None:
        """The motor was sent somewhere, as far as its limits let it.

        Where that is far beyond the slider, which would be of no use then, it goes with the motor.
        """
        (lower, upper), handle = self._limits, self.handle
        at, reach = min(max(position, lower), upper), handle.max - handle.min
        if not handle.min - reach <= at <= handle.max + reach:
            self._sent = None
            return
        self._sent, self.sent_at, self._nearest = at, time.monotonic(), math.inf
        self.put(at)

    def expects(self, at: float) -> bool:
        """Whether the motor, which is at a position, is on its way to where it was sent, or there.

        Else others move it: it goes away from there, by more than a step.
        """
        if self._sent is None:
            return False
        left = abs(at - self._sent)
        self._nearest = min(self._nearest, left)
        if self._has_set_off and left > self._nearest + self.handle.step:
            self._sent = None
        return self._sent is not None

    def rest(self) -> None:
        """Its motor is not on its way, if it can have set off."""
        if self._has_set_off:
            self._sent = None

    @property
    def _has_set_off(self) -> bool:
        return time.monotonic() - self.sent_at >= _SETTING_OFF

    def put(self, at: float) -> None:
        """Put it where the motor is."""
        handle = self.handle
        if not handle.min <= at <= handle.max:
            handle.min, handle.max = min(handle.min, at), max(handle.max, at)
        self._put, self._typing = at, False
        if handle.value != at:
            self._last = handle.value = at

    @property
    def waits(self) -> bool:
        """Whether it is where somebody has put it whose request was not done yet."""
        known = self.handle.value in (self._put, self.done) or self._typing
        return not known and time.time() - self.handle.update_timestamp < _PATIENCE


def _step(reach: float) -> float:
    """The step of a slider that reaches so far."""
    return reach / (max(10, min(_STEPS, int(reach / _FINEST))) + _LEFT)


def by_hand(position: float, last: float, low: float, step: float) -> bool:
    """Whether a hand can have brought a slider to a position: steps from its end or from where it was.

    Args:
        position: Where it is.
        last: Where it was.
        low: Its lower end.
        step: Its step, in which no number of a few digits is counted.
    """
    dragged, pressed = (position - low) / step, (position - last) / step
    rounding = 0.6 * _ROUNDED / step
    if abs(dragged - round(dragged)) <= 1e-3 + rounding:
        return True
    keys = round(pressed)  # at each of them the browser rounds
    near = 1e-3 + (1 + abs(keys)) * rounding
    return abs(keys) <= _MOST_KEYS and abs(pressed - keys) <= near

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Sliders of motors: hands move them, keys beside them do not, and others may move the motors."""

from __future__ import annotations

import asyncio
import math
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cpr_core
from cpr_core.viewing import motor_sliders
from cpr_core.viewing.motor_sliders import MotorSliders, _step, by_hand

#: Lower end and reach of sliders: a motor that turns, a feed, a small stage, a geared motor.
RANGES = [(-0.55, 6.35), (0.43, 0.05), (0.0, 0.002), (-314.0, 628.0)]


@given(
    of=st.sampled_from(RANGES),
    k=st.integers(0, 2000),
    part=st.floats(0.0, 1.0),
    moved=st.integers(-20, 20),
)
def test_hands_move_sliders_by_steps(of, k, part, moved):
    """From their end when dragged, from where they are by keys; the browser rounds."""
    low, reach = of
    step = _step(reach)
    last = low + part * reach
    assert by_hand(round(low + k * step, 7), last, low, step)
    pressed = last
    for _ in range(abs(moved)):
        pressed = round(pressed + np.copysign(step, moved), 7)
    assert by_hand(pressed, last, low, step)


@pytest.mark.parametrize(("low", "reach"), RANGES)
def test_a_hand_can_come_to_both_ends(low, reach):
    """As the browser has it: the nearest step from the lower end, and no farther than the upper one."""
    step = _step(reach)
    assert min(low + round(reach / step) * step, low + reach) == low + reach


@pytest.mark.parametrize(("low", "reach"), RANGES)
def test_numbers_that_are_typed_are_no_steps(low, reach):
    """Of hundreds with few digits some may be; beside where the slider is they do no harm."""
    step, digits = _step(reach), round(2.5 - np.log10(reach))
    numbers = np.unique(np.round(np.linspace(low, low + reach, 400), digits))
    last = low + 0.41 * reach
    far = [x for x in numbers if low < x < low + reach and abs(x - last) > 0.02 * reach]
    taken = [x for x in far if by_hand(x, last, low, step)]
    assert len(far) > 100 and len(taken) <= 0.02 * len(far), taken


def in_own_loop(work):
    """Run a coroutine in a thread: a browser of other tests has a loop in this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, work).result()


class Slider:
    """As that of the browser, which tells what a hand or a key does."""

    def __init__(self, label, low, high, step, value):
        self.min, self.max, self.step, self.value = low, high, step, value
        self.update_timestamp = 0.0

    def on_update(self, tell):
        self.tell = tell

    async def hear(self, value):
        self.value, self.update_timestamp = value, time.time()
        await self.tell(SimpleNamespace(client_id=1, target=self))


@pytest.fixture
def sliders():
    moved, typed = [], []
    made = MotorSliders(
        SimpleNamespace(add_slider=Slider),
        cpr_core.load_robot("rfrfr"),
        [2.59, 0.55],
        lambda *asked: moved.append(asked),
        typed.append,
    )
    return made, made._sliders[0].handle, moved, typed


def test_nothing_that_is_typed_is_asked_for_and_it_is_put_back(sliders):
    made, slider, moved, typed = sliders

    async def type_a_number():
        await asyncio.gather(*(slider.hear(value) for value in (2.0, 2.7, 2.7, slider.max, 5.0)))
        await asyncio.gather(slider.hear(2.0), slider.hear(2.0 + slider.step))  # keys in the box

    in_own_loop(type_a_number())
    assert not moved and set(typed) == {"motor1"}
    assert slider.value == 2.59
    made.show([2.5, 0.55])
    assert slider.value == 2.5


def test_a_hand_may_go_to_an_end_but_not_jump_there(sliders):
    _, slider, moved, typed = sliders
    in_own_loop(slider.hear(slider.min))
    assert not moved and typed == ["motor1"] and slider.value == 2.59
    way = [slider.min + 500 * slider.step, slider.min]

    async def drag():
        for value in way:
            await slider.hear(value)

    in_own_loop(drag())
    assert moved == [(0, value) for value in way] and typed == ["motor1"]
    in_own_loop(slider.hear(2.7))
    assert len(moved) == 2 and slider.value == slider.min  # where the hand had left it


def test_no_number_is_not_typed(sliders):
    """Whoever takes it says so."""
    _, slider, moved, typed = sliders
    in_own_loop(slider.hear(math.nan))
    assert len(moved) == 1 and math.isnan(moved[0][1]) and not typed


def test_what_is_shown_meanwhile_is_where_typed_numbers_give_way_to(sliders):
    """Else a slider went back to where a hand had left it before, and the next key led there."""
    made, slider, moved, _ = sliders
    there = slider.min + 900 * slider.step

    async def go_home_meanwhile():
        await slider.hear(there)
        made.done(0, there)
        hearing = asyncio.create_task(slider.hear(2.7))
        await asyncio.sleep(0.01)
        made.show([2.59, 0.55])
        await hearing
        await slider.hear(2.59 + slider.step)

    in_own_loop(go_home_meanwhile())
    assert moved == [(0, there), (0, 2.59 + slider.step)]


def test_a_slow_hand_comes_to_the_end_too(sliders):
    made, slider, moved, typed = sliders
    near = slider.max - 20 * slider.step
    made.show([near, 0.55])
    in_own_loop(slider.hear(slider.max))
    assert moved == [(0, slider.max)] and not typed


def test_what_was_typed_before_sliders_were_forgotten_is_not_put_back_after(sliders):
    made, slider, moved, _ = sliders

    async def forget_meanwhile():
        hearing = asyncio.create_task(slider.hear(2.7))
        await asyncio.sleep(0.01)
        made.forget()
        made.show([1.0, 0.55])
        await hearing

    in_own_loop(forget_meanwhile())
    assert not moved and slider.value == 1.0


@pytest.fixture
def at_once(monkeypatch):
    """Motors set off at once to where they are sent."""
    monkeypatch.setattr(motor_sliders, "_SETTING_OFF", 0.0)


@pytest.mark.usefixtures("at_once")
def test_a_motor_that_others_move_takes_its_slider_with_it(sliders):
    """Else the next key sent it back to where the hand had sent it before."""
    made, slider, _, _ = sliders
    sent = slider.min + 900 * slider.step
    in_own_loop(slider.hear(sent))
    made.expect(0, sent)
    for at in (2.59, 2.3, 2.3, sent + 0.4 * slider.step, sent):  # on its way, and there
        made.show([at, 0.55])
        assert slider.value == sent
    made.show([sent + 0.9 * slider.step, 0.6])
    assert slider.value == sent
    assert made._sliders[1].handle.value == 0.6
    for at in (sent + 1.1 * slider.step, 2.0, sent, 2.59):
        made.show([at, 0.55])
        assert slider.value == at


@pytest.mark.usefixtures("at_once")
def test_so_does_one_that_never_came(sliders):
    """Halted on its way, and then moved by others."""
    made, slider, _, _ = sliders
    made.expect(0, 3.0)
    for at in (2.59, 2.7, 2.8, 2.8, 2.8 - 0.9 * slider.step):
        made.show([at, 0.55])
        assert slider.value == 3.0
    for at in (2.6, 2.9, 3.0):
        made.show([at, 0.55])
        assert slider.value == at


def test_so_does_one_of_a_robot_that_goes_nowhere(sliders, monkeypatch):
    """Its setpoint was forgotten on the way, by a pause say: the next key sent it on to there."""
    made, slider, _, _ = sliders
    made.expect(0, 3.0)
    made.rest()  # told before the robot knew
    made.show([2.8, 0.55])
    assert slider.value == 3.0
    monkeypatch.setattr(motor_sliders, "_SETTING_OFF", 0.0)
    made.show([2.8, 0.55])
    assert slider.value == 3.0
    made.rest()
    made.show([2.8, 0.55])
    assert slider.value == 2.8


def test_a_motor_sets_off_when_its_request_has_left(sliders, monkeypatch):
    """It waits until somebody hears it."""
    made, slider, _, _ = sliders
    monkeypatch.setattr(motor_sliders.time, "monotonic", lambda: now)
    now = 10.0
    made.expect(0, 3.0)
    now = 20.0
    made.sent(0)
    now = 20.4
    made.rest()
    made.show([2.6, 0.55])
    assert slider.value == 3.0


def test_a_motor_that_goes_on_to_where_it_was_sent_before_leaves_the_hand_its_slider(sliders):
    """A hand that turned back lost it to the next picture."""
    made, slider, moved, _ = sliders
    back = slider.min + 900 * slider.step
    made.expect(0, back)
    for at in (back - 0.01, back + 0.02, back + 0.03):
        made.show([at, 0.55])
        assert slider.value == back and not moved


def test_a_motor_that_is_sent_beyond_its_slider_widens_it(sliders):
    """A motor without limits: the next key sent it back to where the slider had ended."""
    made, slider, moved, _ = sliders
    far = slider.max + 1.0
    made.expect(0, far)
    assert slider.value == slider.max == far
    made.show([2.59, 0.55])
    assert slider.value == far
    in_own_loop(slider.hear(far - slider.step))
    assert moved == [(0, far - slider.step)]
    low = slider.min - 1.0
    made.expect(0, low)
    assert slider.value == slider.min == low


def test_a_number_that_is_typed_wrongly_spoils_no_slider(sliders):
    """A million turns were a pixel of it, though the node refused them."""
    made, slider, moved, _ = sliders
    ends = slider.min, slider.max
    made.expect(0, 1e6)
    made.show([2.6, 0.55])
    assert (slider.min, slider.max, slider.value) == (*ends, 2.6) and not moved


def test_a_motor_that_is_sent_beyond_its_limits_is_expected_at_its_end():
    made = MotorSliders(
        SimpleNamespace(add_slider=Slider),
        cpr_core.load_robot("gough_stewart"),
        cpr_core.solve_home(cpr_core.load_robot("gough_stewart")).motors.tolist(),
        lambda *asked: None,
        lambda name: None,
    )
    slider, limits = made._sliders[0].handle, made._sliders[0]._limits
    assert np.isfinite(limits).all()
    made.expect(0, limits[1] + 1.0)
    assert slider.value == slider.max == limits[1]


@pytest.mark.parametrize(
    ("moves", "limits", "at", "low", "high"),
    [
        ("rad", (-math.inf, math.inf), 1.0, 1.0 - math.pi, 1.0 + math.pi),
        ("m", (-math.inf, math.inf), 1.0, 0.9, 1.1),
        ("m", (-math.inf, 0.5), 0.3, 0.2, 0.5),
        ("m", (0.1, 0.5), 0.6, 0.1, 0.6),
        ("m", (0.1, 0.5), 0.05, 0.05, 0.5),
        ("m", (0.1, 0.1), 0.1, 0.1, 0.1),
    ],
)
def test_a_slider_reaches_to_its_limits_and_to_its_motor(moves, limits, at, low, high):
    """Without limits half a turn, or half a length of the robot; a browser takes no step of 0."""
    motor = SimpleNamespace(
        name="motor1",
        unit=moves,
        moves=moves,
        limits=SimpleNamespace(lower=limits[0], upper=limits[1]),
    )
    robot = SimpleNamespace(
        description=SimpleNamespace(motors=[motor]), motor_units=[1.0 if moves == "rad" else 0.2]
    )
    gui = SimpleNamespace(add_slider=Slider)
    made = MotorSliders(gui, robot, [at], lambda *_: None, lambda *_: None)
    slider = made._sliders[0].handle
    assert (slider.min, slider.max, slider.value) == (pytest.approx(low), pytest.approx(high), at)
    assert slider.step > 0.0


def test_a_slider_stays_where_a_hand_has_put_it_until_that_is_done(sliders):
    made, slider, moved, _ = sliders
    asked = slider.min + 700 * slider.step
    for _ in range(2):  # said again, it is not asked again
        in_own_loop(slider.hear(asked))
        assert moved == [(0, asked)]
    slider.update_timestamp -= 4.0
    made.show([2.5, 0.55])  # of something that was asked before
    assert slider.value == asked
    made.done(0, asked)
    made.show([2.5, 0.55], held=0)  # it was refused: who holds it sees what is asked
    assert slider.value == asked
    made.show([2.5, 0.55])
    assert slider.value == 2.5


def test_a_slider_whose_request_is_never_done_goes_back(sliders):
    made, slider, _, _ = sliders
    in_own_loop(slider.hear(slider.min + 700 * slider.step))
    slider.update_timestamp -= 6.0
    made.show([2.5, 0.55])
    assert slider.value == 2.5

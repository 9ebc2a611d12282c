# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the page of a node shows and takes, without ROS and without a browser."""

import asyncio
import math
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.drive import robot

import cpr_core
from cpr_core.drawing.robot_lines import equilibrium_lines
from cpr_core.model.assessment import Threshold
from cpr_core.viewing import motor_sliders
from cpr_core.viewing.bars import bar
from cpr_ros.page.node_page import NodePage
from cpr_ros.page.typed_motors import TypedMotors

ROBOT = robot("rfrfr")
BARS = [bar("margin", 0.5, Threshold(0.2, 0.1))]


@pytest.fixture(scope="module")
def home():
    return cpr_core.solve_home(ROBOT)


@pytest.fixture
def page(home):
    made = NodePage("cpr_node", "127.0.0.1", 0)
    made.show_robot(ROBOT, home.motors.tolist())
    yield made
    made.close()


def slider(page):
    return page._sliders._sliders[0].handle


def test_a_node_that_is_gone_takes_with_it_all_that_was_known(page):
    page._control.take()
    page.show_presence("there")
    assert (page._take.visible, page._give.visible) == (False, True)
    page.show_stability(1, "near", BARS, under_way=False)
    page._slid(0, 3.0)
    page.show_presence("gone")
    assert not page.in_control and page.take_asked() == {}
    assert (page._take.visible, page._give.visible) == (True, False)
    assert page._words.content == "control was given back: the node is gone"
    assert page._action_bar.color == "gray"
    assert page._action_text.content == "nothing is known of the robot"
    (label, filled), *others = page._bars._rows
    assert (label.content, filled.value, filled.color) == ("margin: none", 100.0, "gray")
    assert others == []
    page.say("as_before")
    page.show_presence("gone")  # nobody is in control any more
    assert page._words.content == "as\\_before"


@pytest.mark.parametrize(
    ("action", "word", "color"), [(0, "NONE", "green"), (1, "SLOW", "yellow"), (2, "HALT", "red")]
)
def test_an_action_has_its_word_and_color(page, action, word, color):
    page.show_stability(action, "why_so", BARS, under_way=False)
    assert page._action_text.content == f"**action {word}**: why\\_so"
    assert page._action_bar.color == color


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_what_is_no_number_is_not_sent(page, number):
    page._control.take()
    page._slid(0, number)
    assert page.take_asked() == {}
    assert page._words.content == f"nothing was sent: expected a finite number, got {number}"


def test_a_slider_that_is_moved_without_control_goes_back_at_once(page, home):
    slider(page).value = 3.0
    page._slid(0, 3.0)
    page.show_motors(home.motors.tolist())
    assert slider(page).value == home.motors[0]
    assert page.take_asked() == {}


def test_a_motor_has_time_to_set_off_from_when_its_setpoint_was_sent(page, home, monkeypatch):
    """A page may wait with it until its publisher is connected."""
    now, motors = 10.0, home.motors.tolist()
    monkeypatch.setattr(motor_sliders.time, "monotonic", lambda: now)
    page._control.take()
    page.show_motors(motors)
    page._slid(0, 3.0)
    now = 20.0
    assert page.take_asked() == {0: 3.0}
    for now, expected in ((20.4, 3.0), (20.6, motors[0])):  # noqa: B007
        page.show_stability(0, "", BARS, under_way=False)
        page.show_motors(motors)
        assert slider(page).value == expected


def test_nothing_of_a_robot_is_left_when_another_comes(page, home, monkeypatch):
    """Nor is a number put back that was typed beside a slider which is no more."""
    monkeypatch.setattr(motor_sliders, "_SETTLED", 0.0)
    page.show_lines(equilibrium_lines(home))
    before, scene = slider(page), page._server.scene._handle_from_node_name
    assert any(name.startswith("/robot") for name in scene)

    async def typed():
        hearing = asyncio.create_task(page._sliders._sliders[0]._hear(2.7))
        await asyncio.sleep(0.0)
        page.show_no_robot()
        await hearing

    with ThreadPoolExecutor(1) as thread:  # a browser of other tests has a loop in this one
        thread.submit(asyncio.run, typed()).result()
    assert not any(name.startswith("/robot") for name in scene)
    assert before._impl.removed
    page.show_motors(home.motors.tolist())
    page.show_lines(equilibrium_lines(home))
    assert not any(name.startswith("/robot") for name in scene)


def test_the_camera_is_aimed_once_for_every_robot(page, home):
    lines, camera = equilibrium_lines(home), page._server.initial_camera
    page.show_lines(replace(lines, rods=(), shades=()))  # nothing to aim at
    page.show_lines(lines)
    camera.position = nowhere = np.array([9.0, 9.0, 9.0])
    page.show_lines(lines)  # whoever looks has turned it meanwhile
    np.testing.assert_array_equal(camera.position, nowhere)
    page.show_no_robot()
    page.show_robot(ROBOT, home.motors.tolist())
    page.show_lines(lines)
    assert not np.array_equal(camera.position, nowhere)


def test_others_and_the_last_minute_are_those_of_now(page):
    page.show_others([])
    assert page._others.content.endswith("nobody")
    page.show_others(["/a", "/b_c"])
    assert page._others.content.endswith("/a, /b\\_c")
    for number in (1.0, 2.0):
        page.show_last_minute((np.array([-1.0, 0.0]), np.full(2, number)), ("margin",))
        np.testing.assert_array_equal(page._plot.data[1], number)


class Field:
    """A field or a button of a page, which are used as a browser would."""

    def __init__(self, label, value="", hint=""):
        self.label, self.value, self.there = label, value, True

    def on_update(self, heard):
        self.used = heard

    on_click = on_update

    def remove(self):
        self.there = False

    def use(self):
        with ThreadPoolExecutor(1) as thread:  # a browser of other tests has a loop in this one
            thread.submit(asyncio.run, self.used(None)).result()


def test_a_button_sends_what_is_to_be_read_on_it():
    made, asked, refused = [], [], []

    def add(*arguments, **options):
        made.append(Field(*arguments, **options))
        return made[-1]

    gui = SimpleNamespace(add_text=add, add_button=add)
    TypedMotors(gui, nullcontext(), ROBOT, [2.5, -1e-17], asked.append, refused.append)
    field, first = made
    assert first.label == "send 2.5 -1e-17"
    for text, label in (("2.123456 -0", "send 2.1235 0"), ("2.5", "nothing to send")):
        field.value = text
        field.use()
        made[-1].use()
        assert made[-1].label == label
        assert [each.there for each in made[1:]] == [False] * (len(made) - 2) + [True]
    assert asked == [[2.123456, 0.0]]
    assert len(refused) == 1 and "expected 2 numbers" in str(refused[0])
    first.use()  # pressed before it was taken away
    assert asked[-1] == [2.5, -1e-17]


def test_bars_follow_what_they_show(page):
    for margin in (0.5, 0.47, 0.15):
        shown = bar("margin", margin, Threshold(0.2, 0.1))
        page.show_stability(0, "", [shown], under_way=False)
        [(label, filled)] = page._bars._rows
        assert label.content == shown.text
        assert filled.value == pytest.approx(100.0 * shown.filled, abs=0.06)

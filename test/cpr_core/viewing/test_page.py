# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a robot in a real browser."""

import threading

import numpy as np
import pytest
from helpers.browser import TIMEOUT, Looker, settled, type_into
from helpers.tracked_robots import tracked

import cpr_core
from cpr_core.drawing.robot_lines import equilibrium_lines, segments
from cpr_core.lie import quaternion_from_rotation, rotation_exp
from cpr_core.viewing.typed import numbers_as_text

pytestmark = pytest.mark.waits(seconds=35)


@pytest.fixture(scope="module")
def robot():
    return cpr_core.load_robot("six_rfs")


@pytest.fixture(scope="module")
def opened(robot, browser):
    """A page and somebody who looks at it: loading takes seconds."""
    page = cpr_core.view(robot)
    looker = Looker(browser, page.address, "motor6")
    looker.until(lambda: looker.visible("/robot/legs"))
    looker.switch("names")  # out of the way of the mouse
    yield page, looker
    looker.page.close()
    page.close()


@pytest.fixture
def page(opened, robot):
    """At home, nothing refused."""
    page = opened[0]
    page.show(cpr_core.solve_home(robot))
    assert page.wait()
    return page


@pytest.fixture
def looker(opened, page):
    settled(*opened)
    return opened[1]


#: Radius of the rings of the handle [m].
RING = 0.3 * 0.65


def type_numbers(page, looker, kind, text):
    equilibrium = page.equilibrium
    values = {
        "motors": equilibrium.motors,
        "pose": equilibrium.pose,
        "wrench": equilibrium.loads.wrench_world,
    }[kind]
    if looker.field("type").input_value() != kind:
        looker.choose("type", kind)
        # The page fills the field with where the robot is.
        looker.until(lambda: looker.field("numbers").input_value() == numbers_as_text(values))
    type_into(page, looker, "numbers", text)
    looker.press("go there")


def test_it_loads_without_complaints_and_asks_nobody_else(page, looker):
    settled(page, looker)
    looker.picture("home")
    assert looker.complaints == []
    assert len(looker.requests) >= 2
    own = page.address.removeprefix("http://")
    for url in looker.requests:
        assert url.removeprefix("blob:").split("://")[1].split("/")[0] == own, url


def test_a_slider_moves_the_robot(robot, page, looker):
    home = page.equilibrium
    thumb = looker.page.get_by_role("slider").nth(2)
    low, high = (float(thumb.get_attribute(f"aria-value{end}")) for end in ("min", "max"))
    step = (high - low) / 2000
    thumb.focus()
    for _ in range(40):
        thumb.press("ArrowRight")
    # Every press arrives; what still came after this would move the robot on while it is looked at.
    looker.until(lambda: page.equilibrium.motors[2] > home.motors[2] + max(0.1, 39.4 * step))
    settled(page, looker)
    reached = page.equilibrium.motors
    np.testing.assert_array_equal(np.delete(reached, 2), np.delete(home.motors, 2))
    expected = cpr_core.solve_forward(robot, reached)
    np.testing.assert_allclose(
        looker.position("/platform"), expected.platform_position, rtol=0, atol=1e-9
    )
    quaternion = looker.quaternion("/platform")
    assert abs(quaternion @ expected.platform_quaternion) == pytest.approx(1.0, abs=1e-9)
    # Lines go to the browser in single precision.
    lines = np.concatenate([segments(leg) for leg in equilibrium_lines(expected).rods])
    np.testing.assert_allclose(looker.pieces("/robot/legs"), lines, rtol=0, atol=2e-7)
    looker.picture("slider")


def test_what_is_typed_beside_a_slider_moves_nothing(page, looker):
    """Every key would: who types 2.70 would ask for 2 first."""
    home = page.equilibrium
    thumb = looker.page.get_by_role("slider").nth(1)
    box = looker.page.locator("input.mantine-NumberInput-input").nth(1)
    shown = float(thumb.get_attribute("aria-valuenow"))
    box.click()
    box.press("Control+a")
    box.press_sequentially("2.70", delay=50)
    looker.page.get_by_text("the box beside a slider only shows").wait_for()
    looker.until(lambda: float(thumb.get_attribute("aria-valuenow")) == shown)
    settled(page, looker)
    assert page.equilibrium is home


def test_an_end_is_come_to_on_the_way(page, looker):
    """The first digit of a number may be there too: a jump is put back, and nothing comes later."""
    home = page.equilibrium
    thumb = looker.page.get_by_role("slider").nth(2)
    shown = float(thumb.get_attribute("aria-valuenow"))
    thumb.focus()
    thumb.press("End")
    looker.page.get_by_text("the box beside a slider only shows").wait_for()
    looker.until(lambda: float(thumb.get_attribute("aria-valuenow")) == shown)
    settled(page, looker)
    assert page.equilibrium is home
    thumb.hover()  # once it stands still, which it was put back to
    box = thumb.bounding_box()
    mouse, x, y = looker.page.mouse, box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    mouse.move(x, y)
    mouse.down()
    slider = page._controls._sliders._sliders[2].handle
    pixels, travelled = np.inf, 0.0  # that are left to the end, as far as moves have told
    while slider.value > slider.min:
        # Not far in the last move: on a busy page it comes late, and is no part of a gesture any more.
        step, before = (40.0 if pixels > 45.0 else max(1.0, 0.5 * pixels)), slider.value
        x, travelled = x - step, travelled + step
        mouse.move(x, y)
        # A busy page would tell of several moves as one, which is a jump.
        looker.until(lambda before=before: slider.value < before)
        pixels = travelled * (slider.value - slider.min) / (home.motors[2] - slider.value)
    mouse.up()
    settled(page, looker)
    assert page.equilibrium.motors[2] < home.motors[2]


def test_a_slider_does_not_go_back_while_its_request_waits(page, looker):
    """Else whoever moves it on, moves it on from there."""
    number, home, gui = 2, page.equilibrium.motors, page.server.gui
    thumb = looker.page.get_by_role("slider").nth(number)
    thumb.evaluate(
        """thumb => { window.passed = [];
        const note = () => window.passed.push(Number(thumb.getAttribute('aria-valuenow')));
        note();
        new MutationObserver(note).observe(thumb, {attributeFilter: ['aria-valuenow']}); }"""
    )
    inputs = gui._gui_input_handle_from_uuid.values()
    name = f"motor{number + 1} "
    slider = next(each for each in inputs if getattr(each, "label", "").startswith(name))
    first, shown, second = (threading.Event() for _ in range(3))

    def keep_it_waiting(_):
        shown.set()  # what was done before it is
        assert second.wait(TIMEOUT)

    page.do("first", lambda _: first.wait(TIMEOUT))
    page.do("second", keep_it_waiting)
    thumb.focus()
    for _ in range(10):
        thumb.press("ArrowRight")
    looker.until(lambda: slider.value > home[number] + 9.5 * slider.step)
    first.set()
    assert shown.wait(TIMEOUT)
    mark = gui.add_markdown("shown by now")  # the browser hears of one thing after the other
    looker.page.get_by_text("shown by now").wait_for()
    mark.remove()
    second.set()
    settled(page, looker)
    passed = looker.page.evaluate("window.passed")
    assert len(passed) > 5
    assert np.all(np.diff(passed) >= 0.0), passed
    assert page.equilibrium.motors[number] == slider.value == pytest.approx(passed[-1])


def test_dragging_the_platform_runs_the_inverse(page, looker):
    home = page.equilibrium
    axis = home.platform_rotation[:, 0]
    grip = home.platform_position + 0.27 * axis  # the head of the arrow
    looker.drag(grip, grip + 0.08 * axis)
    looker.until(
        lambda: np.linalg.norm(page.equilibrium.platform_position - home.platform_position) > 0.03,
        lambda: f"the platform went from {home.pose} to {page.equilibrium.pose}",
    )
    settled(page, looker)
    looker.picture("dragged")
    moved = page.equilibrium.platform_position - home.platform_position
    assert moved @ axis == pytest.approx(np.linalg.norm(moved), rel=1e-3)
    assert np.abs(page.equilibrium.motors - home.motors).max() > 0.01
    assert not looker.visible("/ghost/edge")


def test_a_handle_that_is_hidden_while_it_is_held_follows_the_robot_afterwards(page, looker):
    """Somebody else has hidden it: the browser that held it does not tell that it lets go."""
    home = page.equilibrium
    inputs = page.server.gui._gui_input_handle_from_uuid.values()
    handles = next(part for part in inputs if getattr(part, "label", "") == "handles")
    axis = home.platform_rotation[:, 0]
    grip = home.platform_position + 0.27 * axis
    looker.hold(grip, grip + 0.08 * axis)
    looker.until(lambda: page.equilibrium is not home)
    handles.value = False
    looker.until(lambda: not looker.visible("/handle"))
    looker.page.mouse.up()
    handles.value = True
    looker.until(lambda: looker.visible("/handle"))
    page.show(home)
    settled(page, looker)


def test_past_a_fold_there_is_a_ghost_and_a_reason(page, looker):
    home = page.equilibrium
    axis = home.platform_rotation[:, 0]
    grip = home.platform_position + 0.27 * axis  # the head of the arrow
    looker.drag(grip, grip + 0.6 * axis)
    looker.page.get_by_text("Refused (fold)").wait_for()
    looker.until(lambda: looker.visible("/ghost/edge"))
    settled(page, looker)
    looker.picture("refused")
    looker.until(lambda: "not reached from the start, the branch" in looker.text())
    assert page.equilibrium.margin > 0.0
    # The handle has gone back to the robot (settled); home clears what was refused.
    np.testing.assert_allclose(
        looker.position("/handle"), page.equilibrium.platform_position, atol=1e-9
    )
    looker.press("home")
    looker.until(lambda: not looker.visible("/ghost/edge"))
    settled(page, looker)
    np.testing.assert_allclose(page.equilibrium.motors, home.motors, atol=1e-9)


@pytest.mark.parametrize(
    ("kind", "text", "said"),
    [
        ("motors", "nan nan nan nan nan nan", "all finite"),
        ("motors", "1e300 5 5 5 5 5", "looks like degrees"),
        ("motors", "", "expected 6 numbers"),
        ("motors", "five", "expected 6 numbers"),
        ("pose", "1e300 0 0 1 0 0 0", "looks like millimetres"),
        ("pose", "0 0 1 0 0 0 0", "unit"),
        ("wrench", "0 0 0 inf 0 0", "all finite"),
    ],
)
def test_absurd_numbers_change_nothing_and_are_told(page, looker, kind, text, said):
    home = page.equilibrium
    type_numbers(page, looker, kind, text)
    looker.page.get_by_text("Refused").wait_for()
    assert page.wait()
    looker.until(lambda: said in looker.text())  # "Refused" may be what the one before was told
    assert page.equilibrium is home
    assert looker.field("numbers").input_value() == text  # to be mended


def test_two_pages_see_the_same_robot(page, looker, browser):
    other = Looker(browser, page.address, "motor6")
    type_numbers(page, looker, "motors", "6.0 5.7 5.8 5.4 5.7 5.2")
    looker.until(lambda: page.equilibrium.motors[0] == 6.0)
    for viewer in (looker, other):
        settled(page, viewer)
    np.testing.assert_array_equal(looker.pieces("/robot/legs"), other.pieces("/robot/legs"))
    for viewer in (looker, other):  # numbers come after the scene
        viewer.until(
            lambda viewer=viewer: viewer.field("numbers").input_value().startswith("6 5.7")
        )
    other.page.close()


def test_gravity_modes_and_undo(page, looker):
    home = page.equilibrium
    looker.switch("gravity")
    looker.until(lambda: np.any(page.equilibrium.loads.gravity))
    assert page.wait()
    sunk = page.equilibrium.platform_position
    assert sunk[2] < home.platform_position[2]
    type_into(page, looker, "strain modes", "7")
    looker.press("choose modes")
    looker.until(lambda: page.equilibrium.robot.state_size > home.robot.state_size)
    settled(page, looker)
    assert np.linalg.norm(page.equilibrium.platform_position - sunk) < 1e-3
    for _ in range(2):
        before = page.equilibrium
        looker.press("undo")
        looker.until(lambda before=before: page.equilibrium is not before)
    settled(page, looker)
    assert page.equilibrium is home
    looker.until(lambda: not looker.field("gravity").is_checked())


def test_turning_the_platform_runs_the_inverse_too(page, looker):
    home = page.equilibrium
    across = home.platform_rotation[:, [0, 2]]  # the ring that faces the camera

    def on_ring(angle):
        return home.platform_position + across @ [
            RING * np.cos(angle),
            RING * np.sin(angle),
        ]

    looker.drag(on_ring(0.6), on_ring(0.75))
    looker.until(lambda: page.equilibrium is not home)
    settled(page, looker)
    looker.picture("turned")
    turned = page.equilibrium
    turn = home.platform_rotation.T @ turned.platform_rotation
    np.testing.assert_allclose(turned.platform_position, home.platform_position, atol=1e-9)
    assert np.abs(turn - np.eye(3)).max() > 0.03
    assert turn[1, 1] == pytest.approx(1.0, abs=1e-9)


def test_the_force_is_dragged_by_its_tip(page, looker):
    home = page.equilibrium
    tip = looker.position("/force/tip")
    grip = tip + 0.115 * np.eye(3)[0]
    looker.drag(grip, grip + 0.12 * np.eye(3)[0])
    looker.until(lambda: np.any(page.equilibrium.loads.wrench_world))
    settled(page, looker)
    looker.picture("force")
    force = page.equilibrium.loads.wrench_world[3:]
    assert force[0] == pytest.approx(np.linalg.norm(force), rel=1e-6)
    assert not np.any(page.equilibrium.loads.wrench_world[:3])
    np.testing.assert_array_equal(page.equilibrium.motors, home.motors)
    assert page.equilibrium.platform_position[0] > home.platform_position[0]
    looker.until(lambda: looker.visible("/force/arrow"))


def test_a_tracker_stands_where_it_is_and_its_marker_on_the_platform(browser):
    """Nothing is there of a robot without one."""
    frame, marker = [0.4, -0.6, 1.2, 3.0, 0.3, -0.4], [0.02, -0.03, 0.04, 0.3, 1.1, -0.2]
    page = cpr_core.view(tracked("three_rfs", frame, marker))
    looker = Looker(browser, page.address, "motor3")
    try:
        looker.until(lambda: looker.visible("/tracker") and looker.visible("/platform/marker"))
        for node, numbers in (("/tracker", frame), ("/platform/marker", marker)):
            # What is below the platform is where it is in the platform.
            np.testing.assert_allclose(looker.position(node), numbers[:3], rtol=0, atol=1e-6)
            turn = quaternion_from_rotation(rotation_exp(numbers[3:]))
            assert abs(looker.quaternion(node) @ turn) == pytest.approx(1.0, abs=1e-9)
        looker.picture("tracker")
    finally:
        looker.page.close()
        page.close()

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the page is made of, without a browser."""

import asyncio
import io
import math
import threading
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from PIL import Image

import cpr_core
from cpr_core.lie import quaternion_from_rotation, rotation_exp
from cpr_core.model.assessment import DEFAULT_THRESHOLDS, Threshold
from cpr_core.viewing import bars as of_bars
from cpr_core.viewing.background import Background
from cpr_core.viewing.bars import bar, bars
from cpr_core.viewing.dragged import Grip
from cpr_core.viewing.equilibria_tab import EquilibriaTab, search
from cpr_core.viewing.handled_robot import HandledRobot
from cpr_core.viewing.mailbox import Mailbox
from cpr_core.viewing.map_layer import go_to_cell, read_layer
from cpr_core.viewing.recorded import as_gif, as_yaml
from cpr_core.viewing.sent import put
from cpr_core.viewing.server import close_server, open_server
from cpr_core.viewing.status_panel import as_plain, status_text
from cpr_core.viewing.typed import numbers_as_text, typed_numbers
from cpr_core.viewing.way_tab import frame_at
from cpr_core.workspace import map_workspace, pose_grid
from cpr_ros.settings.parameter_table import THRESHOLDS


@pytest.fixture(scope="module")
def planar():
    return cpr_core.load_robot("rfrfr")


@pytest.mark.parametrize(
    ("value", "filled", "level"),
    [
        (0.2, 0.5, "fine"),
        (0.5, 0.8, "fine"),
        (0.15, 1 / 3, "slow"),
        (0.1, 0.0, "stop"),
        (-3.0, 0.0, "stop"),
        (math.inf, 1.0, "fine"),
        (math.nan, 0.0, "stop"),
    ],
)
def test_a_bar_is_half_full_at_its_warning_and_empty_at_its_stop(value, filled, level):
    found = bar("margin", value, Threshold(0.2, 0.1))
    assert found.filled == pytest.approx(filled, abs=1e-9)
    assert found.level == level
    assert "slow 0.2, stop 0.1" in found.text


def test_everywhere_between_stop_and_warning_a_robot_is_slow():
    threshold = Threshold(0.2, 0.1)
    for value in np.linspace(0.1, 0.2, 50)[1:-1]:
        found = bar("margin", value, threshold)
        assert found.level == "slow"
        assert 0.0 < found.filled < 0.5


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.5, "margin 0.5 (slow 0.2, stop 0.1)"),
        (1.0 / 3.0, "margin 0.333 (slow 0.2, stop 0.1)"),
        (0.0999999, "margin 0.0999999 (slow 0.2, stop 0.1)"),
        (float("nan"), "margin nan (slow 0.2, stop 0.1)"),
    ],
)
def test_a_number_below_a_threshold_looks_so(value, text):
    assert bar("margin", value, Threshold(0.2, 0.1)).text == text


def test_bars_are_those_of_measures_that_the_robot_has(planar):
    names = [found.name for found in bars(cpr_core.solve_home(planar))]
    assert names[:3] == ["margin", "forward singularity", "inverse singularity"]
    limited = cpr_core.load_robot("delta")
    assert "motor range" in [found.name for found in bars(cpr_core.solve_home(limited))]


def test_a_measure_that_is_not_known_is_shown_as_a_stop(monkeypatch):
    values = {"margin": math.nan, "motor_range": 0.5}
    known = SimpleNamespace(value=lambda name: values.get(name, math.inf))
    monkeypatch.setattr(of_bars, "Assessment", lambda _: known)
    assert {each.name: each.level for each in bars(None)} == {
        "margin": "stop",
        "motor range": "fine",
    }


def test_the_node_has_the_thresholds_of_the_core():
    of_node = {name: Threshold(each.warning, each.stop) for name, each in THRESHOLDS.items()}
    assert of_node == DEFAULT_THRESHOLDS


def test_a_handle_is_held_until_the_last_hand_lets_it_go():
    grip = Grip()
    grip.hear(1, "start")
    grip.hear(2, "update")
    grip.hear(1, "end")
    assert grip.held
    grip.hear(2, "end")
    assert not grip.held
    assert grip.hear(1, "update")
    grip.offer(False)
    assert not grip.held
    assert not grip.hear(1, "update")  # it was on its way
    grip.offer(True)
    assert not grip.held
    assert grip.hear(1, "start")
    assert grip.held


def test_of_requests_for_the_same_only_the_newest_is_done():
    failures, done, begun, release = [], [], threading.Event(), threading.Event()
    mailbox = Mailbox(failures.append)

    def first():
        begun.set()
        release.wait(10.0)
        done.append("first")

    mailbox.ask("slider", first)
    assert begun.wait(10.0)
    for number in range(100):
        mailbox.ask("slider", lambda number=number: done.append(number))
    mailbox.ask("other", lambda: done.append("other"))
    mailbox.ask("broken", lambda: 1 / 0)
    release.set()
    assert mailbox.wait(10.0)
    assert done == ["first", 99, "other"]
    assert [type(error) for error in failures] == [ZeroDivisionError]
    mailbox.ask("after", lambda: done.append("after"))
    assert mailbox.wait(10.0)
    assert done[-1] == "after"
    mailbox.close()
    mailbox.ask("late", lambda: done.append("late"))
    assert done[-1] == "after"


@pytest.mark.parametrize("text", ["1 2.5 -3", "1, 2.5, -3", "[1; 2.5; -3]", " (1  2.5\t-3) "])
def test_numbers_are_taken_as_people_type_them(text):
    np.testing.assert_array_equal(typed_numbers("motors", text, ("a", "b", "c")), [1.0, 2.5, -3.0])


@pytest.mark.parametrize(
    "text", ["", "1 2", "1 2 3 4", "one two three", "1 2 nan", "1 2 -inf", "1e999 0 0"]
)
def test_what_is_no_number_is_named(text):
    with pytest.raises(cpr_core.InvalidRequest, match="expected 3 numbers \\(a b c\\)"):
        typed_numbers("motors", text, ("a", "b", "c"))


def test_numbers_come_back_from_their_text():
    values = np.array([1 / 3, -2e-7, 0.0, 1234.5])
    again = typed_numbers("motors", numbers_as_text(values), ("a", "b", "c", "d"))
    np.testing.assert_allclose(again, values, rtol=1e-9)
    assert numbers_as_text(np.array([-0.0])) == "0"


def test_equilibria_come_round_by_round(planar):
    told = []
    search(cpr_core.solve_home(planar), told.append, lambda: False, starts=20, rounds=3)
    assert len(told) == 3
    assert len(told[0]) <= len(told[1]) <= len(told[2])
    energies = [found.equilibrium.energy for found in told[2]]
    assert energies == sorted(energies)
    assert sum(found.from_home for found in told[2]) == 1
    once = cpr_core.find_equilibria(planar, cpr_core.solve_home(planar).motors, starts=20, seed=0)
    assert sum(found.starts for found in told[0]) == sum(found.starts for found in once)
    stopped = []
    search(cpr_core.solve_home(planar), stopped.append, lambda: True, starts=5, rounds=3)
    assert stopped == []


def test_a_search_that_another_one_replaced_says_nothing(planar):
    asked, said = [], []
    server = open_server("equilibria", port=0)
    background = Background(lambda name, action: asked.append(action), pytest.fail)
    try:
        begun = []
        EquilibriaTab(server.gui, lambda name, action: begun.append(action), background)
        find, text, *_ = server.gui._container_handle_from_uuid["root"]._children.values()
        handled = HandledRobot(planar)
        for _ in range(2):
            pressed = find._impl.update_cb[0](None)
            asyncio.run_coroutine_threadsafe(pressed, server.get_event_loop()).result(10.0)
            begun.pop()(handled)
        searches = [thread for thread in threading.enumerate() if "equilibria" in thread.name]
        for search_ in searches:
            search_.join()
        for action in asked:
            action(handled)
            said.append(text.content.split("; ")[1])
    finally:
        background.close()
        close_server(server)
    assert len(said) > 2
    assert set(said[:-1]) == {"searching"}
    assert said[-1] == "done"


def test_a_ray_finds_the_cell_it_meets_and_the_robot_goes_there(planar, tmp_path):
    file = tmp_path / "map.nc"
    grid = pose_grid(planar, {"x": (-0.1, 0.1), "y": (0.74, 0.84)}, resolution=0.02)
    map_workspace(planar, grid, file=file)
    layer = read_layer(planar, file)
    assert layer.size == pytest.approx(0.02)
    assert len(layer.points) == len(layer.colors) == layer.found.reached.sum()
    cell = layer.nearest([0.061, 0.782, 3.0], [0.0, 0.0, -2.0])
    handled = HandledRobot(planar)
    assert go_to_cell(handled, layer.found, cell)
    np.testing.assert_allclose(handled.equilibrium.platform_position, [0.06, 0.78, 0.0], atol=1e-9)
    assert layer.nearest([5.0, 5.0, 3.0], [0.0, 0.0, -1.0]) is None
    assert layer.nearest([0.06, 0.78, 3.0], [0.0, 0.0, 1.0]) is None
    with pytest.raises(cpr_core.InvalidRequest, match="another robot_description"):
        read_layer(cpr_core.load_robot("rfrfr", modes=3), file)


def test_a_cell_that_is_met_in_another_equilibrium_than_the_map_has_is_told(planar, tmp_path):
    """The robot was said to be at the cell, whatever the map told of its stability there."""
    grid = pose_grid(planar, {"x": (-0.05, 0.05), "y": (0.7, 0.8)}, resolution=0.05)
    found = map_workspace(planar, grid)
    cell = grid.nearest([0.0, 0.75])
    handled = HandledRobot(planar)
    assert go_to_cell(handled, found, cell)
    assert handled.words == "at the cell x, y = 0, 0.75 of the map"
    others = cpr_core.find_equilibria(planar, cpr_core.solve_home(planar).motors, seed=0)
    told = []
    for other in others:
        handled.take(other.equilibrium, "")
        if go_to_cell(handled, found, cell):
            same = np.allclose(handled.equilibrium.motors, found.motors[cell], atol=1e-4)
            told.append((same, "in another equilibrium than the map has there" in handled.words))
    assert (False, True) in told and set(told) <= {(True, False), (False, True)}


def test_time_on_a_path_is_a_number_of_its_equilibria(planar):
    way = cpr_core.trace(planar, motors=[2.6, 0.6], points=11)
    assert [frame_at(way, at) for at in (0.0, 0.26, 0.5, 1.0, 7.0, -1.0)] == [0, 3, 5, 10, 10, 0]


def test_a_node_is_put_exactly_where_it_is_to_be():
    class Node:
        """As viser's: places that are nearly the same are not sent."""

        def __init__(self):
            self.sent = {"position": np.zeros(3), "wxyz": np.array([1.0, 0.0, 0.0, 0.0])}

        def __getattr__(self, name):
            return self.sent[name]

        def __setattr__(self, name, value):
            if name == "sent" or not np.allclose(value, self.sent[name]):
                super().__setattr__(name, value) if name == "sent" else self.sent.update(
                    {name: value}
                )

    node = Node()
    for step in (0.0, 1e-9, -1e-9, 1e-5):
        position, quaternion = np.array([step, 1.0 + step, -step]), np.array([1.0, step, 0.0, 0.0])
        put(node, position, quaternion)
        np.testing.assert_array_equal(node.sent["position"], position)
        np.testing.assert_array_equal(node.sent["wxyz"], quaternion)


def test_what_is_where_it_was_is_not_sent_and_what_is_far_once():
    class Node:
        def __init__(self):
            self.sent, self.position = [], np.zeros(3)

        def __setattr__(self, name, value):
            super().__setattr__(name, value)
            if name == "position":
                self.sent.append(value.tolist())

    node = Node()
    for position in ([0.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.5, 0.0]):
        node.sent.clear()
        put(node, np.array(position))
        assert node.sent == [position]


def test_a_screen_is_kept_as_yaml(planar):
    handled = HandledRobot(planar)
    handled.move_motors(handled.equilibrium.motors + [4.0, -4.0])
    kept = yaml.safe_load(as_yaml(handled))
    assert list(kept["motors"].values()) == handled.equilibrium.motors.tolist()
    assert kept["refused"]["kind"] == handled.refused.kind
    assert kept["refused"]["motors"] == handled.refused.asked.motors.tolist()
    assert kept["energy"] == handled.equilibrium.energy
    assert kept["measures"]["margin"] == pytest.approx(handled.equilibrium.margin)


def test_all_that_was_refused_is_kept_as_yaml():
    """Of a pose the angle was not, of loads nothing."""
    robot = cpr_core.load_robot("planar_body")
    handled = HandledRobot(robot)
    assert not handled.move_pose([0.0, 0.0, 4.0])
    kept = yaml.safe_load(as_yaml(handled))["refused"]
    expected = quaternion_from_rotation(rotation_exp([0.0, 0.0, 4.0]))
    assert abs(np.dot(kept["quaternion_wxyz"], expected)) == pytest.approx(1.0)
    wrench = [0.0, 0.0, 30.0, 0.0, -500.0, 0.0]
    assert not handled.load(handled.equilibrium.loads.with_(wrench_world=wrench))
    kept = yaml.safe_load(as_yaml(handled))["refused"]
    assert kept["wrench_world"] == wrench
    assert kept["gravity"] == handled.equilibrium.loads.gravity.tolist()


def test_pictures_become_a_gif():
    frames = [np.full((20, 30, 4), (60 * number, 0, 9, 255), np.uint8) for number in range(4)]
    content = as_gif(frames, 10.0)
    picture = Image.open(io.BytesIO(content))
    assert (picture.format, picture.n_frames, picture.size) == ("GIF", 4, (30, 20))
    picture.seek(3)
    assert picture.convert("RGB").getpixel((15, 10)) == (180, 0, 9)


@pytest.mark.parametrize(
    ("rate", "milliseconds"), [(10.0, 100), (30.0, 30), (2.0, 500), (500.0, 20)]
)
def test_a_gif_is_as_fast_as_its_pictures_were_taken(rate, milliseconds):
    frames = [np.full((20, 30, 3), 60 * number, np.uint8) for number in range(4)]
    assert Image.open(io.BytesIO(as_gif(frames, rate))).info["duration"] == milliseconds


def test_the_page_says_whether_the_robot_is_stable_and_what_was_refused(planar):
    handled = HandledRobot(planar)
    assert "stable with the motors held" in status_text(handled)
    handled.move_motors([1.0])
    assert "Refused" in status_text(handled)
    assert as_plain("a_b*c") == "a\\_b\\*c"


@pytest.mark.parametrize(
    "text", ["1,2.5,-3", "1, 2, 5", "1,\t2,\n5", "[1,2,5]", "1,2,-5", "(1,2,5)"]
)
def test_commas_that_are_no_decimal_ones_are_taken(text):
    assert len(typed_numbers("motors", text, ("a", "b", "c"))) == 3


@pytest.mark.parametrize("text", ["2,6", "-2,6", "2,6 1", "2,6 0,5", "2,6,1,5", "0,5;1", "1,5;2.5"])
def test_commas_that_may_be_decimal_ones_are_refused(text):
    """2,6 was 2 and 6, and the robot set off."""
    with pytest.raises(
        cpr_core.InvalidRequest, match="expected decimal points, and spaces between"
    ):
        typed_numbers("motors", text, ("a", "b"))


@pytest.mark.parametrize("text", ["0,5;1", "1,5; 2", "0,5 1", "1 2,5"])
def test_of_three_numbers_too(text):
    with pytest.raises(cpr_core.InvalidRequest, match="expected decimal points"):
        typed_numbers("motors", text, ("a", "b", "c"))


@pytest.mark.parametrize(
    "text", ["1.234,5", "2.5 1.234,5", "-1.234.567,8 2", "2_7 0.5", "\u0662.\u0665 1", "1 \uff11"]
)
def test_numbers_that_python_reads_otherwise_than_people_write_them_are_refused(text):
    """1.234,5 was 1.234 and 5, and 2_7 was 27."""
    with pytest.raises(cpr_core.InvalidRequest, match="motors: expected"):
        typed_numbers("motors", text, ("motor1", "motor2"))


@pytest.mark.parametrize(
    ("text", "values"),
    [("1.234, 5", [1.234, 5]), ("1.2345,6.5", [1.2345, 6.5]), ("1.23,4", [1.23, 4])],
)
def test_points_and_commas_of_two_numbers_are_taken(text, values):
    np.testing.assert_array_equal(typed_numbers("motors", text, ("motor1", "motor2")), values)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Tabs of the page in a real browser: other equilibria, map, way, record."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from helpers.browser import Looker, settled, type_into
from PIL import Image

import cpr_core
from cpr_core.viewing.typed import numbers_as_text
from cpr_core.workspace import map_workspace, pose_grid


@pytest.fixture(scope="module")
def robot():
    return cpr_core.load_robot("rfrfr")


@pytest.fixture(scope="module")
def map_file(robot, tmp_path_factory):
    file = tmp_path_factory.mktemp("map") / "map.nc"
    grid = pose_grid(robot, {"x": (-0.1, 0.1), "y": (0.74, 0.84)}, resolution=0.02)
    map_workspace(robot, grid, file=file)
    return file


@pytest.fixture(scope="module")
def opened(robot, browser):
    page = cpr_core.view(robot)
    looker = Looker(browser, page.address, "motor2")
    looker.until(lambda: looker.visible("/robot/legs"))
    yield page, looker
    looker.page.close()
    page.close()


@pytest.fixture
def page(opened, robot):
    page = opened[0]
    page.show(cpr_core.solve_home(robot))
    assert page.wait()
    return page


@pytest.fixture
def looker(opened, page):
    return opened[1]


def test_other_equilibria_are_found_and_jumped_to(page, looker):
    home = page.equilibrium
    looker.open_tab("equilibria")
    looker.press("find others")
    looker.page.get_by_text("stable; done").wait_for()
    buttons = looker.page.get_by_role("button").filter(has_text="times")
    labels = buttons.all_inner_texts()
    energies = [float(label.split(" J")[0]) for label in labels]
    assert len(labels) > 2
    assert energies == sorted(energies)
    other = next(number for number, label in enumerate(labels) if "home" not in label)
    buttons.nth(other).evaluate("node => node.click()")
    looker.until(lambda: page.equilibrium is not home)
    settled(page, looker)
    looker.picture("equilibria")
    assert page.equilibrium.energy == pytest.approx(energies[other], rel=1e-4)
    np.testing.assert_array_equal(page.equilibrium.motors, home.motors)


def test_a_click_on_a_map_goes_there(page, looker, map_file):
    looker.open_tab("map")
    looker.page.locator("input[type=file]").last.set_input_files(map_file)
    looker.page.get_by_text("cells are reached").wait_for()
    looker.until(lambda: looker.visible("/map"))
    looker.open_tab("robot")
    looker.switch("handles")  # they would take the click
    looker.until(lambda: not looker.visible("/handle"))
    place = np.array([0.06, 0.78, 0.0])
    looker.click(place)
    looker.until(lambda: np.allclose(page.equilibrium.platform_position, place, atol=1e-9))
    settled(page, looker)
    looker.page.get_by_text("at the cell").wait_for()
    looker.picture("map")
    looker.switch("handles")


def test_a_map_of_other_loads_is_not_shown(page, looker):
    """Its colours and clicks stayed, and stable cells were refused as unstable."""
    looker.open_tab("map")
    looker.until(lambda: looker.visible("/map"))
    pushed = page.equilibrium.loads.with_(wrench_world=[0, 0, 0, 0, -0.1, 0])
    page.do("push", lambda handled: handled.load(pushed))
    looker.page.get_by_text("The map is of other loads than act now").wait_for()
    looker.until(lambda: not looker.visible("/map"))
    loaded = page.equilibrium
    page._maps._clicked(
        SimpleNamespace(
            ray_origin=np.array([0.06, 0.78, 3.0]), ray_direction=np.array([0, 0, -1.0])
        )
    )
    settled(page, looker)
    assert page.equilibrium is loaded
    page.do("undo", lambda handled: handled.undo())
    looker.page.get_by_text("cells are reached").wait_for()
    looker.until(lambda: looker.visible("/map"))
    page.do("modes", lambda handled: handled.choose_modes(7))
    looker.page.get_by_text("The map is of other strain modes").wait_for()
    looker.open_tab("robot")
    looker.until(lambda: looker.field("strain modes").input_value() == "7")
    page.do("undo", lambda handled: handled.undo())
    looker.until(lambda: looker.field("strain modes").input_value() == "5")
    looker.until(lambda: looker.visible("/map"))


def test_a_map_is_shown_again_when_its_strain_modes_are_chosen_again(page, looker):
    """They had to be undone: chosen, the robot was another one, whatever the words promised."""
    looker.open_tab("map")
    looker.until(lambda: looker.visible("/map"))
    before = page.equilibrium
    page.do("modes", lambda handled: handled.choose_modes(7))
    looker.page.get_by_text("The map is of other strain modes").wait_for()
    page.do("modes", lambda handled: handled.choose_modes(5))
    looker.page.get_by_text("cells are reached").wait_for()
    looker.until(lambda: looker.visible("/map"))
    assert page.equilibrium.robot is not before.robot
    page.do("take", lambda handled: setattr(handled, "equilibrium", before))
    looker.until(lambda: page.equilibrium is before)


def test_what_is_no_map_is_told(page, looker, tmp_path):
    file = tmp_path / "wrong.nc"
    file.write_text("no map")
    before = page.equilibrium
    looker.open_tab("map")
    looker.page.locator("input[type=file]").last.set_input_files(file)
    looker.page.get_by_text("not a map of this robot").wait_for()
    looker.until(lambda: "wrong.nc" in looker.text())
    assert page.equilibrium is before


def test_a_way_is_traced_and_played(page, looker):
    looker.open_tab("way")
    looker.choose("to", "pose")
    current_pose = numbers_as_text(page.equilibrium.pose)  # what the page fills the field with
    looker.until(lambda: looker.field("end").input_value() == current_pose)
    type_into(page, looker, "end", "0.1 0.75")
    looker.press("trace from here")
    looker.page.get_by_text("the end is reached").wait_for()
    looker.until(lambda: looker.visible("/way"))
    thumb = looker.page.get_by_role("slider").last
    thumb.focus()
    thumb.press("End")
    looker.until(
        lambda: np.allclose(page.equilibrium.platform_position[:2], [0.1, 0.75], atol=1e-9)
    )
    looker.press("play")
    looker.until(lambda: page.equilibrium.platform_position[0] < 0.09)
    looker.until(
        lambda: np.allclose(page.equilibrium.platform_position[:2], [0.1, 0.75], atol=1e-9)
    )
    settled(page, looker)
    looker.picture("way")
    assert "on the path, time 1.000" in looker.text()
    assert "traced with" not in looker.text()
    loads = page.equilibrium.loads
    pushed = loads.with_(wrench_world=[0, 0, 0, 0, -0.1, 0])
    page.do("push", lambda handled: handled.load(pushed))
    looker.press("play")
    looker.page.get_by_text("time 1.000, under the loads it was traced with").wait_for()
    assert page.equilibrium.loads is loads


def test_what_is_on_screen_is_saved(page, looker):
    looker.open_tab("record")
    with looker.page.expect_download() as kept:
        looker.press("save YAML")
    told = yaml.safe_load(Path(kept.value.path()).read_text())
    assert list(told["motors"].values()) == page.equilibrium.motors.tolist()
    assert told["platform"]["position"] == page.equilibrium.platform_position.tolist()
    looker.press("record GIF")
    for position in (2.7, 2.8):  # pictures of the same are one
        looker.page.get_by_text(re.compile(r"^\d+ pictures$")).wait_for()
        page.do("motor", lambda handled, at=position: handled.move_motor(0, at))
        told = looker.text()
        looker.until(lambda told=told: looker.text() != told)
        looker.page.wait_for_timeout(1500)
    with looker.page.expect_download() as kept:
        looker.press("stop and save")
    picture = Image.open(kept.value.path())
    assert picture.format == "GIF"
    assert picture.n_frames > 1
    assert picture.size == (640, 480)
    looker.picture("record")

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Points of a map in the scene: their colours, their size, and the one that a click means."""

from types import SimpleNamespace

import numpy as np
import pytest

from cpr_core.viewing import map_layer
from cpr_core.viewing.map_layer import MapLayer, go_to_cell, read_layer

BLUE, YELLOW, PURPLE, GREY = map_layer._COLORS.tolist()
ORANGE = map_layer._BEYOND.tolist()


def a_map(along, neighbours, reached=None):
    """Cells along x, each with its neighbours before and behind it; -1: none."""
    count = len(along)
    position = np.column_stack([along, np.zeros((count, 2))])
    return SimpleNamespace(
        reached=np.ones(count, bool) if reached is None else np.array(reached),
        index_locked=np.zeros(count, int),
        within_limits=np.ones(count, bool),
        cells=SimpleNamespace(position=position),
        grid=SimpleNamespace(neighbours=np.array(neighbours)),
        robot=SimpleNamespace(mean_length=0.5),
    )


@pytest.fixture
def layer_of(monkeypatch):
    def read(found):
        monkeypatch.setattr(map_layer, "read_map", lambda *_: found)
        return read_layer(found.robot, "map.nc")

    return read


@pytest.mark.parametrize(
    ("along", "neighbours", "reached", "size"),
    [
        ([0.0, 0.1, 0.7], [[-1, 1], [0, -1], [-1, -1]], [True, True, True], 0.1),
        ([0.0, 0.1, 0.7], [[-1, 1], [0, 2], [1, -1]], [True, True, False], 0.1),
        ([0.0, 0.0, 0.1], [[-1, 1], [0, 2], [1, -1]], [True, True, True], 0.1),
        ([0.0, 0.1, 0.2], [[-1, -1], [-1, -1], [-1, -1]], [True, True, True], 0.01),
    ],
    ids=["border", "not reached", "turned only", "alone"],
)
def test_points_are_as_large_as_reached_neighbours_are_apart(
    layer_of, along, neighbours, reached, size
):
    assert layer_of(a_map(along, neighbours, reached)).size == pytest.approx(size)


def test_points_have_the_colours_of_their_stability_index_unless_beyond_a_limit(layer_of):
    found = a_map(np.arange(6.0), np.full((6, 2), -1))
    found.index_locked = np.array([0, 1, 2, 3, 7, 0])
    found.within_limits[5] = False
    assert layer_of(found).colors.tolist() == [BLUE, YELLOW, PURPLE, GREY, GREY, ORANGE]


def test_a_click_means_the_first_point_on_its_way_and_none_far_beside_it():
    points = np.array([[0.0, 0.0, -3.0], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.5, 0.0, -1.0]])
    layer = MapLayer(None, np.array([10, 11, 12, 13]), points, None, 0.1)
    down = [0.0, 0.0, -2.0]
    assert layer.nearest([0.01, 0.0, 0.0], down) == 11
    assert layer.nearest([0.49, 0.0, 0.0], down) == 13
    assert layer.nearest([0.14, 0.0, 0.0], down) == 11
    assert layer.nearest([0.16, 0.0, 0.0], down) is None


@pytest.mark.parametrize(
    ("given", "controlled", "asked"),
    [("motors", ("x", "y"), "motors"), ("pose", ("x", "y"), "pose"), ("pose", (), "motors")],
)
def test_a_cell_is_gone_to_by_what_its_map_imposes(given, controlled, asked):
    done = []
    handled = SimpleNamespace(
        robot=SimpleNamespace(description=SimpleNamespace(controlled=controlled)),
        move_motors=lambda *of: done.append(("motors", *of)),
        move_pose=lambda *of: done.append(("pose", *of)),
    )
    reached = SimpleNamespace(motors="its motors", pose="its pose")
    found = SimpleNamespace(equilibrium=lambda cell: reached, grid=SimpleNamespace(given=given))
    assert not go_to_cell(handled, found, 3)
    assert done == [(asked, f"its {asked}", "map")]

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where several publish measured motors, the node sends them nowhere right after it has begun there."""

from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
from helpers.drive import robot

from cpr_ros import operated_robot
from cpr_ros.following.moved_by_others import MovedByOthers


@pytest.mark.parametrize(("publishers", "watched"), [(0, False), (1, False), (2, True)])
def test_where_the_robot_is_placed_it_is_watched_whether_all_agree(
    monkeypatch, publishers, watched
):
    others = MovedByOthers(robot("rfrfr"), 0.1)
    monkeypatch.setattr(operated_robot, "other_publishers", lambda node, topic: publishers)
    placed = operated_robot.OperatedRobot(Mock(), Mock(), tick_rate=200.0)
    placed.session, placed.whereabouts = SimpleNamespace(moved_by_others=others), Mock()
    placed.place(np.array([2.6, 0.5]))
    assert placed.whereabouts.place.called
    assert ("was just measured" in others.in_question) == watched == bool(others.in_question)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is known of a node from its streams, and its markers as lines."""

import numpy as np
import pytest
from helpers.drive import Drive, robot
from helpers.markers import markers_of

from cpr_core.drawing.robot_lines import equilibrium_lines
from cpr_ros.page.marker_lines import lines_of
from cpr_ros.page.watched_node import LastMinute, Presence, topic_beside


def test_a_node_is_there_gone_and_back():
    presence = Presence(silence=1.0)
    assert presence.seen(0.0) == "waiting"
    presence.hear(5.0)
    assert presence.seen(5.9) == "there"
    presence.hear(5.9)
    assert [presence.seen(6.8), presence.seen(6.95), presence.seen(7.0)] == [
        "there",
        "there",
        "gone",
    ]
    assert presence.seen(8.9) == "gone"
    presence.hear(9.0)
    assert presence.seen(9.1) == "back"
    for tick in range(30):
        presence.hear(9.5 + 0.5 * tick)
        if tick in (18, 20):  # ten seconds
            assert presence.seen(9.6 + 0.5 * tick) == ("back" if tick == 18 else "there")
    assert presence.seen(24.1) == "there"
    assert [presence.seen(40.0), presence.seen(40.1)] == ["there", "gone"]


def test_who_was_held_up_does_not_call_a_node_gone():
    """What came meanwhile is heard behind the first look."""
    presence = Presence()
    presence.hear(4.0)
    assert [presence.seen(5.9), presence.seen(6.1), presence.seen(6.2)] == [
        "there",
        "there",
        "gone",
    ]
    presence = Presence(silence=1.0)
    presence.hear(5.0)
    assert presence.seen(5.1) == "there"
    assert presence.seen(9.0) == "there"
    presence.hear(9.01)
    assert presence.seen(9.1) == "there"
    assert presence.seen(10.5) == "there"
    assert presence.seen(10.6) == "gone"


def test_a_minute_is_kept():
    minute = LastMinute(("margin", "distance"))
    time, margin, distance = minute.columns(3.0)
    assert np.isnan(margin).all()
    for second in range(100):
        minute.add(float(second), 0.01 * second, np.inf)
    time, margin, distance = minute.columns(99.0)
    assert (time[0], time[-1]) == (-60.0, 0.0)
    assert margin[-1] == 0.99
    assert np.isnan(distance).all()
    minute.add(200.0, 0.5, 0.25)  # nothing came in between
    assert [column.tolist() for column in minute.columns(200.0)] == [[0.0], [0.5], [0.25]]


def test_lines_come_back_from_markers():
    for name in ("six_rfs", "three_prs"):
        outcome = Drive(robot(name)).tick()
        expected = equilibrium_lines(outcome.assessment.equilibrium)
        found = lines_of(markers_of(outcome, "strain"))
        for mine, theirs in zip(found.rods, expected.rods, strict=True):
            np.testing.assert_array_equal(mine, theirs)
        for mine, theirs in zip(found.shades, expected.shades, strict=True):
            np.testing.assert_allclose(mine, theirs, atol=1e-6)
        np.testing.assert_array_equal(found.links, expected.links)
        np.testing.assert_array_equal(found.joints, expected.joints)
        np.testing.assert_array_equal(found.driven, expected.driven)
        np.testing.assert_array_equal(found.platform, expected.platform)
        flat = lines_of(markers_of(outcome, "stability"))
        assert {tuple(shade) for shades in flat.shades for shade in shades.tolist()} == {
            tuple(flat.shades[0][0].tolist())
        }


@pytest.mark.parametrize(
    ("node", "topic"),
    [
        ("cpr_node", "joint_states"),
        ("/cpr_node", "/joint_states"),
        ("left/cpr_node", "left/joint_states"),
        ("/left/cpr_node", "/left/joint_states"),
    ],
)
def test_a_topic_beside_a_node_is_in_its_namespace(node, topic):
    assert topic_beside(node, "joint_states") == topic

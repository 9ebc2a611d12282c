# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a tracker is and its marker sits: read, changed, and what it then tells."""

import numpy as np
import pytest
from helpers.tracked_robots import MARKER, TRACKER, random_frame, tracked

import cpr_core
from cpr_core import DescriptionError
from cpr_core.lie import rotation_exp, rotation_log


def test_a_robot_without_one_has_none():
    assert cpr_core.load_robot("six_rfs").description.tracker is None


def test_of_what_is_not_said_of_it_all_is_nothing():
    tracker = tracked().description.tracker
    position, rotation = np.array([0.1, 0.2, 0.3]), rotation_exp([0.3, 0.2, 0.1])
    told = tracker.marker_in_tracker(position, rotation)
    np.testing.assert_array_equal(told[0], position)
    np.testing.assert_allclose(told[1], rotation, atol=1e-15)


@pytest.mark.parametrize("seed", range(10))
def test_it_tells_where_the_marker_is_and_where_the_platform_is_is_told_back(seed):
    """By matrices that move points, and to and fro."""
    generator = np.random.default_rng(seed)
    frame, marker = random_frame(generator, 2.0), random_frame(generator, 0.1)
    tracker = tracked("delta", frame, marker).description.tracker
    position, rotation = generator.normal(size=3), rotation_exp(generator.normal(size=3))

    def motion(place, turn):
        return np.block([[turn, np.reshape(place, (3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])

    x, y = (motion(each[:3], rotation_exp(each[3:])) for each in (frame, marker))
    a = np.linalg.inv(x) @ motion(position, rotation) @ y
    told = tracker.marker_in_tracker(position, rotation)
    np.testing.assert_allclose(motion(*told), a, atol=1e-14)
    np.testing.assert_allclose(
        motion(*tracker.platform_in_world(*told)), motion(position, rotation), atol=1e-14
    )


def test_how_it_moves_is_how_what_it_tells_differs():
    generator = np.random.default_rng(5)
    tracker = tracked("delta", random_frame(generator, 2.0), random_frame(generator, 0.1))
    tracker = tracker.description.tracker
    position, rotation = generator.normal(size=3), rotation_exp(generator.normal(size=3))
    motions = tracker.marker_motions(rotation)
    for column, way in enumerate(1e-6 * np.eye(6)):
        (low, low_turn), (high, high_turn) = (
            tracker.marker_in_tracker(
                position + sign * way[:3], rotation_exp(sign * way[3:]) @ rotation
            )
            for sign in (-1.0, 1.0)
        )
        differs = np.concatenate([high - low, rotation_log(high_turn @ low_turn.T)]) / 2e-6
        assert motions[:, column] == pytest.approx(differs, abs=1e-8)


def test_its_numbers_are_parameters():
    robot = tracked("rfrfr", [0.1, 0.2, 1.5, np.pi, 0.0, 0.0])
    assert robot.parameter_values(TRACKER) == pytest.approx([0.1, 0.2, 1.5, np.pi, 0.0, 0.0])
    assert robot.parameter_values(MARKER).tolist() == [0.0] * 6
    values = dict(zip((*TRACKER, *MARKER), 0.1 * np.arange(12), strict=True))
    changed = robot.with_parameters(values)
    assert changed.parameter_values(tuple(values)) == pytest.approx(list(values.values()))
    tracker = changed.description.tracker
    np.testing.assert_allclose(tracker.marker_rotation, rotation_exp([0.9, 1.0, 1.1]))


def test_it_moves_nothing_of_the_robot():
    robot = tracked()
    home = cpr_core.solve_home(robot)
    by = cpr_core.derivatives(home, TRACKER, of=("pose", "motors", "efforts", "margin"))
    for rates in (by.position, by.rotation, by.motors, by.efforts, by.margin):
        assert not rates.any()


@pytest.mark.parametrize(
    ("frame", "text"),
    [
        (
            [0, 0, 0, 180.0, 0, 0],
            "tracker.rotation_vector: .* at most a turn in radians, .*degrees",
        ),
        ([0, 0, 0, 6.5, 0, 0], "tracker.rotation_vector: .* at most a turn in radians"),
        ([0, 0, 0, 1e4, 0, 0], "tracker.rotation_vector: .* got \\[10000.0, 0.0, 0.0\\]"),
        ([0, 0, 0, 1, 0], "tracker.rotation_vector: expected exactly 3 entries"),
        ([0, 0, 0, "x", 0, 0], "tracker.rotation_vector\\[0\\]: expected number"),
    ],
)
def test_what_is_no_frame_is_refused(frame, text):
    with pytest.raises(DescriptionError, match=text):
        tracked("six_rfs", frame)


def test_millimetres_are_doubted():
    with pytest.warns(cpr_core.DescriptionWarning, match="tracker.position: .*millimetres"):
        tracked("six_rfs", [100.0, 200.0, 1500.0, 0, 0, 0])
    with pytest.warns(cpr_core.DescriptionWarning, match="tracker.marker.position: .*millimetres"):
        tracked("six_rfs", marker=[0.0, 0.0, 20.0, 0, 0, 0])

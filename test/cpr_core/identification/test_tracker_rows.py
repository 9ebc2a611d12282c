# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What trackers should tell, and how it changes with their numbers."""

from dataclasses import replace

import numpy as np
import pytest

from cpr_core.description.tracker import Tracker
from cpr_core.identification.tracker_rows import TrackerRows
from cpr_core.lie import rotation_exp

STEP = 1e-5


def random_rows(generator, count, lacking=()):
    """Rows of a tracker that tells anything; some of them without a position, others without a turn."""
    told = generator.normal(size=(count, 3))
    turned, turns = np.array(
        [[rotation_exp(vector) for vector in generator.normal(size=(count, 3))] for _ in range(2)]
    )
    for row, part in lacking:
        (told if part == "position" else turned)[row] = np.nan
    return TrackerRows(told, turned, generator.normal(size=(count, 3)), turns, 1e3, 2e2)


def tracker_with(numbers):
    return Tracker(*np.reshape(numbers, (4, 3)))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(
    "lacking",
    [
        [],
        [(1, "position"), (3, "rotation")],
        [(row, "rotation") for row in range(6)],
        [(row, "position") for row in range(6)],
    ],
)
def test_rates_are_those_of_differences(seed, lacking):
    generator = np.random.default_rng(seed)
    rows, numbers = random_rows(generator, 6, lacking), generator.normal(size=12)
    rates = rows.rates(tracker_with(numbers))
    assert rates.shape == (36 - 3 * len(lacking), 12)
    for column, way in zip(rates.T, STEP * np.eye(12), strict=True):
        low, high = (rows.differences(tracker_with(numbers + side * way)) for side in (-1, 1))
        np.testing.assert_allclose(column, (high - low) / (2.0 * STEP), atol=1e-4)


def test_the_tracker_that_told_it_differs_in_nothing():
    generator = np.random.default_rng(7)
    rows, tracker = random_rows(generator, 4), tracker_with(generator.normal(size=12))
    platforms = zip(rows.platform_positions, rows.platform_rotations, strict=True)
    poses = [tracker.marker_in_tracker(*platform) for platform in platforms]
    told, turned = (np.array(part) for part in zip(*poses, strict=True))
    same = replace(rows, marker_positions=told, marker_rotations=turned)
    np.testing.assert_allclose(same.differences(tracker), 0.0, atol=1e-11)

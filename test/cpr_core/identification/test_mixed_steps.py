# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Steps that go around where they lead, and no longer do when they are mixed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpr_core.identification.mixed_steps import MixedSteps


@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.sampled_from([1.0, 0.3]))
def test_steps_of_a_linear_iteration_end_after_one_more_than_there_are_directions(
    seed, directions, part
):
    """Those of three others are right at once, whatever is taken of the rest."""
    generator = np.random.default_rng(seed)
    basis = np.linalg.qr(generator.normal(size=(directions + 3, directions + 3)))[0]
    turned, straight = basis[:, :directions], basis[:, directions:]
    speeds = generator.uniform(1.5, 4.0, directions)  # alone they go farther and farther
    end, place = generator.normal(size=(2, directions + 3))
    mixed = MixedSteps(directions)
    for _ in range(directions + 2):
        way = end - place
        along = turned @ (speeds * (turned.T @ way))
        rest = straight @ (straight.T @ way)
        place = place + mixed.mixed(place, along + rest, part * along + rest)
    np.testing.assert_allclose(place, end, rtol=0.0, atol=1e-6)


def test_the_first_step_is_the_one_that_is_taken():
    assert MixedSteps(1).mixed(np.zeros(2), np.ones(2), np.array([0.5, 1.0])).tolist() == [0.5, 1.0]


@pytest.mark.parametrize("speed", [0.5, 1.0, 1.9])
def test_a_place_that_was_reached_is_kept(speed):
    mixed, place = MixedSteps(2), np.array([1.0, -2.0])
    for _ in range(60):
        place = place + mixed.mixed(place, -speed * place, -speed * place)
    np.testing.assert_allclose(place, 0.0, atol=1e-12)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Gain, rate and limit of a loop that are changed while it is closed set nothing in motion."""

import numpy as np
import pytest
from helpers.closed_loop import TARGET, ClosedLoop, frozen, live

from cpr_ros.operation.live_changes import apply_live


def test_a_gain_of_zero_holds_what_there_is(bench):
    apply_live(bench.session, live(loop_gain=0.0), bench.now)
    frozen(bench, 0.5, "loop_gain is 0")


@pytest.mark.parametrize("seen", [True, False])
def test_a_rate_that_was_zero_sets_nothing_in_motion(bench, seen):
    """What was wound up meanwhile was let go: the motors set off by themselves."""
    apply_live(bench.session, live(loop_gain=4.0, loop_max_rate=0.0), bench.now)
    bench.follow(TARGET + [0.0, 0.01])
    bench.run(1.0)
    frozen(bench, 0.5, "loop_max_rate is 0")
    if not seen:
        bench.every = 0.0
        bench.run(0.3)
    before = bench.session.commands.newest
    assert apply_live(bench.session, live(loop_gain=4.0, loop_max_rate=1.0), bench.now)
    bench.run(0.5)
    np.testing.assert_array_equal(bench.session.commands.newest, before)


def test_a_correction_beyond_a_new_limit_is_forgotten_and_the_robot_holds(bench):
    """It stayed, frozen, above what loop_max_correction allowed."""
    size = bench.session.loop.coordinates.size(bench.session.loop.correction)
    motors = bench.model.motors
    assert apply_live(bench.session, live(loop_max_correction=0.5 * size), bench.now)
    np.testing.assert_array_equal(bench.session.loop.correction, 0.0)
    bench.run(0.5)
    np.testing.assert_array_equal(bench.model.motors, motors)


def test_one_on_its_way_beyond_a_new_limit_goes_no_farther():
    """It went on to where the last picture had wanted it."""
    bench = ClosedLoop("rfrfr", loop_gain=100.0, loop_max_rate=0.02)
    bench.follow([0.05, 0.75])
    bench.run(1.0)
    bench.every, bench.next_picture = 1.0, bench.now
    bench.run(0.1)
    loop = bench.session.loop
    size = loop.coordinates.size(loop.correction)
    limit = 1.05 * size
    changed = live(loop_gain=100.0, loop_max_rate=0.02, loop_max_correction=limit)
    apply_live(bench.session, changed, bench.now)
    for _ in range(12):
        bench.run(0.1)
        assert loop.coordinates.size(loop.correction) <= limit


def test_no_parameter_sets_a_frozen_correction_free(bench):
    apply_live(bench.session, live(loop_gain=0.0), bench.now)
    bench.run(0.5)
    goal, motors = bench.session.follower.goal, bench.model.motors
    assert goal is not None
    assert apply_live(bench.session, live(loop_gain=4.0), bench.now)
    assert bench.session.follower.goal is None
    bench.run(0.5)
    np.testing.assert_array_equal(bench.model.motors, motors)

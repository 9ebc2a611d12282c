# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Every live parameter of a session counts from the call that sets it on."""

from dataclasses import replace

import pytest
from helpers.session_bench import LIVE, Bench

from cpr_ros.operation.live_changes import apply_live

ANOTHER = replace(
    LIVE,
    settings=replace(LIVE.settings, max_speed=0.123),
    wrench_timeout=1.1,
    measured_timeout=1.2,
    moved_tolerance=0.13,
    max_lead=1.4,
    time_limit=1.5,
    loop=replace(LIVE.loop, gain=0.16),
    twist_timeout=1.7,
    felt_wrench=replace(LIVE.felt_wrench),
)


@pytest.mark.parametrize("source", ["setpoint", "measured"])
def test_every_value_reaches_whoever_uses_it(source):
    bench = Bench(motor_source=source)
    session, live = bench.session, ANOTHER
    if session.tracking is not None:
        session.tracking.at_rest = True
    assert not apply_live(session, live, bench.now)
    assert session.follower.settings is live.settings
    assert session.loop.settings is live.loop
    assert session.felt.settings is live.felt_wrench
    assert session.solver.time_limit == live.time_limit
    assert session.wrench.watchdog.timeout == live.wrench_timeout
    assert session.jogger.watchdog.timeout == live.twist_timeout
    assert session.measured.watchdog.timeout == live.measured_timeout
    assert session.moved_by_others.tolerance == live.moved_tolerance
    assert session.commands.tolerance == live.moved_tolerance
    assert session.commands.max_lead == live.max_lead
    assert (session.tracking is None) == (source == "setpoint")
    if session.tracking is not None:
        assert session.tracking.watchdog.timeout == live.measured_timeout
        assert not session.tracking.at_rest

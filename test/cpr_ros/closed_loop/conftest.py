# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot met at its setpoint in the measured pose."""

import pytest
from helpers.closed_loop import TARGET, ClosedLoop

from cpr_ros.closed_loop.loop_status import Loop


@pytest.fixture
def bench():
    """The planar robot, met at its setpoint within some 1e-3."""
    made = ClosedLoop("rfrfr", loop_gain=4.0, loop_max_rate=1.0)
    made.follow(TARGET)
    made.run(1.5)
    assert made.status.loop == Loop.CLOSED
    assert made.error(TARGET) < 2e-3
    return made

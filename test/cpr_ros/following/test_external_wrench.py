# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

import numpy as np
import pytest
from helpers.drive import robot

from cpr_core import InvalidRequest
from cpr_ros.following.external_wrench import ExternalWrench


@pytest.mark.parametrize("frame", ["wrench_world", "wrench_body"])
def test_the_newest_wrench_acts_until_it_is_too_old(frame):
    six = robot("six_rfs")
    wrench = ExternalWrench(six, timeout=0.5)
    loads = six.default_loads.with_(gravity=[0.0, 1.0, -9.0])
    assert wrench.loads(loads, 0.0) is loads
    pushed = loads.with_(**{frame: [0, 0, 0, 1.0, 0, 0]})
    wrench.take(pushed, 1.0)
    assert wrench.loads(loads, 1.4) is pushed
    released = wrench.loads(pushed, 1.6)
    np.testing.assert_array_equal([released.wrench_world, released.wrench_body], 0.0)
    np.testing.assert_array_equal(released.gravity, loads.gravity)
    assert wrench.loads(pushed, 1.7) is released
    assert wrench.watchdog.age(1.7) == -1.0


def test_a_timeout_of_zero_keeps_the_wrench():
    six = robot("six_rfs")
    wrench = ExternalWrench(six, timeout=0.0)
    pushed = six.default_loads.with_(wrench_world=[0, 0, 0, 1.0, 0, 0])
    wrench.take(pushed, 0.0)
    assert wrench.loads(six.default_loads, 1e6) is pushed


def test_a_wrench_out_of_the_plane_is_refused_and_the_last_one_stays():
    planar = robot("rfrfr")
    wrench = ExternalWrench(planar, timeout=0.0)
    good = planar.default_loads.with_(wrench_world=[0, 0, 0, 0.1, 0, 0])
    wrench.take(good, 0.0)
    with pytest.raises(InvalidRequest, match="planar"):
        wrench.take(good.with_(wrench_world=[0, 0, 0, 0, 0, 1.0]), 1.0)
    assert wrench.loads(good, 2.0) is good
    assert wrench.watchdog.age(2.0) == 2.0

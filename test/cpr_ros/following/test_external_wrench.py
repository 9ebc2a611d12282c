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


def test_a_wrench_that_is_too_old_is_missing_until_another_comes():
    """The robot was told to be stable under nothing, as if no sensor had ever said otherwise."""
    planar = robot("rfrfr")
    wrench, none = ExternalWrench(planar, timeout=0.5), planar.default_loads
    pushed = none.with_(wrench_world=[0, 0, 0, 0.1, 0, 0])
    assert wrench.missing == ""
    wrench.take(pushed, 0.0)
    wrench.loads(pushed, 0.4)
    assert wrench.missing == ""
    wrench.loads(pushed, 0.6)
    assert (
        wrench.missing == "the external wrench is older than wrench_timeout 0.5 s and acts no more"
    )
    wrench.watchdog.timeout = 0.0
    assert wrench.missing == ""  # none is too old
    wrench.watchdog.timeout = 0.5
    assert wrench.missing
    wrench.take(pushed, 1.0)
    assert wrench.missing == ""
    wrench.loads(pushed, 2.0)
    wrench.forget_missing()
    assert wrench.missing == ""


def test_a_wrench_of_zero_says_that_nothing_pushes_any_more():
    planar = robot("rfrfr")
    wrench, none = ExternalWrench(planar, timeout=0.5), planar.default_loads
    wrench.take(none.with_(wrench_world=[0, 0, 0, 0.1, 0, 0]), 0.0)
    wrench.take(none.with_(wrench_world=np.zeros(6)), 0.1)
    wrench.loads(none, 1.0)
    assert wrench.missing == ""


def test_the_same_wrench_once_more_is_not_another_one():
    """The robot was solved for again with every message of a constant wrench."""
    planar = robot("rfrfr")
    wrench, none = ExternalWrench(planar, timeout=0.5), planar.default_loads
    first = none.with_(wrench_world=[0, 0, 0, 0.1, 0, 0])
    wrench.take(first, 0.0)
    wrench.take(none.with_(wrench_world=[0, 0, 0, 0.1, 0, 0]), 0.4)
    assert wrench.loads(first, 0.8) is first
    wrench.take(none.with_(wrench_world=[0, 0, 0, 0.1, 1e-9, 0]), 0.8)
    assert wrench.loads(first, 0.8) is not first

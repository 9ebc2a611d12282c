# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Names of other libraries, and where what they stand for is."""

import copy
import pickle

import numpy as np
import pytest

import cpr_core
from cpr_core.model.other_names import OF_EQUILIBRIA, OF_ROBOTS

ROBOT = cpr_core.load_robot("rfrfr")
HOME = cpr_core.solve_home(ROBOT)
KNOWN = {
    "cpr_core": cpr_core,
    "robot": ROBOT,
    "equilibrium": HOME,
    "motors": HOME.motors,
    "pose": HOME.pose,
}


@pytest.mark.parametrize(
    ("owner", "name", "there"),
    [(ROBOT, *pair) for pair in OF_ROBOTS.items()]
    + [(HOME, *pair) for pair in OF_EQUILIBRIA.items()],
)
def test_it_is_told_where_it_is_and_it_is_there(owner, name, there, monkeypatch):
    monkeypatch.setattr(cpr_core, "view", lambda robot: robot)
    with pytest.raises(AttributeError, match=f"no attribute '{name}'; there is ") as caught:
        getattr(owner, name)
    assert str(caught.value).endswith(there)
    assert (caught.value.name, caught.value.obj) == (name, owner)
    assert eval(there, KNOWN) is not None


@pytest.mark.parametrize("owner", [ROBOT, HOME])
def test_other_names_are_missing_as_ever(owner):
    with pytest.raises(AttributeError, match=r"object has no attribute 'nothing'$"):
        getattr(owner, "nothing")  # noqa: B009
    assert not hasattr(owner, "nothing")
    assert getattr(owner, "forward", None) is None
    for same in (copy.copy(owner), copy.deepcopy(owner), pickle.loads(pickle.dumps(owner))):
        assert type(same) is type(owner)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(HOME)).motors, HOME.motors)


def test_a_robot_is_made_of_a_description():
    with pytest.raises(cpr_core.InvalidRequest, match="got str 'rfrfr': load_robot makes a robot"):
        cpr_core.Robot("rfrfr")

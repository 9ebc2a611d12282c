# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Events are where bisection alone finds them, in fewer solves."""

import numpy as np
import pytest

from cpr_core import NotReached, load_robot, solve_forward_by_effort, solve_home
from cpr_core.solving import bracketing
from cpr_core.solving.path import Path
from cpr_core.solving.targets import MotorTarget


def ends(robot, targets, solved):
    """Where walks to efforts are stopped, by number, and how many points they have asked for."""
    home, found = solve_home(robot), {}
    solved.clear()
    for number, efforts in enumerate(targets):
        try:
            solve_forward_by_effort(robot, efforts, start=home)
        except NotReached as end:
            found[number] = end.event
    return found, len(solved)


@pytest.mark.parametrize(
    ("name", "kind"), [("rfrfr", "fold"), ("six_rfs", "fold"), ("gough_stewart", "motor_limit")]
)
def test_events_are_where_bisection_finds_them_in_fewer_solves(name, kind, monkeypatch):
    robot, random, solved = load_robot(name), np.random.default_rng(1), []
    at, along = Path.at, Path.along
    monkeypatch.setattr(Path, "at", lambda *given: solved.append(given) or at(*given))
    monkeypatch.setattr(Path, "along", lambda *given: solved.append(given) or along(*given))
    home = solve_home(robot).efforts
    size = np.abs(home).max()
    targets = [home + 4.0 * size * random.normal(size=len(home)) for _ in range(5)]
    found, count = ends(robot, targets, solved)
    monkeypatch.setattr(bracketing, "_narrowed", lambda find, wide: wide)
    expected, more = ends(robot, targets, solved)
    assert found.keys() == expected.keys()
    assert kind in [event.kind for event in found.values()]
    for number, event in found.items():
        assert event.kind == expected[number].kind
        assert (event.index_before, event.index_after) == (
            expected[number].index_before,
            expected[number].index_after,
        )
        assert event.fraction == pytest.approx(expected[number].fraction, abs=5e-9)
        assert (
            bracketing.distance(*(_Place(each.equilibrium) for each in (event, expected[number])))
            < 1e-5
        )
    assert count < 0.85 * more


class _Place:
    def __init__(self, equilibrium):
        self.equilibrium = equilibrium


@pytest.mark.parametrize("arc", [0.0, 1e-9, -1e-9, 0.05, -0.05])
def test_a_step_by_arc_length_may_be_none_and_may_lead_back(arc):
    robot = load_robot("rfrfr")
    home = solve_home(robot)
    path = Path(home, MotorTarget(home.motors + [0.4, -0.3]), home.loads)
    start = path.begin()
    tangent = path.tangent(start)
    found = bracketing.along(path, start, tangent, arc)
    assert found.fraction == pytest.approx(arc * tangent.fraction, rel=0.1, abs=1e-12)
    assert tangent.cosine(found.tangent) > 0.99

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots with motions that cost no elastic energy, as of what hangs: stability without a margin."""

import math

import numpy as np
import pytest
from helpers.pendulum import pendulum, with_hanging_links

from cpr_core import (
    NoForwardSolution,
    UnstableEquilibrium,
    critical_load,
    derivatives,
    load_robot,
    restore_equilibrium,
    solve_forward,
    solve_home,
    solve_inverse,
    trace,
)

#: A way of rfrfr on which it is unstable from 0.89 to 0.998, and stable at both ends.
FIRST = np.array([0.26248885530230015, -0.2484422279951375])
LAST = np.array([0.2073511413318955, -0.024830572845052398])


@pytest.fixture(scope="module")
def start():
    found = solve_inverse(with_hanging_links("rfrfr", (0.6, 0.9), 0.6), FIRST, stable_only=True)
    assert math.isnan(found.margin)
    return found


def test_a_stretch_without_stability_is_not_stepped_over(start):
    """What hangs has no say in it; the way was accepted, and no event was told."""
    with pytest.raises(UnstableEquilibrium) as refused:
        solve_inverse(start.robot, LAST, start=start, stable_only=True)
    assert refused.value.fraction == pytest.approx(0.894, abs=1e-4)
    found = trace(start.robot, pose=LAST, start=start, points=2)
    assert [event.kind for event in found.events] == ["stability", "stability"]


def test_near_requests_look_for_one_too(start):
    near = solve_inverse(start.robot, FIRST + 0.885 * (LAST - FIRST), start=start)
    with pytest.raises(UnstableEquilibrium):
        solve_inverse(start.robot, LAST, start=near, stable_only=True)


def test_a_fold_under_a_load_is_a_critical_load(start):
    """It was told to be no end of stability: the eigenvalue of what hangs is small from the start."""
    found, alone = (
        critical_load(solve_home(robot), [0.0, -1.0, 0.0])
        for robot in (start.robot, load_robot("rfrfr"))
    )
    assert found.value == pytest.approx(alone.value, rel=1e-4)
    assert found.kind == alone.kind == "fold"


def test_light_links_that_hang_make_no_crossing_of_a_fold(start):
    """They are hardly held anywhere, which looked like a second branch; heavier ones did not."""
    for mass in (1e-7, 1e-6, 1e-4):
        paths = [f"legs[2].chain[{number}].mass" for number in (1, 3, 5)]
        robot = start.robot.with_parameters(dict.fromkeys(paths, mass))
        home = solve_home(robot)
        loads = home.loads.with_(wrench_world=[0, 0, 0, 0, -6.0, 0])
        with pytest.raises(NoForwardSolution, match="the branch turns back") as refused:
            solve_forward(robot, home.motors, start=home, loads=loads)
        assert refused.value.event.kind == "fold"


@pytest.mark.parametrize("way", [0.0, 0.5, 0.95])
def test_what_hangs_follows_and_all_else_has_its_margin(start, way):
    """Also where that is negative."""
    place, robot = FIRST + way * (LAST - FIRST), load_robot("rfrfr")
    alone = solve_inverse(robot, place, start=solve_inverse(robot, FIRST))
    found = solve_inverse(start.robot, place, start=start)
    assert (alone.margin < 0.0) == (way == 0.95)
    assert alone.spectrum_locked.firm_margin == alone.margin
    assert found.spectrum_locked.firm_margin == pytest.approx(alone.margin, abs=1e-5)


@pytest.mark.parametrize("moved", [0.0, 0.05, 0.1])
def test_where_there_is_no_margin_it_has_no_derivatives(start, moved):
    """They were anything, by rounding: -0.9 per kg of the platform, say."""
    motors = solve_home(start.robot).motors + [moved, -moved]
    paths = ["platform.mass", "rod.young_modulus", "rod.shear_modulus"]
    found = derivatives(
        solve_forward(start.robot, motors), paths, of=("margin", "smallest_eigenvalue")
    )
    assert np.isnan(found.margin).all()
    assert np.isfinite(found.smallest_eigenvalue).all()


def test_what_stands_on_its_head_has_none():
    robot = pendulum()
    home = solve_home(robot)
    assert home.spectrum_locked.firm_margin > 0.0
    shape = home.motors, home.leg_coordinates, -home.multipliers
    place = home.platform_rotation, home.platform_position
    upside_down = restore_equilibrium(robot, home.loads.scaled(-1.0), *shape, *place)
    assert not upside_down.stable
    assert upside_down.spectrum_locked.firm_margin == -math.inf


def test_the_greatest_margin_is_that_of_all_else():
    """It was found anywhere."""
    robot = with_hanging_links("four_rfr", (0.0, 0.9), 0.4)
    margins = [
        solve_inverse(robot, [-0.06, 0.03, 0.1], objective=name).spectrum_locked.firm_margin
        for name in ("greatest_margin", "least_motion", "least_effort")
    ]
    assert margins[0] == max(margins)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is found by condensing legs, against the dense method."""

import gc
import math
import weakref
from dataclasses import replace

import numpy as np
import pytest
from helpers.columns import AT_TIP, column
from helpers.kernel_entry import prepared
from helpers.random_chains import random_chain_robot
from helpers.shipped_steps import CHAINS, SHORT_FORM, STEPS
from helpers.yaml_content import shipped_content

from cpr_core import (
    DistributedForce,
    Loads,
    NotReached,
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    spectrum,
)
from cpr_core.description import joints, motors
from cpr_core.kernels.linearisation_kernel import linearise
from cpr_core.kernels.pencil import pencil_of
from cpr_core.model.stability import _Dense


def equilibria(name, count):
    """Home and places around it, under a force."""
    robot, rng = load_robot(name), np.random.default_rng(7)
    force = [0, 0, 0, 0.02, -0.03, 0.0 if robot.planar else 0.04]
    loads = robot.default_loads.with_(wrench_world=force)
    found = [solve_home(robot)]
    while len(found) < count:
        change = 2.0 * rng.uniform(-1.0, 1.0, robot.motor_count) * np.abs(STEPS[name])
        try:
            found.append(solve_forward(robot, solve_home(robot).motors + change, loads=loads))
        except NotReached as error:
            found.append(error.last)
    return found


def assert_eigenvalues_same(equilibrium):
    """They agree, as far as the dense method's own rounding allows."""
    found = equilibrium.linearisation
    readings = [("locked", found.smallest_locked)]
    if equilibrium.robot.kernel_arrays.one_slot_a_motor:
        readings.append(("free", found.smallest_free))
    for motors_are, value in readings:
        dense = spectrum(equilibrium, motors_are).eigenvalues
        assert value == pytest.approx(dense[0], rel=1e-10, abs=1e-10 * np.abs(dense).max())
    assert found.margin == pytest.approx(_Dense(equilibrium, "locked").margin(), rel=1e-9, abs=1e-9)


def assert_same(equilibrium):
    """So do matrices."""
    assert_eigenvalues_same(equilibrium)
    found = equilibrium.linearisation
    n = equilibrium.robot.motor_count
    moved, efforts = equilibrium.dense_response.moved, equilibrium.dense_response.efforts
    platform = moved[equilibrium.robot.platform_indices]
    for name, expected in (
        ("jacobian", platform[:, :n]),
        ("platform_by_wrench", platform[:, n:]),
        ("efforts_by_motors", efforts[:, :n]),
        ("efforts_by_wrench", efforts[:, n:]),
    ):
        size = np.abs(expected).max(initial=0.0)
        np.testing.assert_allclose(
            getattr(found.response, name), expected, rtol=0, atol=1e-8 * size, err_msg=name
        )


@pytest.mark.parametrize("name", [*SHORT_FORM, *CHAINS])
def test_condensed_and_dense_agree_at_many_equilibria(name):
    for equilibrium in equilibria(name, 12):
        assert_same(equilibrium)


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("seed", range(6))
def test_they_agree_with_passive_joints_with_and_without_springs(seed, planar):
    made = random_chain_robot(seed, planar)
    content = made.content | {"home": made.content["home"] | {"joints": made.joints}}
    robot = load_robot(content)
    home, rng = solve_home(robot), np.random.default_rng(seed)
    compared = 0
    for size in (0.0, 0.1, 0.2, 0.3):
        away = home.motors + size * rng.uniform(-1.0, 1.0, robot.motor_count)
        try:
            reached = solve_forward(robot, away)
        except NotReached:
            continue  # at a fold, matrices are as large as rounding makes them
        assert_eigenvalues_same(reached)
        if reached.linearisation.response is not None:  # else some leg is nearly straight
            assert_same(reached)
            compared += 1
    assert compared >= 2


def hinged(stiffness, weight=False):
    """A 3-PRS with springs at its hinges; a weight may hang between two of them about one axis."""
    content = shipped_content("three_prs")
    for leg in content["legs"]:
        leg["chain"][2]["stiffness"] = stiffness
    if weight:
        chain = content["legs"][0]["chain"]
        hanging = [chain[2], {"link": [-0.05, 0, 0], "mass": 0.1}, {"link": [0.05, 0, 0]}]
        chain[2:2] = hanging
    return load_robot(content)


def test_the_energy_of_springs_at_joints_counts():
    soft, stiff = (solve_home(hinged(stiffness)) for stiffness in (0.05, 5.0))
    for home in (soft, stiff):
        assert_same(home)
    assert abs(soft.margin - stiff.margin) > 0.01


def test_a_motion_of_joints_without_elastic_energy_is_told_by_the_dense_method():
    """The weight swings and the platform stays: without the energy of springs there is no margin."""
    robot = hinged(0.5, weight=True)
    home = solve_home(robot)
    assert_same(home)
    pencil, found = pencil_of(robot.kernel_arrays, robot.strain_grams), np.empty(3)
    without = prepared(robot.kernel_arrays, pencil=pencil)
    pencil.springs["lane"][:] = 0.0
    matrix = np.empty((len(robot.kernel_arrays.border_indices),) * 2)
    linearise(without, home.factors, home.record, True, False, found, matrix)
    assert math.isnan(found[0])
    # Found from the start, where otherwise the softest motion has led to it.
    assert found[1] == pytest.approx(home.linearisation.smallest_locked, rel=1e-11)


def test_they_agree_where_robots_are_unstable():
    robot = load_robot("rfrfr", modes=12)
    equilibrium, seen = solve_inverse(robot, [0.0, 0.8]), []
    for y in (0.3, 0.0358, 0.0357, 0.03, -0.05, -0.1):
        equilibrium = solve_inverse(robot, [0.0, y], start=equilibrium)
        assert_same(equilibrium)
        seen.append((equilibrium.index_locked, equilibrium.linearisation.margin < 0.0))
    assert [index for index, _ in seen] == [0, 0, 1, 1, 1, 2]
    assert all((index > 0) == negative for index, negative in seen)
    spatial = load_robot("six_rfs")
    softened = solve_forward(
        spatial, solve_home(spatial).motors + np.array([2, 2, -1.6, -1.6, -2, -2], float)
    )
    assert softened.index_free > 0
    assert_same(softened)


def test_they_agree_under_loads_without_potential():
    robot = load_robot("six_rfs")
    for field, wrench in (
        ("wrench_world", [0.02, -0.01, 0.03, 0.1, 0, 0]),
        ("wrench_body", [0.01, 0.02, 0, 0, 0.1, -0.2]),
    ):
        loaded = solve_forward(
            robot, solve_home(robot).motors, loads=Loads.none().with_(**{field: wrench})
        )
        assert_same(loaded)


@pytest.mark.parametrize("planar", [True, False])
def test_they_agree_without_motors(planar):
    robot = column(motors.Welded(), joints.Fixed(AT_TIP), planar=planar)
    pushed = [0.0, 0.02 * (not planar), 0.05, 0.0, 0.1, 0.2 * (not planar)]
    bent = solve_forward(robot, [], loads=robot.default_loads.with_(wrench_world=pushed))
    assert_same(bent)


@pytest.mark.parametrize("share", np.linspace(0.9, 1.1, 9))
def test_margins_keep_their_digits_where_the_leg_alone_has_the_same_eigenvalue(share):
    """What a tip holds adds nothing to a column's stiffness: a pivot of the leg is nearly zero there."""
    robot = column(motors.Welded(), joints.Fixed(AT_TIP), planar=False)
    pushed = share * np.array([0.0, 0.02, 0.05, 0.0, 0.1, 0.2])
    bent = solve_forward(robot, [], loads=robot.default_loads.with_(wrench_world=pushed))
    dense = _Dense(bent, "locked").margin()
    assert bent.linearisation.margin == pytest.approx(dense, abs=1e-12)


@pytest.mark.parametrize("modes", [3, 8, 12])
def test_they_agree_for_any_number_of_modes(modes):
    assert_same(solve_home(load_robot("six_rfs", modes=modes)))


def test_a_straight_leg_is_told_too():
    """A straight clamped leg cannot hold its tip along itself."""
    straight = solve_home(column(motors.Welded(), joints.Fixed(AT_TIP)))
    assert_same(straight)
    assert straight.spectrum_locked.margin == pytest.approx(1.0)


def fed_straight(angle, tip):
    """A straight rod that a motor feeds, and a bent one beside it, in the plane."""
    rod = {"length": 0.45, "section": {"shape": "circular", "radius": 0.001}}
    rod |= {"young_modulus": 210e9, "shear_modulus": 82e9}
    along = [float(np.cos(angle)), float(np.sin(angle)), 0.0]
    turn = 2.0 * 0.45  # of the bent one
    end = np.array([np.sin(turn), 1.0 - np.cos(turn), 0.0]) / 2.0
    place = 0.45 * np.array(along)
    tips = {
        "fixed": {"type": "fixed", "position": [0, 0, 0], "tangent": along},
        "revolute": {"type": "revolute", "position": [0, 0, 0]},
    }
    bent = {
        "base": {"position": (place - end).tolist(), "tangent": [1, 0, 0]},
        "rod": rod | {"rest_curvature": {"bending_3": [2.0]}},
        "motor": {"type": "revolute", "axis": [0, 0, 1]},
        "tip": tips["fixed"] | {"tangent": [float(np.cos(turn)), float(np.sin(turn)), 0.0]},
    }
    straight = {
        "base": {"position": [0, 0, 0], "tangent": along},
        "motor": {"type": "extensible"},
        "tip": tips[tip],
    }
    content = {
        "name": "fed_straight",
        "space": "planar",
        "rod": rod,
        "strain": {"bending_3": 5},
        "platform": {"shape": "body"},
        "legs": [straight, bent],
        "controlled": ["x", "y"],
        "home": {"motors": [0.45, 0.0], "platform": {"position": place.tolist()}},
    }
    return load_robot(content)


@pytest.mark.parametrize("tip", ["fixed", "revolute"])
@pytest.mark.parametrize("angle", [0.0, 0.2, 0.9])
def test_they_agree_where_a_motor_feeds_a_straight_rod(angle, tip):
    """Free, the motor pushes against next to nothing: its pivot is rounding, of either sign."""
    robot = fed_straight(angle, tip)
    home = solve_home(robot)
    for force in (0.0, *10.0 ** np.arange(-12.0, -1.0)):
        pushed = robot.default_loads.with_(wrench_world=[0, 0, 0, 0.3 * force, force, 0])
        assert_same(solve_forward(robot, home.motors, start=home, loads=pushed))


@pytest.mark.parametrize("push", [0.1, 0.3, 1.0])
def test_a_fed_rod_hardly_bent_answers_as_precisely_as_any(push):
    """Behind it the tip is clamped beside its axis; the feed answered with all digits wrong."""
    content = {
        "name": "fed",
        "space": "planar",
        "rod": {
            "length": 0.43,
            "section": {"shape": "circular", "radius": 0.0016},
            "young_modulus": 110e9,
            "shear_modulus": 42e9,
        },
        "legs": [
            {
                "base": {"position": [0, 0, 0], "tangent": [-0.943, -0.333, 0]},
                "chain": [
                    {"rod": {}, "motor": "feed"},
                    {"link": [0.037, 0.0046, 0], "tangent": [0.7585, -0.6517, 0]},
                ],
                "tip": {"type": "fixed", "position": [0, 0, 0], "tangent": [-0.87, 0.48, 0]},
            }
        ],
        "controlled": ["y"],
        "home": {"motors": [0.43], "platform": {"position": [-0.4, -0.15, 0]}},
    }
    robot = load_robot(content)
    loads = Loads.none().with_(
        distributed=[
            DistributedForce("leg1", [0, 1], push * np.array([[-0.31, 0.31, 0], [-0.55, -0.47, 0]]))
        ]
    )
    home = solve_home(robot)
    found = solve_forward(robot, home.motors, start=home, loads=loads)
    whole = found.dense_response.of_platform(robot.platform_indices)
    scale = np.abs(whole.matrix).max()
    np.testing.assert_allclose(found.response.matrix, whole.matrix, rtol=0, atol=1e-8 * scale)


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "two_rods"])
def test_the_order_of_questions_changes_nothing(name):
    """Held motors are asked for alone by who commands them, with all the rest by others."""
    robot = load_robot(name)
    first = solve_home(robot)
    together, apart = (replace(first, record=first.record.copy()) for _ in range(2))
    whole, margin = together.linearisation, apart.margin
    assert margin == whole.margin == together.margin == apart.linearisation.margin
    assert apart.linearisation.smallest_locked == whole.smallest_locked
    assert apart.linearisation.smallest_free == whole.smallest_free
    np.testing.assert_array_equal(apart.linearisation.response.matrix, whole.response.matrix)


def test_it_is_computed_once_and_kept_as_long_as_the_equilibrium():
    home = solve_home(load_robot("rfrfr"))
    assert home.linearisation is home.linearisation
    with pytest.raises(ValueError, match="read-only"):
        home.linearisation.response.jacobian[0, 0] = 0.0


def test_nothing_that_was_asked_keeps_an_equilibrium_alive():
    """At two hundred ticks a second garbage must not wait for the collector of circles."""
    robot = load_robot("rfrfr")
    equilibrium = solve_forward(robot, [2.6, 0.56])
    for found in (equilibrium.spectrum_locked, equilibrium.spectrum_free):
        assert np.isfinite([found.smallest, found.eigenvalues[0]]).all()
    assert equilibrium.spectrum_locked.margin > 0.0
    _ = kinemato_statics(equilibrium).stiffness()
    gone = weakref.ref(equilibrium)
    gc.disable()
    try:
        del equilibrium, found
        assert gone() is None
    finally:
        gc.enable()

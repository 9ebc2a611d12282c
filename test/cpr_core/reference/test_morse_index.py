# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Stability of continuous chains by their Jacobi fields: indices, conjugate points, classical loads."""

from collections import Counter
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
import yaml
from helpers.reference_robots import (
    FILES,
    loaded,
    met,
    reference_robot,
    robot_with,
    robot_with_tips,
    walked,
)
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from cpr_core import InvalidRequest, kinemato_statics, load_robot, solve_forward, solve_home
from cpr_core.reference import morse_index as morse_index_module
from cpr_core.reference.conjugate_points import conjugate_points
from cpr_core.reference.continuous_equilibrium import ContinuousEquilibrium
from cpr_core.reference.continuous_rods import solve_continuous
from cpr_core.reference.morse_index import energy_form, index_beyond, index_falls, morse_index
from cpr_core.reference.shooting_method import ACCURATE, ShootingMethod

#: Halves the time; errors stay far below what is compared.
METHOD = ShootingMethod(steps=32)
CHAIN_FILES = [
    name
    for name in FILES
    if any(leg.elements is not None for leg in reference_robot(name).description.legs)
]
#: Configurations of all robots of chains together.
CONFIGURATIONS = 200


@pytest.mark.parametrize("name", FILES)
def test_both_indices_are_those_of_continuous_rods(name):
    robot = reference_robot(name)
    count = -(-CONFIGURATIONS // len(CHAIN_FILES)) if name in CHAIN_FILES else 6
    near = list(islice(walked(robot, count, seed=1), count // 3))
    far = list(islice(met(robot, count, seed=1), count - len(near)))
    assert len(near) + len(far) == count
    seen = Counter()
    for modes in near + far:
        rods = solve_continuous(modes, method=METHOD)
        assert_allclose(rods.platform_position, modes.platform_position, rtol=0.0, atol=1e-4)
        assert morse_index(rods) == (modes.index_locked, modes.index_free)
        seen[modes.index_locked] += 1
    assert seen[0]
    assert name not in CHAIN_FILES or len(seen) > 1


def assert_responds_alike(modes):
    """The form answers to motors and to wrenches on the platform as the tangent of the modes does."""
    rods, robot = solve_continuous(modes), modes.robot
    form, kinematics = energy_form(rods), kinemato_statics(modes)
    outer = len(robot.platform_axes) + robot.motor_count
    unit = robot.numbers.unit[-outer:] / np.sqrt(robot.numbers.energy_unit)
    condensed = np.linalg.inv(np.linalg.inv(form.matrix)[:outer, :outer]) / unit / unit[:, None]
    platform, motors = np.split(np.arange(outer), [len(robot.platform_axes)])
    compliance = np.linalg.inv(condensed[np.ix_(platform, platform)])
    across = condensed[np.ix_(motors, platform)]
    efforts = condensed[np.ix_(motors, motors)] - across @ compliance @ across.T
    scale = np.abs(efforts).max()
    assert_allclose(efforts, kinematics.efforts_by_motors, rtol=0.0, atol=1e-5 * scale)
    into_body = np.kron(np.eye(2), modes.platform_rotation.T)
    into_body = into_body[np.ix_(robot.platform_axes, robot.platform_axes)]
    found = into_body @ compliance @ into_body.T
    expected = kinematics.platform_by_wrench
    assert_allclose(found, expected, rtol=0.0, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("name", FILES)
def test_robots_are_as_stiff_as_continuous_rods(name):
    for modes in walked(reference_robot(name, 16), 2, seed=4):
        assert_responds_alike(modes)


@pytest.mark.parametrize(
    ("chains", "shared"),
    [
        (("passive turn", "passive shift", "sprung shift"), False),
        (("two rods", "rigid middle", "joint between rods"), True),
        (("joint behind the rod", "motor at the far end", "two motors"), True),
        (("one motor twice", "fed behind a joint", "fed and turned"), False),
        (("end piece", "universal", "hub"), True),
    ],
)
def test_every_element_counts(chains, shared):
    robot = robot_with(chains, modes=10, shared=shared)
    assert robot.motor_count < 3 or not shared
    home = solve_home(robot)
    assert_responds_alike(solve_forward(robot, home.motors, start=home, loads=loaded(robot)))
    for modes in islice(met(robot, 3, seed=2), 4):
        assert morse_index(solve_continuous(modes)) == (modes.index_locked, modes.index_free)


@pytest.mark.parametrize("tip", ["revolute", "universal"])
def test_tips_that_hold_some_moments_count(tip):
    home = solve_home(robot_with_tips(tip))
    assert_responds_alike(home)
    assert morse_index(solve_continuous(home)) == (home.index_locked, home.index_free)


@pytest.mark.parametrize(("name", "count"), [("rfrfr", 12), ("six_rfs", 5)])
def test_the_count_is_that_of_conjugate_points_on_the_robots_of_the_paper(name, count):
    seen = set()
    for modes in islice(met(reference_robot(name), count, seed=5), count):
        rods = solve_continuous(modes)
        points = conjugate_points(rods)
        assert morse_index(rods).locked == len(points)
        if points and len(points) not in seen:
            assert_allclose(index_falls(rods), points, rtol=0.0, atol=1e-8)
        seen.add(len(points))
    assert len(seen) > 1


def test_rods_may_be_cut_in_parts_that_are_too_long_at_first(monkeypatch):
    """A whole rod may have a conjugate point of its own, of which its ends know nothing."""
    monkeypatch.setattr(morse_index_module, "_LONGEST", 1e3)
    seen = set()
    for modes in islice(met(reference_robot("rfrfr"), 12, seed=5), 12):
        assert morse_index(solve_continuous(modes)) == (modes.index_locked, modes.index_free)
        seen.add((modes.index_locked, modes.index_free))
    assert len(seen) == 3


@pytest.mark.parametrize("name", CHAIN_FILES)
def test_conjugate_points_of_chains_are_as_many_as_the_index_says(name):
    modes = max(met(reference_robot(name), 8, seed=1), key=lambda each: each.index_locked)
    rods = solve_continuous(modes, method=METHOD)
    points = conjugate_points(rods)
    assert len(points) == modes.index_locked > 0
    for point in {*points} - {1.0}:
        beyond = [index_beyond(rods, max(0.0, point + side)) for side in (-1e-6, 1e-6)]
        assert beyond[0] - beyond[1] == points.count(point)
    assert index_beyond(rods, 0.95) == points.count(1.0)


COLUMN = """
name: column
space: spatial
rod: {length: 0.4, section: {shape: circular, radius: 0.001}, young_modulus: 210e9, shear_modulus: 82e9}
controlled: []
legs:
- base: {position: [0, 0, 0], tangent: [1, 0, 0], normal: [0, 1, 0]}
  chain: []
  tip: {type: fixed, position: [0, 0, 0], tangent: [1, 0, 0], normal: [0, 1, 0]}
home: {motors: [], platform: {position: [0.4, 0, 0]}}
"""
STIFFNESS = 210e9 * np.pi / 4.0 * 1e-12
LENGTH, SPRING, FOOT, HEAD = 0.4, 0.9, 0.03, 0.06


def straight(chain, load):
    """A column along x, straight under a dead load at its head."""
    content = yaml.safe_load(COLUMN)
    content["legs"][0]["chain"] = chain
    robot = load_robot(content)
    reach = sum(
        element["link"][0] if "link" in element else element.get("rod", {}).get("length", 0.0)
        for element in chain
    )
    passive = sum({"universal": 2, "revolute": 1}.get(e.get("joint"), 0) for e in chain)
    return ContinuousEquilibrium(
        robot=robot,
        loads=robot.default_loads.with_(wrench_world=[0, 0, 0, -load, 0, 0]),
        motors=np.zeros(0),
        passive=np.zeros(passive),
        platform_rotation=np.eye(3),
        platform_position=np.array([reach, 0.0, 0.0]),
        base_wrenches=np.array([[0.0, 0.0, 0.0, -load, 0.0, 0.0]]),
        residual=0.0,
        iterations=0,
        method=ACCURATE,
    )


ROD = {"rod": {"length": LENGTH}}
SPRUNG = {"joint": "universal", "axes": [[0, 1, 0], [0, 0, 1]], "stiffness": SPRING}


def sprung_column(k, foot=0.0, head=0.0, spring=SPRING):
    """Zero where a sprung foot, a rod and a head, rigid but for the rod, stay bent under EJ k^2.

    With w the deflection of the rod and y that of the load, E J w'' = P (y - w), so
    w = y + a cos ks + b sin ks; at its start the spring has turned by P y / spring.
    """
    load = STIFFNESS * k**2
    turn = load / spring  # for y = 1
    a, b = foot * turn - 1.0, turn / k
    sine, cosine = np.sin(k * LENGTH), np.cos(k * LENGTH)
    return a * cosine + b * sine + head * k * (b * cosine - a * sine)


@pytest.mark.parametrize(
    ("chain", "equation"),
    [
        ([ROD], lambda k: -np.cos(k * LENGTH)),
        ([SPRUNG, ROD], lambda k: sprung_column(k)),
        ([ROD, {"link": [HEAD, 0, 0]}], lambda k: sprung_column(k, head=HEAD, spring=1e12)),
        (
            [SPRUNG, {"link": [FOOT, 0, 0]}, ROD, {"link": [HEAD, 0, 0]}],
            lambda k: sprung_column(k, FOOT, HEAD),
        ),
    ],
    ids=["column", "sprung foot", "rigid head", "sprung, with foot and head"],
)
def test_columns_with_springs_and_rigid_ends_buckle_at_their_loads(chain, equation):
    waves = np.linspace(0.1, 30.0, 3000)
    signs = np.sign([equation(k) for k in waves])
    roots = [
        brentq(equation, waves[i], waves[i + 1], xtol=1e-13)
        for i in np.flatnonzero(signs[1:] != signs[:-1])
    ]
    assert len(roots) >= 3
    for number, root in enumerate(roots[:3]):
        load = STIFFNESS * root**2
        # A round column bends either way.
        for factor, index in ((1.0 - 1e-8, 2 * number), (1.0 + 1e-8, 2 * number + 2)):
            column = straight(chain, factor * load)
            assert column.balance.largest < 1e-11
            assert morse_index(column) == (index, index)


@pytest.mark.parametrize("first", [0.1, 0.3])
def test_beyond_a_section_of_two_rods_is_a_shorter_column(first):
    """Sections count along the rods of a leg, whichever of them they are in."""
    waves = 2.6 * np.pi
    parts = [{"rod": {"length": first}}, {"rod": {"length": LENGTH - first}}]
    column = straight(parts, STIFFNESS * (waves / LENGTH) ** 2)
    for number in range(1, 4):
        section = 1.0 - (number - 0.5) * np.pi / waves  # Euler: clamped here, free at the tip
        assert index_beyond(column, section - 1e-7) == 2 * number
        assert index_beyond(column, section + 1e-7) == 2 * number - 2


def test_gravity_on_links_counts():
    """A pendulum that stands is unstable about both axes of its joint."""
    heavy, free = {"link": [0.2, 0, 0], "mass": 0.5}, SPRUNG | {"stiffness": 0.0}
    for gravity, index in ((9.81, 0), (-9.81, 2)):
        column = straight([{"rod": {"length": 0.05}}, free, heavy], -0.5 * gravity)
        loads = column.robot.default_loads.with_(gravity=[gravity, 0, 0])
        hanging = replace(column, loads=loads)
        assert hanging.balance.largest < 1e-11
        assert morse_index(hanging).locked == index


def test_sections_that_are_none_are_refused():
    column = straight([ROD], 0.1)
    for u in (-0.1, 0.96):
        with pytest.raises(InvalidRequest, match="section"):
            index_beyond(column, u)

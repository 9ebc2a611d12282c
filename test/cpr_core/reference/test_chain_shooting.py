# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Strain modes against continuous rods by shooting, on every robot; the general and the compiled way."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from helpers.chain_robots import CHAINS
from helpers.reference_paths import numbers, read
from helpers.reference_robots import (
    FILES,
    loaded,
    reference_robot,
    robot_with,
    robot_with_tips,
    walked,
)
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose

from cpr_core import (
    InvalidRequest,
    NoForwardSolution,
    Robot,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.description.chain import ChainJoint, ChainRod
from cpr_core.description.loads import DistributedForce, PointForce
from cpr_core.reference import (
    chain_robot,
    morse_index,
)
from cpr_core.reference.chain_shooting import solve_chains
from cpr_core.reference.continuous_rods import follow_motors, solve_continuous
from cpr_core.reference.shooting_method import ACCURATE, ShootingMethod
from cpr_core.rods.rod import Profile, Rod
from cpr_core.rods.sections import CircularSection, RectangularSection

#: Every chain of the helper, three to a robot that can be assembled.
CHAINS_OF_ROBOTS = [
    ("motor", "zero and ratio", "sprung motor"),
    ("passive turn", "passive shift", "sprung shift"),
    ("driven shift", "motor", "hub"),
    ("bent hub", "heavy hub", "nothing but a rod"),
    ("end piece", "universal", "hub"),
    ("two rods", "rigid middle", "joint between rods"),
    ("joint behind the rod", "motor at the far end", "two motors"),
    ("fed behind a rod", "one motor twice", "hub"),
    ("one motor twice", "fed behind a joint", "fed and turned"),
    ("hub", "passive turn", "crank and universal"),
    ("no rod", "motor", "hub"),
    ("fed by a roller", "motor", "hub"),
]


def assert_same(rods, modes, position=1e-7, effort=1e-6):
    assert rods.residual < rods.method.tolerance
    assert rods.integration_error < 1e-9
    assert_allclose(rods.platform_position, modes.platform_position, rtol=0.0, atol=position)
    assert_allclose(rods.platform_rotation, modes.platform_rotation, rtol=0.0, atol=10 * position)
    assert_allclose(rods.efforts, modes.efforts, rtol=0.0, atol=effort)


@pytest.mark.parametrize("name", FILES)
def test_every_robot_is_where_continuous_rods_are(name):
    robot = reference_robot(name)
    home, loads = solve_home(robot), loaded(robot)
    heavy = solve_forward(robot, home.motors, start=home, loads=loads)
    for modes in (home, heavy, *walked(robot, 2, seed=3)):
        assert_same(solve_continuous(modes), modes)
    if robot.motor_count == len(robot.platform_axes):
        held = solve_continuous(heavy, "pose")
        assert_allclose(held.platform_position, heavy.platform_position, rtol=0.0, atol=0.0)
        assert_allclose(held.motors, heavy.motors, rtol=0.0, atol=1e-6)


def test_rods_under_large_forces_are_shot_along_in_parts():
    """Nearly straight legs that are pulled by 30 N: what the base does wrong grows far beyond."""
    for modes in walked(reference_robot("gough_stewart"), 3, seed=1):
        rods = solve_continuous(modes)
        assert rods.nodes
        assert rods.integration_error < 1e-11
        assert_same(rods, modes, position=1e-6, effort=1e-4)  # of twelve modes


def test_every_chain_is_in_some_robot():
    assert {chain for chains in CHAINS_OF_ROBOTS for chain in chains} == set(CHAINS)


@pytest.mark.parametrize("chains", CHAINS_OF_ROBOTS, ids="-".join)
def test_every_element_of_chains_is_where_continuous_rods_are(chains):
    robot = robot_with(chains, modes=12)
    home = solve_home(robot)
    modes = solve_forward(robot, home.motors, start=home, loads=loaded(robot))
    rods = solve_continuous(modes)
    assert_same(rods, modes)
    passive = [i for leg in rods.model.legs for i in leg.passive]
    assert_allclose(rods.passive, modes.state[passive], rtol=0.0, atol=1e-6)


def with_rods(robot, change):
    """The robot with other rods."""
    description = robot.description
    legs = tuple(
        replace(
            leg,
            rod=change(leg.rod),
            elements=tuple(
                replace(element, rod=change(element.rod))
                if isinstance(element, ChainRod)
                else element
                for element in leg.chain
            ),
        )
        for leg in description.legs
    )
    return Robot(replace(description, legs=legs, stations=(0.3, 0.6)))


def tapered(rod: Rod) -> Rod:
    return replace(rod, section=CircularSection(rod.section.radius, 0.85 * rod.section.radius))


def profiled(rod: Rod) -> Rod:
    at, factors = np.array([0.0, 0.3, 1.0]), np.array([1.0, 1.1, 0.95])
    return replace(rod, profile=Profile(at, factors, factors**0.5))


def flat(rod: Rod) -> Rod:
    size = 1.8 * rod.section.radius
    return replace(rod, section=RectangularSection(1.3 * size, 0.8 * size))


def bent_at_rest(rod: Rod) -> Rod:
    return replace(rod, rest_curvature=(np.array([0.3]), np.array([0.2, -0.3]), np.array([0.6])))


@pytest.mark.parametrize("change", [tapered, profiled, flat, bent_at_rest])
def test_rods_that_are_not_alike_all_along_or_to_all_sides(change):
    robot = with_rods(robot_with(("motor", "hub", "one motor twice"), modes=16), change)
    modes = solve_home(robot)
    assert_same(solve_continuous(modes), modes)


def test_forces_on_rods_and_wrenches_of_any_kind():
    robot = with_rods(robot_with(("motor", "hub", "fed behind a joint"), modes=14), lambda rod: rod)
    home = solve_home(robot)
    names = [leg.name for leg in robot.description.legs]
    loads = robot.default_loads.with_(
        gravity=[0.4, -0.2, -9.81],
        wrench_world=[0.02, 0.01, -0.03, 0.1, 0.2, -0.1],
        wrench_body=[0.01, -0.02, 0.02, 0.1, -0.1, 0.2],
        distributed=[
            DistributedForce(
                name, np.array([0.0, 0.6, 1.0]), [[0.1, 0, 0], [0, 0.2, 0.1], [0.1, 0.1, 0]]
            )
            for name in names
        ],
        points=[PointForce(name, 0.3, [0.05, -0.08, 0.1]) for name in names],
    )
    modes = solve_forward(robot, home.motors, start=home, loads=loads)
    rods = solve_continuous(modes)
    assert_same(rods, modes, position=2e-7, effort=2e-6)
    with pytest.raises(InvalidRequest, match="potential"):
        morse_index.morse_index(rods)


def test_forces_on_one_of_several_rods():
    robot = with_rods(load_robot("two_rods", modes=12), lambda rod: rod)
    first_rod, second_rod = robot.rod_names[:2]
    force = [[0.3, 0.1, 0.0], [0.0, -0.4, 0.0]]
    loads = robot.default_loads.with_(
        distributed=[DistributedForce(first_rod, np.array([0.0, 1.0]), force)],
        points=[PointForce(second_rod, 0.3, [0.2, -0.3, 0.0])],
    )
    home = solve_home(robot)
    modes = solve_forward(robot, home.motors, start=home, loads=loads)
    assert np.linalg.norm(modes.platform_position - home.platform_position) > 1e-3
    assert_same(solve_continuous(modes), modes)


@pytest.mark.parametrize("tip", ["revolute", "universal"])
def test_tips_that_hold_some_moments(tip):
    modes = solve_home(robot_with_tips(tip))
    assert_same(solve_continuous(modes), modes)


PATHS = {"rfrfr": ("rfrfr_forward_path.csv", 2), "six_rfs": ("6rfs_forward_path.csv", 6)}


@pytest.mark.parametrize("name", PATHS)
def test_the_general_way_is_the_compiled_one_on_the_robots_of_the_paper(name):
    file, count = PATHS[name]
    equilibrium = solve_home(load_robot(name))
    rows = read(file)[::10] if name == "rfrfr" else read(file)[:2]
    for row in rows:
        equilibrium = solve_forward(
            equilibrium.robot, numbers(row, *(f"q{k + 1}" for k in range(count))), start=equilibrium
        )
        for held in ("motors", "pose"):
            compiled = solve_continuous(equilibrium, held)
            general = solve_chains(equilibrium, motors_held=held == "motors", method=ACCURATE)
            for quantity in (
                "platform_position",
                "platform_rotation",
                "motors",
                "efforts",
                "base_wrenches",
            ):
                expected = getattr(compiled, quantity)
                assert_allclose(getattr(general, quantity), expected, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(("tableau", "order"), [("RK4", 4), ("DOPRI5", 5), ("DOP853", 8)])
def test_integrators_have_their_order_on_chains(tableau, order):
    home = solve_home(
        robot_with(("one motor twice", "fed behind a joint", "fed and turned"), modes=8)
    )
    exact = solve_continuous(home)
    errors = []
    for steps in (4, 8) if tableau == "DOP853" else (16, 32):
        found = solve_continuous(home, method=ShootingMethod(tableau, steps))
        errors.append(np.linalg.norm(found.platform_position - exact.platform_position))
        assert found.integration_error > 0.0
    assert np.log2(errors[0] / errors[1]) > order - 0.6


def test_what_shooting_does_not_cover_is_refused():
    home = solve_home(robot_with(("motor", "hub", "sprung motor"), modes=6))
    with pytest.raises(InvalidRequest, match="as many motors"):
        solve_continuous(home, "pose")
    with pytest.raises(InvalidRequest, match="leg1: expected a motor and a rod, not a chain"):
        follow_motors(solve_continuous(home), [home.motors])
    with pytest.raises(NoForwardSolution, match="shooting: residual"):
        solve_continuous(home, method=ShootingMethod(tolerance=0.0))


@dataclass(frozen=True)
class Screw(ChainJoint):
    """A joint there is not."""

    kind = "screw"
    unit = "rad"


def test_elements_it_does_not_know_are_refused():
    description = robot_with(("motor", "hub", "sprung motor"), modes=6).description
    first, *others = description.legs
    screwed = replace(first, elements=(Screw((0.0, 0.0, 1.0)), *first.chain))
    robot = Robot(replace(description, legs=(screwed, *others)))
    with pytest.raises(
        InvalidRequest, match="leg1: expected turns, shifts, links and rods, got Screw"
    ):
        chain_robot.chain_robot(robot, robot.default_loads, ACCURATE)


@pytest.mark.parametrize("modes", [3, 5])
def test_rods_that_run_away_are_no_solution(modes):
    """Numpy's own error came out of it, and a line of LAPACK's on the terminal."""
    content = shipped_content("planar_body")
    radius = content["rod"]["section"]["radius"]
    content["rod"]["section"]["radius"] = [0.1 * radius, radius]
    robot = load_robot(content | {"gravity": [0.0, -9.81, 0.0]}, modes=modes)
    home = solve_home(robot)
    with pytest.raises(NoForwardSolution, match="shooting: residual"):
        solve_continuous(solve_forward(robot, home.motors + 0.2, start=home))

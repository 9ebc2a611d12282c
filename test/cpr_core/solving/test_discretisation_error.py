# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The estimated error of an answer against answers with many modes."""

import json
from dataclasses import replace

import numpy as np
import pytest
from helpers.chain_robots import as_chains
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose

from benchmarks.discretisation_error import MODES, compare, in_richer_space
from cpr_core import (
    CprError,
    InvalidRequest,
    Robot,
    error_of,
    find_equilibria,
    leg_shapes,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
)
from cpr_core.command_line import main
from cpr_core.description.description_file import shipped_robots
from cpr_core.lie import rotation_log
from cpr_core.rods.rod import Profile, StrainModes
from cpr_core.rods.strain_basis import STRAIN_BASES
from cpr_core.solving.discretisation_error import embedded

ROBOTS = list(shipped_robots())


@pytest.mark.parametrize("name", ROBOTS)
def test_it_is_within_a_factor_of_three(name):
    """But for a few next to where a small change is a large one; never a tenth."""
    ratios = np.concatenate([compare(name, modes, count=5, seed=1).ratios for modes in MODES])
    assert np.mean((ratios > 1.0 / 3.0) & (ratios < 3.0)) >= 0.95, ratios
    assert ratios.min() > 0.1


def test_it_says_what_it_is():
    found = error_of(solve_home(load_robot("rfrfr")), "pose")
    assert (
        repr(found) == "<DiscretisationError, pose held: platform 0 m, 0 rad from continuous rods'>"
    )
    found = error_of(solve_home(load_robot("rfrfr")))
    assert f"motors held: platform {found.distance:.3g} m, " in repr(found)


def test_most_robots_tell_something_with_few_modes():
    """The test above would be empty if all errors were rounding."""
    assert all(len(compare(name, 3, count=2).ratios) == 4 for name in ROBOTS if name != "delta")


@pytest.mark.parametrize(
    "name", ["rfrfr", "six_rfs", "gough_stewart", "three_rfr_hubs", "two_rods"]
)
def test_parts_are_those_of_the_answer_with_many_modes(name):
    """Direction and size, whatever is held; compared in the whole, as some parts are hardly changed."""
    robot = load_robot(name, modes=4)
    exact, home = load_robot(name, modes=16), solve_home(robot)
    way = 0.1 * robot.motor_units * np.cos(np.arange(robot.motor_count))
    coarse = solve_forward(robot, home.motors + way)
    for problem, true in (
        ("motors", solve_forward(exact, coarse.motors)),
        ("pose", solve_inverse(exact, coarse.pose)),
        ("efforts", solve_forward_by_effort(exact, coarse.efforts)),
    ):
        found = error_of(coarse, problem)
        turn = rotation_log(true.platform_rotation @ coarse.platform_rotation.T)
        expected = {
            "position": true.platform_position - coarse.platform_position,
            "rotation": turn,
            "motors": true.motors - coarse.motors,
            "efforts": true.efforts - coarse.efforts,
        }
        for part, change in expected.items():
            size = max(np.linalg.norm(change), 1e-9)
            away = np.linalg.norm(getattr(found, part) - change)
            assert away < 0.4 * size, (problem, part)
        held = {"motors": found.motors, "pose": found.position, "efforts": found.efforts}
        assert not np.any(held[problem])


@pytest.mark.parametrize("basis", STRAIN_BASES)
def test_modes_are_combinations_of_richer_ones(basis):
    made = STRAIN_BASES[basis]()
    counts = (made.modes or 3, 0, made.modes or 4)
    modes = StrainModes(counts, made)
    richer = modes.richer(2)
    assert richer.counts[1] == 0
    assert all(more > few for more, few in zip(richer.counts, counts, strict=True) if few)
    sigma = np.linspace(0.0, 1.0, 101)
    for direction in (0, 2):
        few, many = (of.values(sigma)[:, of.directions == direction] for of in (modes, richer))
        combined = many @ np.linalg.lstsq(many, few, rcond=None)[0]
        assert_allclose(combined, few, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_an_embedded_equilibrium_has_the_same_shape(name):
    robot = load_robot(name)
    home = solve_home(robot)
    richer = embedded(home, Robot(robot.description.with_richer_modes(3)))
    for leg, same in zip(leg_shapes(home), leg_shapes(richer), strict=True):
        assert_allclose(same.position, leg.position, rtol=0.0, atol=1e-7 * robot.mean_length)
    assert_allclose(richer.multipliers, home.multipliers, rtol=0.0, atol=0.0)


def test_splines_too():
    content = shipped_content("rfrfr")
    content["strain"] = {"basis": "bsplines", "degree": 3, "knots": [0.5]}
    home = solve_home(load_robot(content))
    finest = home.robot.description
    for _ in range(3):
        finest = finest.with_richer_modes(1)
    true = in_richer_space(home, Robot(finest))
    away = np.linalg.norm(true.platform_position - home.platform_position)
    assert 1.0 / 3.0 < error_of(home).distance / away < 3.0


def jump_ratios(name, softer):
    """Estimate over truth where the second half of every rod is softer."""
    content = as_chains(name, links=False)
    rod = content["rod"]
    halves = [{"rod": {"length": 0.5 * rod["length"]}} for _ in range(2)]
    halves[1]["rod"] |= {key: softer * rod[key] for key in ("young_modulus", "shear_modulus")}
    for leg in content["legs"]:
        leg["chain"] = [element for element in leg["chain"] if "rod" not in element] + halves
    true = load_robot(content, modes=10)
    factors = np.array([1.0, 1.0, softer, softer])
    jump = Profile(np.array([0.0, 0.5, 0.50001, 1.0]), factors, np.ones(4))
    random = np.random.default_rng(0)
    for modes in MODES:
        shipped = load_robot(name, modes=modes).description
        legs = (replace(leg, rod=replace(leg.rod, profile=jump)) for leg in shipped.legs)
        robot = Robot(replace(shipped, legs=tuple(legs)))
        motors = solve_home(robot).motors + 0.1 * random.uniform(-1, 1, robot.motor_count)
        found, exact = solve_forward(robot, motors), solve_forward(true, motors)
        away = np.linalg.norm(exact.platform_position - found.platform_position)
        assert away > 1e-5
        yield error_of(found).distance / away


def test_jumps_that_descriptions_refuse_are_told():
    """Polynomials follow them badly; the truth are two rods in a chain."""
    ratios = np.array(
        [
            ratio
            for name in ("rfrfr", "three_rfs")
            for softer in (0.7, 0.5, 0.2)
            for ratio in jump_ratios(name, softer)
        ]
    )
    assert np.mean((ratios > 1.0 / 3.0) & (ratios < 3.0)) >= 0.95, ratios
    assert ratios.min() > 0.1


def test_with_many_modes_nothing_is_left():
    found = error_of(solve_home(load_robot("six_rfs", modes=14)))
    assert found.distance < 1e-10
    assert np.abs(found.efforts).max() < 1e-9


def test_bad_questions_are_refused():
    home = solve_home(load_robot("rfrfr"))
    with pytest.raises(InvalidRequest, match="expected an Equilibrium"):
        error_of("home")
    with pytest.raises(InvalidRequest, match="expected motors, efforts or pose"):
        error_of(home, "wrench")
    with pytest.raises(InvalidRequest, match="no single solution"):
        error_of(solve_home(load_robot("four_rfr")), "pose")


def test_where_the_step_leads_nowhere_there_is_no_estimate():
    home = solve_home(load_robot("rfrfr"))
    for problem in ("motors", "pose", "efforts"):
        assert error_of(home, problem).estimate.iterations == 1
        with pytest.raises(CprError, match=f"singular with its {problem} held"):
            error_of(replace(home, record=np.full_like(home.record, np.nan)), problem)


def test_the_estimate_is_as_stable_as_what_it_is_of():
    """Its indices are those of its spectra, also where the equilibrium is unstable."""
    robot = load_robot("six_rfs", modes=8)
    motors = solve_home(robot).motors + 0.05
    found = [each.equilibrium for each in find_equilibria(robot, motors, starts=20)]
    assert {(each.index_locked, each.index_free) for each in found} >= {(0, 0), (1, 2)}
    for equilibrium in found:
        estimate = error_of(equilibrium).estimate
        assert estimate.signs == equilibrium.signs
        assert estimate.index_locked == estimate.spectrum_locked.index
        assert estimate.index_free == estimate.spectrum_free.index
        assert estimate.stable == equilibrium.stable


def test_the_command_prints_it(capsys):
    arguments = ["forward", "rfrfr", "--motors", "2.7", "0.5", "--modes", "3", "--error"]
    assert main(arguments) == 0
    told = capsys.readouterr().out
    assert "continuous rods with the same motors would change" in told
    assert main([*arguments, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["discretisation_error"]
    equilibrium = solve_forward(load_robot("rfrfr", modes=3), [2.7, 0.5])
    expected = error_of(equilibrium)
    assert found["platform"]["position"] == expected.position.tolist()
    assert found["held"] == "motors"
    assert f"{expected.distance:14.1e} m" in told
    assert main(["inverse", "rfrfr", "--pose", "0.1", "0.75", "--error"]) == 0
    assert "with the same pose" in capsys.readouterr().out

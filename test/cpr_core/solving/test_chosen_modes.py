# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Modes that are chosen for a tolerance: exact enough, no more than needed, and told where not."""

import json
import pickle

import numpy as np
import pytest
import yaml
from helpers.ring_robots import clamped_columns
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose

from benchmarks.chosen_modes import compare_with_tolerance
from cpr_core import (
    CprError,
    DescriptionError,
    InvalidRequest,
    Robot,
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.command_line import main
from cpr_core.description.description_file import shipped_robots
from cpr_core.solving.buckling_modes import buckling_modes
from cpr_core.solving.chosen_modes import (
    TOLD,
    choose_modes,
    compared_modes,
    equilibria_near_home,
    with_many_modes,
)
from cpr_core.solving.fewest_modes import fewest_modes

ROBOTS = list(shipped_robots())
#: So much stiffer platforms may become by a mode of torsion that is given up.
NOTHING = 1e-3


def counts_of(robot):
    return [rod.modes.counts for rod in robot.description.rods]


@pytest.mark.parametrize("name", ROBOTS)
def test_they_are_exact_enough_and_elsewhere_the_estimate_tells(name):
    kept = compare_with_tolerance(name, 1e-5, count=8, seed=2)
    assert list(kept.silent) == []
    exact = with_many_modes(load_robot(name), 1e-8)
    near = compared_modes(kept.robot, exact)
    assert near.true < 1.2e-5  # itself chosen by comparison with what is right to a tenth
    assert near.estimated <= TOLD * 1e-5


def yielding(equilibrium):
    """How the platform yields to wrenches, motors held."""
    return kinemato_statics(equilibrium).platform_by_wrench


def largest_loss(before, after):
    """Largest part of a compliance that is lost in any direction."""
    return np.linalg.eigvals(np.linalg.solve(before, before - after)).real.max()


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "three_prs", "three_rfr_hubs"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
def test_none_is_there_in_vain(name, tolerance):
    """With one mode less in any direction of any rod most of the tolerance is used, or more than it.

    But for those that rods need to buckle where they do; without one of torsion the platform is stiffer.
    """
    chosen = choose_modes(load_robot(name), tolerance)
    exact = with_many_modes(load_robot(name), tolerance)
    counts, bending = counts_of(chosen), buckling_modes(exact[0])
    for rod in range(0, len(counts), 2):
        for direction in range(3):
            if counts[rod][direction] <= (bending[rod] if direction else 1):
                continue
            fewer = [list(count) for count in counts]
            fewer[rod][direction] -= 1
            less = Robot(chosen.description.with_mode_counts([tuple(count) for count in fewer]))
            if direction == 0:
                yields = [yielding(solve_home(each)) for each in (chosen, less)]
                assert largest_loss(*yields) > NOTHING
            else:
                assert compared_modes(less, exact).true > 0.25 * tolerance


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "gough_stewart"])
def test_what_giving_modes_up_does_is_foreseen(name):
    """First order only: a small budget is used, and hardly exceeded."""
    exact = with_many_modes(load_robot(name), 1e-7)
    counts = fewest_modes(exact, 1e-6, [1] * len(exact[0].robot.description.rods))
    robot = Robot(exact[0].robot.description.with_mode_counts(counts))
    assert 1e-7 < compared_modes(robot, exact).true < 1.3e-6


def held_at_zero(exact, counts):
    """How far platforms move, to first order, where all that is not among the modes is held at zero.

    And how they yield to wrenches then, dimensionless.
    """
    robot = exact[0].robot
    given_up = [
        rod.strain.start + sum(rod.element.modes.counts[:direction]) + number
        for rod, few in zip(robot.numbers.rods, counts, strict=True)
        for direction, many in enumerate(rod.element.modes.counts)
        for number in range(few[direction], many)
    ]
    free, unit = robot.kernel_arrays.motor_index, robot.kernel_arrays.unit
    axes = robot.platform_indices[robot.platform_axes >= 3]
    held = np.eye(free)[given_up]
    for equilibrium in exact:
        tangent = (equilibrium.tangent * unit * unit[:, None])[:free, :free]
        whole = np.block([[tangent, held.T], [held, np.zeros((len(held), len(held)))]])
        rest = np.concatenate([np.zeros(free), -(equilibrium.state / unit)[given_up]])
        moved = np.linalg.solve(whole, rest)[axes] * unit[axes]
        pushed = np.eye(len(whole))[:, robot.platform_indices]
        yield float(np.linalg.norm(moved)), pushed.T @ np.linalg.solve(whole, pushed)


@pytest.mark.parametrize("basis", ["legendre", "chebyshev", "monomials"])
@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "three_prs"])
def test_modes_are_given_up_until_the_budget_is_used(name, basis):
    """Against all that is given up held at once; modes that are not orthogonal depend on each other."""
    content, budget = shipped_content(name), 1e-4
    content["strain"] = {"basis": basis}
    exact = with_many_modes(load_robot(content), 1e-6)
    counts = fewest_modes(exact, budget, [1] * len(exact[0].robot.description.rods))
    moved, yields = zip(*held_at_zero(exact, counts), strict=True)
    assert max(moved) <= 1.0001 * budget
    for direction in range(3):
        fewer = [list(count) for count in counts]
        fewer[-1][direction] -= 1
        if fewer[-1][direction] >= (0 if direction == 0 else 1) and counts[-1][direction] > 1:
            farther, less = zip(*held_at_zero(exact, fewer), strict=True)
            stiffer = direction == 0 and max(map(largest_loss, yields, less)) > 0.9999 * NOTHING
            assert stiffer or max(farther) > 0.9999 * budget


ONE_ROD = """
name: one_rod
space: spatial
rod:
  {length: 0.6, section: {shape: circular, radius: 0.001}, young_modulus: 210e9, shear_modulus: 82e9}
strain: {tolerance: 1e-5}
controlled: [x]
legs:
- base: {position: [0, 0, 0], tangent: [1, 0, 0], normal: [0, 1, 0]}
  chain:
  - {joint: prismatic, axis: [1, 0, 0], motor: motor1}
  - {rod: {}}
  tip: {type: fixed, position: [0, 0, 0], tangent: [1, 0, 0], normal: [0, 1, 0]}
home: {motors: [0], bow: [0, -1, 0]}
"""


def test_rods_that_twist_have_torsion_and_others_none():
    assert all(counts[0] >= 1 for counts in counts_of(choose_modes(load_robot("three_prs"), 1e-5)))
    assert all(counts[0] == 0 for counts in counts_of(choose_modes(load_robot("six_rfs"), 1e-5)))


@pytest.mark.parametrize(
    "section",
    [
        {"shape": "circular", "radius": 0.001},
        {"shape": "given", "torsion": 0.1, "bending_2": 0.4, "bending_3": 0.12},
    ],
)
def test_rods_that_only_loads_twist_have_torsion_too(section):
    """The platform could not turn about them, and no error was told: motors alone do not twist them."""
    robot = clamped_columns(section)
    found = choose_modes(robot, 1e-5)
    assert counts_of(found) == [(1, 5, 5)] * 3
    loads = robot.default_loads.with_(wrench_world=[0.0, 0.0, 0.01, 0.0, 0.0, 0.0])
    turned = [solve_forward(each, [0.0] * 3, loads=loads) for each in (found, robot)]
    angles = [at.platform_rotation[1, 0] for at in turned]
    assert angles[1] > 5e-3
    assert angles[0] == pytest.approx(angles[1], rel=1e-3)


@pytest.mark.parametrize(
    "rod",
    [
        {"section": {"shape": "circular", "radius": [0.0014, 0.0005]}},
        {"rest_curvature": {"bending_3": [5.0]}},
    ],
    ids=["cone", "semicircle"],
)
def test_rods_that_loads_twist_unevenly_have_all_the_torsion_they_need(rod):
    """One rod from a carriage to the platform, without a force at home wherever its motor is."""
    one = yaml.safe_load(ONE_ROD)
    one["legs"][0]["chain"][1]["rod"] |= rod
    found, many = load_robot(one), load_robot(one, modes=14)
    yields = [kinemato_statics(solve_home(each)).platform_by_wrench for each in (found, many)]
    assert_allclose(np.diag(yields[0]), np.diag(yields[1]), rtol=5e-3, atol=1e-12)


def test_motors_with_narrow_limits_are_moved_as_far_as_these():
    """They were not moved at all, and straight legs were exact at home alone."""
    content, many = shipped_content("gough_stewart"), load_robot("gough_stewart", modes=14)
    home = solve_home(many)
    step = 0.09 * many.mean_length
    for leg in content["legs"]:
        leg["motor"]["limits"] = {"position": [home.motors[0] - step, home.motors[0] + step]}
    moved = home.motors + np.array([0.99 * step, 0, 0, 0, 0, 0])
    robots = choose_modes(load_robot(content), 1e-5), many
    at = [solve_forward(robot, moved).platform_position for robot in robots]
    assert_allclose(*at, rtol=0.0, atol=1e-5)


def test_the_numbers_of_before_do_not_matter():
    few, many = (choose_modes(load_robot("rfrfr", modes=modes), 1e-6) for modes in (2, 9))
    assert counts_of(few) == counts_of(many)


def test_a_tolerance_of_the_description_is_kept_by_what_is_loaded():
    content = shipped_content("rfrfr")
    content["strain"] = {"tolerance": 1e-7}
    robot = load_robot(content)
    assert counts_of(robot) == counts_of(choose_modes(load_robot("rfrfr"), 1e-7))
    assert robot.description.tolerance == 1e-7
    assert counts_of(pickle.loads(pickle.dumps(robot))) == counts_of(robot)
    assert counts_of(load_robot(content, modes=3)) == [(0, 0, 3), (0, 0, 3)]
    assert counts_of(load_robot(yaml.safe_dump(content))) == counts_of(robot)
    assert load_robot("rfrfr").description.tolerance == np.inf


def test_modes_in_place_of_a_tolerance_are_those_of_all_directions():
    """Who names a tolerance has left no direction out, so that torsion is not."""
    content = shipped_content("gough_stewart")
    expected = counts_of(load_robot(content))
    assert min(map(min, expected)) > 0
    content["strain"] = {"tolerance": 1e-4}
    for leg in content["legs"]:
        leg.pop("strain", None)
    assert counts_of(load_robot(content, modes=4)) == [(4, 4, 4)] * len(expected)
    exact, found = (solve_home(load_robot(each, modes=12)) for each in ("gough_stewart", content))
    np.testing.assert_allclose(found.pose, exact.pose, atol=1e-9)


def test_chosen_modes_stay_where_other_numbers_change():
    content = shipped_content("six_rfs")
    content["strain"] = {"tolerance": 1e-6}
    robot = load_robot(content)
    changed = robot.with_parameters({"rod.young_modulus": 200e9})
    assert len(set(counts_of(robot))) > 1
    assert counts_of(changed) == counts_of(robot)
    assert changed.description.tolerance == 1e-6


def test_rods_of_a_chain_are_chosen_for_one_by_one():
    """The rods of one leg are of different length."""
    content = shipped_content("two_rods")
    content["strain"] = {"basis": "chebyshev", "tolerance": 1e-5}
    robot = load_robot(content)
    assert len(set(counts_of(robot))) > 1
    assert all(type(rod.modes.basis).__name__ == "Chebyshev" for rod in robot.description.rods)
    assert compared_modes(robot, with_many_modes(robot, 1e-9)).true <= 1e-5


@pytest.mark.parametrize(
    ("strain", "own", "field", "text"),
    [
        ({"tolerance": 1e-5, "bending_3": 4}, None, "strain.bending_3", "no number of modes"),
        ({"tolerance": 1e-5}, {"bending_3": 4}, "legs[1].strain.bending_3", "tolerance chooses"),
        ({}, {"tolerance": 1e-5}, "legs[1].strain.tolerance", "in the robot's strain"),
        ({"tolerance": 1e-5, "basis": "bsplines"}, None, "strain.basis", "any number of modes"),
        ({"tolerance": 1e-5, "basis": "bsplines", "degree": 2}, None, "strain.degree", "chooses"),
        ({"tolerance": 1e-12}, None, "strain.tolerance", "1e-09"),
        ({"tolerance": 0.01, "basis": "no"}, None, "strain.basis", "no"),
    ],
)
def test_mistakes_name_the_field(strain, own, field, text):
    content = shipped_content("rfrfr")
    content["strain"] = strain
    if own is not None:
        content["legs"][1]["strain"] = own
    with pytest.raises(DescriptionError, match=text) as caught:
        load_robot(content)
    assert caught.value.field == field


def test_what_cannot_be_met_says_how_near_it_comes():
    """Polynomials do not follow a thin place."""
    content = shipped_content("rfrfr")
    content["strain"] = {"tolerance": 1e-9}
    content["rod"]["profile"] = {"at": [0.0, 0.39, 0.5, 0.61, 1.0], "stiffness": [1, 1, 0.6, 1, 1]}
    with pytest.raises(DescriptionError, match=r"is about .* two rods in a chain") as caught:
        load_robot(content)
    assert caught.value.field == "strain.tolerance"


def test_a_robot_without_a_home_is_not_told_that_its_tolerance_is_wrong():
    content = shipped_content("rfrfr")
    content["strain"] = {"tolerance": 1e-5}
    content["legs"][1]["base"]["position"] = [5.0, 0.0, 0.0]
    with pytest.raises(DescriptionError, match="cannot be assembled") as caught:
        load_robot(content)
    assert caught.value.field == "home"
    assert str(caught.value).count("rfrfr") == str(caught.value).count("home") == 1


def test_bad_questions_are_refused():
    robot = load_robot("rfrfr")
    for tolerance in (0.0, -1e-5, 1e-10, "1e-5", np.nan):
        with pytest.raises(InvalidRequest, match="tolerance"):
            choose_modes(robot, tolerance)
    with pytest.raises(InvalidRequest, match=r"at least 1e-09 m, got 9\.9999999e-10$"):
        choose_modes(robot, 9.9999999e-10)
    with pytest.raises(InvalidRequest, match="expected a Robot"):
        choose_modes("rfrfr", 1e-5)
    content = shipped_content("rfrfr")
    content["strain"] = {"basis": "bsplines"}
    with pytest.raises(InvalidRequest, match=r"^modes: they cannot be chosen: B-splines"):
        choose_modes(load_robot(content), 1e-5)


def test_near_home_is_home_and_every_motor_to_either_side():
    robot = load_robot("rfrfr")
    found = [
        equilibrium.motors - solve_home(robot).motors for equilibrium in equilibria_near_home(robot)
    ]
    np.testing.assert_allclose(
        found, [[0, 0], [-0.1, 0], [0.1, 0], [0, -0.1], [0, 0.1]], atol=1e-15
    )


def test_the_command_prints_a_table_and_what_was_chosen(capsys):
    assert main(["modes", "rfrfr", "--tolerance", "1e-6", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    chosen = choose_modes(load_robot("rfrfr"), 1e-6)
    assert found["chosen"] == {
        "leg1": list(counts_of(chosen)[0]),
        "leg2": list(counts_of(chosen)[1]),
    }
    compared = {row["modes"]: row for row in found["compared"]}
    assert compared["chosen"]["difference"] <= 1e-6 < compared["5"]["difference"]
    written = compared["written"]  # 5
    assert written["difference"] == pytest.approx(compared["5"]["difference"], rel=1e-6)
    assert found["reference_error"] <= 1e-9
    assert compared["3"]["strain_coordinates"] == 6
    assert all(
        1.0 / 3.0 < row["estimated_error"] / row["difference"] < 3.0
        for row in found["compared"]
        if row["difference"] > 1e-9
    )
    assert all(row["estimated_error"] != row["difference"] for row in found["compared"])
    assert all(row["solve_time"] > 0.0 for row in found["compared"])
    assert main(["modes", "rfrfr"]) == 0
    told = capsys.readouterr().out
    assert all(float(line.split()[-1]) > 1.0 for line in told.splitlines()[4:12])  # microseconds
    assert "tolerance 1e-05 m" in told
    assert "difference: from many modes, which themselves are exact to 2e-10 m or so" in told
    assert "true" not in told
    assert "chosen: torsion, bending_2, bending_3" in told
    with pytest.raises(SystemExit):
        main(["modes", "rfrfr", "--tolerance", "-1"])
    assert "expected a positive length in metres, got -1" in capsys.readouterr().err


def test_the_command_asks_for_no_more_than_the_tolerance(capsys, tmp_path):
    content = shipped_content("rfrfr")
    content["rod"]["profile"] = {"at": [0.0, 0.39, 0.5, 0.61, 1.0], "stiffness": [1, 1, 0.6, 1, 1]}
    with pytest.raises(CprError, match="1e-09 m is not met"):
        with_many_modes(load_robot(content), 1e-9)
    file = tmp_path / "thin.yaml"
    file.write_text(yaml.safe_dump(content | {"strain": {"tolerance": 1e-3}}))
    assert main(["modes", str(file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["tolerance"] == 1e-3
    assert found["compared"][-1]["difference"] <= 1e-3
    assert 1e-9 < found["reference_error"] <= 1e-4  # not the truth: what differs less tells nothing


def test_a_cone_whose_error_falls_slowly_has_modes_too():
    """24 modes are a tenth of the tolerance off, and were refused for less than that."""
    content = shipped_content("rfrfr")
    radius = content["rod"]["section"]["radius"]
    content["rod"]["section"]["radius"] = [0.2 * radius, radius]
    content["gravity"] = [0.0, -9.81, 0.0]
    tolerance = 1e-5
    chosen = choose_modes(load_robot(content), tolerance)
    true = compared_modes(chosen, equilibria_near_home(load_robot(content, modes=36))).true
    assert true < tolerance and max(chosen.description.rods[0].modes.counts) < 24
    with pytest.raises(
        CprError, match=r"modes in every direction is about .* half the tolerance"
    ) as told:
        choose_modes(load_robot(content), 1e-6)
    assert "jump" not in str(told.value)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Derivatives by parameters against full solves of robots with other parameters."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from helpers.parameter_kinds import parameter_kinds, with_loads
from helpers.shipped_steps import REDUNDANT, STEPS
from helpers.solved_beside import polished, robots_beside, solved_slopes
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose, assert_array_equal

from cpr_core import (
    CprError,
    DescriptionError,
    InvalidRequest,
    Robot,
    UnknownParameter,
    continued,
    derivatives,
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.description.changed_description import named_parameters
from cpr_core.description.description_file import shipped_robots
from cpr_core.kernels.condensation_kernel import DELAYED
from cpr_core.lie import angle_motions, rotation_exp
from cpr_core.model.residual_rates import parameter_scales

ROBOTS = list(shipped_robots())
STATE = ("position", "rotation", "motors", "efforts")
#: A straight rod, welded to the ground and to the platform.
COLUMN = """
name: column
space: planar
rod: {length: 0.5, section: {shape: circular, radius: 0.001}, young_modulus: 210e9, shear_modulus: 82e9}
strain: {bending_3: 6}
platform: {shape: body}
legs:
- base: {position: [0, 0, 0], tangent: [1, 0, 0]}
  motor: {type: welded}
  tip: {type: fixed, position: [0, 0, 0], tangent: [1, 0, 0]}
controlled: []
home: {motors: [], platform: {position: [0.5, 0, 0]}}
"""
#: Steps of the solves compared with, in parts of what moves the robot by a natural unit.
STEPS_TRIED = (1e-3, 1e-4)


def equilibrium_of(name):
    robot = with_loads(load_robot(name))
    found = solve_forward(robot, solve_home(robot).motors + np.array(STEPS[name]))
    return polished(found, "motors")


def problems_of(name):
    return ("motors", "efforts") if name in REDUNDANT else ("motors", "pose", "efforts")


def natural_units(robot):
    energy = robot.arrays.energy_unit
    return {
        "position": robot.mean_length,
        "rotation": 1.0,
        "motors": robot.motor_units,
        "efforts": energy / robot.motor_units,
        "margin": 1.0,
        "smallest_eigenvalue": energy,
    }


def compared(equilibrium, path, problem, quantities, tolerance=1e-6):
    """Assert that derivatives are those of full solves; whether there were any to compare with.

    Full solves have errors of their own, of fourth order in their steps: one of two has to agree.
    """
    robot, units = equilibrium.robot, natural_units(equilibrium.robot)
    of = ("pose", "motors", "efforts", *(name for name in quantities if name not in STATE))
    found = derivatives(equilibrium, path, of, problem)
    (parameter,) = named_parameters(robot.description, path)
    (scale,) = parameter_scales(equilibrium, (parameter,))
    mine = {name: scale * getattr(found, name)[..., 0] / units[name] for name in quantities}
    if scale == 0.0:
        assert not any(np.any(getattr(found, name)) for name in STATE)
        return False
    moved = max(
        1.0,
        *(
            np.abs(scale * getattr(found, name) / np.reshape(units[name], (-1, 1))).max()
            for name in STATE
        ),
    )
    away = []
    for part in STEPS_TRIED:
        step = part * scale / moved
        robots = robots_beside(robot, parameter, step)
        if robots is None:
            return False
        true = solved_slopes(equilibrium, robots, step, problem)
        away.append(
            max(np.abs(mine[name] - scale * true[name] / units[name]).max() for name in quantities)
        )
        if away[-1] < tolerance * moved:
            return True
    raise AssertionError((path, problem, away, moved))


@pytest.mark.parametrize("name", ROBOTS)
def test_state_derivatives_are_those_of_full_solves(name):
    """Every kind of parameter, the three problems in turn; one that all robots have in all of them."""
    equilibrium, seen = equilibrium_of(name), 0
    problems = problems_of(name)
    for number, path in enumerate(parameter_kinds(equilibrium.robot)):
        asked = (
            problems
            if path in ("rod.length", "loads.platform_force[0]")
            else [problems[number % len(problems)]]
        )
        for problem in asked:
            try:
                seen += compared(equilibrium, path, problem, STATE)
            except CprError as error:
                assert "planar" in str(error), path
    assert seen > 18


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "planar_body", "four_rfr", "three_rfr_hubs"])
def test_slopes_of_stability_are_those_of_full_solves(name):
    """Robots whose eigenvalues stay apart; also legs in chains and redundant motors."""
    equilibrium, problems = equilibrium_of(name), problems_of(name)
    seen = 0
    for number, path in enumerate(parameter_kinds(equilibrium.robot)[::2]):
        try:
            problem = problems[number % len(problems)]
            seen += compared(equilibrium, path, problem, ("margin", "smallest_eigenvalue"))
        except CprError as error:
            assert "planar" in str(error), path
    assert seen > 8


def test_a_wildcard_is_the_sum_over_the_legs():
    equilibrium = equilibrium_of("six_rfs")
    single = [f"legs[{leg}].base.position[1]" for leg in range(6)]
    for problem in problems_of("six_rfs"):
        every = derivatives(equilibrium, "legs[*].base.position[1]", problem=problem)
        parts = derivatives(equilibrium, single, problem=problem)
        assert every.parameters == ("legs[*].base.position[1]",)
        for name in STATE:
            expected = getattr(parts, name).sum(axis=1, keepdims=True)
            assert_allclose(getattr(every, name), expected, rtol=1e-8, atol=1e-9)


def test_several_legs_are_the_sum_over_these():
    """The zero of a crank that moves two legs is its motor."""
    equilibrium = equilibrium_of("delta")
    single = [f"legs[{leg}].chain[0].offset" for leg in range(6)]
    cranks = [f"legs[{leg},{leg + 1}].chain[0].offset" for leg in (0, 2, 4)]
    for problem in problems_of("delta"):
        found = derivatives(equilibrium, cranks, problem=problem)
        parts = derivatives(equilibrium, single, problem=problem)
        assert found.parameters == tuple(cranks)
        for name in STATE:
            expected = getattr(parts, name).reshape(-1, 3, 2).sum(axis=2)
            assert_allclose(getattr(found, name), expected, rtol=1e-7, atol=1e-8)
    by_motor = kinemato_statics(equilibrium).jacobian
    found = derivatives(equilibrium, cranks)
    assert_allclose(found.twist_body, by_motor, rtol=1e-7, atol=1e-8)


def test_the_zero_of_a_motor_is_the_motor():
    """With the motors held; the Jacobian is in the axes of the platform, and so is ``twist_body``."""
    equilibrium = equilibrium_of("six_rfs")
    model = kinemato_statics(equilibrium)
    offsets = [f"legs[{leg}].motor.offset" for leg in range(6)]
    found = derivatives(equilibrium, offsets)
    assert_allclose(found.twist_body, model.jacobian, rtol=1e-8, atol=1e-9)
    assert_allclose(found.efforts, model.efforts_by_motors, rtol=1e-7, atol=1e-9)
    assert_array_equal(found.motors, np.zeros((6, 6)))
    assert np.abs(found.rotation - found.twist_body[:3]).max() > 0.1
    held = derivatives(equilibrium, offsets, problem="pose")
    assert_allclose(held.motors, -np.eye(6), rtol=1e-8, atol=1e-8)
    assert np.abs(held.twist_body).max() < 1e-9


def test_a_force_on_the_platform_is_a_wrench():
    equilibrium = equilibrium_of("three_rfs")
    model, turn = kinemato_statics(equilibrium), equilibrium.platform_rotation
    forces = [f"loads.platform_force[{axis}]" for axis in range(3)]
    found = derivatives(equilibrium, forces)
    assert_allclose(
        found.twist_body, model.platform_by_wrench[:, 3:] @ turn.T, rtol=1e-8, atol=1e-12
    )
    assert_allclose(found.efforts, model.efforts_by_wrench[:, 3:] @ turn.T, rtol=1e-8, atol=1e-10)


def test_what_moves_with_the_whole_robot():
    """All bases shifted: the platform shifts, motors and efforts do not notice."""
    equilibrium = equilibrium_of("gough_stewart")
    found = derivatives(equilibrium, "legs[*].base.position[2]")
    assert_allclose(found.position[:, 0], [0.0, 0.0, 1.0], rtol=0.0, atol=1e-7)
    assert np.abs(found.rotation).max() < 1e-7
    assert np.abs(found.efforts).max() < 1e-6


def test_what_is_asked_for_is_there_and_nothing_else():
    equilibrium = equilibrium_of("rfrfr")
    found = derivatives(equilibrium, ["rod.length", "rod.density"], of="margin")
    assert found.margin.shape == (2,)
    assert found.position.shape == found.motors.shape == found.efforts.shape == (0, 2)
    assert found.smallest_eigenvalue.shape == (0,)
    whole = derivatives(equilibrium, ["rod.length", "rod.density"])
    assert whole.twist_body.shape == (6, 2)
    assert whole.motors.shape == whole.efforts.shape == (2, 2)
    assert whole.margin.shape == (0,)
    assert derivatives(equilibrium, "rod.length", problem="efforts").problem == "efforts"


@pytest.mark.parametrize("name", ROBOTS)
def test_it_does_not_matter_where_was_asked_first(name):
    """At home motors at zero or a level platform may hide what a parameter does elsewhere."""
    answers = []
    for first in (False, True):
        robot = with_loads(load_robot(name))
        home = solve_home(robot)
        away = polished(solve_forward(robot, home.motors + 2.0 * np.array(STEPS[name])), "motors")
        paths = parameter_kinds(robot)
        for path in paths if first else ():
            refusal(home, path)
        answers.append([refusal(away, path) for path in paths])
    units = natural_units(robot)
    for path, mine, other in zip(paths, *answers, strict=True):
        if isinstance(mine, CprError):
            assert str(mine) == str(other)
            continue
        (scale,) = parameter_scales(away, named_parameters(robot.description, path))
        for name in STATE:
            values = [scale * getattr(found, name)[:, 0] / units[name] for found in (other, mine)]
            size = max(np.abs(values[1]).max(), 1.0)  # as of full solves
            assert_allclose(*values, rtol=0.0, atol=1e-6 * size, err_msg=path)


@pytest.mark.parametrize("tiny", [1e-9, 3e-11, 1e-13, -1e-20, 1e-300])
def test_a_number_next_to_zero_is_varied_as_zero_is(tiny):
    """Steps that were parts of it were lost beside a motor at 5 rad: it did nothing at all."""
    path, answers = "legs[3].motor.offset", []
    for value in (0.0, tiny):
        robot = load_robot("six_rfs").with_parameters({path: value})
        answers.append(derivatives(solve_home(robot), path))
    for name in STATE:
        both = [getattr(found, name) for found in answers]
        assert_allclose(*both, rtol=0.0, atol=1e-6 * max(1.0, np.abs(both[0]).max()))
    assert np.abs(answers[1].position).max() > 0.1


def test_what_only_stretches_a_direction_does_nothing_to_stability():
    """Rounding was taken for an effect of it, and it was varied by 2^25: the whole call was refused."""
    content = shipped_content("delta")
    turn = rotation_exp([0.0, 0.0, 0.1])
    for leg in content["legs"]:
        for field in ("position", "tangent", "normal"):
            leg["base"][field] = (turn @ np.array(leg["base"][field], float)).tolist()
    home = solve_home(load_robot(content))
    paths = [f"legs[{leg}].base.normal[{axis}]" for leg in range(6) for axis in range(3)]
    found = derivatives(home, paths, of=("margin", "smallest_eigenvalue"))
    for slopes in (found.margin.reshape(6, 3), found.smallest_eigenvalue.reshape(6, 3)):
        size = np.abs(slopes[:, 2]).min()
        assert size > 1e-6
        assert_allclose(slopes[:, :2], 0.0, rtol=0.0, atol=1e-6 * size)


def refusal(equilibrium, path):
    """Derivatives, or why there are none."""
    try:
        return derivatives(equilibrium, path)
    except CprError as error:
        return error


def test_the_second_question_is_answered_by_the_same_numbers():
    equilibrium = equilibrium_of("six_rfs")
    paths = ["rod.length", "legs[0].motor.offset"]
    first, again = derivatives(equilibrium, paths), derivatives(equilibrium, paths)
    alone = derivatives(equilibrium, paths[1])
    for name in STATE:
        assert_array_equal(getattr(first, name), getattr(again, name))
        assert_allclose(getattr(first, name)[:, 1:], getattr(alone, name), rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(
    ("arguments", "kind", "told"),
    [
        (("rod.lenght",), UnknownParameter, "did you mean rod.length"),
        (("rod.length", "wrench"), InvalidRequest, "expected some of pose, motors"),
        (("rod.length", ()), InvalidRequest, "expected some of pose, motors"),
        (("rod.length", "pose", "wrench"), InvalidRequest, "expected motors, efforts or pose"),
        (([],), InvalidRequest, "at least one path"),
        (("rod.yield_strain",), InvalidRequest, "not given"),
        (("legs[0].base.position[2]",), CprError, "planar"),
    ],
)
def test_bad_questions_are_refused(arguments, kind, told):
    with pytest.raises(kind, match=told):
        derivatives(solve_home(load_robot("rfrfr")), *arguments)


def test_no_equilibrium_and_no_single_solution():
    with pytest.raises(InvalidRequest, match="expected an Equilibrium"):
        derivatives("home", "rod.length")
    home = solve_home(load_robot("four_rfr"))
    with pytest.raises(InvalidRequest, match="no single solution"):
        derivatives(home, "rod.length", problem="pose")


def test_with_a_motor_held_beside_the_pose():
    """Redundant motors: the one more than the pose needs stays where it is."""
    robot = with_loads(load_robot("four_rfr")).holding((2,))
    free = equilibrium_of("four_rfr")
    equilibrium = solve_forward(robot, free.motors)
    found = derivatives(equilibrium, "rod.length", problem="pose")
    assert found.motors[2] == 0.0
    assert np.abs(found.position).max() < 1e-9
    assert np.abs(found.motors).max() > 0.1


def test_single_angles_are_held_as_they_are_controlled():
    """Pitch and yaw, which are no turns about axes of the world once there is any yaw."""
    content = yaml.safe_load(load_robot("three_prs").description.text)
    robot = load_robot(content | {"controlled": ["z", "pitch", "yaw"]})
    equilibrium = solve_forward(robot, solve_home(robot).motors + np.array(STEPS["three_prs"]))
    found = derivatives(equilibrium, "legs[0].tip.position[1]", problem="pose")
    rates = np.linalg.solve(angle_motions(equilibrium.platform_rotation), found.rotation[:, 0])
    assert abs(rates[0]) > 1.0
    assert_allclose(rates[1:], 0.0, rtol=0.0, atol=1e-9 * abs(rates[0]))
    assert abs(found.rotation[1, 0]) > 1e-4 * abs(rates[0])
    assert abs(found.position[2, 0]) < 1e-9


def test_rods_without_a_load_notice_the_first_one():
    """Kernels leave loads on rods out where there are none."""
    equilibrium = solve_home(load_robot("six_rfs"))
    assert not equilibrium.load_arrays.on_rods[0]
    for path in ("gravity[2]", "loads.rod_force[2]"):
        for problem in problems_of("six_rfs"):
            assert compared(equilibrium, path, problem, STATE)
    assert np.abs(derivatives(equilibrium, "gravity[2]").position).max() > 1e-4


def test_slopes_of_stability_where_descriptions_end_are_those_of_the_robot_without_limits():
    """A rod that is next to nothing at the limit of its motor has none with a smaller offset."""
    content, equilibria = shipped_content("gough_stewart"), []
    for limits in ({"position": [1e-9, 0.8]}, {}):
        content["legs"][0]["motor"] = {"type": "extensible", "offset": 0.0, "limits": limits}
        robot = load_robot(content)
        away = solve_forward(robot, solve_home(robot).motors + np.array(STEPS["gough_stewart"]))
        equilibria.append(polished(away, "motors"))
    limited, free = equilibria
    (offset,) = named_parameters(free.robot.description, "legs[0].motor.offset")
    step = STEPS_TRIED[1] * parameter_scales(free, (offset,))[0]
    assert robots_beside(limited.robot, offset, step) is None
    true = solved_slopes(free, robots_beside(free.robot, offset, step), step, "motors")
    found = derivatives(limited, offset.path, of=("margin", "smallest_eigenvalue"))
    assert found.margin[0] == pytest.approx(true["margin"], rel=1e-6)
    assert found.smallest_eigenvalue[0] == pytest.approx(true["smallest_eigenvalue"], rel=1e-6)


def test_a_singular_equilibrium_has_none():
    equilibrium = equilibrium_of("rfrfr")
    nothing = equilibrium.factors.copy()
    nothing["lane"][1:] = 0.0  # before that is how it was factored
    singular = replace(equilibrium, known_factors=nothing)
    assert derivatives(equilibrium, "rod.length").position.any()
    with pytest.raises(CprError, match="singular with its motors held"):
        derivatives(singular, "rod.length")


def test_where_no_factors_are_kept():
    """A straight rod under no force is not eliminated on its own: its tangent is evaluated again."""
    home = solve_home(load_robot(COLUMN))
    assert home.factors["lane"][0, 0] == DELAYED
    forces = [f"loads.platform_force[{axis}]" for axis in range(2)]
    found, model = derivatives(home, forces), kinemato_statics(home)
    assert found.position[1, 1] > 1e-3
    assert_allclose(found.twist_body[[2, 3, 4]], model.platform_by_wrench[:, 1:], atol=1e-10)


def test_strain_modes_are_those_of_the_robot():
    """Also where they are not those of the file."""
    coarse, fine = load_robot("six_rfs", modes=3), load_robot("six_rfs", modes=7)
    assert isinstance(coarse, Robot)
    found = [derivatives(solve_home(robot), "rod.length").position for robot in (coarse, fine)]
    assert_allclose(found[0], found[1], rtol=0.05)
    assert np.abs(found[0] - found[1]).max() > 1e-6


def test_where_forces_may_act_is_not_varied_and_where_they_do_is():
    """A station that moves alone moves the nodes: what differed was the error of the quadrature."""
    content = shipped_content("rfrfr")
    content["stations"] = [0.3]
    content["rod"]["profile"] = {"at": [0.0, 0.45, 1.0], "stiffness": [1.0, 1.3, 1.1]}
    content["loads"] = {
        "points": [{"leg": "leg1", "at": 0.6, "force": [2.0, 1.0, 0.0]}],
        "distributed": [
            {"leg": "leg2", "at": [0.0, 0.7, 1.0], "force": [[0, 0, 0], [3, 1, 0], [0, 0, 0]]}
        ],
    }
    robot = load_robot(content)
    home = solve_home(robot)
    for path in ("stations[0]", "stations[*]"):
        with pytest.raises(InvalidRequest, match=r"stations.* cannot be varied: the quadrature"):
            derivatives(home, [path, "rod.young_modulus"])
    for path in ("rod.profile.at[1]", "loads.points[0].at", "loads.distributed[0].at[1]"):
        at = robot.parameter_values(path)[0]
        ahead, behind = (
            continued(home, robot.with_parameters({path: at + way})).platform_position
            for way in (1e-4, -1e-4)
        )
        slope = (ahead - behind) / 2e-4
        assert np.linalg.norm(slope) > 1e-4
        found = derivatives(home, path).position[:, 0]
        assert_allclose(found, slope, rtol=0.0, atol=1e-3 * np.linalg.norm(slope))


@pytest.mark.parametrize("path", ["legs[0].base.position[0]", "legs[1].tip.position[1]"])
@pytest.mark.parametrize("name", ["six_rus", "delta", "gough_stewart"])
def test_slopes_of_eigenvalues_that_are_close_to_others(name, path):
    """Their differences reached beyond where the next one is smaller, and were off by up to a half."""
    robot = load_robot(name)
    home = solve_home(robot)
    away = 0.002 * robot.motor_units * np.cos(np.arange(robot.motor_count))
    start = solve_forward(robot, home.motors + away, start=home)
    found = derivatives(start, [path], of=("margin", "smallest_eigenvalue"))
    value, step = float(robot.parameter_values(path)[0]), 1e-6
    before, after = (
        continued(start, robot.with_parameters({path: value + change})) for change in (-step, step)
    )
    for slope, first, last in (
        (found.margin[0], before.margin, after.margin),
        (
            found.smallest_eigenvalue[0],
            before.spectrum_locked.smallest,
            after.spectrum_locked.smallest,
        ),
    ):
        assert slope == pytest.approx((last - first) / (2.0 * step), rel=1e-3)


def with_a_force(at):
    content = shipped_content("rfrfr")
    content["loads"] = {"points": [{"leg": "leg1", "at": at, "force": [0.05, -0.1, 0.0]}]}
    return load_robot(content)


@pytest.mark.parametrize("others", [(), ("legs[1].motor.offset", "legs[0].motor.offset")])
def test_a_number_that_can_only_get_smaller(others):
    """It was refused: there is no robot on the other side."""
    path, largest, way = "loads.points[0].at", 1.0 - 4e-6, 1e-3

    def at(value):
        return solve_forward(with_a_force(value), [2.7, 0.4])

    middle = at(largest)
    found = derivatives(middle, [path, *others], of=("pose", "efforts", "margin"))
    near = [middle, *(at(largest - number * way) for number in (1, 2, 3))]
    weights = np.array([11.0, -18.0, 9.0, -2.0]) / (6.0 * way)
    for own, values in (
        (found.position[:, 0], [equilibrium.platform_position for equilibrium in near]),
        (found.efforts[:, 0], [equilibrium.efforts for equilibrium in near]),
        (found.margin[:1], [[equilibrium.margin] for equilibrium in near]),
    ):
        expected = weights @ np.array(values)
        assert_allclose(own, expected, rtol=0.0, atol=1e-4 * np.abs(expected).max() + 1e-9)
    single = derivatives(middle, path)
    assert_allclose(found.position[:, 0], single.position[:, 0], rtol=1e-9)


def test_a_number_that_can_go_neither_way_is_refused_with_the_reason():
    home = solve_home(load_robot("rfrfr"))
    with pytest.raises(DescriptionError, match=r"expected z = 0 in a planar robot, got .* 1e-05"):
        derivatives(home, "gravity[2]")

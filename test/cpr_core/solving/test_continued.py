# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Equilibria that go on as those of the same robot with other parameters."""

import numpy as np
import pytest
import yaml
from helpers.parameter_kinds import with_loads
from helpers.shipped_steps import REDUNDANT, STEPS
from numpy.testing import assert_allclose

from cpr_core import (
    InvalidRequest,
    MotorLimitExceeded,
    NoForwardSolution,
    NoInverseSolution,
    TimeLimitExceeded,
    UnstableEquilibrium,
    continued,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
)
from cpr_core.description.description_file import shipped_robots
from cpr_core.solving import continued as module

ROBOTS = list(shipped_robots())
#: Under a force it has several stable equilibria, of which another one may be home of another robot.
UNLOADED = "three_prs"
#: Unstable under these efforts, motors turning by radians for a thousandth of the change.
SOFT = ("six_rus", "efforts")


def equilibrium_of(name):
    robot = load_robot(name)
    robot = robot if name == UNLOADED else with_loads(robot)
    return solve_forward(robot, solve_home(robot).motors + 0.5 * np.array(STEPS[name]))


def changed(robot, factor=1.02):
    """Other rods, another platform and other bases."""
    length, modulus = robot.parameter_values(["rod.length", "rod.young_modulus"])
    force = robot.parameter_values("loads.platform_force[0]")[0]
    tip = "legs[0].tip.position[1]"
    return robot.with_parameters(
        {
            "rod.length": factor * length,
            "rod.young_modulus": modulus / factor,
            "loads.platform_force[0]": factor * force,
            tip: robot.parameter_values(tip)[0] + 0.5 * (factor - 1.0) * robot.mean_length,
        }
    )


@pytest.mark.parametrize("name", ROBOTS)
def test_it_is_what_the_new_robot_finds_from_its_home(name):
    start = equilibrium_of(name)
    robot = changed(start.robot)
    home = solve_home(robot)
    solves = {
        "motors": lambda: solve_forward(robot, start.motors, start=home),
        "pose": lambda: solve_inverse(robot, start.pose, start=home),
        "efforts": lambda: solve_forward_by_effort(
            robot, start.efforts, start=continued(start, robot)
        ),
    }
    for problem, solve in solves.items():
        if (problem == "pose" and name in REDUNDANT) or (name, problem) == SOFT:
            continue
        found = continued(start, robot, problem)
        expected = solve()
        assert found.robot is robot
        assert found.converged
        place = {"rtol": 0.0, "atol": 1e-6 * robot.mean_length}
        assert_allclose(found.platform_position, expected.platform_position, **place)
        assert_allclose(
            found.motors / robot.motor_units, expected.motors / robot.motor_units, atol=1e-6
        )
        assert found.index_locked == expected.index_locked
        if name != "gough_stewart":  # the nominal length of rods that are fed is a matter of units
            assert (
                np.abs(found.platform_position - start.platform_position).max() > 0.0
                or problem == "pose"
            )


def test_what_is_held_stays_to_the_last_digit():
    start = equilibrium_of("six_rfs")
    robot = changed(start.robot)
    assert_allclose(continued(start, robot).motors, start.motors, rtol=0.0, atol=0.0)
    pose = continued(start, robot, "pose")
    assert_allclose(pose.platform_position, start.platform_position, rtol=0.0, atol=1e-15)
    efforts = continued(start, robot, "efforts")
    assert_allclose(efforts.efforts, start.efforts, rtol=0.0, atol=1e-9)


def test_home_is_not_looked_for(monkeypatch):
    """One step where little changes, of one robot; several where much does."""
    start = equilibrium_of("six_rfs")
    robot = changed(start.robot)
    between, made = module.between, []
    monkeypatch.setattr(module, "between", lambda *all: (made.append(1), between(*all))[1])
    monkeypatch.setattr("cpr_core.solving.home.solve_home", None)
    found = continued(start, robot)
    assert not made
    assert 0 < found.iterations < 8
    far = continued(start, start.robot.with_parameters({"rod.length": 1.8}))
    assert made
    back = continued(far, start.robot)
    assert_allclose(back.platform_position, start.platform_position, rtol=0.0, atol=1e-9)


def test_to_the_same_robot_nothing_changes():
    start = equilibrium_of("six_rus")
    found = continued(
        start,
        start.robot.with_parameters({"rod.length": start.robot.parameter_values("rod.length")[0]}),
    )
    assert_allclose(found.state, start.state, rtol=0.0, atol=1e-9)


def test_a_way_in_many_steps_is_the_way_in_one():
    """Defaults that are written out on the way count from where they were."""
    start = equilibrium_of("six_rfs")
    values = {"legs[2].motor.offset": 0.4, "platform.center_of_mass[0]": 0.05}
    step = start
    for part in np.linspace(0.1, 1.0, 10):
        step = continued(
            step, start.robot.with_parameters({p: part * v for p, v in values.items()})
        )
    found = continued(start, start.robot.with_parameters(values))
    assert_allclose(found.platform_position, step.platform_position, rtol=0.0, atol=1e-9)
    middle = module.between(start.robot.description, found.robot.description, 0.5)
    assert middle.legs[2].drive.zero == 0.2
    assert_allclose(middle.center_of_mass, [0.025, 0.0, 0.0])


def test_loads_of_the_description_follow_and_those_of_the_request_stay():
    robot = load_robot("six_rfs")
    loads = robot.default_loads.with_(wrench_world=[0.0, 0.0, 0.0, 0.0, 0.0, -0.2])
    start = solve_forward(robot, solve_home(robot).motors, loads=loads)
    heavy = robot.with_parameters({"gravity[2]": -1.0, "loads.platform_force[0]": 3.0})
    found = continued(start, heavy)
    assert found.loads.gravity.tolist() == [0.0, 0.0, -1.0]
    assert found.loads.wrench_world.tolist() == loads.wrench_world.tolist()
    plain = continued(solve_home(robot), robot.with_parameters({"gravity[2]": -1.0}))
    assert plain.loads is plain.robot.default_loads


def loaded_until_it_buckles(problem="motors", **options):
    start = solve_home(load_robot("six_rfs"))
    heavy = start.robot.with_parameters({"loads.platform_force[2]": -40.0})
    return continued(start, heavy, problem, **options)


def test_a_fold_between_is_told():
    """With the fraction where it is, and the last equilibrium before it: its margin is nearly gone."""
    with pytest.raises(NoForwardSolution, match="motors held") as caught:
        loaded_until_it_buckles()
    error = caught.value
    assert 0.05 < error.fraction < 0.95
    assert error.last.index_locked == 0
    assert 0.0 < error.last.margin < 0.05
    assert error.event.equilibrium is error.last
    force = error.last.robot.parameter_values("loads.platform_force[2]")[0]
    assert np.isclose(force, -40.0 * error.fraction)


@pytest.mark.parametrize(
    ("stable_only", "kind", "event"),
    [(False, NoForwardSolution, "bifurcation"), (True, UnstableEquilibrium, "stability")],
)
def test_a_symmetric_robot_is_not_led_over_a_bifurcation(stable_only, kind, event):
    """On the symmetric branch Newton's method converges wherever it begins, stable or not."""
    robot = load_robot("three_rfs")
    start = solve_forward(robot, np.full(3, solve_home(robot).motors.mean()))
    unit = robot.kernel_arrays.energy_unit / robot.mean_length**2
    crushed = robot.with_parameters({"loads.platform_force[2]": -10.0 * unit})
    with pytest.raises(kind) as caught:
        continued(start, crushed, stable_only=stable_only)
    assert caught.value.event.kind == event
    assert caught.value.event.index_before == 0 < caught.value.event.index_after
    assert caught.value.last.stable
    assert 0.0 < caught.value.last.margin < 0.01


def test_a_way_is_not_gone_in_one_leap(monkeypatch):
    """Even where Newton's method would: the whole robot somewhere else, three rods away."""
    start = solve_home(load_robot("six_rfs"))
    between, made = module.between, []
    monkeypatch.setattr(module, "between", lambda *all: (made.append(1), between(*all))[1])
    bases = {f"legs[{leg}].base.position[2]": 3.0 * start.robot.mean_length for leg in range(6)}
    found = continued(start, start.robot.with_parameters(bases))
    moved = found.platform_position - start.platform_position
    assert_allclose(moved, [0.0, 0.0, 3.0], rtol=0.0, atol=1e-8)
    assert len(made) > 4


def test_a_pose_that_other_parameters_do_not_reach():
    start = equilibrium_of("rfrfr")
    short = start.robot.with_parameters({"rod.length": 0.3 * start.robot.mean_length})
    with pytest.raises(NoInverseSolution, match="pose held") as caught:
        continued(start, short, "pose")
    assert 0.0 < caught.value.fraction < 1.0
    assert_allclose(caught.value.last.platform_position, start.platform_position, atol=1e-12)


def test_limits_hold():
    start = equilibrium_of("three_prs")
    stiff = start.robot.with_parameters({"legs[0].chain[0].limits.position[0]": 0.2})
    assert start.motors[0] < 0.2
    with pytest.raises(MotorLimitExceeded):
        continued(start, stiff)


def test_time_is_limited():
    with pytest.raises(TimeLimitExceeded) as caught:
        loaded_until_it_buckles(time_limit=0.0)
    assert caught.value.event.kind == "time_limit"
    assert caught.value.fraction == caught.value.event.fraction == 0.0


def test_unstable_starts_are_refused_where_stability_is_asked_for():
    start = solve_home(load_robot("six_rfs"))
    with pytest.raises(NoForwardSolution) as caught:
        loaded_until_it_buckles()
    last = caught.value.last
    moment = last.robot.default_loads.with_(wrench_world=[0.01, 0.0, 0.0, 0.0, 0.0, 0.0])
    turning = solve_forward(start.robot, start.motors, start=start, loads=moment)
    with pytest.raises(UnstableEquilibrium, match="not known to be stable"):
        continued(turning, changed(with_loads(start.robot)), stable_only=True)
    assert continued(turning, changed(with_loads(start.robot))).converged


@pytest.mark.parametrize(
    ("robot", "problem", "told"),
    [
        ("six_rfs", "motors", "expected a Robot"),
        (load_robot("rfrfr"), "motors", "the robot of the start"),
        (load_robot("six_rfs", modes=6), "motors", "the robot of the start"),
        (load_robot("six_rfs"), "wrench", "expected motors, efforts or pose"),
    ],
)
def test_other_robots_are_refused(robot, problem, told):
    with pytest.raises(InvalidRequest, match=told):
        continued(solve_home(load_robot("six_rfs")), robot, problem)


def test_no_equilibrium_and_no_single_solution():
    with pytest.raises(InvalidRequest, match="expected an Equilibrium"):
        continued("home", load_robot("rfrfr"))
    home = solve_home(load_robot("four_rfr"))
    with pytest.raises(InvalidRequest, match="no single solution"):
        continued(home, home.robot, "pose")


def test_a_robot_that_differs_in_more_than_numbers_is_refused():
    """Also where it has as many unknowns."""
    start = solve_home(load_robot("six_rfs"))
    content = yaml.safe_load(start.robot.description.text)
    content["legs"][1]["name"] = "another"
    with pytest.raises(InvalidRequest, match=r"numbers of its description only, not in legs\[1\]"):
        continued(start, load_robot(content))


def test_there_and_back_over_a_default():
    start = equilibrium_of("six_rfs")
    shifted = continued(start, start.robot.with_parameters({"platform.center_of_mass[0]": 0.02}))
    assert np.abs(shifted.platform_position - start.platform_position).max() > 1e-5
    back = continued(shifted, start.robot)
    assert_allclose(back.platform_position, start.platform_position, rtol=0.0, atol=1e-9)

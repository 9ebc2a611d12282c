# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A gear or a screw between motor and joint changes the numbers of the motor, and nothing else."""

import warnings

import numpy as np
import pytest
from helpers.geared_robots import geared
from helpers.shipped_steps import STEPS
from helpers.yaml_content import shipped_content

from cpr_core import (
    DescriptionError,
    DescriptionWarning,
    MotorLimitExceeded,
    derivatives,
    find_equilibria,
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
    trace,
)
from cpr_core.workspace import map_workspace, motor_grid


@pytest.fixture(scope="module", params=STEPS)
def pair(request):
    """A robot, the same with gears, and ways of joints by ways of motors."""
    return geared(request.param)


def far(robot):
    """Motor positions well away from home."""
    return solve_home(robot).motors + 2.0 * np.array(STEPS[robot.description.name])


def assert_same(found, expected, ratios, tolerance=1e-9):
    np.testing.assert_allclose(found.motors * ratios, expected.motors, atol=tolerance)
    np.testing.assert_allclose(found.platform_position, expected.platform_position, atol=tolerance)
    np.testing.assert_allclose(found.platform_rotation, expected.platform_rotation, atol=tolerance)
    size = max(1.0, np.abs(expected.efforts).max())
    np.testing.assert_allclose(found.efforts / ratios, expected.efforts, atol=tolerance * size)
    indices = expected.index_locked, expected.index_free
    assert (found.index_locked, found.index_free) == indices
    assert found.margin == pytest.approx(expected.margin, abs=1e-8)


def test_home_and_where_motors_lead_are_the_same(pair):
    robot, moved, ratios = pair
    assert_same(solve_home(moved), solve_home(robot), ratios)
    target = far(robot)
    assert_same(solve_forward(moved, target / ratios), solve_forward(robot, target), ratios)


def test_so_are_the_motors_of_a_pose(pair):
    robot, moved, ratios = pair
    pose = solve_forward(robot, far(robot)).pose
    assert_same(solve_inverse(moved, pose), solve_inverse(robot, pose), ratios, 1e-8)


def test_so_is_how_near_it_is_to_singularities_and_how_it_gives_way(pair):
    robot, moved, ratios = pair
    expected = kinemato_statics(solve_forward(robot, far(robot)))
    found = kinemato_statics(solve_forward(moved, far(robot) / ratios))
    problems = ("forward",) if robot.redundancy else ("forward", "inverse")
    for problem in problems:
        for length in (None, 0.03):
            values = [each.smallest_singular_value(problem, length) for each in (found, expected)]
            assert values[0] == pytest.approx(values[1], rel=2e-6, abs=1e-9)
    np.testing.assert_allclose(found.jacobian / ratios, expected.jacobian, atol=1e-8)
    held = np.abs(expected.compliance()).max()
    np.testing.assert_allclose(found.compliance(), expected.compliance(), atol=1e-7 * held)
    loops = np.full(len(ratios), 30.0)
    free = [found.compliance(loops * ratios**2), expected.compliance(loops)]
    np.testing.assert_allclose(*free, atol=1e-7 * np.abs(free[1]).max())


def test_so_are_a_path_and_what_happens_on_it(pair):
    robot, moved, ratios = pair
    target = solve_home(robot).motors + 12.0 * np.array(STEPS[robot.description.name])
    expected = trace(robot, motors=target, points=5)
    found = trace(moved, motors=target / ratios, points=5)
    kinds = [[event.kind for event in path.events] for path in (found, expected)]
    fractions = [[event.fraction for event in path.events] for path in (found, expected)]
    assert kinds[0] == kinds[1]
    np.testing.assert_allclose(*fractions, atol=1e-6)
    assert found.reached == expected.reached
    assert_same(found.last, expected.last, ratios, 1e-5)


def test_so_is_a_path_of_efforts(pair):
    robot, moved, ratios = pair
    efforts = solve_forward(robot, 0.8 * solve_home(robot).motors + 0.2 * far(robot)).efforts
    expected = solve_forward_by_effort(robot, efforts)
    assert_same(solve_forward_by_effort(moved, efforts * ratios), expected, ratios, 1e-6)


@pytest.mark.parametrize("objective", ["least_motion", "least_effort", "greatest_margin"])
def test_redundant_motors_are_shared_out_in_the_same_way(objective):
    robot, moved, ratios = geared("four_rfr")
    pose = solve_forward(robot, far(robot)).pose
    found = solve_inverse(moved, pose, objective=objective)
    assert_same(found, solve_inverse(robot, pose, objective=objective), ratios, 1e-5)


def test_so_are_all_equilibria():
    robot, moved, ratios = geared("rfrfr")
    motors = solve_home(robot).motors
    expected = find_equilibria(robot, motors, starts=40)
    found = find_equilibria(moved, motors / ratios, starts=40)
    assert len(found) == len(expected) > 3
    for each, other in zip(found, expected, strict=True):
        assert_same(each.equilibrium, other.equilibrium, ratios, 1e-7)
        assert (each.stable, each.from_home) == (other.stable, other.from_home)


def test_so_is_a_map_over_motors():
    robot, moved, ratios = geared("three_prs")
    places = [np.linspace(0.05, 0.2, 6), np.linspace(0.08, 0.16, 4)]
    maps = []
    for each, ways in ((robot, np.ones(3)), (moved, ratios)):
        axes = {
            f"motor{number + 1}": sorted(along / ways[number])
            for number, along in enumerate(places)
        }
        grid = motor_grid(each, axes, held={"motor3": 0.1 / ways[2]})
        maps.append(map_workspace(each, grid, workers=0))
    found, expected = maps
    assert np.all(expected.reached)
    # The second screw is left-handed: its axis runs the other way.
    flipped = np.arange(expected.grid.size).reshape(6, 4)[:, ::-1].ravel()
    for name in ("forward_margin", "inverse_margin", "limit_margins", "index_free", "strains"):
        values = getattr(found, name)[flipped], getattr(expected, name)
        np.testing.assert_allclose(*values, atol=1e-7, err_msg=name)


def test_limits_of_a_motor_are_those_in_front_of_its_gear():
    _, moved, ratios = geared("three_prs")
    beyond = np.array([0.2501, 0.1, 0.1]) / ratios
    with pytest.raises(MotorLimitExceeded, match="motor1"):
        solve_forward(moved, beyond)
    inside = np.array([0.2499, 0.1, 0.1]) / ratios
    assert solve_forward(moved, inside).converged


@pytest.mark.parametrize(
    ("name", "motor", "gear"),
    [
        ("six_rfs", {}, {"ratio": -0.01}),
        ("rfrfr", {}, {"ratio": 3.0}),
        ("planar_body", {"type": "prismatic", "axis": [0.6, -0.8, 0.0]}, {"ratio": 0.1}),
        ("planar_body", {"type": "prismatic", "axis": [0.6, -0.8, 0.0]}, {"lead": -0.002}),
    ],
)
def test_the_short_form_has_gears_too(name, motor, gear):
    content = shipped_content(name)
    leg = content["legs"][0]
    if motor:  # the joint has to reach: zero at the base
        leg["motor"] = dict(motor)
        content["home"]["motors"][0] = 0.0
        content["home"].pop("platform", None)
    plain = load_robot(content)
    leg["motor"] |= gear
    ratio = gear.get("ratio", gear.get("lead", 0.0) / (2.0 * np.pi))
    ratios = np.array([ratio] + [1.0] * (plain.motor_count - 1))
    content["home"]["motors"][0] /= ratio
    moved = load_robot(content)
    assert moved.motor_names == plain.motor_names
    units = [each.description.motors[0].unit for each in (moved, plain)]
    assert units == ["rad" if "lead" in gear else units[1], "m" if motor else "rad"]
    assert_same(solve_home(moved), solve_home(plain), ratios)
    way = 0.02 * plain.motor_units * np.cos(np.arange(plain.motor_count))
    target = solve_home(plain).motors + way
    assert_same(solve_forward(moved, target / ratios), solve_forward(plain, target), ratios)


# What is written.


def screwed(**fields):
    """The content of a robot whose first motor has a screw."""
    content = shipped_content("three_prs")
    joint = content["legs"][0]["chain"][0]
    del joint["limits"]
    joint.update(fields)
    for name in [name for name, value in joint.items() if value is None]:
        del joint[name]
    return content


def test_a_motor_with_a_screw_is_in_radians():
    content = screwed(lead=0.01)
    content["home"]["motors"][0] = 20.0 * np.pi
    robot = load_robot(content)
    motor, other, _ = robot.description.motors
    assert (motor.unit, motor.effort_unit, other.unit) == ("rad", "N m", "m")
    home = solve_home(robot)
    np.testing.assert_allclose(home.platform_position, HOME.platform_position, atol=1e-9)
    # A turn does the work of a lead.
    assert home.efforts[0] * 2.0 * np.pi == pytest.approx(0.01 * HOME.efforts[0], rel=1e-7)
    path = "legs[0].chain[0].lead"
    found = derivatives(home, path).position[:, 0]
    ways = []
    for sign in (-1.0, 1.0):
        content["legs"][0]["chain"][0]["lead"] = 0.01 * (1.0 + sign * 1e-4)
        ways.append(solve_forward(load_robot(content), home.motors).platform_position)
    np.testing.assert_allclose(found, (ways[1] - ways[0]) / 2e-6, rtol=1e-5, atol=1e-7)


HOME = solve_home(load_robot("three_prs"))


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"lead": 0.0}, r"chain\[0\]\.lead: expected a number other than zero"),
        ({"lead": 0.01, "ratio": 2.0}, "a motor that turns has a lead, one that shifts a ratio"),
        ({"lead": 0.01, "motor": None}, "no motor moves this joint"),
        ({"lead": 0.01, "motor": "motor2"}, "'motor2' cannot turn at one joint, which has a lead"),
        ({"lead": "1 mm"}, "lead"),
    ],
)
def test_what_no_screw_can_be_is_refused(fields, text):
    with pytest.raises(DescriptionError, match=text):
        load_robot(screwed(**fields))


@pytest.mark.parametrize(
    ("name", "gear"),
    [
        ("six_rus", {"lead": 0.01}),
        ("six_rfs", {"lead": 0.01}),
        ("six_rfs", {"ratio": 0.0}),
        ("six_rfs", {"ratio": 0.5, "name": "motor2"}),
    ],
)
def test_a_turning_joint_has_no_lead_and_no_other_motors_name(name, gear):
    content = shipped_content(name)
    leg = content["legs"][0]
    (leg["chain"][0] if "chain" in leg else leg["motor"]).update(gear)
    with pytest.raises(DescriptionError, match=list(gear)[-1]):
        load_robot(content)


def test_units_are_doubted_by_where_the_joint_would_be():
    """A hundred turns of a screw are no degrees; the same number without one is millimetres."""
    content = screwed(lead=0.001, limits={"position": [0.0, 1500.0]})
    content["home"]["motors"][0] = 628.3
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load_robot(content)
    content = screwed(lead=0.001, limits={"position": [0.0, 90000.0]})
    content["home"]["motors"][0] = 36000.0
    with pytest.warns(DescriptionWarning) as told:
        load_robot(content)
    assert [str(each.message).rpartition(": ")[2] for each in told] == [
        "looks like degrees, expected radians"
    ] * 2
    with pytest.warns(DescriptionWarning, match="limits.position: 1500: looks like millimetres"):
        load_robot(screwed(limits={"position": [0.0, 1500.0]}))

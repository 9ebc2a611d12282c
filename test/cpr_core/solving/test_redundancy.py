# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots with more motors than controlled coordinates: what the freedom is used for."""

import numpy as np
import pytest
from helpers.yaml_content import shipped_content
from scipy.optimize import minimize

from cpr_core import (
    InvalidRequest,
    MotorLimitExceeded,
    NoInverseSolution,
    Robot,
    TimeLimitExceeded,
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    trace,
    trace_through,
)

TARGET = np.array([-0.06, 0.03, 0.1])


def without_limits(name="four_rfr"):
    content = shipped_content(name)
    for leg in content["legs"]:
        leg["chain"][0].pop("limits", None)
    return load_robot(content)


def point_robot():
    """Four legs on a point, of no symmetry: two coordinates, two motors too many."""
    legs = []
    for x, y in ((0.05, 0.5), (-0.5, 0.1), (-0.1, -0.45), (0.5, -0.05)):
        base = {"position": [x, y, 0.0], "tangent": [-x, -y, 0.0]}
        tip = {"type": "revolute", "position": [0.0, 0.0, 0.0]}
        motor = {"type": "revolute", "axis": [0, 0, 1]}
        legs.append({"base": base, "motor": motor, "tip": tip})
    content = shipped_content("rfrfr")
    content |= {"legs": legs, "controlled": ["x", "y"]}
    content["rod"] = {**content["rod"], "length": 0.7}
    content["home"] = {"motors": [1.0, 1.0, 1.0, 1.0], "bow": "left"}
    return load_robot(content)


@pytest.fixture(scope="module", params=["four_rfr", "point"])
def robot(request):
    return without_limits() if request.param == "four_rfr" else point_robot()


@pytest.mark.parametrize(
    ("motors", "words"),
    [
        ((0, 1), "expected 1 to hold"),
        ((), "expected 1 to hold"),
        ((4,), "at most 3"),
        ((-1,), "at least 0"),
        ((2, 2), "different motors"),
        (("motor1",), "a whole number"),
        ("motor1", "numbers of different motors, from 0 to 3"),
        ((True,), "a whole number"),
        (None, "numbers of different motors"),
        (0, "numbers of different motors"),
    ],
)
def test_motors_that_cannot_be_held_are_refused(motors, words):
    """With an equation too many kernels would write beyond their memory."""
    robot = load_robot("four_rfr")
    with pytest.raises(InvalidRequest, match=words) as caught:
        robot.holding(motors)
    assert caught.value.argument == "motors"
    if motors:
        with pytest.raises(InvalidRequest, match=words):
            Robot(robot.description, motors)
    with pytest.raises(InvalidRequest, match="expected 0 to hold, as 2 motors move 2"):
        load_robot("rfrfr").holding((0,))


def test_a_robot_holds_the_motors_it_is_told_to_however_they_are_told():
    """It was kept by the name of what told them, which another iterator had again."""
    robot = load_robot("four_rfr")
    for motor in (0, 1, 2, 0, 3):
        held = robot.holding(each for each in [motor])
        assert held.held_motors == (motor,)
        assert held is robot.holding([motor]) is robot.holding(np.array([motor]))


def test_motors_that_are_held_stay(robot):
    motors = np.arange(robot.redundancy)
    held = robot.holding(motors)
    assert held.redundancy == 0
    found = solve_inverse(held, moved(held, 0.2))
    np.testing.assert_array_equal(found.motors[motors], solve_home(held).motors[motors])
    np.testing.assert_allclose(found.pose, moved(held, 0.2), atol=1e-9)


def moved(robot, size=1.0):
    """The pose of home, moved."""
    home = solve_home(robot)
    return home.pose + size * TARGET[: len(home.pose)]


MEASURES = {
    "least_effort": lambda found, home: found.efforts @ found.efforts,
    "least_motion": lambda found, home: np.sum((found.motors - home.motors) ** 2),
    "greatest_margin": lambda found, home: -found.margin,
}


@pytest.mark.parametrize("objective", MEASURES)
def test_the_optimum_is_that_of_another_method(robot, objective):
    """Minimised over all motors by scipy, with the pose as constraint and forward solutions only."""
    home, pose = solve_home(robot), moved(robot)
    found = solve_inverse(robot, pose, objective=objective)
    assert found.objective == objective
    np.testing.assert_allclose(found.pose, pose, rtol=0.0, atol=1e-10)

    def at(motors):
        return solve_forward(robot, motors, start=found)

    other = minimize(
        lambda motors: MEASURES[objective](at(motors), home),
        found.motors + 0.02 * np.array([1.0, -1.0, 0.5, 0.3]),
        method="SLSQP",
        bounds=[(motor - 0.05, motor + 0.05) for motor in found.motors],
        constraints=[{"type": "eq", "fun": lambda motors: at(motors).pose - pose}],
        options={"ftol": 1e-14, "maxiter": 300},
    )
    best, value = at(other.x), MEASURES[objective](found, home)
    assert np.abs(best.pose - pose).max() < 1e-9
    assert value <= other.fun + 1e-7 * abs(other.fun)
    if objective != "greatest_margin":  # its top may be flat, or a ridge
        np.testing.assert_allclose(found.motors, other.x, rtol=0.0, atol=1e-6)
        assert value == pytest.approx(other.fun, rel=1e-6)


def test_objectives_differ_and_each_is_best_at_its_own(robot):
    home, pose = solve_home(robot), moved(robot)
    found = {name: solve_inverse(robot, pose, objective=name) for name in MEASURES}
    for name, measure in MEASURES.items():
        values = {other: measure(each, home) for other, each in found.items()}
        assert min(values, key=values.__getitem__) == name
        assert all(value > values[name] for other, value in values.items() if other != name)


def with_fine_motor(name):
    """A shipped robot without limits, a fine motor after the first one, about the same axis."""
    content = shipped_content(name)
    for leg in content["legs"]:
        leg["chain"][0].pop("limits", None)
    chain = content["legs"][0]["chain"]
    chain.insert(1, {**chain[0], "motor": "fine"})
    content["home"]["motors"].insert(1, 0.0)
    return load_robot(content)


def test_motors_that_change_no_effort_stay_where_least_motion_has_them_along_a_way():
    """The one against the other changes nothing: rounding decided, and they went many turns."""
    robot = with_fine_motor("three_rfr_hubs")
    home = last = solve_home(robot)
    for way in np.linspace(0.0, 1.0, 5):
        pose = home.pose + way * np.array([0.03, -0.02, 0.05])
        least = solve_inverse(robot, pose, start=last)
        last = solve_inverse(robot, pose, start=last, objective="least_effort")
        np.testing.assert_allclose(last.motors, least.motors, rtol=0.0, atol=1e-7)
    far = solve_inverse(robot, pose, objective="least_effort")
    np.testing.assert_allclose(far.motors, last.motors, rtol=0.0, atol=1e-6)


def test_efforts_are_least_beside_motors_that_change_none():
    """Two motors too many: along the one self-motion that changes efforts they are stationary."""
    plain, robot = without_limits(), with_fine_motor("four_rfr")
    assert robot.redundancy == 2
    home = solve_home(robot)
    found = solve_inverse(robot, home.pose + TARGET, objective="least_effort")
    way = found.motors - home.motors
    assert way[0] == pytest.approx(way[1], abs=1e-7) and way[0] != pytest.approx(0.0, abs=1e-3)
    one = solve_forward(plain, [found.motors[0] + found.motors[1], *found.motors[2:]])
    model = kinemato_statics(one)
    slope = model.efforts_by_motors.T @ (one.efforts * [2.0, 1.0, 1.0, 1.0]) @ model.self_motions
    least = model.efforts_by_motors.T @ one.efforts @ model.self_motions
    assert np.abs(slope).max() < 1e-7 < np.abs(least).max()


def test_least_motion_is_the_default_and_starts_where_it_is_told(robot):
    home, pose = solve_home(robot), moved(robot)
    found = solve_inverse(robot, pose)
    assert found.objective == "least_motion"
    again = solve_inverse(robot, pose, start=found)
    np.testing.assert_allclose(again.motors, found.motors, rtol=0.0, atol=1e-9)
    elsewhere = solve_inverse(robot, pose, objective="least_effort")
    near = solve_inverse(robot, pose + 1e-6, start=elsewhere)
    assert np.abs(near.motors - elsewhere.motors).max() < 1e-4
    # The way is across the self-motions: nothing of it could be saved.
    way = found.motors - home.motors
    assert np.abs(way @ kinemato_statics(found).self_motions).max() < 1e-6


def test_self_motions_leave_the_platform_and_predictions_are_shortest(robot):
    found = solve_inverse(robot, moved(robot))
    model = kinemato_statics(found)
    motions = model.self_motions
    assert motions.shape == (4, robot.redundancy)
    np.testing.assert_allclose(motions.T @ motions, np.eye(robot.redundancy), atol=1e-12)
    np.testing.assert_allclose(model.jacobian @ motions, 0.0, atol=1e-10)
    step = 1e-4
    for motion in motions.T:
        beside = [
            solve_forward(robot, found.motors + s * motion, start=found) for s in (step, -step)
        ]
        assert np.abs(beside[0].pose - beside[1].pose).max() < 1e-7
    platform = np.linspace(0.3, -0.2, len(robot.platform_axes))
    increments = model.predict_inverse(platform)
    np.testing.assert_allclose(increments.platform, platform, atol=1e-10)
    np.testing.assert_allclose(increments.motors @ motions, 0.0, atol=1e-10)


def test_singular_values_are_those_of_the_wide_matrix(robot):
    model = kinemato_statics(solve_home(robot))
    a, _, e, w = model.matrices()
    assert len(robot.controlled_axes) == len(robot.platform_axes)
    whole = np.hstack([a, e, -w[:, : robot.motor_count]])
    assert whole.shape[1] == len(whole) + robot.redundancy
    expected = np.linalg.svd(whole, compute_uv=False)[::-1]
    found = model.singularity("inverse")
    np.testing.assert_allclose(found.singular_values, expected, rtol=1e-9)
    assert found.sign == 0
    assert model.singular_values("inverse")[0] == pytest.approx(expected[0], rel=1e-9)


def test_paths_are_loops_of_inverse_solutions(robot):
    poses = solve_home(robot).pose + np.linspace(0.0, 1.0, 6)[1:, None] * (
        moved(robot) - solve_home(robot).pose
    )
    one_by_one, last = [], solve_home(robot)
    for pose in poses:
        last = solve_inverse(robot, pose, start=last)
        one_by_one.append(last.motors)
    through = trace_through(robot, poses=poses)
    np.testing.assert_allclose(through.motors, one_by_one, rtol=0.0, atol=1e-9)
    straight = trace(robot, pose=poses[-1], points=6)
    assert straight.reached
    assert straight.events == ()
    np.testing.assert_allclose(straight.motors[1:], one_by_one, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(straight.fractions, np.linspace(0.0, 1.0, 6))


def test_motors_go_on_from_an_inverse_solution_as_from_the_same_place_found_by_motors(robot):
    """It has no determinant that could change sign: an inverse singularity was passed at once."""
    by_pose = solve_inverse(robot, moved(robot))
    by_motors = solve_forward(robot, by_pose.motors)
    assert by_pose.signs == by_motors.signs
    for start in (by_pose, by_motors):
        assert trace(robot, motors=by_pose.motors + 0.02, start=start, points=5).events == ()


@pytest.mark.parametrize("points", [2, 6])
@pytest.mark.parametrize(
    "made",
    [point_robot, without_limits, lambda: load_robot("four_rfr")],
    ids=["point", "without limits", "with limits"],
)
def test_the_fraction_of_an_event_is_where_the_platform_is_then(made, points):
    """The way is straight in the coordinates, in however many parts it is gone."""
    robot = made()
    start = solve_home(robot).pose
    goal = start + 12.0 * TARGET[: len(start)]
    found = trace(robot, pose=goal, points=points)
    assert not found.reached
    for event in found.events:
        place = start + event.fraction * (goal - start)
        np.testing.assert_allclose(event.equilibrium.pose, place, rtol=0.0, atol=1e-9)


def test_loads_change_on_the_way(robot):
    loads = robot.default_loads.with_(wrench_world=[0, 0, 0, 0.5, -0.3, 0])
    found = solve_inverse(robot, moved(robot), loads=loads)
    assert found.loads is loads
    again = solve_forward(robot, found.motors + 1e-6, start=found)
    again = solve_forward(robot, found.motors, start=again)
    np.testing.assert_allclose(again.pose, moved(robot), rtol=0.0, atol=1e-9)


def test_what_is_out_of_reach_is_told():
    robot = without_limits()
    home = solve_home(robot)
    with pytest.raises(NoInverseSolution, match="inverse singularity") as caught:
        solve_inverse(robot, home.pose + [0.4, 0.0, 0.0])
    last = caught.value.last
    assert 0.05 < last.platform_position[0] < 0.4 and last.robot is robot
    assert kinemato_statics(last).singular_values("inverse")[0] < 1e-3
    reach = caught.value.fraction * 0.4
    assert solve_inverse(robot, home.pose + [reach - 1e-4, 0.0, 0.0]).converged


def test_limits_stop_the_way_and_bound_what_is_best():
    content = shipped_content("four_rfr")
    home = solve_home(without_limits())
    free = solve_inverse(without_limits(), home.pose + TARGET)
    far = int(np.argmax(np.abs(free.motors - home.motors)))
    span = sorted((float(home.motors[far]), float(0.5 * (home.motors + free.motors)[far])))
    margin = 1e-3
    content["legs"][far]["chain"][0]["limits"] = {"position": [span[0] - margin, span[1] + margin]}
    robot = load_robot(content)
    with pytest.raises(MotorLimitExceeded) as caught:
        solve_inverse(robot, home.pose + TARGET)
    assert 0.0 < caught.value.fraction < 1.0
    # Within the limits the best there is: no farther than they allow.
    near = solve_inverse(robot, home.pose + 0.2 * TARGET, objective="least_effort")
    assert span[0] - margin - 1e-9 <= near.motors[far] <= span[1] + margin + 1e-9


def test_an_objective_without_freedom_is_refused(robot):
    six = load_robot("rfrfr")
    with pytest.raises(InvalidRequest, match=r"objective: expected none: .* no more motors"):
        solve_inverse(six, solve_home(six).pose, objective="least_effort")
    with pytest.raises(
        InvalidRequest, match="expected least_motion, least_effort or greatest_margin"
    ):
        solve_inverse(robot, moved(robot), objective="fun")
    with pytest.raises(InvalidRequest, match="motors are imposed"):
        trace_through(robot, motors=[solve_home(robot).motors], objective="least_effort")
    with pytest.raises(InvalidRequest, match="past_folds"):
        trace(robot, pose=moved(robot), past_folds=True)


def test_time_is_limited():
    robot = without_limits()
    with pytest.raises(TimeLimitExceeded):
        solve_inverse(robot, moved(robot, 1.5), time_limit=0.0)

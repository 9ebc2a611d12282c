# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The problems: consistency between them, starts, loads, refusals, immutability."""

import pickle

import numpy as np
import pytest

from cpr_core import (
    Equilibrium,
    InvalidRequest,
    Loads,
    NoForwardSolution,
    NoInverseSolution,
    NonFiniteInput,
    continued,
    load_robot,
    restore_equilibrium,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
    trace_through,
)
from cpr_core.model.model_state import evaluate

SIX_TARGET = np.array([5.86, 5.56, 5.86, 5.46, 5.86, 5.26]) + [0.2, -0.1, 0.15, 0.1, -0.2, 0.05]
GRAVITY = {"rfrfr": [0, -9.81, 0], "six_rfs": [0, 0, -9.81]}


@pytest.fixture(scope="module", params=["rfrfr", "six_rfs"])
def robot(request):
    return load_robot(request.param)


def motors_near_home(robot):
    return SIX_TARGET if robot.motor_count == 6 else np.array([2.7, 0.45])


def assert_solves_the_model(equilibrium):
    """By a fresh evaluation of Eq. (32), not by what the solver says."""
    robot = equilibrium.robot
    value = evaluate(
        robot,
        robot.load_arrays(equilibrium.loads),
        equilibrium.state,
        equilibrium.platform_rotation,
        equilibrium.platform_position,
    )
    rows = np.arange(robot.kernel_arrays.motor_index)
    unit = robot.kernel_arrays.unit[rows] / robot.kernel_arrays.energy_unit
    assert np.abs(value.residual[rows] * unit).max() < 1e-10
    np.testing.assert_allclose(value.residual[robot.motor_indices], equilibrium.efforts)
    rotation = equilibrium.platform_rotation
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)


def test_home_is_a_stable_equilibrium_at_the_home_motors(robot):
    home = solve_home(robot)
    assert_solves_the_model(home)
    np.testing.assert_array_equal(home.motors, robot.description.home.motors)
    assert home.index_locked == home.index_free == 0
    assert solve_home(robot) is home


@pytest.mark.parametrize("loaded", [False, True])
def test_inverse_and_by_effort_give_back_the_forward_solution(robot, loaded):
    loads = Loads.none().with_(gravity=GRAVITY[robot.description.name]) if loaded else None
    forward = solve_forward(robot, motors_near_home(robot), loads=loads)
    assert_solves_the_model(forward)
    inverse = solve_inverse(robot, forward.pose, loads=loads)
    by_effort = solve_forward_by_effort(robot, forward.efforts, start=inverse)
    for other in (inverse, by_effort):
        assert_solves_the_model(other)
        np.testing.assert_allclose(other.motors, forward.motors, atol=1e-8)
        np.testing.assert_allclose(other.efforts, forward.efforts, atol=1e-8)
        np.testing.assert_allclose(other.leg_coordinates, forward.leg_coordinates, atol=1e-7)


def test_one_request_or_many_small_ones_lead_to_the_same_place(robot):
    target = motors_near_home(robot)
    at_once = solve_forward(robot, target)
    stepwise = solve_home(robot)
    for fraction in np.linspace(0.05, 1.0, 20):
        motors = (1.0 - fraction) * solve_home(robot).motors + fraction * target
        stepwise = solve_forward(robot, motors, start=stepwise)
    np.testing.assert_allclose(stepwise.state, at_once.state, atol=1e-9)


def test_loads_of_the_start_are_kept_unless_others_are_given(robot):
    loads = Loads.none().with_(gravity=GRAVITY[robot.description.name])
    loaded = solve_forward(robot, solve_home(robot).motors, loads=loads)
    onward = solve_forward(robot, motors_near_home(robot), start=loaded)
    assert onward.loads is loads
    unloaded = solve_forward(robot, motors_near_home(robot), start=loaded, loads=Loads.none())
    direct = solve_forward(robot, motors_near_home(robot))
    np.testing.assert_allclose(unloaded.state, direct.state, atol=1e-9)
    assert np.linalg.norm(onward.state - direct.state) > 1e-3


def test_gravity_lowers_the_platform(robot):
    loads = Loads.none().with_(gravity=GRAVITY[robot.description.name])
    down = np.array(GRAVITY[robot.description.name]) / 9.81
    loaded = solve_forward(robot, solve_home(robot).motors, loads=loads)
    assert down @ (loaded.platform_position - solve_home(robot).platform_position) > 1e-3


def test_energy_gained_along_a_path_is_the_work_of_the_motors(robot):
    """Gauss quadrature of tau . dq against the difference of the potential, gravity on."""
    loads = Loads.none().with_(gravity=GRAVITY[robot.description.name])
    first = solve_forward(robot, solve_home(robot).motors, loads=loads)
    step = motors_near_home(robot) - first.motors
    last = solve_forward(robot, first.motors + step, start=first)
    nodes, weights = np.polynomial.legendre.leggauss(10)
    equilibrium, work = first, 0.0
    for node, weight in zip(0.5 * (nodes + 1.0), 0.5 * weights, strict=True):
        equilibrium = solve_forward(robot, first.motors + node * step, start=equilibrium)
        work += weight * equilibrium.efforts @ step
    assert last.energy - first.energy == pytest.approx(work, rel=1e-6)


def test_a_force_on_the_platform_is_carried_by_the_tips(robot):
    force = np.array([0.05, -0.1, 0.0])
    loads = Loads.none().with_(wrench_world=[0, 0, 0, *force])
    loaded = solve_forward(robot, solve_home(robot).motors, loads=loads)
    axes = 2 if robot.planar else 3
    carried = loaded.multipliers.reshape(-1, axes).sum(axis=0)
    np.testing.assert_allclose(carried, force[:axes], atol=1e-11)


def test_straight_rods_are_no_obstacle():
    """Legs without strain: blocks are singular there, the robot is not."""
    content = {
        "name": "two_columns",
        "space": "planar",
        "rod": {
            "length": 0.5,
            "section": {"shape": "circular", "radius": 0.001},
            "young_modulus": 2.1e11,
            "shear_modulus": 8.2e10,
        },
        "legs": [
            {
                "base": {"position": [x, 0, 0], "tangent": [-x, 0.4, 0]},
                "motor": {"type": "revolute", "axis": [0, 0, 1]},
                "tip": {"type": "revolute", "position": [0, 0, 0]},
            }
            for x in (-0.3, 0.3)
        ],
        "platform": {"shape": "point"},
        "controlled": ["x", "y"],
        "home": {
            "motors": [0.0, 0.0],
            "platform": {"position": [0, 0.4, 0]},
            "strain": [{}, {}],
        },
    }
    robot = load_robot(content)
    np.testing.assert_allclose(solve_home(robot).platform_position, [0, 0.4, 0], atol=1e-12)
    np.testing.assert_allclose(solve_home(robot).efforts, 0.0, atol=1e-10)
    pulled = solve_forward(
        robot, [0.0, 0.0], loads=Loads.none().with_(wrench_world=[0, 0, 0, 0, 0.1, 0])
    )
    # Each rod pulls along itself: two times F cos(angle) = 0.1 with cos(angle) = 0.8.
    np.testing.assert_allclose(np.linalg.norm(pulled.multipliers[:2]), 0.0625, rtol=1e-6)


def test_unreachable_requests_say_how_far_they_came():
    robot = load_robot("rfrfr")
    with pytest.raises(NoInverseSolution) as caught:
        solve_inverse(robot, [0.0, 3.0])
    # The rods are straight at the border of the reach.
    assert caught.value.last.platform_position[1] == pytest.approx(np.sqrt(0.96), abs=1e-3)
    assert 0.0 < caught.value.fraction < 0.1
    assert_solves_the_model(caught.value.last)
    with pytest.raises(NoForwardSolution):
        solve_forward(
            robot,
            solve_home(robot).motors,
            loads=Loads.none().with_(wrench_world=[0, 0, 0, 0, 1e9, 0]),
        )


@pytest.mark.parametrize(
    "values", [[1.0], [1.0, 2.0, 3.0], [[1.0, 2.0]], "ab", [1.0, "x"], None, []]
)
def test_wrong_motor_vectors_are_refused(values):
    with pytest.raises(InvalidRequest, match=r"motors: expected 2 numbers \(motor1 motor2\)"):
        solve_forward(load_robot("rfrfr"), values)


def test_values_that_are_not_finite_are_refused():
    robot = load_robot("rfrfr")
    for bad in (np.nan, np.inf):
        with pytest.raises(NonFiniteInput):
            solve_forward(robot, [2.59, bad])
        with pytest.raises(NonFiniteInput):
            solve_inverse(robot, [0.0, bad])


def test_a_start_of_another_robot_is_refused_with_what_to_do_instead():
    robot, kept = load_robot("rfrfr"), pickle.loads(pickle.dumps(solve_home(load_robot("rfrfr"))))
    with pytest.raises(
        InvalidRequest, match=r"same robot.*start\.robot.*continued\(start, robot\)"
    ):
        solve_forward(robot, [2.59, 0.55], start=kept)
    its_own = solve_forward(kept.robot, [2.7, 0.5], start=kept)
    this_one = solve_forward(robot, [2.7, 0.5], start=continued(kept, robot))
    np.testing.assert_allclose(this_one.state, its_own.state, rtol=0.0, atol=1e-12)


def test_loads_that_are_not_borne_are_named():
    """The motors stay: that they were not reached led whoever had meant 1 N and not 1 kN astray."""
    home = solve_home(load_robot("rfrfr"))
    pushed = home.loads.with_(wrench_world=[0, 0, 0, 0, -100.0, 0])
    with pytest.raises(NoForwardSolution) as caught:
        solve_forward(home.robot, home.motors, loads=pushed)
    assert str(caught.value).startswith("motors under other loads (wrench_world): not reached")
    with pytest.raises(NoForwardSolution, match=r"^motors: not reached"):
        solve_forward(home.robot, [150.0, 0.5], loads=home.loads)


def test_an_equilibrium_cannot_be_changed(robot):
    result = solve_forward(robot, motors_near_home(robot))
    for array in (result.state, result.motors, result.efforts, result.platform_rotation):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    with pytest.raises(AttributeError):
        result.energy = 0.0


def test_an_equilibrium_is_restored_from_its_numbers(robot):
    kept = solve_forward(robot, motors_near_home(robot))

    def restore(leg_coordinates=kept.leg_coordinates) -> Equilibrium:
        return restore_equilibrium(
            robot,
            kept.loads,
            np.round(kept.motors, 12),
            np.round(leg_coordinates, 9),
            np.round(kept.multipliers, 9),
            np.round(kept.platform_rotation, 9),
            np.round(kept.platform_position, 9),
        )

    np.testing.assert_allclose(restore().state, kept.state, atol=1e-9)
    with pytest.raises(InvalidRequest, match="expected an equilibrium"):
        restore(np.zeros(len(kept.leg_coordinates)))
    with pytest.raises(InvalidRequest, match="leg_coordinates"):
        restore(kept.leg_coordinates[1:])


def restored(kept, rotation, loads=None):
    return restore_equilibrium(
        kept.robot,
        kept.loads if loads is None else loads,
        kept.motors,
        kept.leg_coordinates,
        kept.multipliers,
        rotation,
        kept.platform_position,
    )


@pytest.mark.parametrize("digits", [2, 4])
def test_a_rounded_rotation_does_not_shear_the_platform(digits):
    robot = load_robot("six_rfs")
    kept = solve_forward(robot, SIX_TARGET)
    found = restored(kept, np.round(kept.platform_rotation, digits))
    np.testing.assert_allclose(found.platform_rotation, kept.platform_rotation, atol=1e-9)
    np.testing.assert_allclose(found.state, kept.state, atol=1e-9)
    for rotation in (1.1 * kept.platform_rotation, -kept.platform_rotation):
        with pytest.raises(InvalidRequest, match="platform_rotation: expected a rotation matrix"):
            restored(kept, rotation)


def test_numbers_of_other_loads_are_not_restored_as_another_equilibrium():
    """Newton's method finds one all the same where they are no more than some percent off."""
    robot = load_robot("six_rfs")
    kept = solve_forward(robot, SIX_TARGET)
    pushed = kept.loads.with_(wrench_world=[0, 0, 0, 0, 0.2, 0])
    with pytest.raises(InvalidRequest, match="expected an equilibrium"):
        restored(kept, kept.platform_rotation, pushed)


def test_a_planar_equilibrium_is_restored_in_its_plane_only():
    kept = solve_home(load_robot("rfrfr"))
    turned = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    for rotation, shift in ((np.eye(3), [0, 0, 0.001]), (turned, [0, 0, 0])):
        with pytest.raises(InvalidRequest, match="planar robot"):
            restore_equilibrium(
                kept.robot,
                kept.loads,
                kept.motors,
                kept.leg_coordinates,
                kept.multipliers,
                rotation,
                kept.platform_position + shift,
            )


def test_the_pose_of_an_equilibrium_is_what_the_inverse_problem_takes(robot):
    home = solve_home(robot)
    pose = home.pose
    np.testing.assert_array_equal(pose[:2], home.platform_position[:2])
    if not robot.planar:
        np.testing.assert_array_equal(pose[3:], home.platform_quaternion)
    np.testing.assert_allclose(solve_inverse(robot, pose).motors, home.motors, atol=1e-9)


@pytest.mark.parametrize("solve", [solve_forward, solve_forward_by_effort])
@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"start": [2.59, 0.55]}, "start: expected an Equilibrium"),
        ({"time_limit": "soon"}, "time_limit: expected a time of at least 0 s, got 'soon'"),
        ({"time_limit": -1.0}, "time_limit"),
        ({"time_limit": float("nan")}, "time_limit"),
        ({"time_limit": True}, "time_limit"),
        ({"loads": "gravity"}, "loads: expected Loads"),
    ],
)
def test_options_of_wrong_types_are_refused(solve, options, says):
    robot = load_robot("rfrfr")
    with pytest.raises(InvalidRequest, match=says):
        solve(robot, solve_home(robot).motors, **options)


@pytest.mark.parametrize("rotation", [np.eye(2), "level", [[1, 0, 0], [0, 1]], 1.0, None])
def test_a_stored_rotation_of_another_shape_is_refused(rotation):
    home = solve_home(load_robot("rfrfr"))
    with pytest.raises(InvalidRequest, match="platform_rotation"):
        restore_equilibrium(
            home.robot,
            home.loads,
            home.motors,
            home.leg_coordinates,
            home.multipliers,
            rotation,
            home.platform_position,
        )


@pytest.mark.parametrize("pitch", [1.5708, 2.5, -1.5708, 1.5707964])
def test_a_pitch_beyond_a_right_angle_is_refused(pitch):
    """Roll, pitch and yaw would not come back as they were given."""
    robot = load_robot("three_rfs")
    height, roll, _ = solve_home(robot).pose
    with pytest.raises(
        InvalidRequest, match=f"expected a pitch of at most pi/2 rad, got {pitch} rad"
    ):
        solve_inverse(robot, [height, roll, pitch])


@pytest.mark.parametrize("length", [0.0, -0.3])
def test_a_rod_length_of_zero_or_less_is_refused(length):
    robot = load_robot("gough_stewart")
    motors = solve_home(robot).motors.copy()
    motors[2] = length
    with pytest.raises(InvalidRequest, match="motor3: expected a rod length above 0 m"):
        solve_forward(robot, motors)
    rows = [solve_home(robot).motors, motors, solve_home(robot).motors]
    with pytest.raises(InvalidRequest, match=rf"motor3: .*, got {length:g} m"):
        trace_through(robot, motors=rows)

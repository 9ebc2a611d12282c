# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""First-order behaviour against differences of full solves, reciprocity, singularities."""

import numpy as np
import pytest
from helpers.rigid_leg import rigid_leg
from helpers.shipped_steps import REDUNDANT, STEPS

from cpr_core import InvalidRequest, load_robot, solve_forward, solve_home, solve_inverse
from cpr_core.description.chain import Turn
from cpr_core.description.description_file import shipped_robots
from cpr_core.lie import quaternion_from_rotation, rotation_exp, rotation_log
from cpr_core.model.kinemato_statics import kinemato_statics
from cpr_core.model.problem_units import problem_units
from cpr_core.solving.requests import pose_meaning

#: Axes of the platform that numbers of a pose move; the turns of a quaternion.
AXES = {"roll": 0, "pitch": 1, "yaw": 2, "angle": 2, "x": 3, "y": 4, "z": 5}
TURNS = {True: (0, 1, 2), False: ()}


def placed(name):
    robot = load_robot(name)
    force = [0, 0, 0, 0.02, -0.03, 0.0 if robot.planar else 0.04]
    loads = robot.default_loads.with_(wrench_world=force)
    return solve_forward(robot, solve_home(robot).motors + np.array(STEPS[name]), loads=loads)


def body_twist(start, end):
    """Platform motion from one equilibrium to another, in the platform frame."""
    rotation = start.platform_rotation
    turn = rotation_log(rotation.T @ end.platform_rotation)
    shift = rotation.T @ (end.platform_position - start.platform_position)
    return np.concatenate([turn, shift])[start.robot.platform_axes]


def difference(function, size):
    """Central difference of order four of a function of one number."""
    return (8 * (function(size) - function(-size)) - (function(2 * size) - function(-2 * size))) / (
        12 * size
    )


def close(found, expected):
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * scale)


@pytest.fixture(scope="module", params=sorted(shipped_robots()))
def equilibrium(request):
    return placed(request.param)


@pytest.fixture(scope="module", params=sorted(set(shipped_robots()) - set(REDUNDANT)))
def here_square(request):
    return placed(request.param)


def test_motor_columns_are_those_of_full_solves(equilibrium):
    model = kinemato_statics(equilibrium)
    size = 2e-4 * equilibrium.robot.arrays.unit[equilibrium.robot.motor_indices]
    for motor in range(equilibrium.robot.motor_count):
        step = np.eye(equilibrium.robot.motor_count)[motor]

        def solved(amount, step=step):
            return solve_forward(
                equilibrium.robot, equilibrium.motors + amount * step, start=equilibrium
            )

        for name, value in (
            ("jacobian", lambda e: body_twist(equilibrium, e)),
            ("efforts_by_motors", lambda e: e.efforts - equilibrium.efforts),
            ("legs_by_motors", lambda e: e.leg_coordinates - equilibrium.leg_coordinates),
            ("multipliers_by_motors", lambda e: e.multipliers - equilibrium.multipliers),
        ):
            column = difference(lambda a, value=value, t=solved: value(t(a)), size[motor])
            scale = np.abs(getattr(model, name)).max()
            np.testing.assert_allclose(
                getattr(model, name)[:, motor], column, rtol=0, atol=1e-6 * scale, err_msg=name
            )


def test_wrench_columns_are_those_of_full_solves(equilibrium):
    model, robot = kinemato_statics(equilibrium), equilibrium.robot
    turn = np.zeros((6, 6))
    turn[:3, :3] = turn[3:, 3:] = equilibrium.platform_rotation
    columns, efforts = [], []
    for axis in robot.platform_axes:
        size = 1e-3 * robot.arrays.energy_unit
        wrench = turn[:, axis]

        def loaded(amount, wrench=wrench):
            loads = equilibrium.loads.with_(
                wrench_world=equilibrium.loads.wrench_world + amount * wrench
            )
            return solve_forward(robot, equilibrium.motors, start=equilibrium, loads=loads)

        columns.append(difference(lambda a, t=loaded: body_twist(equilibrium, t(a)), size))
        efforts.append(difference(lambda a, t=loaded: t(a).efforts, size))
    close(model.platform_by_wrench, np.transpose(columns))
    close(model.efforts_by_wrench, np.transpose(efforts))


def test_compliance_is_symmetric_and_motors_only_add_to_it(equilibrium):
    model = kinemato_statics(equilibrium)
    held = model.compliance()
    close(held, held.T)
    n = equilibrium.robot.motor_count
    for stiffness in (1e9, 5.0):
        yielding = model.compliance(np.full(n, stiffness))
        close(yielding, yielding.T)
        loops = model.efforts_by_motors + np.diag(np.full(n, stiffness))
        if np.linalg.eigvalsh(0.5 * (loops + loops.T)).min() > 0.0:  # the motors hold the rods
            assert np.linalg.eigvalsh(yielding - held).min() > -1e-9 * np.abs(held).max()
    close(model.compliance(np.full(n, 1e12)), held)
    np.testing.assert_allclose(
        model.stiffness() @ held, np.eye(len(held)), atol=1e-7 * np.linalg.cond(held)
    )


def test_a_platform_that_cannot_move_along_a_rigid_leg_has_no_stiffness():
    model = kinemato_statics(solve_home(rigid_leg()))
    with pytest.raises(InvalidRequest, match=r"stiffness: .*cannot along its twist") as caught:
        model.stiffness()
    named = np.array(str(caught.value).split("[")[1].split("]")[0].split(", "), float)
    home = model.equilibrium
    leg = home.platform_rotation.T @ (home.platform_position - [0.0, -0.1, 0.0])
    np.testing.assert_allclose(
        named[1:] / np.linalg.norm(named[1:]), leg[:2] / np.linalg.norm(leg), atol=1e-2
    )
    assert named[0] == pytest.approx(0.0, abs=1e-9)
    yielding = model.compliance([5.0, 5.0, 5.0])
    close(model.stiffness([5.0, 5.0, 5.0]) @ yielding, np.eye(3))


def test_compliance_at_constant_effort_is_that_of_the_condensed_stiffness(equilibrium):
    """Eliminate the motors from the stiffness of motors and platform together."""
    model, n = kinemato_statics(equilibrium), equilibrium.robot.motor_count
    by_platform = np.linalg.inv(model.platform_by_wrench)
    coupling = -by_platform @ model.jacobian
    motors = model.efforts_by_motors - coupling.T @ model.jacobian
    whole = np.block([[motors, coupling.T], [coupling, by_platform]])
    compliance = np.linalg.inv(whole)[n:, n:]
    close(model.compliance(np.zeros(n)), compliance)


def test_reciprocity_of_motors_and_platform(equilibrium):
    """dtau_a/dw_p = -(dSigma_p/dq_a)^T, and dtau_a/dq_a is symmetric."""
    model = kinemato_statics(equilibrium)
    close(model.efforts_by_wrench, -model.jacobian.T)
    close(model.efforts_by_motors, model.efforts_by_motors.T)
    softening = np.linalg.eigvalsh(0.5 * (model.efforts_by_motors + model.efforts_by_motors.T))
    assert equilibrium.index_free == equilibrium.index_locked + int(np.sum(softening < 0.0))


def test_the_papers_matrices_hold_for_any_motion(equilibrium):
    """A dq_a + P dSigma_p + E dq_e = W dw for the responses to motors and to wrenches."""
    model, robot = kinemato_statics(equilibrium), equilibrium.robot
    a, p, e, w = model.matrices()
    n, unit = robot.motor_count, robot.arrays.unit
    r = n + len(robot.elastic_indices) + len(robot.platform_indices)
    assert (len(a), len(p), len(e), len(w)) == (r, r, r, r)
    energy = robot.arrays.energy_unit
    motors, platform = unit[robot.motor_indices], unit[robot.platform_indices]
    legs = robot.unit_motions[np.ix_(robot.elastic_indices, robot.elastic_indices)]
    left = (
        a
        + p @ (model.jacobian / platform[:, None] * motors)
        + e @ (np.linalg.solve(legs, model.legs_by_motors) * motors)
    )
    right = w[:, :n] @ (model.efforts_by_motors * motors[:, None] * motors / energy)
    np.testing.assert_allclose(left, right, atol=1e-8 * max(np.abs(right).max(), 1.0))


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs"])
def test_the_prediction_error_falls_as_the_square_of_the_step(name):
    start = placed(name)
    model, direction = kinemato_statics(start), np.array(STEPS[name])
    errors = []
    for size in (0.2, 0.1, 0.05):
        end = solve_forward(start.robot, start.motors + size * direction, start=start)
        predicted = model.jacobian @ (size * direction)
        errors.append(np.linalg.norm(body_twist(start, end) - predicted))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


def test_predictions_invert_each_other(here_square):
    model, robot = kinemato_statics(here_square), here_square.robot
    motors = 1e-3 * np.array(STEPS[robot.description.name])
    wrench = 1e-4 * np.arange(1.0, 1.0 + len(robot.platform_axes))
    forward = model.predict_forward(motors, wrench)
    back = model.predict_inverse(forward.platform, wrench)
    for name in ("motors", "efforts", "platform", "wrench"):
        np.testing.assert_allclose(
            getattr(back, name), getattr(forward, name), rtol=1e-6, atol=1e-12, err_msg=name
        )


def test_any_admissible_choice_of_increments_gives_the_same_motion(equilibrium):
    """Eqs. (45) and (46), and mixtures of them, from one consistent set of increments."""
    model, n = kinemato_statics(equilibrium), equilibrium.robot.motor_count
    motors = 1e-3 * np.array(STEPS[equilibrium.robot.description.name])
    wrench = 1e-4 * np.arange(1.0, 1.0 + len(equilibrium.robot.platform_axes))
    known = model.predict_forward(motors, wrench)
    half = known.motors.copy()
    half[n // 2 :] = np.nan
    other_half = known.efforts.copy()
    other_half[: n // 2] = np.nan
    choices = (
        {"motors": known.motors, "wrench": known.wrench},
        {"platform": known.platform, "efforts": known.efforts},
        {"motors": half, "efforts": other_half, "wrench": known.wrench},
        {"motors": known.motors, "platform": known.platform},
    )
    for choice in choices:
        found = model.solve(**choice)
        for name in ("motors", "efforts", "platform", "wrench"):
            expected = getattr(known, name)
            np.testing.assert_allclose(
                getattr(found, name), expected, rtol=0, atol=1e-6 * np.abs(expected).max()
            )
    with pytest.raises(InvalidRequest, match="given numbers"):
        model.solve(motors=known.motors)
    with pytest.raises(InvalidRequest, match="motors: expected"):
        model.solve(motors=[1.0] * (n + 1), wrench=known.wrench)


def test_the_inverse_prediction_is_the_slope_of_inverse_solves():
    start = solve_inverse(load_robot("three_rfs"), [0.72, 0.1, -0.05])
    step = np.array([0.001, 0.002, -0.001])

    def solved(amount):
        return solve_inverse(start.robot, np.array([0.72, 0.1, -0.05]) + amount * step, start=start)

    motion = difference(lambda a: body_twist(start, solved(a)), 0.1)
    motors = difference(lambda a: solved(a).motors - start.motors, 0.1)
    close(kinemato_statics(start).predict_inverse(motion).motors, motors)


def test_motors_by_pose_are_the_slopes_of_inverse_solves(here_square):
    """By every coordinate, in the order of the platform's axes whatever that of the description."""
    robot, names = here_square.robot, pose_meaning(here_square.robot)
    axes = sorted({AXES[name] for name in names if name in AXES} | set(TURNS["qw" in names]))
    slopes = kinemato_statics(here_square).motors_by_pose
    assert slopes.shape == (robot.motor_count, len(axes))
    for column, axis in enumerate(axes):

        def motors(amount, axis=axis):
            pose = here_square.pose
            if "qw" in names and axis < 3:
                turned = rotation_exp(amount * np.eye(3)[axis]) @ here_square.platform_rotation
                pose[names.index("qw") :][:4] = quaternion_from_rotation(turned)
            else:
                moved = next(number for number, name in enumerate(names) if AXES.get(name) == axis)
                pose[moved] += amount
            return solve_inverse(robot, pose, start=here_square, loads=here_square.loads).motors

        close(slopes[:, column], difference(motors, 1e-5))


def test_the_inverse_singularity_of_the_six_rfs_path():
    """Near t = 48 of Eq. (53) the indicator changes sign; motor 6 moves nothing."""
    robot = load_robot("six_rfs")
    first = np.array([5.86, 5.56, 5.86, 5.46, 5.86, 5.26])
    last = np.array([7.95, 7.65, 4.29, 3.89, 3.77, 3.17])

    def at(t, start):
        return solve_forward(robot, first + (last - first) * t / 50, start=start)

    solution, signs = solve_home(robot), []
    for t in range(51):
        solution = at(t, solution)
        signs.append(kinemato_statics(solution).singularity("inverse").sign)
    changes = [t for t in range(50) if signs[t] != signs[t + 1]]
    assert changes == [47]
    low, high, solution = 47.0, 48.0, at(47.0, solution)
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        solution = at(middle, solution)
        if kinemato_statics(solution).singularity("inverse").sign == signs[47]:
            low = middle
        else:
            high = middle
    singular = kinemato_statics(solution).singularity("inverse")
    assert singular.smallest < 1e-8
    assert low == pytest.approx(47.814, abs=2e-3)
    direction = np.abs(singular.motors) / np.linalg.norm(singular.motors)
    assert robot.motor_names[int(direction.argmax())] == "motor6"
    assert direction.max() > 0.9
    np.testing.assert_allclose(singular.platform, 0.0, atol=1e-12)


def test_the_forward_problem_is_singular_where_locked_stability_is_lost():
    robot = load_robot("rfrfr", modes=12)
    solution = solve_inverse(robot, [0.0, 0.1], start=solve_inverse(robot, [0.0, 0.8]))
    signs, values = [], []
    for y in (0.05, 0.0358, 0.0356, 0.02):
        solution = solve_inverse(robot, [0.0, y], start=solution)
        forward = kinemato_statics(solution).singularity("forward")
        signs.append(forward.sign)
        values.append(forward.smallest)
    assert signs[0] == signs[1] == -signs[2] == -signs[3]
    assert max(values[1:3]) < 0.05 * min(values[0], values[3])


def test_the_characteristic_length_decides_and_units_do_not():
    solution = placed("six_rfs")
    model = kinemato_statics(solution)
    default = model.singularity("inverse")
    assert model.singularity("inverse", 1.0).smallest == pytest.approx(default.smallest, rel=1e-9)
    assert model.singularity("inverse", 0.1).smallest != pytest.approx(default.smallest, rel=1e-2)


@pytest.mark.parametrize("problem", ["forward", "inverse", "inverse_by_effort"])
@pytest.mark.parametrize("length", [None, 0.3])
def test_singular_values_alone_are_the_same(equilibrium, problem, length):
    if problem == "inverse" and not equilibrium.robot.description.controlled:
        return
    model = kinemato_statics(equilibrium)
    whole = model.singularity(problem, length).singular_values
    np.testing.assert_allclose(
        model.singular_values(problem, length), whole, rtol=1e-9, atol=1e-12 * whole[-1]
    )


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "gough_stewart"])
def test_natural_units_follow_from_a_length_and_an_energy(name):
    """Curvatures are over the length, forces the energy over it, moments the energy, shifts lengths."""
    robot, length = load_robot(name), 0.3
    units = problem_units(robot, length)
    unit, energy = units.states, units.energy
    expected = np.full(robot.state_size, np.nan)
    for leg, numbers in zip(robot.description.legs, robot.numbers.legs, strict=True):
        expected[numbers.strain] = 1.0 / length
        expected[numbers.forces], expected[numbers.moments] = energy / length, energy
        for element, index in zip(leg.chain, numbers.coordinates, strict=True):
            if index is not None:
                expected[index] = 1.0 if isinstance(element, Turn) else length
    expected[robot.platform_indices] = np.where(robot.platform_axes < 3, 1.0, length)
    np.testing.assert_allclose(unit, expected, rtol=1e-12)
    # Both of the same rods: E J over the length.
    assert energy * length == pytest.approx(robot.arrays.energy_unit * robot.mean_length)


@pytest.mark.filterwarnings("error::scipy.linalg.LinAlgWarning")
def test_motors_may_be_of_any_stiffness_side_by_side():
    """Each of its own: held, free and everything in between, without a warning of the solver."""
    model = kinemato_statics(placed("six_rfs"))
    free = np.arange(6) < 3
    mixed = model.compliance(np.where(free, 1e-300, 1e300))
    inner = np.ix_(free, free)
    yielding = np.linalg.solve(model.efforts_by_motors[inner], model.efforts_by_wrench[free])
    expected = model.platform_by_wrench - model.jacobian[:, free] @ yielding
    np.testing.assert_allclose(mixed, expected, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(
        model.stiffness(np.where(free, 1e-300, 1e300)) @ mixed, np.eye(6), atol=1e-9
    )


@pytest.mark.parametrize("name", ["rfrfr", "gough_stewart", "three_prs"])
def test_the_motor_part_of_a_null_direction_is_in_rad_and_m(name):
    """It is that of the dimensionless matrix, of either sign, in the units of the motors."""
    solution = placed(name)
    model, robot = kinemato_statics(solution), solution.robot
    for length in (robot.mean_length, 0.3 * robot.mean_length):
        a, _, e, w = model.matrices(length)
        matrix = np.hstack([a, e, -w[:, robot.motor_count :]])
        null = np.linalg.svd(matrix)[2][-1, : robot.motor_count]
        expected = null * problem_units(robot, length).states[robot.motor_indices]
        found = model.singularity("inverse_by_effort", length).motors
        close(found * np.sign(found @ expected), expected)


@pytest.mark.parametrize("motor", [0, 1])
def test_no_motor_has_a_negative_stiffness(motor):
    model = kinemato_statics(placed("rfrfr"))
    stiffness = np.full(2, 3.0)
    stiffness[motor] = -1e-3
    with pytest.raises(InvalidRequest, match="motor_stiffness: expected numbers of at least 0"):
        model.compliance(stiffness)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""First-order behaviour against differences of full solves, and reciprocity."""

import numpy as np
import pytest
from helpers.placed_equilibria import close, placed
from helpers.rigid_leg import rigid_leg
from helpers.shipped_steps import REDUNDANT, STEPS
from helpers.turntable import turntable

from cpr_core import InvalidRequest, load_robot, solve_forward, solve_home, solve_inverse
from cpr_core.description.description_file import shipped_robots
from cpr_core.lie import quaternion_from_rotation, rotation_exp, rotation_log
from cpr_core.model.kinemato_statics import kinemato_statics
from cpr_core.solving.requests import pose_meaning

#: Axes of the platform that numbers of a pose move; the turns of a quaternion.
AXES = {"roll": 0, "pitch": 1, "yaw": 2, "angle": 2, "x": 3, "y": 4, "z": 5}
TURNS = {True: (0, 1, 2), False: ()}


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


@pytest.fixture(scope="module", params=sorted(shipped_robots()))
def equilibrium(request):
    return placed(request.param)


@pytest.fixture(scope="module", params=sorted(set(shipped_robots()) - set(REDUNDANT)))
def square(request):
    return placed(request.param)


def test_motor_columns_are_those_of_full_solves(equilibrium):
    model = kinemato_statics(equilibrium)
    size = 2e-4 * equilibrium.robot.kernel_arrays.unit[equilibrium.robot.motor_indices]
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
        size = 1e-3 * robot.kernel_arrays.energy_unit
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


def nearly_straight(motor):
    """A point between two cranks: from the one a rigid link, from the other a rod, straight at 2.2."""
    link, rod = [{"link": [0.2, 0, 0]}], [{"rod": {}}]
    elbow = {"joint": "revolute", "axis": [0, 0, 1], "name": "elbow"}
    legs = [
        {
            "base": {"position": [x, 0, 0], "tangent": [1, 0, 0]},
            "chain": [
                {"joint": "revolute", "axis": [0, 0, 1], "motor": f"motor{x}"},
                {"link": [0.1, 0, 0]},
                *rest,
            ],
            "tip": {"type": "revolute", "position": [0, 0, 0]},
        }
        for x, rest in ((-0.12, [elbow, *link]), (0.12, rod))
    ]
    robot = load_robot(
        {
            "name": "nearly_straight",
            "space": "planar",
            "rod": {
                "length": 0.2,
                "section": {"shape": "circular", "radius": 0.001},
                "young_modulus": 200e9,
                "shear_modulus": 77e9,
            },
            "strain": {"bending_3": 5},
            "platform": {"shape": "point"},
            "legs": legs,
            "controlled": ["x", "y"],
            "home": {"motors": [1.5, 2.2], "joints": {"elbow": -0.2}},
        }
    )
    return kinemato_statics(solve_forward(robot, [motor, 2.2]))


@pytest.mark.parametrize("motor", [2.01, 2.07, 2.17, 2.25])
def test_a_rigid_leg_has_no_stiffness_either_where_rods_hardly_yield(motor):
    """What is left of the compliance along it is rounding, not a part of what is soft beside it."""
    model = nearly_straight(motor)
    assert np.linalg.eigvalsh(model.compliance())[0] == pytest.approx(0.0, abs=1e-14)
    with pytest.raises(InvalidRequest, match=r"stiffness: .*this one cannot along its twist"):
        model.stiffness()


def turned_arm(motor, ratio=1.0):
    """A bow that a motor turns, clamped to the platform, without loads."""
    home = load_robot(
        {
            "name": "arm",
            "space": "planar",
            "rod": {
                "length": 0.5,
                "section": {"shape": "circular", "radius": 0.001},
                "young_modulus": 210e9,
                "shear_modulus": 80e9,
                "rest_curvature": {"bending_3": [2.0]},
            },
            "strain": {"bending_3": 4},
            "legs": [
                {
                    "base": {"position": [0, 0, 0], "tangent": [1, 0, 0]},
                    "motor": {"type": "revolute", "axis": [0, 0, 1], "ratio": ratio},
                    "tip": {"type": "fixed", "position": [0, 0, 0], "tangent": [1, 0, 0]},
                }
            ],
            "controlled": ["angle"],
            "home": {"motors": [0.0], "platform": {"position": [0.42, 0.23, 0]}},
        }
    )
    return kinemato_statics(solve_forward(home, [motor / ratio]))


@pytest.mark.parametrize("ratio", [1.0, 0.01])
@pytest.mark.parametrize("motor", [0.0, 0.3, 0.5, 0.7, 1.0])
def test_motors_that_hold_nothing_give_no_compliance_whatever_rounding_leaves(motor, ratio):
    model = turned_arm(motor, ratio)
    tip = model.equilibrium.platform_rotation.T @ -model.equilibrium.platform_position
    for ask in (model.compliance, model.stiffness):
        with pytest.raises(
            InvalidRequest, match=r"^motor_stiffness: .* without any force"
        ) as caught:
            ask([0.0])
    by_motor, by_platform = (
        np.array(part.split("]")[0].split(", "), float) for part in str(caught.value).split("[")[1:]
    )
    turn = by_platform[0]
    assert abs(by_motor[0] * ratio) == pytest.approx(abs(turn), rel=1e-2)
    np.testing.assert_allclose(by_platform[1:] / turn, [tip[1], -tip[0]], atol=2e-3)
    close(model.compliance([1e12]), model.compliance())
    soft = 1e-7 * ratio**2
    yielding = model.compliance([soft])
    assert yielding[0, 0] - model.compliance()[0, 0] == pytest.approx(1e7, rel=1e-6)
    np.testing.assert_allclose(model.stiffness([soft]) @ yielding, np.eye(3), atol=1e-5)


def test_a_platform_that_hardly_anything_holds_is_not_said_to_be_held():
    """Beside a motion that is so soft nothing is left of the others."""
    with pytest.raises(InvalidRequest, match=r"^stiffness: .* moves freely along its twist"):
        turned_arm(0.3).stiffness([1e-11])


def test_a_turntable_at_constant_effort_has_no_compliance():
    model = kinemato_statics(solve_home(turntable()))
    with pytest.raises(
        InvalidRequest, match=r"twist \[0, 0, -?0.707, 0, 0, 0\] .* without any force"
    ):
        model.compliance([0.0])
    assert np.isfinite(model.compliance([5.0])).all()


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


def test_predictions_invert_each_other(square):
    model, robot = kinemato_statics(square), square.robot
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


def test_motors_by_pose_are_the_slopes_of_inverse_solves(square):
    """By every coordinate, in the order of the platform's axes whatever that of the description."""
    robot, names = square.robot, pose_meaning(square.robot)
    axes = sorted({AXES[name] for name in names if name in AXES} | set(TURNS["qw" in names]))
    slopes = kinemato_statics(square).motors_by_pose
    assert slopes.shape == (robot.motor_count, len(axes))
    for column, axis in enumerate(axes):

        def motors(amount, axis=axis):
            pose = square.pose
            if "qw" in names and axis < 3:
                turned = rotation_exp(amount * np.eye(3)[axis]) @ square.platform_rotation
                pose[names.index("qw") :][:4] = quaternion_from_rotation(turned)
            else:
                moved = next(number for number, name in enumerate(names) if AXES.get(name) == axis)
                pose[moved] += amount
            return solve_inverse(robot, pose, start=square, loads=square.loads).motors

        close(slopes[:, column], difference(motors, 1e-5))


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


@pytest.mark.parametrize("motor", [0, 1])
def test_no_motor_has_a_negative_stiffness(motor):
    model = kinemato_statics(placed("rfrfr"))
    stiffness = np.full(2, 3.0)
    stiffness[motor] = -1e-3
    with pytest.raises(InvalidRequest, match="motor_stiffness: expected numbers of at least 0"):
        model.compliance(stiffness)

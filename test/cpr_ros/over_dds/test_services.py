# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Forward and inverse services, called from another process as a controller would."""

import math

import numpy as np
import pytest
from cpr_msgs.msg import Equilibrium, ErrorCode
from cpr_msgs.srv import SolveForward, SolveInverse
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from std_srvs.srv import SetBool

import cpr_core

SIX_HOME = [5.86, 5.56, 5.86, 5.46, 5.86, 5.26]
SIX_NAMES = [f"motor{k}" for k in range(1, 7)]


def forward_request(names, positions, **fields):
    return SolveForward.Request(
        motors=JointState(name=names, position=[float(value) for value in positions]),
        start=SolveForward.Request.START_HOME,
        **fields,
    )


def forward(running, request):
    return running.client.call(SolveForward, "/cpr_node/solve_forward", request)


def inverse(running, request):
    return running.client.call(SolveInverse, "/cpr_node/solve_inverse", request)


def planar_target(x, y, **fields):
    target = PoseStamped()
    target.pose.position.x, target.pose.position.y = float(x), float(y)
    return SolveInverse.Request(platform=target, start=SolveInverse.Request.START_HOME, **fields)


def position(solution):
    point = solution.platform_in_base.position
    return np.array([point.x, point.y, point.z])


def assert_success(answer):
    assert answer.error_code.val == ErrorCode.SUCCESS, answer.error_code.message
    assert answer.error_code.message == ""
    assert answer.solution.converged
    assert answer.solution.residual < 1e-10


def test_forward_gives_what_the_library_gives(six_rfs):
    target = np.array(SIX_HOME) + 0.2
    answer = forward(six_rfs, forward_request(SIX_NAMES, target))
    assert_success(answer)
    expected = cpr_core.solve_forward(cpr_core.load_robot("six_rfs"), target)
    np.testing.assert_allclose(position(answer.solution), expected.platform_position, atol=1e-12)
    np.testing.assert_allclose(answer.solution.motors.effort, expected.efforts, atol=1e-9)
    quaternion = answer.solution.platform_in_base.orientation
    np.testing.assert_allclose(
        [quaternion.w, quaternion.x, quaternion.y, quaternion.z],
        expected.platform_quaternion,
        atol=1e-12,
    )
    assert answer.solution.index_locked == expected.index_locked
    assert answer.solution.index_free == expected.index_free
    assert answer.solution.solve_time > 0.0
    assert answer.solution.header.frame_id == "base"


def test_motors_are_taken_by_name_in_any_order(six_rfs):
    target = np.array(SIX_HOME) + np.linspace(0.0, 0.1, 6)
    straight = forward(six_rfs, forward_request(SIX_NAMES, target))
    order = [3, 0, 5, 1, 4, 2]
    mixed = forward(
        six_rfs, forward_request([SIX_NAMES[k] for k in order], [target[k] for k in order])
    )
    assert_success(mixed)
    assert list(mixed.solution.motors.name) == SIX_NAMES
    np.testing.assert_allclose(position(mixed.solution), position(straight.solution), atol=1e-13)


def test_inverse_returns_the_motors_of_a_forward_solution(six_rfs):
    target = np.array(SIX_HOME) + [0.1, -0.05, 0.0, 0.1, 0.05, -0.1]
    reached = forward(six_rfs, forward_request(SIX_NAMES, target))
    request = SolveInverse.Request(
        platform=PoseStamped(pose=reached.solution.platform_in_base),
        controlled=["orientation", "x", "y", "z"],
        start=SolveInverse.Request.START_HOME,
    )
    answer = inverse(six_rfs, request)
    assert_success(answer)
    np.testing.assert_allclose(answer.solution.motors.position, target, atol=1e-8)


def test_forward_by_effort_returns_to_the_motors(rfrfr):
    reached = forward(rfrfr, forward_request(["motor1", "motor2"], [2.65, 0.60]))
    request = SolveForward.Request(
        motors=JointState(name=["motor1", "motor2"], effort=reached.solution.motors.effort),
        start=SolveForward.Request.START_HOME,
    )
    answer = forward(rfrfr, request)
    assert_success(answer)
    np.testing.assert_allclose(answer.solution.motors.position, [2.65, 0.60], atol=1e-8)


def test_wrench_in_base_and_in_platform_frame(six_rfs):
    expected_robot = cpr_core.load_robot("six_rfs")
    for frame, field in (
        ("", "wrench_world"),
        ("base", "wrench_world"),
        ("platform", "wrench_body"),
    ):
        wrench = WrenchStamped(header=Header(frame_id=frame))
        wrench.wrench.force.x, wrench.wrench.torque.z = 0.2, 0.01
        request = forward_request(SIX_NAMES, SIX_HOME, wrench=[wrench])
        answer = forward(six_rfs, request)
        assert_success(answer)
        loads = cpr_core.Loads.none().with_(**{field: [0, 0, 0.01, 0.2, 0, 0]})
        expected = cpr_core.solve_forward(expected_robot, SIX_HOME, loads=loads)
        np.testing.assert_allclose(
            position(answer.solution), expected.platform_position, atol=1e-12
        )


def test_start_given_continues_from_that_equilibrium(rfrfr):
    first = inverse(rfrfr, planar_target(0.1, 0.6))
    request = planar_target(0.15, 0.55)
    request.start = SolveInverse.Request.START_GIVEN
    request.start_equilibrium = [first.solution]
    answer = inverse(rfrfr, request)
    assert_success(answer)
    direct = inverse(rfrfr, planar_target(0.15, 0.55))
    np.testing.assert_allclose(
        answer.solution.motors.position, direct.solution.motors.position, atol=1e-9
    )


def test_a_given_start_brings_its_loads(rfrfr):
    wrench = WrenchStamped()
    wrench.wrench.force.y = -0.05
    first = inverse(rfrfr, planar_target(0.1, 0.6, wrench=[wrench]))
    assert_success(first)
    assert first.solution.loads[0].wrench_in_base == wrench.wrench
    again = planar_target(0.1, 0.6)
    again.start, again.start_equilibrium = again.START_GIVEN, [first.solution]
    second = inverse(rfrfr, again)
    assert second.solution.loads == first.solution.loads
    np.testing.assert_allclose(
        second.solution.motors.position, first.solution.motors.position, atol=1e-9
    )
    unloaded = inverse(rfrfr, planar_target(0.1, 0.6))
    assert list(unloaded.solution.loads) == []
    assert (
        np.abs(np.subtract(unloaded.solution.motors.position, first.solution.motors.position)).max()
        > 1e-4
    )


def test_apply_moves_the_node_and_only_apply_does(rfrfr):
    def published():
        return rfrfr.client.messages(JointState, "/joint_states", 3)[-1].position

    before = published()
    assert_success(forward(rfrfr, forward_request(["motor1", "motor2"], [2.7, 0.5])))
    assert published() == before
    answer = forward(rfrfr, forward_request(["motor1", "motor2"], [2.7, 0.5], apply=True))
    assert_success(answer)
    assert list(published()) == [2.7, 0.5]
    back = forward(rfrfr, forward_request(["motor1", "motor2"], [2.59, 0.55], apply=True))
    assert_success(back)


def bad_forward_requests():
    nan, names = math.nan, ["motor1", "motor2"]
    return {
        "empty": (SolveForward.Request(), ErrorCode.INVALID_ROBOT_STATE, "motors.name"),
        "unknown name": (
            forward_request(["motor1", "elbow"], [1, 1]),
            ErrorCode.INVALID_ROBOT_STATE,
            "elbow",
        ),
        "missing name": (
            forward_request(["motor1"], [1]),
            ErrorCode.INVALID_ROBOT_STATE,
            "missing: motor2",
        ),
        "duplicate name": (
            forward_request(["motor1", "motor2", "motor1"], [1, 1, 1]),
            ErrorCode.INVALID_ROBOT_STATE,
            "twice: motor1",
        ),
        "too few values": (
            forward_request(names, [1]),
            ErrorCode.INVALID_ROBOT_STATE,
            "expected 2 numbers",
        ),
        "no values": (forward_request(names, []), ErrorCode.INVALID_ROBOT_STATE, "got none"),
        "NaN": (forward_request(names, [nan, 1]), ErrorCode.NON_FINITE_INPUT, "finite"),
        "infinity": (forward_request(names, [math.inf, 1]), ErrorCode.NON_FINITE_INPUT, "finite"),
        "bad start": (
            SolveForward.Request(motors=JointState(name=names, position=[1.0, 1.0]), start=7),
            ErrorCode.INVALID_ROBOT_STATE,
            "start",
        ),
        "no start": (
            SolveForward.Request(
                motors=JointState(name=names, position=[2.59, 0.55]),
                start=SolveForward.Request.START_GIVEN,
            ),
            ErrorCode.INVALID_ROBOT_STATE,
            "start_equilibrium: expected one, got 0",
        ),
        "start that is no equilibrium": (
            SolveForward.Request(
                motors=JointState(name=names, position=[2.59, 0.55]),
                start=SolveForward.Request.START_GIVEN,
                start_equilibrium=[
                    Equilibrium(
                        motors=JointState(name=names, position=[2.59, 0.55]),
                        leg_coordinates=[0.0] * 10,
                        multipliers=[0.0] * 4,
                    )
                ],
            ),
            ErrorCode.INVALID_ROBOT_STATE,
            "start",
        ),
    }


@pytest.mark.parametrize("case", bad_forward_requests())
def test_bad_forward_request_is_refused_with_a_reason(rfrfr, case):
    request, code, text = bad_forward_requests()[case]
    answer = forward(rfrfr, request)
    assert answer.error_code.val == code, answer.error_code.message
    assert text in answer.error_code.message
    assert (answer.solution.index_locked, answer.solution.index_free) == (-1, -1)  # 0 is stable
    assert math.isnan(answer.solution.margin)  # 0 is critical
    assert_still_answers(rfrfr)


def bad_inverse_requests():
    wrong_frame = planar_target(0, 0.8)
    wrong_frame.platform.header.frame_id = "camera"
    wrong_wrench, nan_wrench, out_of_plane = (
        planar_target(0, 0.8, wrench=[WrenchStamped()]) for _ in range(3)
    )
    wrong_wrench.wrench[0].header.frame_id = "camera"
    nan_wrench.wrench[0].wrench.force.x = math.nan
    out_of_plane.wrench[0].wrench.force.z = 1.0
    return {
        "unreachable": (planar_target(0, 3), ErrorCode.NO_IK_SOLUTION, "of the way"),
        "NaN": (planar_target(math.nan, 0), ErrorCode.NON_FINITE_INPUT, "finite"),
        "frame": (wrong_frame, ErrorCode.FRAME_TRANSFORM_FAILURE, "camera"),
        "wrench frame": (wrong_wrench, ErrorCode.FRAME_TRANSFORM_FAILURE, "camera"),
        "wrench NaN": (nan_wrench, ErrorCode.NON_FINITE_INPUT, "wrench"),
        "wrench out of the plane": (out_of_plane, ErrorCode.INVALID_ROBOT_STATE, "planar"),
        "controlled": (
            planar_target(0, 0.8, controlled=["x", "z"]),
            ErrorCode.INVALID_ROBOT_STATE,
            "expected x, y",
        ),
        "unstable": (
            planar_target(0, 0.0, apply=True),
            ErrorCode.UNSTABLE_EQUILIBRIUM,
            "unstable",
        ),
    }


@pytest.mark.parametrize("case", bad_inverse_requests())
def test_bad_inverse_request_is_refused_with_a_reason(rfrfr, case):
    request, code, text = bad_inverse_requests()[case]
    answer = inverse(rfrfr, request)
    assert answer.error_code.val == code, answer.error_code.message
    assert text in answer.error_code.message
    assert_still_answers(rfrfr)


@pytest.mark.parametrize("quaternion", [(0, 0, 0, 0), (1, 1, 0, 0), (0.5, 0, 0, 0)])
def test_a_quaternion_that_is_no_rotation_is_refused(six_rfs, quaternion):
    request = SolveInverse.Request()
    orientation = request.platform.pose.orientation
    orientation.w, orientation.x, orientation.y, orientation.z = map(float, quaternion)
    request.platform.pose.position.z = 0.8
    answer = inverse(six_rfs, request)
    assert answer.error_code.val == ErrorCode.INVALID_QUATERNION


def test_a_failed_request_changes_nothing(rfrfr):
    def state():
        return rfrfr.client.messages(JointState, "/joint_states", 3)[-1]

    before = state()
    answer = inverse(rfrfr, planar_target(0, 3, apply=True))
    assert answer.error_code.val == ErrorCode.NO_IK_SOLUTION
    after = state()
    assert (before.position, before.effort) == (after.position, after.effort)


def assert_still_answers(running):
    answer = inverse(running, planar_target(0, 0.8))
    assert_success(answer)
    np.testing.assert_allclose(answer.solution.motors.position, [2.7677872, 0.3738055], atol=1e-4)


def test_a_motor_a_turn_away_is_no_short_way(rfrfr):
    """The rods would have to be wound there; the branch ends before."""
    answer = forward(rfrfr, forward_request(["motor1", "motor2"], [2.59 + 2.0 * math.pi, 0.55]))
    assert answer.error_code.val == ErrorCode.NOT_CONVERGED
    far = forward(rfrfr, forward_request(["motor1", "motor2"], [1e20, 0.55], apply=True))
    assert far.error_code.val == ErrorCode.NOT_CONVERGED
    assert "too far" in far.error_code.message


def test_a_burst_of_requests_is_answered_whole(rfrfr):
    client = rfrfr.client.node.create_client(
        SolveInverse, "/cpr_node/solve_inverse", qos_profile=QoSProfile(depth=1000)
    )
    assert client.wait_for_service(20.0)
    futures = [client.call_async(planar_target(0.0, 0.8)) for _ in range(300)]
    rfrfr.client.spin_until(lambda: all(future.done() for future in futures), timeout=60.0)
    assert all(future.result().error_code.val == ErrorCode.SUCCESS for future in futures)


def test_a_pause_does_not_wait_for_a_burst_of_requests_before_it(six_rfs):
    """They take some milliseconds each, and come first."""
    node, home = six_rfs.client.node, cpr_core.solve_home(cpr_core.load_robot("six_rfs"))
    solving = node.create_client(
        SolveForward, "/cpr_node/solve_forward", qos_profile=QoSProfile(depth=1000)
    )
    pausing = node.create_client(SetBool, "/cpr_node/pause")
    assert solving.wait_for_service(20.0)
    assert pausing.wait_for_service(20.0)
    request = forward_request(SIX_NAMES, home.motors + [0.5, -0.5] * 3)
    futures = [solving.call_async(request) for _ in range(400)]
    paused = pausing.call_async(SetBool.Request(data=True))
    six_rfs.client.spin_until(paused.done)
    answered = sum(future.done() for future in futures)
    six_rfs.client.spin_until(lambda: all(future.done() for future in futures), timeout=60.0)
    assert answered < 100
    outcomes = {
        (future.result().error_code.val, *future.result().solution.motors.position)
        for future in futures
    }
    assert len(outcomes) == 1
    six_rfs.client.call(SetBool, "/cpr_node/pause", SetBool.Request(data=False))


def test_long_names_are_refused_fast_and_briefly(rfrfr):
    names = [f"m{k}" for k in range(10_000)]
    answer = forward(rfrfr, forward_request(names, [0.0] * len(names)))
    assert answer.error_code.val == ErrorCode.INVALID_ROBOT_STATE
    assert len(answer.error_code.message) < 1100


@pytest.mark.parametrize("held", ["motors", "efforts"])
def test_the_model_error_is_told_to_those_who_ask(six_rfs, held):
    home = cpr_core.solve_home(cpr_core.load_robot("six_rfs"))
    request = forward_request(SIX_NAMES, home.motors, with_model_error=True)
    if held == "efforts":
        request.motors.position, request.motors.effort = [], home.efforts.tolist()
    answer = forward(six_rfs, request)
    assert_success(answer)
    told, expected = answer.model_error[0], cpr_core.error_of(home, held)
    assert told.held == held
    assert told.distance == pytest.approx(expected.distance, rel=1e-4)
    changes = [told.position.x, told.position.y, told.position.z]
    np.testing.assert_allclose(changes, expected.position, rtol=0.0, atol=1e-9)
    turn = [told.rotation.x, told.rotation.y, told.rotation.z]
    np.testing.assert_allclose(turn, expected.rotation, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(told.motors, expected.motors, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(told.efforts, expected.efforts, rtol=0.0, atol=1e-8)
    assert expected.distance > 1e-6
    request.with_model_error = False
    assert len(forward(six_rfs, request).model_error) == 0


def test_the_model_error_of_an_inverse_solution_is_one_of_the_motors(rfrfr):
    request = planar_target(0.1, 0.75)
    request.with_model_error = True
    answer = inverse(rfrfr, request)
    assert_success(answer)
    robot = cpr_core.load_robot("rfrfr")
    expected = cpr_core.error_of(cpr_core.solve_inverse(robot, [0.1, 0.75]), "pose")
    told = answer.model_error[0]
    assert (told.held, told.distance) == ("pose", 0.0)
    np.testing.assert_allclose(told.motors, expected.motors, rtol=1e-4, atol=1e-12)
    assert np.abs(expected.motors).max() > 1e-7


def test_eigenvalues_are_told_to_those_who_ask(six_rfs):
    target = np.array(SIX_HOME) + 0.1
    fast = forward(six_rfs, forward_request(SIX_NAMES, target))
    whole = forward(six_rfs, forward_request(SIX_NAMES, target, with_eigenvalues=True))
    assert_success(fast)
    expected = cpr_core.solve_forward(cpr_core.load_robot("six_rfs"), target)
    for name, value in (
        ("margin", expected.spectrum_locked.margin),
        ("smallest_eigenvalue_locked", expected.spectrum_locked.smallest),
        ("smallest_eigenvalue_free", expected.spectrum_free.smallest),
    ):
        assert math.isnan(getattr(fast.solution, name))
        assert getattr(whole.solution, name) == pytest.approx(value, rel=1e-9)
    assert fast.solution.index_locked == whole.solution.index_locked == 0
    assert fast.solution.index_free == whole.solution.index_free
    np.testing.assert_allclose(position(fast.solution), position(whole.solution), atol=1e-13)

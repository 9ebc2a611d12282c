# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Ten thousand malformed messages and requests: no crash, no false success, a correct node."""

import math

import hypothesis.strategies as st
import numpy as np
import pytest
from cpr_msgs.msg import Equilibrium, ErrorCode, Loads, StabilityMetrics
from cpr_msgs.srv import CheckStability, GetKinematoStatics, Predict, SolveForward, SolveInverse
from geometry_msgs.msg import PoseStamped, WrenchStamped
from helpers.driver import Driver
from hypothesis import HealthCheck, Phase, given, settings
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

import cpr_core

HOME = [5.86, 5.56, 5.86, 5.46, 5.86, 5.26]
NAMES = [f"motor{k}" for k in range(1, 7)]
EXAMPLES = 10_000

no_number = st.sampled_from([math.nan, math.inf, -math.inf])
any_number = st.floats(allow_nan=True, allow_infinity=True)
# A name that is none of the motors. ROS ends a string at a zero.
word = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=12).filter(
    lambda text: text not in NAMES
)
place = st.integers(0, 5)


@st.composite
def bad_joint_state(draw, *, partial=False):
    """Motors by name with one thing wrong, or several."""
    names, positions = list(NAMES), list(HOME)
    kind = draw(st.sampled_from(["number", "name", "twice", "count", "nothing", "missing"]))
    if kind == "number":
        positions[draw(place)] = draw(no_number)
    elif kind == "name":
        names[draw(place)] = draw(word)
    elif kind == "twice":
        first = draw(place)
        names[first] = names[(first + 1) % 6]
    elif kind == "count" or (kind == "missing" and partial):
        count = draw(st.integers(0, 12).filter(lambda number: number != 6))
        positions = draw(st.lists(any_number, min_size=count, max_size=count))
    elif kind == "missing":
        dropped = draw(place)
        del names[dropped], positions[dropped]
    else:
        return JointState()
    order = draw(st.permutations(range(len(names))))
    return JointState(name=[names[k] for k in order], position=positions)


@st.composite
def bad_pose(draw):
    message = PoseStamped()
    message.pose.position.z, message.pose.orientation.w = 0.8, 1.0
    kind = draw(st.sampled_from(["position", "orientation", "norm", "frame"]))
    if kind == "position":
        setattr(message.pose.position, draw(st.sampled_from("xyz")), draw(no_number))
    elif kind == "orientation":
        setattr(message.pose.orientation, draw(st.sampled_from("wxyz")), draw(no_number))
    elif kind == "norm":
        message.pose.orientation.w = draw(
            st.floats(-1e300, 1e300).filter(lambda w: abs(abs(w) - 1) > 0.1)
        )
    else:
        message.header.frame_id = draw(word.filter(lambda text: text not in ("", "base")))
    return message


@st.composite
def bad_wrench(draw):
    message = WrenchStamped()
    if draw(st.booleans()):
        part = draw(st.sampled_from([message.wrench.force, message.wrench.torque]))
        setattr(part, draw(st.sampled_from("xyz")), draw(no_number))
    else:
        message.header.frame_id = draw(word.filter(lambda t: t not in ("", "base", "platform")))
    return message


@st.composite
def bad_equilibrium(draw):
    """Numbers that are no equilibrium; small ones, too, are none with these multipliers."""
    count = draw(st.integers(0, 80))
    return Equilibrium(
        motors=JointState(name=NAMES, position=HOME),
        leg_coordinates=draw(st.lists(any_number, min_size=count, max_size=count)),
        multipliers=[0.0] * draw(st.integers(0, 30)),
        loads=draw(st.sampled_from([[], [Loads()]])),
    )


def bad_given():
    """Where an equilibrium is needed: none, or one that is none."""
    return st.one_of(st.just([]), bad_equilibrium().map(lambda message: [message]))


wrong_choice = st.integers(3, 255)


@st.composite
def bad_solve(draw, kind):
    """A solve request with something wrong in what is asked or in where to start."""
    request = kind.Request(start=kind.Request.START_HOME, apply=True)
    if kind is SolveForward:
        request.motors = JointState(name=NAMES, position=HOME)
    else:
        request.platform.pose.position.z, request.platform.pose.orientation.w = 0.8, 1.0
    what = draw(st.sampled_from(["target", "start", "given", "wrench", "controlled", "objective"]))
    if what == "target" or (what in ("controlled", "objective") and kind is SolveForward):
        if kind is SolveForward:
            request.motors = draw(bad_joint_state())
        else:
            request.platform = draw(bad_pose())
    elif what == "start":
        request.start = draw(wrong_choice)
    elif what == "given":
        request.start, request.start_equilibrium = 2, draw(bad_given())
    elif what == "wrench":
        request.wrench = [draw(bad_wrench())]
    elif what == "objective":
        request.objective = draw(word.filter(bool))
    else:
        request.controlled = [draw(word)]
    return request


@st.composite
def bad_question(draw, kind):
    """A question about an equilibrium with something wrong."""
    request = kind.Request(at=kind.Request.AT_HOME)
    what = draw(st.sampled_from(["at", "given", "own"]))
    if what == "at":
        request.at = draw(wrong_choice)
    elif what == "given":
        request.at, request.equilibrium = 2, draw(bad_given())
    elif kind is GetKinematoStatics:
        if draw(st.booleans()):
            request.characteristic_length = draw(st.one_of(no_number, st.floats(-1e3, -1e-9)))
        else:
            count = draw(st.integers(1, 12).filter(lambda number: number != 6))
            request.motor_stiffness = [1.0] * count
    elif kind is Predict:
        if draw(st.booleans()):
            request.problem = draw(st.integers(2, 255))
        else:
            request.motor_increments = draw(
                st.lists(any_number, max_size=12).filter(
                    lambda values: len(values) != 6 or not np.all(np.isfinite(values))
                )
            )
    else:
        request.motors_are = draw(st.integers(2, 255))
    return request


bad_command = st.lists(any_number, max_size=12).filter(
    lambda data: len(data) != 6 or not np.all(np.isfinite(data))
)
# Bytes that are no message of any type.
noise = st.binary(max_size=64)

anything_bad = st.one_of(
    st.tuples(st.just(SolveForward), bad_solve(SolveForward)),
    st.tuples(st.just(SolveInverse), bad_solve(SolveInverse)),
    st.tuples(st.just(GetKinematoStatics), bad_question(GetKinematoStatics)),
    st.tuples(st.just(Predict), bad_question(Predict)),
    st.tuples(st.just(CheckStability), bad_question(CheckStability)),
    st.tuples(st.just("motor_setpoint"), bad_joint_state(partial=True)),
    st.tuples(st.just("commands"), bad_command.map(lambda data: Float64MultiArray(data=data))),
    st.tuples(st.just("platform"), bad_pose()),
    st.tuples(st.just("wrench"), bad_wrench()),
    st.tuples(st.sampled_from(["motor_setpoint", "commands", "platform", "wrench"]), noise),
)
SERVICES = {
    SolveForward: "solve_forward",
    SolveInverse: "solve_inverse",
    GetKinematoStatics: "get_kinemato_statics",
    Predict: "predict",
    CheckStability: "check_stability",
}


@pytest.mark.slow
def test_ten_thousand_malformed_messages_and_requests(six_rfs):
    drive = Driver(six_rfs.client)
    sent = {}

    @settings(
        max_examples=EXAMPLES,
        deadline=None,
        database=None,
        derandomize=True,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(anything_bad)
    def send(pair):
        where, what = pair
        sent[where] = sent.get(where, 0) + 1
        if isinstance(where, str):
            getattr(drive, where).publish(what)
            drive.client.executor.spin_once(timeout_sec=0.0)
            return
        answer = drive.client.call(where, f"/cpr_node/{SERVICES[where]}", what)
        assert answer.error_code.val not in (ErrorCode.SUCCESS, ErrorCode.UNDEFINED), what
        assert answer.error_code.val != ErrorCode.FAILURE, answer.error_code.message
        assert answer.error_code.message

    try:
        send()
        assert sum(sent.values()) >= EXAMPLES
        assert len(sent) == 9
        assert six_rfs.process.process.poll() is None
        # Nothing moved, nothing is in force, and the answers are right.
        states = np.array([state.position for state in drive.all(JointState)])
        np.testing.assert_allclose(states, np.tile(HOME, (len(states), 1)), rtol=0, atol=0)
        drive.until(lambda: len(drive.all(StabilityMetrics)) > 2)
        assert drive.metrics.state == StabilityMetrics.STATE_IDLE
        assert (drive.metrics.setpoint_age, drive.metrics.wrench_age) == (-1.0, -1.0)
        target = np.array(HOME) + 0.1
        robot = cpr_core.load_robot("six_rfs")
        expected = cpr_core.solve_forward(robot, target).platform_position
        drive.assert_correct(*target, expected=expected)
        drive.send_motors(*target)
        drive.until(lambda: np.array_equal(drive.motors, target))
        drive.go_home()
    finally:
        drive.close()

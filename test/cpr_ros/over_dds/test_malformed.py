# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Ten thousand malformed messages and requests: no crash, no false success, a correct node."""

import random

import numpy as np
import pytest
from cpr_msgs.msg import Equilibrium, ErrorCode, Loads, StabilityMetrics
from cpr_msgs.srv import CheckStability, GetKinematoStatics, Predict, SolveForward, SolveInverse
from geometry_msgs.msg import PoseStamped, WrenchStamped
from helpers.driver import Driver
from helpers.wild import NO_NUMBERS, any_number, any_numbers, word
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

import cpr_core

HOME = [5.86, 5.56, 5.86, 5.46, 5.86, 5.26]
NAMES = [f"motor{k}" for k in range(1, 7)]
EXAMPLES = 10_000


def other_than(allowed, chance):
    """A word that is none of those."""
    while (found := word(chance)) in allowed:
        pass
    return found


def other_count(chance):
    """Numbers, but not six."""
    count = chance.choice([number for number in range(13) if number != 6])
    return [any_number(chance) for _ in range(count)]


def not_motors(chance):
    """Numbers that are not six finite ones."""
    while len(found := any_numbers(chance, 12)) == 6 and np.all(np.isfinite(found)):
        pass
    return found


def bad_joint_state(chance, *, partial=False):
    """Motors by name with one thing wrong, or several."""
    names, positions = list(NAMES), list(HOME)
    kind = chance.choice(["number", "name", "twice", "count", "nothing", "missing"])
    place = chance.randrange(6)
    if kind == "number":
        positions[place] = chance.choice(NO_NUMBERS)
    elif kind == "name":
        names[place] = other_than(NAMES, chance)
    elif kind == "twice":
        names[place] = names[(place + 1) % 6]
    elif kind == "count" or (kind == "missing" and partial):
        positions = other_count(chance)
    elif kind == "missing":
        del names[place], positions[place]
    else:
        return JointState()
    order = chance.sample(range(len(names)), len(names))
    return JointState(name=[names[k] for k in order], position=positions)


def bad_pose(chance):
    message = PoseStamped()
    message.pose.position.z, message.pose.orientation.w = 0.8, 1.0
    kind = chance.choice(["position", "orientation", "norm", "frame"])
    if kind == "position":
        setattr(message.pose.position, chance.choice("xyz"), chance.choice(NO_NUMBERS))
    elif kind == "orientation":
        setattr(message.pose.orientation, chance.choice("wxyz"), chance.choice(NO_NUMBERS))
    elif kind == "norm":
        norm = 1.0
        while not (abs(norm - 1) > 0.1 and norm <= 1e300):
            norm = abs(any_number(chance))
        message.pose.orientation.w = chance.choice((-norm, norm))
    else:
        message.header.frame_id = other_than(("", "base"), chance)
    return message


def bad_wrench(chance):
    message = WrenchStamped()
    if chance.random() < 0.5:
        part = chance.choice([message.wrench.force, message.wrench.torque])
        setattr(part, chance.choice("xyz"), chance.choice(NO_NUMBERS))
    else:
        message.header.frame_id = other_than(("", "base", "platform"), chance)
    return message


def bad_equilibrium(chance):
    """Numbers that are no equilibrium; small ones, too, are none with these multipliers."""
    return Equilibrium(
        motors=JointState(name=NAMES, position=HOME),
        leg_coordinates=any_numbers(chance, 80),
        multipliers=[0.0] * chance.randint(0, 30),
        loads=chance.choice([[], [Loads()]]),
    )


def bad_given(chance):
    """Where an equilibrium is needed: none, or one that is none."""
    return chance.choice([[], [bad_equilibrium(chance)]])


def bad_solve(chance, kind):
    """A solve request with something wrong in what is asked or in where to start."""
    request = kind.Request(start=kind.Request.START_HOME, apply=True)
    if kind is SolveForward:
        request.motors = JointState(name=NAMES, position=HOME)
    else:
        request.platform.pose.position.z, request.platform.pose.orientation.w = 0.8, 1.0
    fault = chance.choice(["target", "start", "given", "wrench", "controlled", "objective"])
    if fault == "target" or (fault in ("controlled", "objective") and kind is SolveForward):
        if kind is SolveForward:
            request.motors = bad_joint_state(chance)
        else:
            request.platform = bad_pose(chance)
    elif fault == "start":
        request.start = chance.randint(3, 255)
    elif fault == "given":
        request.start, request.start_equilibrium = 2, bad_given(chance)
    elif fault == "wrench":
        request.wrench = [bad_wrench(chance)]
    elif fault == "objective":
        request.objective = other_than(("",), chance)
    else:
        request.controlled = [other_than(NAMES, chance)]
    return request


def bad_question(chance, kind):
    """A question about an equilibrium with something wrong."""
    request = kind.Request(at=kind.Request.AT_HOME)
    fault = chance.choice(["at", "given", "own"])
    if fault == "at":
        request.at = chance.randint(3, 255)
    elif fault == "given":
        request.at, request.equilibrium = 2, bad_given(chance)
    elif kind is GetKinematoStatics:
        if chance.random() < 0.5:
            negative = -(10.0 ** chance.uniform(-9.0, 3.0))
            request.characteristic_length = chance.choice((*NO_NUMBERS, negative))
        else:
            count = chance.choice([number for number in range(1, 13) if number != 6])
            request.motor_stiffness = [1.0] * count
    elif kind is Predict:
        if chance.random() < 0.5:
            request.problem = chance.randint(2, 255)
        else:
            request.motor_increments = not_motors(chance)
    else:
        request.motors_are = chance.randint(2, 255)
    return request


def anything_bad(chance):
    """Where to, and what."""
    where = chance.choice([*SERVICES, *TOPICS, "noise"])
    if where in (SolveForward, SolveInverse):
        return where, bad_solve(chance, where)
    if where in SERVICES:
        return where, bad_question(chance, where)
    if where in TOPICS:
        return where, TOPICS[where](chance)
    # Bytes that are no message of any type.
    return chance.choice(list(TOPICS)), chance.randbytes(chance.randint(0, 64))


TOPICS = {
    "motor_setpoint": lambda chance: bad_joint_state(chance, partial=True),
    "commands": lambda chance: Float64MultiArray(data=not_motors(chance)),
    "platform": bad_pose,
    "wrench": bad_wrench,
}
SERVICES = {
    SolveForward: "solve_forward",
    SolveInverse: "solve_inverse",
    GetKinematoStatics: "get_kinemato_statics",
    Predict: "predict",
    CheckStability: "check_stability",
}


@pytest.mark.slow
def test_ten_thousand_malformed_messages_and_requests(six_rfs):
    drive, chance = Driver(six_rfs.client), random.Random(1)
    sent = {}

    def send(where, message):
        sent[where] = sent.get(where, 0) + 1
        if isinstance(where, str):
            getattr(drive, where).publish(message)
            drive.client.executor.spin_once(timeout_sec=0.0)
            return
        answer = drive.client.call(where, f"/cpr_node/{SERVICES[where]}", message)
        assert answer.error_code.val not in (ErrorCode.SUCCESS, ErrorCode.UNDEFINED), message
        assert answer.error_code.val != ErrorCode.FAILURE, answer.error_code.message
        assert answer.error_code.message

    try:
        for _ in range(EXAMPLES):
            send(*anything_bad(chance))
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

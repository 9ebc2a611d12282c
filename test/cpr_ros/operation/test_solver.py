# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Which equilibrium a request is about, and how long it may take."""

from itertools import count

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from cpr_msgs.msg import Equilibrium as EquilibriumMessage
from cpr_msgs.msg import ErrorCode
from cpr_msgs.srv import CheckStability, GetKinematoStatics, Predict, SolveForward, SolveInverse
from geometry_msgs.msg import PoseStamped
from helpers.drive import PERIOD, SETTINGS, robot
from sensor_msgs.msg import JointState

from cpr_core import TimeLimitExceeded, solve_forward, solve_home
from cpr_core.model.assessment import Assessment
from cpr_ros.error_codes import RequestError
from cpr_ros.following.setpoint_following import SetpointFollower
from cpr_ros.messages.equilibrium_messages import fill_equilibrium
from cpr_ros.messages.frames import Frames
from cpr_ros.operation.solver import Solver

FRAMES = Frames("base", "platform")


@pytest.fixture
def solver():
    """Its robot is neither at home nor at the equilibrium that a request brings."""
    return made()


def made(*check_applied):
    planar, length = robot("rfrfr"), None
    follower = SetpointFollower(planar, PERIOD, SETTINGS)
    solver = Solver(planar, FRAMES, follower, 20.0, length, *check_applied)
    solver.current = Assessment(solve_forward(planar, [2.7, 0.4]))
    return solver


def as_message(equilibrium):
    message = EquilibriumMessage()
    fill_equilibrium(message, equilibrium, FRAMES, Time(), 0.0, eigenvalues=False)
    return message


@pytest.mark.parametrize("service", [CheckStability, GetKinematoStatics, Predict])
def test_a_question_is_about_the_equilibrium_it_names(solver, service):
    request = service.Request()
    assert solver.equilibrium_of(request) is solver.current.equilibrium
    request.at = request.AT_HOME
    assert solver.equilibrium_of(request) is solve_home(solver.robot)
    given = solve_forward(solver.robot, [2.8, 0.3])
    request.at, request.equilibrium = request.AT_GIVEN, [as_message(given)]
    found = solver.equilibrium_of(request)
    np.testing.assert_array_equal(found.motors, given.motors)
    np.testing.assert_allclose(found.platform_position, given.platform_position, atol=1e-9)


@pytest.mark.parametrize("service", [CheckStability, GetKinematoStatics, Predict])
def test_a_question_about_no_equilibrium_is_refused(solver, service):
    request = service.Request(at=3)
    with pytest.raises(
        RequestError, match="at: expected AT_CURRENT 0, AT_HOME 1 or AT_GIVEN 2, got 3"
    ) as refused:
        solver.equilibrium_of(request)
    assert refused.value.val == ErrorCode.INVALID_ROBOT_STATE
    request.at = request.AT_GIVEN
    with pytest.raises(RequestError, match="equilibrium: expected one, got 0") as refused:
        solver.equilibrium_of(request)
    assert refused.value.val == ErrorCode.INVALID_ROBOT_STATE


def asked_forward(solver):
    motors = JointState(name=list(solver.robot.motor_names), position=[2.9, 0.2])
    return solver.forward(SolveForward.Request(motors=motors, apply=True))


def asked_inverse(solver):
    target = PoseStamped()
    target.pose.position.x, target.pose.position.y = 0.1, 0.7
    return solver.inverse(SolveInverse.Request(platform=target, apply=True))


@pytest.mark.parametrize("ask", [asked_forward, asked_inverse])
def test_what_is_applied_has_one_time_limit_for_all_of_it(ask):
    """The solution could take all of it, and the way of the motors there all of it again."""
    left = []
    solver = made(lambda solution, deadline: left.append(deadline.left))
    solver.clock = count(step=3.0).__next__  # every part of a request takes so long
    ask(solver)
    assert left == [20.0 - 2 * 3.0]


@pytest.mark.parametrize("ask", [asked_forward, asked_inverse])
def test_a_solution_is_given_what_is_left_when_it_begins(solver, ask):
    before = solver.current
    solver.clock = count(step=20.0).__next__
    with pytest.raises(TimeLimitExceeded):
        ask(solver)
    assert solver.current is before

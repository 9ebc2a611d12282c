# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the next start would begin elsewhere, nothing leads on until what is kept is right again."""

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode
from helpers.session_bench import commanded

from cpr_ros.error_codes import RequestError
from cpr_ros.following.goals import MotorGoal
from cpr_ros.following.supervision import Action

WHY = "where the robot is cannot be kept"


def target(session):
    return MotorGoal(session.robot, session.solver.current.equilibrium.motors + [0.1, -0.1])


def test_a_motion_ends_and_no_setpoint_is_taken_until_the_place_is_kept_again(bench):
    session = bench.session
    commanded(session, session.solver.current.equilibrium.motors)
    session.orders.follow(target(session), bench.now)
    for _ in range(3):
        bench.tick()
    sent = len(bench.commands)
    assert sent
    session.outgoing.unkept = WHY
    for _ in range(5):
        bench.tick()
    assert len(bench.commands) == sent and session.follower.goal is None
    assert session.verdict(bench.now).action == Action.HALT
    assert WHY in session.verdict(bench.now).text
    with pytest.raises(RequestError, match=WHY) as refused:
        session.orders.follow(target(session), bench.now)
    assert refused.value.val == ErrorCode.NOT_READY
    session.outgoing.unkept = ""
    goal = target(session)
    session.orders.follow(goal, bench.now)
    for _ in range(200):
        bench.tick()
    np.testing.assert_array_equal(bench.commands[-1], goal.motors)
    assert session.verdict(bench.now).action != Action.HALT

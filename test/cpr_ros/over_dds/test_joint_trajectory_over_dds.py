# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Timed trajectories from programs that speak control_msgs, as MoveIt does."""

import ctypes
import os
import sys

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from cpr_msgs.msg import StabilityMetrics
from helpers.control_messages import OF_THE_SETUP, control_messages
from helpers.goal_client import GoalClient
from helpers.joint_trajectory import DOWN, HOME, NAMES, trajectory
from helpers.node_process import running_node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import MultiDOFJointTrajectory


def resting(times, positions, names=NAMES):
    """A trajectory that rests at every point."""
    return trajectory(times, positions, np.zeros(np.shape(positions)), names)


@pytest.fixture(scope="module")
def control_msgs(request, tmp_path_factory):
    """The package, for this process and those it starts; that of the set-up, or kept for later runs."""
    cache = getattr(request.config, "cache", None)  # not with -p no:cacheprovider
    if OF_THE_SETUP.exists():
        kept = OF_THE_SETUP
    else:
        kept = cache.mkdir("control_msgs") if cache else tmp_path_factory.mktemp("control_msgs")
    found = control_messages(kept)
    with pytest.MonkeyPatch.context() as patch:
        for name, path in found.items():
            patch.setenv(name, str(path), prepend=os.pathsep)
        if found:
            patch.syspath_prepend(found["PYTHONPATH"])
            # This process has read its path of libraries; DDS asks for them by name, and is given these.
            for library in found["LD_LIBRARY_PATH"].glob("lib*.so"):
                ctypes.CDLL(str(library))
        yield
    for name in [name for name in sys.modules if name.partition(".")[0] == "control_msgs"]:
        del sys.modules[name]


@pytest.fixture(scope="module")
def rfrfr(control_msgs, tmp_path_factory):
    """A node that has found control_msgs: it looks when Python starts it."""
    folder = tmp_path_factory.mktemp("joint_trajectories")
    with running_node(folder, "robot:=rfrfr", "max_speed:=4", cold=True) as running:
        yield running


@pytest.fixture
def following(control_msgs, drive):
    from control_msgs.action import FollowJointTrajectory

    client = GoalClient(
        drive.client, FollowJointTrajectory, f"{drive.name}/follow_joint_trajectory"
    )
    try:
        yield client
    finally:
        client.close()


def ended(following, **fields):
    """Status, error code and words of a goal."""
    done = following.result(following.send(**fields))
    return done.status, done.result.error_code, done.result.error_string


def tolerance(name, **parts):
    from control_msgs.msg import JointTolerance

    return JointTolerance(name=name, **parts)


def test_one_is_followed_and_told_point_by_point(drive, following):
    ways = np.array([[0.1, 0.05], [0.2, -0.1], [0.3, -0.2]])
    names = NAMES[::-1]  # feedback comes in the order of the goal
    message = resting([0.5, 1.0, 1.5], (HOME + ways)[:, ::-1], names)
    near = [tolerance("motor1", position=0.5), tolerance("motor2", position=-1.0)]  # -1: any
    status, code, words = ended(
        following, trajectory=message, path_tolerance=near, goal_tolerance=near[:1]
    )
    assert (status, code) == (GoalStatus.STATUS_SUCCEEDED, following.kind.Result.SUCCESSFUL), words
    drive.until(lambda: np.array_equal(drive.motors, HOME + ways[-1]))
    told = following.feedback
    assert {tuple(feedback.joint_names) for feedback in told} == {tuple(names)}
    numbers = [feedback.index for feedback in told]
    assert numbers == sorted(numbers)
    assert set(numbers) <= {0, 1, 2}
    assert {0, 1} <= set(numbers)
    for feedback in told:
        desired, actual, error = (
            np.array(point.positions)
            for point in (feedback.desired, feedback.actual, feedback.error)
        )
        np.testing.assert_allclose(error, desired - actual, atol=1e-12)
        assert feedback.header.stamp.sec > 0
    actual = np.array([feedback.actual.positions[1] for feedback in told])
    assert actual[0] < HOME[0] + 0.1 < HOME[0] + 0.2 < actual[-1]


def test_a_cancelled_one_is_held(drive, following):
    handle = following.send(trajectory=resting([10.0], [HOME + [2.0, 0.0]]))
    drive.until(lambda: drive.motors[0] > HOME[0] + 0.05)
    assert following.cancel(handle) == 1
    assert following.result(handle).status == GoalStatus.STATUS_CANCELED
    drive.until_state(StabilityMetrics.STATE_IDLE)
    drive.forget()
    drive.until(lambda: len(drive.all(JointState)) >= 5)
    (held,) = np.unique([state.position for state in drive.all(JointState)], axis=0)
    assert 0.05 < held[0] - HOME[0] < 1.9


def test_into_the_instability_it_is_refused_beforehand(drive, following):
    status, code, words = ended(following, trajectory=resting([8.0], [DOWN]))
    assert (status, code) == (GoalStatus.STATUS_ABORTED, following.kind.Result.INVALID_GOAL)
    assert "below margin_stop 0.05" in words
    drive.until(lambda: np.array_equal(drive.motors, HOME))


def test_one_whose_time_is_over_is_refused(drive, following):
    message = resting([1.0], [HOME])
    message.header.stamp.sec = 1
    status, code, words = ended(following, trajectory=message)
    assert (status, code) == (
        GoalStatus.STATUS_ABORTED,
        following.kind.Result.OLD_HEADER_TIMESTAMP,
    )
    assert "expected a point still to come" in words


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"trajectory": resting([1.0], [[2.6]], ["motor1"])}, "missing: motor2"),
        ({"path_tolerance": ["elbow"]}, "path_tolerance[0].name: expected each of motor1, motor2"),
        (
            {"multi_dof_trajectory": MultiDOFJointTrajectory(joint_names=["platform"])},
            "multi_dof_trajectory: expected none",
        ),
    ],
    ids=["a motor is missing", "tolerance of no motor", "several degrees of freedom"],
)
def test_what_is_wrong_is_refused_with_the_reason(drive, following, fields, words):
    given = {"trajectory": resting([1.0], [HOME])} | fields
    if "path_tolerance" in given:
        given["path_tolerance"] = [
            tolerance(name, position=0.1) for name in given["path_tolerance"]
        ]
    status, code, told = ended(following, **given)
    assert (status, code) == (GoalStatus.STATUS_ABORTED, following.kind.Result.INVALID_JOINTS)
    assert words in told
    drive.until(lambda: np.array_equal(drive.motors, HOME))


def test_one_that_falls_behind_its_tolerances_is_given_up(drive, following):
    """Below the warning threshold it is slowed down, by more than its first motor allows."""
    given = {"margin_warning": 0.99, "margin_stop": 0.9, "max_speed": 0.8}
    assert drive.set_parameters(**given).successful
    message = resting([1.0], [HOME + [0.5, -0.5]])
    try:
        beyond = ended(
            following, trajectory=message, path_tolerance=[tolerance("motor1", position=0.01)]
        )
        drive.go_home()
        late = ended(
            following,
            trajectory=message,
            goal_tolerance=[tolerance("motor1", position=1e-3)],
            goal_time_tolerance=Duration(nanosec=10**7),
        )
    finally:
        given = {"margin_warning": 0.2, "margin_stop": 0.05, "max_speed": 4.0}
        assert drive.set_parameters(**given).successful
    kind = following.kind.Result
    for (status, code, words), number in (
        (beyond, kind.PATH_TOLERANCE_VIOLATED),
        (late, kind.GOAL_TOLERANCE_VIOLATED),
    ):
        assert (status, code) == (GoalStatus.STATUS_ABORTED, number), words
        assert "motor1" in words

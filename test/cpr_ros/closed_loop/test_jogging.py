# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A twist moves the platform setpoint, as long as twists come."""

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode
from geometry_msgs.msg import TwistStamped
from helpers.closed_loop import FRAMES, PERIOD, ClosedLoop, live
from helpers.drive import robot, uncontrolled_robot
from helpers.yaml_content import shipped_content
from hypothesis import given, settings
from hypothesis import strategies as st

from cpr_core import CprError, InvalidRequest, load_robot, solve_home
from cpr_core.lie import rotation_exp, rotation_log
from cpr_ros.closed_loop.jogging import Jogger, JogGoal, PlatformTwist
from cpr_ros.closed_loop.pose_loop import PoseLoop
from cpr_ros.error_codes import RequestError
from cpr_ros.following.goals import PoseGoal
from cpr_ros.following.supervision import State
from cpr_ros.messages.frames import Frames
from cpr_ros.messages.platform_messages import platform_twist
from cpr_ros.operation.live_changes import apply_live

SLACK = 1.0 + 2e-5


def twisted(linear=(0, 0, 0), angular=(0, 0, 0), in_platform=False):
    return PlatformTwist(np.array([*angular, *linear], float), in_platform)


class Jog(ClosedLoop):
    """Ten twists a second for a time."""

    def jog(self, twist, seconds):
        for tick in range(round(seconds / PERIOD)):
            if tick % 5 == 0:
                self.session.orders.jog(twist, self.now)
            self.tick()


@pytest.fixture
def planar():
    made = Jog("rfrfr", payload=[0.0, 0.0, 0.0, 0.0, 0.5, 0.0])
    made.every = 0.0
    return made


def test_the_platform_moves_with_the_twist_and_stops_when_it_ends(planar):
    first = planar.model.pose
    planar.jog(twisted(linear=(0.05, -0.1, 0.0)), 1.0)
    moved = planar.model.pose - first
    np.testing.assert_allclose(moved, [0.05, -0.1], rtol=0.02)
    assert moved[1] == pytest.approx(-2.0 * moved[0], rel=1e-6)  # straight
    planar.run(0.5)  # 0.25 s more, of the newest twist
    stopped = planar.model.pose
    assert np.linalg.norm(stopped - planar.model.pose) == 0.0
    assert np.linalg.norm(stopped - first) <= 1.25 * np.linalg.norm([0.05, -0.1])
    planar.run(0.5)
    np.testing.assert_array_equal(planar.model.pose, stopped)
    assert planar.states[-1] == State.IDLE
    assert planar.longest_step <= SLACK


def test_a_twist_of_the_platform_turns_with_it():
    """Forwards and to the left at once, seen from the platform: an arc."""
    jog = Jog("planar_body")
    jog.every = 0.0
    first, start = jog.model.platform_rotation, jog.model.platform_position
    jog.jog(twisted(linear=(0.01, 0.0, 0.0), angular=(0.0, 0.0, 0.1), in_platform=True), 1.0)
    angle = rotation_log(jog.model.platform_rotation @ first.T)[2]
    assert angle == pytest.approx(0.1, rel=0.02)
    radius = 0.01 / 0.1
    arc = first @ [radius * np.sin(angle), radius * (1.0 - np.cos(angle)), 0.0]
    np.testing.assert_allclose(jog.model.platform_position - start, arc, rtol=0.0, atol=2e-5)


def test_the_orientation_turns_about_the_axis_of_the_twist():
    jog = Jog("six_rfs")
    jog.every = 0.0
    start = jog.model
    jog.jog(twisted(angular=(0.1, -0.05, 0.1)), 1.0)
    turned = rotation_log(jog.model.platform_rotation @ start.platform_rotation.T)
    np.testing.assert_allclose(turned, [0.1, -0.05, 0.1], rtol=0.02)
    np.testing.assert_allclose(
        jog.model.platform_position, start.platform_position, rtol=0.0, atol=1e-9
    )


def test_jogging_into_a_halt_and_back_out(planar):
    apply_live(planar.session, live(max_speed=4.0), planar.now)
    planar.follow([0.0, 0.2])
    planar.run(1.0)
    planar.jog(twisted(linear=(0.0, -0.2, 0.0)), 1.5)
    assert planar.states[-1] == State.HALTED
    lowest = planar.model.pose
    assert 0.05 <= planar.session.solver.current.margin < 0.06
    goal = planar.session.follower.goal
    assert np.linalg.norm(goal.pose - lowest) <= 0.2 * PERIOD * SLACK  # it has not run away
    planar.jog(twisted(linear=(0.0, 0.2, 0.0)), 0.5)
    assert planar.states[-1] in (State.FOLLOWING, State.IDLE)
    assert planar.model.pose[1] - lowest[1] > 0.07
    planar.jog(twisted(linear=(0.0, -0.2, 0.0)), 1.0)
    assert planar.states[-1] == State.HALTED
    planar.run(0.5)
    assert planar.states[-1] == State.IDLE  # no twist, nothing to halt
    assert planar.longest_step <= SLACK


def test_a_robot_that_does_not_move_is_asked_for_the_same_whenever_ticks_come():
    """What is refused to a halted robot need not be solved again then."""
    home = solve_home(robot("rfrfr"))
    loop = PoseLoop(home.robot, PERIOD, live().loop)
    jogger, rng, asked = Jogger(home.robot, PERIOD, loop, 0.25), np.random.default_rng(0), []
    goal, now = jogger.begin(home, 0.0), 0.0
    for _ in range(20):
        now += PERIOD * rng.uniform(0.8, 1.2)
        jogger.take(twisted(linear=(0.0, -0.2, 0.0)), now)
        jogger.advance(home, False, now)
        asked.append(goal.destination)
    assert len(set(asked[5:])) == 1
    np.testing.assert_allclose(goal.pose - home.pose, [0.0, -0.2 * PERIOD], rtol=1e-6)


@pytest.mark.parametrize("period", [0.005, 0.5, 1.0])
def test_a_twist_goes_no_farther_than_it_is_obeyed_whatever_the_ticks(period):
    """The first tick of a slow node took a whole period at once."""
    home = solve_home(robot("rfrfr"))
    jogger = Jogger(home.robot, period, PoseLoop(home.robot, period, live().loop), 0.25)
    goal = jogger.begin(home, 0.0)
    jogger.take(twisted(linear=(0.02, 0.0, 0.0)), max(0.0, period - 0.1))
    for number in range(1, round(3.0 / period)):
        jogger.advance(home, True, number * period)
    assert 0.0 < goal.pose[0] - home.pose[0] <= 0.02 * (0.25 + 0.005)


def test_a_twist_that_is_too_fast_goes_straight_at_the_speed_of_the_motors(planar):
    first = planar.model.pose
    planar.jog(twisted(linear=(3.0, -4.0, 0.0)), 0.3)
    moved = planar.model.pose - first
    assert np.linalg.norm(moved) > 0.05
    assert moved[1] / moved[0] == pytest.approx(-4.0 / 3.0, rel=1e-6)
    assert 0.8 < planar.longest_step <= SLACK
    planar.run(0.5)
    begun, moved = planar.model.pose, planar.session.follower.goal.pose
    assert np.linalg.norm(moved - begun) < 1e-9


def test_the_newest_motion_wins_and_a_twist_of_zero_is_none(planar):
    goal = PoseGoal(planar.robot, [0.0, 0.75])
    planar.session.orders.follow(goal, planar.now)
    planar.jog(twisted(), 0.05)
    assert planar.session.follower.goal is goal
    planar.jog(twisted(linear=(0.1, 0.0, 0.0)), 0.1)
    assert isinstance(planar.session.follower.goal, JogGoal)
    planar.session.orders.follow(goal, planar.now)
    planar.run(1.0)
    assert planar.session.follower.goal is goal
    np.testing.assert_allclose(planar.model.pose, [0.0, 0.75], rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("timeout", [0.1, 1.0])
def test_another_timeout_of_twists_holds_at_once(planar, timeout):
    apply_live(planar.session, live(twist_timeout=timeout), planar.now)
    first = planar.model.pose
    planar.session.orders.jog(twisted(linear=(0.05, 0.0, 0.0)), planar.now)
    planar.run(1.5)
    way = planar.model.pose - first
    np.testing.assert_allclose(way, [0.05 * timeout, 0.0], atol=0.05 * 1.01 * PERIOD)


def test_a_paused_node_takes_no_twist(planar):
    planar.session.orders.pause(True)
    with pytest.raises(RequestError, match="paused"):
        planar.session.orders.jog(twisted(linear=(0.1, 0.0, 0.0)), planar.now)
    planar.session.orders.pause(False)
    planar.run(0.1)
    assert planar.states[-1] == State.IDLE


def test_the_measured_platform_moves_where_it_is_jogged():
    jog = Jog("rfrfr", loop_gain=5.0, loop_max_rate=1.0)
    jog.follow([0.0, 0.7])
    jog.run(2.0)
    assert jog.error([0.0, 0.7]) < 1e-4
    jog.jog(twisted(linear=(0.05, 0.0, 0.0)), 1.0)
    jog.run(2.0)
    wanted = jog.session.follower.goal.pose
    assert 0.05 <= wanted[0] <= 0.05 * 1.25  # a second, and the time of the last twist
    assert wanted[1] == pytest.approx(0.7, abs=1e-8)
    assert jog.error(wanted) < 1e-4
    assert jog.longest_step <= SLACK


@pytest.mark.filterwarnings("ignore:.*controlled. at home the platform has a pitch")
def test_a_turn_that_the_angles_do_not_tell_is_refused():
    """With the platform's x along its normal roll is about the axis of yaw: the turn was lost."""
    content = shipped_content("three_rfs")
    for leg in content["legs"]:
        x, y, z = leg["tip"]["position"]
        leg["tip"]["position"] = [z, y, -x]
    home, turned = solve_home(robot("three_rfs")), solve_home(load_robot(content))
    for equilibrium, refused in ((home, ""), (turned, "do not tell this turn")):
        jogger = Jogger(
            equilibrium.robot, PERIOD, PoseLoop(equilibrium.robot, PERIOD, live().loop), 0.25
        )
        for size in (1e-9, 1.0, 1e300):
            for axis in ((size, 0.0, 0.0), (0.6 * size, 0.8 * size, 0.0)):
                if refused:
                    with pytest.raises(InvalidRequest, match=f"at a pitch of .*{refused}"):
                        jogger.check_told(twisted(angular=axis), equilibrium)
                else:
                    jogger.check_told(twisted(angular=axis), equilibrium)
            jogger.check_told(twisted(linear=(0.0, 0.0, size)), equilibrium)


floats = st.floats(allow_nan=False, allow_infinity=False)


@settings(deadline=None, max_examples=40)
@given(values=st.lists(floats, min_size=6, max_size=6), in_platform=st.booleans())
def test_whatever_the_twist_the_setpoint_stays_near(values, in_platform):
    for name in ("planar_body", "three_rfs", "six_rfs"):
        home = solve_home(robot(name))
        loop = PoseLoop(home.robot, PERIOD, live().loop)
        jogger = Jogger(home.robot, PERIOD, loop, 0.25)
        goal = jogger.begin(home, 0.0)
        jogger.take(PlatformTwist(np.array(values), in_platform), 0.0)
        for tick in range(1, 4):
            jogger.advance(home, False, tick * PERIOD)
            space = loop.coordinates
            assert np.isfinite(goal.pose).all()
            assert space.size(space.way(home.pose, goal.pose)) <= 0.05 * (1.0 + 1e-9)


def message(frame="", **components):
    made = TwistStamped()
    made.header.frame_id = frame
    for name, value in components.items():
        part, axis = name.split("_")
        setattr(getattr(made.twist, part), axis, value)
    return made


@pytest.mark.parametrize(
    ("name", "components", "wrong"),
    [
        ("rfrfr", {"linear_x": 0.1, "angular_z": 0.1}, "angular.z"),
        ("planar_body", {"linear_z": 0.1}, "linear.z"),
        ("three_rfs", {"linear_x": 0.1, "linear_y": 0.1}, "linear.x, linear.y"),
        ("three_rfs", {"angular_z": 0.1}, "angular.z"),
    ],
)
def test_what_the_robot_does_not_control_is_refused_by_name(name, components, wrong):
    with pytest.raises(CprError, match=f"got {wrong} as well"):
        platform_twist(robot(name), message(**components), FRAMES)


def test_twists_are_taken_in_the_base_and_the_platform_frame():
    six = robot("six_rfs")
    taken = platform_twist(six, message("platform", linear_x=0.1, angular_z=0.2), FRAMES)
    np.testing.assert_array_equal(taken.twist, [0.0, 0.0, 0.2, 0.1, 0.0, 0.0])
    turn = rotation_exp([0.0, 0.0, 0.5 * np.pi])
    np.testing.assert_allclose(taken.in_base(turn), [0, 0, 0.2, 0, 0.1, 0], atol=1e-15)
    fixed = platform_twist(six, message("base", linear_x=0.1), FRAMES)
    np.testing.assert_array_equal(fixed.in_base(turn), [0, 0, 0, 0.1, 0, 0])
    with pytest.raises(RequestError, match="expected 'base' or 'platform', got 'map'") as refused:
        platform_twist(six, message("map", linear_x=0.1), FRAMES)
    assert refused.value.val == ErrorCode.FRAME_TRANSFORM_FAILURE
    with pytest.raises(CprError, match="twist"):
        platform_twist(six, message(linear_x=np.nan), FRAMES)


def test_twists_in_a_third_frame_are_turned_if_somebody_knows_the_frame():
    """What moves nothing is refused in the base frame: a camera that looks on says x for sideways."""
    camera = np.array([[0.6, 0.0, 0.8], [0.8, 0.0, -0.6], [0.0, 1.0, 0.0]])  # its axes, in columns
    known = Frames("base", "platform", lambda name: camera if name == "camera" else None)
    ahead = message("camera", linear_x=0.1, linear_z=0.2, angular_y=0.3)
    for name in ("six_rfs", "three_rfr_hubs"):
        taken = platform_twist(robot(name), ahead, known)
        assert not taken.in_platform
        np.testing.assert_allclose(taken.twist, [0, 0, 0.3, 0.22, -0.04, 0], atol=1e-15)
    with pytest.raises(CprError, match=r"got angular\.z as well"):
        platform_twist(robot("rfrfr"), ahead, known)  # its platform does not turn
    away = message("camera", linear_y=0.1)
    with pytest.raises(CprError, match=r"got linear\.z as well"):
        platform_twist(robot("three_rfr_hubs"), away, known)
    assert platform_twist(robot("six_rfs"), away, known).twist[5] == pytest.approx(0.1)
    with pytest.raises(RequestError, match="expected 'base' or 'platform', got 'map'"):
        platform_twist(robot("six_rfs"), message("map", linear_x=0.1), known)


def test_a_robot_that_controls_nothing_is_not_jogged():
    with pytest.raises(CprError, match="controls no platform coordinates"):
        platform_twist(uncontrolled_robot(), message(linear_x=0.1), FRAMES)

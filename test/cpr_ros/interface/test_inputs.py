# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is made of messages as they come, each given to its callback."""

from types import SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from helpers.closed_loop import DEFAULTS, FIXED, FRAMES
from helpers.drive import robot, uncontrolled_robot
from helpers.session_bench import ticked
from helpers.tracked_robots import tracked
from rclpy.clock import Clock
from rclpy.duration import Duration
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from cpr_core import solve_home
from cpr_core.lie import quaternion_from_rotation, rotation_exp
from cpr_ros.closed_loop.loop_status import Loop
from cpr_ros.following.goals import MotorGoal
from cpr_ros.following.supervision import State
from cpr_ros.interface.first_measured import first_measured
from cpr_ros.interface.inputs import Inputs
from cpr_ros.operation.session import Session
from cpr_ros.operation.starting_place import begin_at
from cpr_ros.setpoint_topics import SETPOINTS
from cpr_ros.settings.node_settings import Parameters, live_parameters

NAN = float("nan")


class Listening:
    """A session, and what listens for it, with given times."""

    def __init__(self, robot, source="setpoint", published=("/joint_states",), **changed):
        self.felt_names, self.warnings, self.measured_by = [], [], 1
        fixed = Parameters(**FIXED | {"characteristic_length": None, "motor_source": source})
        live = live_parameters(lambda name: changed.get(name, DEFAULTS[name]))
        self.session, self.now, self._callbacks = Session(robot, FRAMES, fixed, live), 100.0, {}
        self.node = SimpleNamespace(
            create_subscription=self._subscribe,
            get_clock=Clock,
            get_logger=lambda: SimpleNamespace(warning=self.warnings.append),
            resolve_topic_name=lambda topic: f"/{topic}",
            count_publishers=lambda topic: self.measured_by,
            publishers=[SimpleNamespace(topic_name=topic) for topic in published],
        )
        self.inputs = Inputs(self.node, FRAMES, self, lambda: self.now)

    def active_session(self):
        return self.session

    def place(self, motors):
        pass

    def _subscribe(self, kind, topic, callback, qos, raw):
        self._callbacks[topic] = callback

    def feel(self, session, message, now):
        self.felt_names.append(list(message.name))

    def hear(self, topic, message):
        self._callbacks[topic](message)

    def hear_motors(self, **positions):
        """A setpoint of some motors."""
        message = JointState(name=list(positions), position=list(positions.values()))
        self.hear("~/motor_setpoint", message)

    def hear_measured(self, names, positions):
        message = JointState(name=names, position=positions)
        self.hear("measured_joint_states", message)

    def tick(self, seconds=0.0):
        self.now += seconds or self.session.period
        return ticked(self.session, self.now)[0].state

    @property
    def motors(self):
        return self.session.solver.current.equilibrium.motors

    def hear_pose(self, position, orientation, frame="", ahead=None):
        """A measured pose, x y z and w x y z; ahead: how far its stamp is [s], None: it has none."""
        message = PoseStamped()
        message.header.frame_id = frame
        if ahead is not None:
            stamp = Clock().now() + Duration(nanoseconds=round(1e9 * ahead))
            message.header.stamp = stamp.to_msg()
        point, turn = message.pose.position, message.pose.orientation
        point.x, point.y, point.z = map(float, position)
        turn.w, turn.x, turn.y, turn.z = map(float, orientation)
        self.hear("~/measured_platform_pose", message)

    @property
    def dropped(self):
        """How many messages were dropped."""
        return self.inputs.dropped.counts.total()

    @property
    def believed(self):
        """The measured pose that corrects setpoints."""
        return self.session.loop._measured.newest

    @property
    def disbelieved(self):
        """Why the newest measured pose does not."""
        return self.session.loop._measured.problem

    @property
    def felt(self):
        """The measured pose that wrenches are estimated with."""
        return self.session.felt._pose


def test_every_topic_is_one_of_setpoints_or_known_to_be_none():
    """The page of the node tells who else sends setpoints: a new topic was missing there."""
    heard = set(Listening(robot("rfrfr"))._callbacks)
    setpoints = {f"~/{name}" for name in SETPOINTS}
    assert setpoints <= heard
    assert heard - setpoints == {
        "~/external_wrench",
        "~/measured_platform_pose",
        "measured_joint_states",
    }


@pytest.mark.parametrize(("publishers", "frozen"), [(1, False), (2, True)])
def test_poses_of_several_cameras_are_looked_at_as_such(publishers, frozen):
    listening = Listening(robot("rfrfr"))
    listening.measured_by, home = publishers, solve_home(robot("rfrfr")).pose
    for number in range(20):
        listening.now += 0.02
        x, y = home + 0.06 * (number % 2)
        listening.hear_pose([x, y, 0.0], [1.0, 0.0, 0.0, 0.0])
    assert ("two places" in listening.disbelieved) == frozen


def test_motors_that_are_not_named_keep_their_setpoint():
    listening = Listening(robot("rfrfr"))
    listening.hear_motors(motor1=2.7)
    listening.hear_motors(motor2=0.5)
    np.testing.assert_array_equal(listening.session.follower.goal.motors, [2.7, 0.5])
    while listening.tick() != State.IDLE:
        pass
    listening.hear_motors(motor1=2.6)
    np.testing.assert_array_equal(listening.session.follower.goal.motors, [2.6, 0.5])


def test_motors_that_are_not_named_stay_where_they_are_if_their_setpoint_is_stale():
    """Minutes after a client had died its setpoint came to life, by a hundredth of one motor."""
    listening = Listening(robot("rfrfr"), setpoint_timeout=0.5)
    home = listening.motors.copy()
    listening.hear_motors(motor1=2.9, motor2=0.2)
    for _ in range(5):
        assert listening.tick() == State.FOLLOWING
    assert listening.tick(seconds=200.0) == State.STALE
    held = listening.motors.copy()
    assert 0.2 < held[1] < home[1]
    listening.hear_motors(motor1=held[0] + 0.01)
    while listening.tick() != State.IDLE:
        assert listening.motors[1] == held[1]
    np.testing.assert_array_equal(listening.motors, held + [0.01, 0.0])


@pytest.mark.parametrize("timeout", [0.0, 0.3])
def test_a_motor_whose_controller_is_gone_stops_though_others_are_asked_for(timeout):
    """Every setpoint kept all motors going; without a timeout nobody has asked for more."""
    listening = Listening(robot("rfrfr"), setpoint_timeout=timeout, max_speed=0.5)
    home, limit, ticks = listening.motors.copy(), listening.session.period * 0.5, 0
    listening.hear_motors(motor1=home[0] + 1.0)  # once
    while listening.now < 103.0:
        if ticks % 10 == 0:
            listening.hear_motors(motor2=home[1])
        listening.tick()
        ticks += 1
    way = listening.motors[0] - home[0]
    if timeout:
        assert 0.3 * 0.5 - limit <= way <= (0.3 + 11 * listening.session.period) * 0.5
        (warning,) = listening.warnings
        assert "motor1 stays where it is: its own setpoint is older" in warning
        assert "setpoint_timeout 0.3 s" in warning
    else:
        assert way == 1.0 and not listening.warnings
    assert listening.motors[1] == pytest.approx(home[1], abs=1e-12)


def test_setpoints_of_all_motors_count_for_each_of_them():
    listening = Listening(robot("rfrfr"), setpoint_timeout=0.3, max_speed=0.5)
    home = listening.motors.copy()
    for count in range(150):
        if count % 10 == 0:
            asked = Float64MultiArray(data=[home[0] + 0.2, home[1]])
            listening.hear("~/commands", serialize_message(asked))
            listening.hear_motors(motor2=home[1] - 0.2)
        listening.tick()
    np.testing.assert_allclose(listening.motors, home + [0.2, -0.2], rtol=0, atol=1e-12)
    assert not listening.warnings


@pytest.mark.parametrize("ages", [True, False])
def test_no_setpoint_goes_on_with_a_goal_that_it_ends(ages):
    """Who is told that the goal is replaced takes the motors for held, and cannot cancel them."""
    listening = Listening(robot("rfrfr"))
    home, session = listening.motors.copy(), listening.session
    goal = MotorGoal(session.robot, home + [0.3, 0.0])
    session.orders.follow(goal, listening.now, ages=ages)
    for _ in range(5):
        listening.tick()
    held = listening.motors.copy()
    assert home[0] < held[0] < home[0] + 0.3
    listening.hear_motors(motor2=home[1] + 0.01)
    while listening.tick() != State.IDLE:
        pass
    np.testing.assert_array_equal(listening.motors, [held[0], home[1] + 0.01])


def test_motors_that_are_not_named_do_not_go_on_home():
    """A return that is halted can be replaced by a setpoint: by that one only."""
    listening = Listening(robot("rfrfr"), margin_warning=0.999, margin_stop=0.98)
    session = listening.session
    listening.hear_motors(motor1=2.39, motor2=0.75)
    while listening.tick() != State.IDLE:
        pass
    session.orders.reset()
    while listening.tick() != State.HALTED:
        pass
    held = listening.motors.copy()
    listening.hear_motors(motor1=2.39)
    assert listening.dropped == 0
    np.testing.assert_array_equal(session.follower.goal.motors, [2.39, held[1]])


@pytest.mark.parametrize(
    ("z", "orientation"), [(NAN, (1, 0, 0, 0)), (0, (0, 0, 0, 0)), (0, (NAN, 0, 0, 0))]
)
def test_a_measured_pose_is_not_refused_for_what_the_robot_does_not_control(z, orientation):
    """A tracker of points knows no orientation; the loop was frozen for good."""
    listening = Listening(robot("rfrfr"))
    listening.hear_pose([0.01, 0.84, z], orientation)
    assert listening.dropped == 0
    np.testing.assert_array_equal(listening.believed, [0.01, 0.84])
    assert listening.felt is None  # it needs all of it
    assert listening.session.loop.status(None, listening.now).loop == Loop.OPEN


def test_a_measured_pose_that_is_whole_is_felt_too():
    listening = Listening(robot("rfrfr"))
    listening.hear_pose([0.01, 0.84, 0.0], [1, 0, 0, 0])
    np.testing.assert_array_equal(listening.felt[1], [0.01, 0.84, 0, 1, 0, 0, 0])


def test_a_pose_that_is_stamped_ahead_is_not_felt_as_of_now():
    """It corrects nothing, as nobody knows how old it is; wrenches were estimated with it."""
    listening = Listening(robot("rfrfr"))
    listening.hear_pose([0.01, 0.84, 0.0], [1, 0, 0, 0], ahead=3.0)
    assert listening.believed is None
    assert listening.felt[0] == pytest.approx(listening.now + 3.0, abs=0.5)
    listening.hear_pose([0.01, 0.84, 0.0], [1, 0, 0, 0])
    assert listening.felt[0] == listening.now


def test_of_a_measured_pose_that_is_refused_nothing_is_used():
    """A planar robot was tilted by more than it may be: dropped, yet it was felt with."""
    listening = Listening(robot("planar_body"))
    listening.hear_pose([0.0, 0.0, 0.0], [np.cos(0.2), np.sin(0.2), 0, 0])
    assert listening.dropped == 1
    assert listening.believed is None and listening.felt is None


def test_a_robot_that_controls_nothing_feels_with_a_measured_pose():
    """It was said to be dropped, and used."""
    listening = Listening(uncontrolled_robot())
    listening.hear_pose([0.0, 0.84, 0.0], [1, 0, 0, 0])
    assert listening.dropped == 0
    assert listening.felt is not None and listening.believed is None
    listening.hear_pose([0.0, 0.84, 0.0], [0, 0, 0, 0])
    assert listening.dropped == 1


@pytest.mark.parametrize("name", ["rfrfr", "planar_body", "six_rfs"])
def test_what_a_tracker_tells_is_the_platform_s_pose_in_the_base_frame(name):
    """Taken as the pose in the base frame is: to correct setpoints, and to feel."""
    described = tracked(name, [0.4, -0.6, 1.8, 3.0, 0.3, -0.4], [0.02, -0.03, 0.04, 0.3, 1.1, -0.2])
    home = solve_home(described)
    told, turned = described.description.tracker.marker_in_tracker(
        home.platform_position, home.platform_rotation
    )
    plain, listening = Listening(described), Listening(described)
    plain.hear_pose(home.platform_position, home.platform_quaternion, "base")
    listening.hear_pose(told, quaternion_from_rotation(turned), "tracker")
    assert plain.dropped == listening.dropped == 0
    np.testing.assert_allclose(listening.believed, plain.believed, atol=1e-14)
    np.testing.assert_allclose(listening.felt[1], plain.felt[1], atol=1e-14)


def test_a_tracker_of_points_needs_no_orientation():
    listening = Listening(tracked("rfrfr", [0.1, 0.2, 1.5, np.pi, 0.0, 0.0]))
    listening.hear_pose([0.0, -0.6, 1.5], [0, 0, 0, 0], "tracker")
    assert listening.dropped == 0
    np.testing.assert_allclose(listening.believed, [0.1, 0.8], atol=1e-14)
    listening = Listening(tracked("rfrfr", [0.1, 0.2, 1.5, np.pi, 0.0, 0.0], [0.01, 0, 0, 0, 0, 0]))
    listening.hear_pose([0.0, -0.6, 1.5], [0, 0, 0, 0], "tracker")
    assert listening.dropped == 0
    np.testing.assert_allclose(listening.believed, [0.09, 0.8], atol=1e-14)


@pytest.mark.parametrize("orientation", [(1, 0, 0, 0), (0.7, 0.1, 0.1, 0.7), (0, 0, 0, 0)])
def test_a_platform_that_is_a_point_does_not_turn_whatever_its_marker_does(orientation):
    """As calibration has it: the arm of its marker was turned with it, centimetres off."""
    quaternion = np.array(orientation, float) / max(np.linalg.norm(orientation), 1e-9)
    listening = Listening(tracked("rfrfr", [0.1, 0.2, 1.5, np.pi, 0, 0], [0.03, 0, 0.01, 0, 0, 0]))
    listening.hear_pose([0.0, -0.6, 1.5], quaternion, "tracker")
    assert listening.dropped == 0
    np.testing.assert_allclose(listening.believed, [0.07, 0.8], atol=1e-14)


@pytest.mark.parametrize("orientation", [(0, 0, 0, 0), (NAN, NAN, NAN, NAN)])
def test_an_orientation_that_was_not_measured_is_the_model_s_for_the_marker_s_arm(orientation):
    """A delta controls none, and its marker is off the middle: every pose was dropped."""
    described = tracked("delta", [0.4, -0.6, 1.8, 3.0, 0.3, -0.4], [0.05, -0.03, 0.04, 0, 0, 0])
    home = solve_home(described)
    told, _ = described.description.tracker.marker_in_tracker(
        home.platform_position, home.platform_rotation
    )
    listening = Listening(described)
    listening.hear_pose(told, orientation, "tracker")
    assert listening.dropped == 0
    np.testing.assert_allclose(listening.believed, home.platform_position, atol=1e-14)
    listening = Listening(tracked("six_rfs", [0.1, 0.2, 1.5, np.pi, 0, 0], [0.03, 0, 0, 0, 0, 0]))
    listening.hear_pose([0.0, -0.6, 1.5], orientation, "tracker")  # it controls its orientation
    assert listening.dropped == 1 and listening.believed is None
    assert "orientation" in listening.disbelieved


@pytest.mark.parametrize("orientation", [(0, 0, 0, 0), (NAN, NAN, NAN, NAN)])
@pytest.mark.parametrize(
    ("name", "turns"),
    [("three_prs", "roll and pitch"), ("six_rfs", "orientation"), ("planar_body", "angle")],
)
@pytest.mark.parametrize("frame", ["tracker", ""])
def test_a_tracker_of_points_is_told_which_coordinates_need_an_orientation(
    frame, name, turns, orientation
):
    """It was told of unit length only, not that points cannot correct such a robot."""
    listening = Listening(tracked(name, [0.1, 0.2, 1.5, np.pi, 0, 0]))
    listening.hear_pose([0.0, -0.6, 1.5], orientation, frame)
    assert listening.dropped == 1
    told = f"the robot controls {turns}: points alone cannot close its loop"
    problem = listening.disbelieved
    assert problem.startswith("pose.orientation: expected a rotation, as ")
    assert told in problem


@pytest.mark.parametrize("heading", [-2.0, 0.4, 0.8, 3.0])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_small_tilt_does_not_change_the_angle_of_a_planar_platform(heading, sign):
    """Milliradians of it came into the angle, where the tilt was not along an axis of the base."""
    listening = Listening(robot("planar_body"))
    tilted = rotation_exp([0.15, -0.1, 0.0]) @ rotation_exp([0.0, 0.0, heading])
    listening.hear_pose([0.0, 0.1, 0.0], sign * quaternion_from_rotation(tilted))
    assert listening.dropped == 0
    assert listening.believed[2] == pytest.approx(heading, abs=1e-12)


@pytest.mark.parametrize("position", [(NAN, 0, 1), (0, 0, float("inf"))])
def test_numbers_of_a_tracker_that_are_none_are_dropped(position):
    """Also those that would lead along what the robot does not control: axes are others."""
    listening = Listening(tracked("rfrfr", [0.1, 0.2, 1.5, np.pi, 0.0, 0.0]))
    listening.hear_pose(position, [1, 0, 0, 0], "tracker")
    assert listening.dropped == 1 and listening.believed is None
    assert "finite" in listening.disbelieved


def test_a_robot_without_a_tracker_takes_none():
    listening = Listening(robot("rfrfr"))
    listening.hear_pose([0.0, 0.8, 0.0], [1, 0, 0, 0], "tracker")
    assert listening.dropped == 1
    assert "expected 'base', got 'tracker'" in listening.disbelieved
    listening = Listening(tracked("rfrfr"))
    listening.hear_pose([0.0, 0.8, 0.0], [1, 0, 0, 0], "map")
    assert "expected 'base' or 'tracker', got 'map'" in listening.disbelieved


def test_joints_of_others_on_the_topic_are_nothing_to_be_felt_with():
    """Every message of a gripper was a reason of its own, told in the log, and so was the end of it."""
    listening = Listening(robot("rfrfr"))
    for names in (["gripper"], ["motor1", "motor2"], ["gripper", "motor1"]):
        listening.hear_measured(names, [0.1] * len(names))
    assert listening.felt_names == [["motor1", "motor2"], ["gripper", "motor1"]]


MOTORS = ["motor1", "motor2"]


@pytest.mark.parametrize("source", ["setpoint", "measured"])
@pytest.mark.parametrize("unplaced", [False, True])
@pytest.mark.parametrize(
    ("names", "positions"),
    [
        (MOTORS, [NAN, 0.5]),
        (MOTORS, [2.6, float("inf")]),
        (MOTORS, [2.6]),
        (MOTORS, []),
        (MOTORS + MOTORS, [2.6, 0.5, 2.6, 0.5]),
        (["gripper", "motor1"], [0.0, 2.6]),
        ([], [2.6, 0.5]),
    ],
)
def test_measured_motors_that_are_of_no_use_are_counted(source, unplaced, names, positions):
    """Encoders were dead, and neither the log nor /diagnostics had a word of it."""
    listening = Listening(robot("rfrfr"), source)
    listening.session.unplaced = unplaced
    listening.hear_measured(names, positions)
    assert listening.inputs.dropped.counts == {"measured_joint_states": 1}
    assert listening.session.measured.newest(listening.now) is None
    assert listening.session.measured.missing(listening.now)


def test_a_node_does_not_measure_by_what_it_publishes_itself():
    """With joint_states for measured_joint_states it was where it was measured, and nobody measured."""
    listening = Listening(robot("rfrfr"), published=["/joint_states", "/measured_joint_states"])
    assert len(listening.warnings) == 1
    assert "measured_joint_states, where the node itself publishes" in listening.warnings[0]
    with pytest.raises(KeyError):
        listening.hear_measured(MOTORS, [2.6, 0.5])
    motors, instead = first_measured(listening.node, listening.session.robot, 5.0, lambda: False)
    assert motors is None
    assert (
        instead
        == "measured_joint_states is /measured_joint_states, where the node itself publishes"
    )


@pytest.mark.parametrize("topic", ["~/measured_platform_pose", "~/external_wrench", "~/commands"])
def test_a_node_hears_nothing_that_it_publishes_itself(topic):
    """With its own pose for a measured one every goal was measured at its target."""
    listening = Listening(robot("rfrfr"), published=["/joint_states", f"/{topic}"])
    assert listening.warnings == [
        f"{topic} is /{topic}, where the node itself publishes: nothing is taken from there"
    ]
    assert topic not in listening._callbacks


@pytest.mark.parametrize("source", ["setpoint", "measured"])
@pytest.mark.parametrize("unplaced", [False, True])
def test_joints_of_others_alone_are_no_mistake(source, unplaced):
    listening = Listening(robot("rfrfr"), source)
    listening.session.unplaced = unplaced
    listening.hear_measured(["gripper", "finger"], [NAN])
    listening.hear_measured(["gripper", "motor2", "motor1"], [NAN, 0.5, 2.6])
    assert listening.dropped == 0
    assert listening.session.measured.missing(listening.now) == ""


@pytest.mark.parametrize("source", ["setpoint", "measured"])
@pytest.mark.parametrize("publishers", [1, 2])
def test_one_publisher_is_one_robot_whatever_it_says(source, publishers):
    """A glitch, or a motor that is shaken; of two publishers it is two robots."""
    listening = Listening(robot("rfrfr"), source)
    listening.measured_by, session = publishers, listening.session
    home = listening.motors.copy()
    if source == "setpoint":
        begin_at(session, session.solver.current.equilibrium, home, 0.0)
    for number in range(60):
        measured = home + [0.4 * (number % 2), 0.0]
        listening.hear_measured(["motor1", "motor2"], measured.tolist())
        listening.tick(seconds=0.02)
    told = session.verdict(listening.now)
    assert ("in two places" in told.text) == (publishers == 2)

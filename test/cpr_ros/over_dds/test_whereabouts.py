# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the robot is when the node starts, and that no command is far from the one before."""

import itertools
import random
import signal
import time
from types import SimpleNamespace

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from cpr_msgs.action import MoveTo
from cpr_msgs.msg import Equilibrium, ErrorCode, StabilityMetrics
from cpr_msgs.srv import SolveForward
from helpers.branches import stable_elsewhere
from helpers.drive import changed_robot
from helpers.driver import EVERY_MESSAGE, Driver
from helpers.goal_client import GoalClient
from helpers.node_process import Client, NodeProcess, change, free_domain
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from cpr_core import load_robot, solve_forward, solve_home, solve_inverse
from cpr_ros.messages.conversions import Frames, fill_equilibrium
from cpr_ros.operation.kept_state import KeptState

pytestmark = pytest.mark.waits(seconds=80)

HOME = np.array([2.59, 0.55])
SPEED, RATE = 0.8, 200.0
STEP = SPEED / RATE
#: At which a node is ended or taken through its life; five ways, one after the other.
MOMENTS = 5


class Bench:
    """A robot's side: hears commands, sends setpoints, says what it measures."""

    def __init__(self, folder):
        self.folder, self.domain, self.starts = folder, free_domain(), 0
        self.client = Client(self.domain)
        self.commands, self.ended = [], []
        node = self.client.node
        node.create_subscription(
            Float64MultiArray,
            "/cpr_node/motor_commands",
            lambda message: self.commands.append(np.array(message.data)),
            EVERY_MESSAGE,
        )
        self.setpoints = node.create_publisher(Float64MultiArray, "/cpr_node/commands", 1)
        self.measured = None
        self.process = None

    def start(self, *parameters, until="ready"):
        arguments = ["-p", "robot:=rfrfr", "-p", f"max_speed:={SPEED}", "-p", f"tick_rate:={RATE}"]
        arguments += ["-p", f"state_directory:={self.folder / 'states'}"]
        for parameter in parameters:
            arguments += ["-p", parameter]
        self.starts += 1
        self.process = NodeProcess(self.folder / f"node{self.starts}.log", self.domain, arguments)
        if until:
            self.process.wait_for_log(until)

    @property
    def file(self):
        """In which the node keeps where it is."""
        return self.folder / "states" / f"cpr_node.{self.domain}.state"

    def kept(self, robot):
        """The file of the node, which nobody else may open meanwhile."""
        return KeptState(self.file, robot)

    def keep(self, robot, found=None):
        """Leave a last state, somewhere beside home if not said where."""
        kept = self.kept(robot)
        found = found or solve_forward(robot, [2.7, 0.4])
        kept.keep(found, found.motors)
        kept.close()

    def measure(self, motors, names=("motor1", "motor2")):
        """Say ten times a second where the motors are, and nothing else any more."""
        node = self.client.node
        self.measure_no_more()
        publisher = node.create_publisher(
            JointState, "/measured_joint_states", qos_profile_sensor_data
        )
        message = JointState(name=names, position=[float(q) for q in motors])
        timer = node.create_timer(0.1, lambda: publisher.publish(message))
        self.measured = timer, publisher

    def measure_no_more(self):
        if self.measured is not None:
            timer, publisher = self.measured
            self.client.node.destroy_timer(timer)
            self.client.node.destroy_publisher(publisher)
            self.measured = None

    def send(self, *motors):
        self.setpoints.publish(Float64MultiArray(data=[float(motor) for motor in motors]))

    def until_heard(self, count=1):
        heard = len(self.commands)
        self.client.spin_until(lambda: len(self.commands) >= heard + count)

    def until_said(self, text):
        """In the log; meanwhile the robot measures."""
        self.client.spin_until(lambda: text in self.process.output(), timeout=240.0)

    def until_answered(self):
        """By the node of now: requests may go to one that was killed, which is not known for a while."""
        states = self.client.node.create_client(GetState, "/cpr_node/get_state")
        asked = []

        def answered():
            if not asked or time.monotonic() > asked[-1][0] + 0.5:
                asked.append((time.monotonic(), states.call_async(GetState.Request())))
            return any(future.done() for _, future in asked)

        self.client.spin_until(answered)
        self.client.node.destroy_client(states)

    def until_at(self, motors):
        def arrived():
            return self.commands and np.array_equal(self.commands[-1], motors)

        self.client.spin_until(arrived)

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.client.executor.spin_once(timeout_sec=0.005)

    def change(self, *transitions):
        for transition in transitions:
            assert change(self.client, transition), self.process.output()

    def kill(self):
        """Kill the node. What it was about to send, or sent to nobody, is in its file."""
        self.process.process.send_signal(signal.SIGKILL)
        self.process.process.wait()
        heard = -1
        while heard < len(self.commands):  # what is on the way
            heard = len(self.commands)
            self.spin(0.2)
        kept = self.kept(load_robot("rfrfr"))
        last = kept.last()
        kept.close()
        assert np.abs(last.commands - self.commands[-1]).max() <= 5.0 * STEP
        self.ended.append(self.commands)
        self.commands = [last.commands]

    def longest_step(self):
        """Longest way of a motor between two commands, in ticks."""
        lives = [life for life in (*self.ended, self.commands) if len(life) > 1]
        return max(np.abs(np.diff(life, axis=0)).max() for life in lives) / STEP

    def close(self):
        self.client.close()
        assert self.process.stop() in (0, -signal.SIGKILL, 1), self.process.output()


@pytest.fixture
def bench(tmp_path):
    made = Bench(tmp_path)
    yield made
    made.close()


def test_a_killed_node_goes_on_where_it_was(bench):
    """The fault: driven to [3.6, -0.4], killed, restarted, the first command led back to home."""
    bench.start()
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(3.6, -0.4)
    bench.until_at([3.6, -0.4])
    bench.kill()
    bench.start()
    assert "where it was last, motors (3.6, -0.4)" in bench.process.output()
    bench.until_heard()
    np.testing.assert_array_equal(bench.commands[-1], [3.6, -0.4])
    assert bench.longest_step() <= 1.0 + 2e-5
    # To begin at home in spite of that is gone to at the speed limit.
    assert bench.process.stop() == 0
    bench.ended.append(
        bench.commands
    )  # the first ones may not be heard: nodes have to be discovered
    bench.commands = []
    bench.start("start_from:=home")
    assert "commands go from the last ones, (3.6, -0.4), to home" in bench.process.output()
    bench.until_at(HOME)
    assert bench.longest_step() <= 1.0 + 2e-5


def test_no_command_is_far_from_the_one_before_whatever_happens_in_motion(bench):
    """Ended or taken through its life at random moments on the way between setpoints."""
    chance = random.Random(1)
    bench.keep(load_robot("rfrfr"))
    bench.start()
    deactivate, activate = Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_ACTIVATE
    clean, configure = Transition.TRANSITION_CLEANUP, Transition.TRANSITION_CONFIGURE
    for moment in range(MOMENTS):
        bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
        bench.until_heard()
        where = HOME + chance.uniform(0.2, 1.0) * np.array([0.9, -0.9])
        bench.send(*where)
        bench.until_heard()
        bench.spin(chance.uniform(0.0, 0.4))
        match moment % 5:
            case 0:
                bench.kill()
                bench.start()
            case 1:
                assert bench.process.stop(signal.SIGTERM) == 0
                bench.start()
            case 2:
                bench.change(deactivate, clean, configure, activate)
            case 3:
                bench.change(deactivate, activate)
            case 4:
                bench.kill()
                bench.start("autostart:=false", until="unconfigured")
                bench.until_answered()
                bench.change(configure, activate)
        bench.until_heard()
        assert bench.longest_step() <= 1.0 + 2e-5, (moment, bench.longest_step())
    assert sum(map(len, (*bench.ended, bench.commands))) > 50


def test_an_applied_solution_is_gone_to_at_the_speed_limit(bench):
    bench.keep(load_robot("rfrfr"))
    bench.start()
    bench.until_heard()
    request = SolveForward.Request(
        motors=JointState(name=["motor1", "motor2"], position=[2.9, 0.2]), apply=True
    )
    answer = bench.client.call(SolveForward, "/cpr_node/solve_forward", request)
    assert answer.error_code.val == 1
    bench.until_at([2.9, 0.2])
    assert bench.longest_step() <= 1.0 + 2e-5
    assert len(bench.commands) > 0.19 / STEP


def test_an_applied_solution_at_the_last_commands_is_where_it_was_last(bench):
    """Only motion was kept: one that was taken back came alive again, another branch was forgotten."""
    robot = load_robot("rfrfr")
    home, other = solve_home(robot), stable_elsewhere(robot)
    bench.keep(robot, home)
    bench.start()
    bench.until_heard()
    message = Equilibrium()
    fill_equilibrium(message, other, Frames("base", "platform"), Time(), 0.0, eigenvalues=False)
    motors = JointState(name=["motor1", "motor2"], position=home.motors.tolist())
    request = SolveForward.Request(
        motors=motors,
        apply=True,
        start=SolveForward.Request.START_GIVEN,
        start_equilibrium=[message],
    )
    answer = bench.client.call(SolveForward, "/cpr_node/solve_forward", request)
    assert answer.error_code.val == 1, answer.error_code.message
    bench.until_heard()
    bench.kill()
    bench.start()
    states = bench.client.messages(JointState, "/joint_states", 1)
    np.testing.assert_allclose(states[0].effort, other.efforts, rtol=0.0, atol=1e-8)
    assert np.abs(other.efforts - home.efforts).max() > 1e-3


def test_motors_that_others_have_moved_and_that_are_measured_are_not_sent_back(bench):
    """The command of before was said again, and the next motion began there: 124 ticks' ways at once."""
    bench.measure([3.2, -0.1])
    bench.start("start_from:=measured", until="")
    bench.until_said("ready")
    bench.until_heard()
    bench.measure([2.7, 0.4])  # by hand
    bench.until_said("where it is measured, motors (2.7, 0.4)")
    assert "somebody else has moved the motors: one was measured 0.5 " in bench.process.output()
    bench.spin(0.2)  # what is on the way
    heard = len(bench.commands)
    bench.spin(2.2)
    assert len(bench.commands) == heard
    bench.commands = [np.array([2.7, 0.4])]
    bench.send(2.75, 0.35)
    bench.until_at([2.75, 0.35])
    assert bench.longest_step() <= 1.0 + 2e-5


def test_commands_do_not_run_away_from_motors_that_do_not_follow(bench):
    """Without power, or jammed: commands went all the way, and the node began again where they were."""
    still, slow = [2.7, 0.4], 0.25
    bench.measure(still)
    # On its way for several seconds: a busy machine says late what is measured.
    bench.start("start_from:=measured", f"max_speed:={slow}", "max_lead:=0.0", until="")
    bench.until_said("ready")
    bench.until_heard()
    bench.send(3.6, -0.4)
    bench.until_said("the motors do not follow: one was measured ")
    begun = "where it is measured, motors (2.7, 0.4)"
    bench.client.spin_until(lambda: bench.process.output().count(begun) == 2)
    bench.spin(0.2)  # what is on the way
    ahead = max(float(np.abs(command - still).max()) for command in bench.commands)
    assert 0.1 < ahead < 0.8  # of 0.9
    bench.commands = [np.array(still)]
    bench.send(2.75, 0.35)
    bench.until_at([2.75, 0.35])
    assert bench.longest_step() <= 1.0 + 2e-5


def test_commands_wait_for_motors_that_do_not_follow(bench):
    """They go no farther ahead than max_lead allows; motors that stay where they are end what waits."""
    still, slow, lead = [2.7, 0.4], 0.25, 0.2
    bench.measure(still)
    bench.start("start_from:=measured", f"max_speed:={slow}", until="")
    bench.until_said("ready")
    bench.until_heard()
    bench.send(3.6, -0.4)
    bench.until_said("as far as max_lead allows, and all at rest for 0.5 s while commands waited")
    bench.spin(0.2)  # what is on the way
    ahead = max(float(np.abs(command - still).max()) for command in bench.commands)
    assert 0.9 * lead * slow < ahead <= lead * slow * (1.0 + 1e-5)
    bench.commands = [bench.commands[-1]]
    bench.send(*still)  # as near as the last command was
    bench.until_at(still)
    assert bench.longest_step() <= 1.0 + 2e-5


def test_a_goal_is_not_reached_by_motors_that_stay_where_they_are(bench):
    """It was said to be, as soon as the commands were there, and of a short way nobody found out."""
    still = [2.7, 0.4]
    bench.measure(still)
    # Measurements are not old while this process, which measures, is held up.
    bench.start("start_from:=measured", "measured_timeout:=600.0", until="")
    bench.until_said("ready")
    bench.until_heard()
    drive = Driver(bench.client)
    moves = GoalClient(bench.client, MoveTo, "/cpr_node/move_to")
    motors = JointState(name=["motor1", "motor2"], position=[2.75, 0.4])
    goal = {"given": MoveTo.Goal.GIVEN_MOTORS, "motors": motors}
    result = moves.result(moves.send(**goal)).result
    assert result.error_code.val == ErrorCode.CONTROL_FAILED
    assert "motor1 is measured at 2.7 rad, its command is 2.75" in result.error_code.message
    bench.until_at([2.75, 0.4])  # the result may be taken first
    # Who knows that a load holds them off says so.
    assert drive.set_parameters(arrived_tolerance=0.06).successful
    assert moves.result(moves.send(**goal)).result.error_code.val == ErrorCode.SUCCESS
    assert drive.set_parameters(arrived_tolerance=0.01).successful
    bench.measure([2.75, 0.4])
    bench.spin(0.3)  # what is on the way
    assert moves.result(moves.send(**goal)).result.error_code.val == ErrorCode.SUCCESS
    moves.close()
    drive.close()


def test_motors_that_were_moved_and_are_measured_no_more_are_sent_nowhere(bench):
    """Setpoints were refused for ever, HALT was never said, and after a clean-up they jumped."""
    bench.measure([2.7, 0.4])
    bench.start(until="")
    bench.until_said("ready")
    node, streamed = bench.client.node, []
    node.create_subscription(StabilityMetrics, "/cpr_node/stability", streamed.append, 10)
    bench.until_heard()
    steps = itertools.count(1)
    publisher = node.create_publisher(JointState, "/measured_joint_states", qos_profile_sensor_data)
    bench.measure_no_more()
    timer = node.create_timer(
        0.05,
        lambda: publisher.publish(
            JointState(name=["motor1", "motor2"], position=[2.7 + 0.02 * next(steps), 0.4])
        ),
    )

    def until_action(action):
        streamed.clear()
        bench.client.spin_until(lambda: streamed and streamed[-1].action == action)
        return streamed[-1]

    told = until_action(StabilityMetrics.ACTION_HALT)
    assert "somebody else has moved the motors" in told.status_text
    node.destroy_timer(timer)
    node.destroy_publisher(publisher)
    bench.spin(2.0)  # until nobody is found any more who publishes
    bench.commands = []
    deactivate, activate = Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_ACTIVATE
    clean, configure = Transition.TRANSITION_CLEANUP, Transition.TRANSITION_CONFIGURE
    bench.change(deactivate, activate)
    assert "somebody else" in until_action(StabilityMetrics.ACTION_HALT).status_text
    refused = bench.process.output().count("~/commands: dropped: somebody else has moved")
    bench.send(2.75, 0.35)
    bench.client.spin_until(
        lambda: bench.process.output().count("~/commands: dropped: somebody else") > refused
    )
    bench.change(deactivate, clean, configure)
    assert not change(bench.client, activate)
    assert "and nothing publishes measured_joint_states" in bench.process.output()
    assert not bench.commands
    measured = [3.1, 0.2]
    bench.measure(measured)
    bench.client.spin_until(lambda: change(bench.client, activate))
    until_action(StabilityMetrics.ACTION_NONE)
    bench.commands = [np.array(measured)]
    bench.send(3.0, 0.3)
    bench.until_at([3.0, 0.3])
    assert bench.longest_step() <= 1.0 + 2e-5


@pytest.mark.parametrize("measured", ["before", "after"])
def test_home_is_gone_to_once(bench, measured):
    """A robot that was only deactivated set off for home as it became active, or was measured later."""
    deactivate, activate = Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_ACTIVATE
    bench.start("start_from:=home")
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    place = [2.7, 0.4]
    bench.send(*place)
    bench.until_at(place)
    bench.change(deactivate, activate, deactivate)  # whether it has moved since is not the question
    if measured == "before":
        bench.measure(place)
        bench.client.spin_until(lambda: bench.measured[1].get_subscription_count() > 0)
    bench.change(activate)
    if measured == "after":
        bench.until_heard()
        bench.measure(place)
    bench.until_said("where it is measured, motors (2.7, 0.4)")
    bench.commands = [np.array(place)]
    bench.until_heard(2)
    assert np.unique(bench.commands, axis=0).tolist() == [place]
    # A clean-up begins anew.
    clean, configure = Transition.TRANSITION_CLEANUP, Transition.TRANSITION_CONFIGURE
    bench.change(deactivate, clean, configure, activate)
    bench.until_at(HOME)
    assert bench.longest_step() <= 1.0 + 2e-5


def test_where_a_tracked_robot_was_is_known_to_a_node_that_moves_it(bench):
    """The node knew better and kept nothing: the first command was that of before it was moved."""
    bench.start("start_from:=home")
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(3.2, -0.1)
    bench.until_at([3.2, -0.1])
    assert bench.process.stop() == 0
    bench.measure([2.7, 0.4])
    bench.start("motor_source:=measured", until="")
    bench.until_said("ready")
    states = []
    bench.client.node.create_subscription(JointState, "/joint_states", states.append, 10)
    bench.client.spin_until(
        lambda: states and np.allclose(states[-1].position, [2.7, 0.4], atol=1e-12)
    )
    bench.process.process.send_signal(signal.SIGKILL)
    bench.process.process.wait()
    bench.measure_no_more()
    bench.spin(0.3)
    bench.commands = []
    bench.start()
    assert "where it was last, motors (2.7, 0.4)" in bench.process.output()
    bench.until_heard()
    np.testing.assert_array_equal(bench.commands[0], [2.7, 0.4])


def test_what_is_measured_is_where_the_node_begins(bench):
    """Also if it was elsewhere last."""
    measured, robot = [3.2, -0.1], load_robot("rfrfr")
    bench.keep(robot)
    bench.measure(measured)
    bench.start("start_from:=measured", until="")
    bench.client.spin_until(lambda: "ready" in bench.process.output(), timeout=240.0)
    assert "where it is measured, motors (3.2, -0.1)" in bench.process.output()
    bench.until_heard()
    states = bench.client.messages(JointState, "/joint_states", 1)
    np.testing.assert_array_equal(states[0].position, measured)
    expected = solve_forward(robot, measured)
    np.testing.assert_allclose(states[0].effort, expected.efforts, rtol=0.0, atol=1e-8)
    assert all(np.array_equal(command, measured) for command in bench.commands)


def test_where_it_was_measured_it_is_after_a_restart_without_any_motion(bench):
    """The last state was that of long ago, and commands sprang to it."""
    bench.keep(load_robot("rfrfr"))
    bench.measure([3.2, -0.1])
    bench.start("start_from:=measured", until="")
    bench.client.spin_until(lambda: "ready" in bench.process.output(), timeout=240.0)
    assert bench.process.stop() == 0
    bench.ended.append(bench.commands)
    bench.commands = []
    bench.start("start_from:=last")
    assert "where it was last, motors (3.2, -0.1)" in bench.process.output()
    bench.until_heard()
    np.testing.assert_array_equal(bench.commands[-1], [3.2, -0.1])


def test_setpoints_sent_while_the_node_becomes_active_are_not_followed(bench):
    """It waits for measured motors meanwhile; they were in its queues and delivered as if new."""
    bench.start("autostart:=false", "start_from:=measured", until="")
    bench.change(Transition.TRANSITION_CONFIGURE)
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    node = bench.client.node
    by_name = node.create_publisher(JointState, "/cpr_node/motor_setpoint", 10)
    bench.client.spin_until(lambda: by_name.get_subscription_count() > 0)
    client = node.create_client(ChangeState, "/cpr_node/change_state")
    client.wait_for_service()
    request = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_ACTIVATE))
    activated = client.call_async(request)
    bench.spin(1.0)  # it waits for up to 5 s
    for motor in (3.0, 3.1):
        by_name.publish(JointState(name=["motor1"], position=[motor]))
        bench.send(motor, 0.1)
    bench.spin(0.5)
    assert not activated.done()
    bench.measure([3.2, -0.1])
    bench.client.spin_until(activated.done)
    assert activated.result().success
    bench.until_heard(2)
    assert all(np.array_equal(command, [3.2, -0.1]) for command in bench.commands)
    bench.send(3.19, -0.09)
    bench.until_at([3.19, -0.09])  # what comes afterwards is
    assert "Traceback" not in bench.process.output()


def test_what_no_equilibrium_explains_keeps_the_node_from_being_active(bench):
    bench.measure([20.0, 0.55])
    bench.start("start_from:=measured", until="")
    bench.client.spin_until(lambda: bench.process.process.poll() is not None, timeout=240.0)
    assert bench.process.process.returncode == 1
    assert "the robot is measured at motors (20, 0.55)" in bench.process.output()
    assert not bench.commands


def test_a_node_that_is_to_start_measured_says_that_nothing_is(bench):
    bench.start("start_from:=measured", until="")
    bench.client.spin_until(lambda: bench.process.process.poll() is not None, timeout=240.0)
    assert bench.process.process.returncode == 1
    said = bench.process.output()
    expected = "no measured_joint_states with its motors (motor1, motor2) that tells it came in 5 s"
    assert f"{expected}: no message " in said
    assert "nobody publishes it" in said


def test_a_topic_with_joints_of_others_alone_is_told_by_their_names(bench):
    """Nobody knows whether they are the motors under other names: it moves nothing, and ends."""
    bench.measure([3.2, -0.1], names=["finger", "thumb"])
    bench.start(until="")
    bench.client.spin_until(lambda: bench.process.process.poll() is not None, timeout=240.0)
    assert bench.process.process.returncode == 1
    said, name = bench.process.output(), bench.client.node.get_name()
    assert f"came in 5 s: of other joints only: finger, thumb; published by /{name}. If" in said
    assert "start_from:=last or start_from:=home begins without" in said
    assert not bench.commands


def test_a_configure_that_fails_lets_the_state_file_go_and_a_retry_fails_for_the_same_reason(bench):
    """The second one could not lock the file, knew nothing, and succeeded: no command was limited."""
    robot = load_robot("rfrfr")
    bench.keep(robot, solve_inverse(robot, [0.0, 0.0]))
    bench.start("autostart:=false", "start_from:=last", until="")
    for count in (1, 2):
        assert not change(bench.client, Transition.TRANSITION_CONFIGURE)
        said = bench.process.output()
        assert said.count("cannot rest at its last equilibrium, which is unstable") == count
    assert "will not be kept" not in said
    bench.keep(robot)  # nobody has locked it, and the next one finds what is there
    bench.change(Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE)
    bench.until_heard()
    np.testing.assert_array_equal(bench.commands[0], [2.7, 0.4])


@pytest.mark.parametrize("start_from", ["auto", "measured"])
def test_where_it_cannot_have_stayed_it_has_to_be_measured(bench, start_from):
    """A last state that is no place to begin is no reason not to begin where motors are measured."""
    robot = load_robot("rfrfr")
    bench.keep(robot, solve_inverse(robot, [0.0, 0.0]))
    bench.start("autostart:=false", f"start_from:={start_from}", until="")
    bench.change(Transition.TRANSITION_CONFIGURE)
    assert "is not used: the robot cannot rest at its last eq" in bench.process.output()
    assert "where the robot is has to be measured" in bench.process.output()
    for _ in range(2):
        assert not change(bench.client, Transition.TRANSITION_ACTIVATE)
    reason = {"auto": "nothing publishes", "measured": "no measured_joint_states with"}[start_from]
    assert bench.process.output().count(reason) == 2
    bench.measure([3.2, -0.1])
    bench.spin(1.0)  # the node has to discover who measures
    bench.change(Transition.TRANSITION_ACTIVATE)
    bench.until_heard()
    assert all(np.array_equal(command, [3.2, -0.1]) for command in bench.commands)


def keep_no_equilibrium(bench, motors=(2.7, 0.4)):
    """Leave a last state of which only the commands are of use."""
    robot = load_robot("rfrfr")
    found = solve_forward(robot, [2.7, 0.4])
    numbers = found.configuration.copy()
    numbers[: robot.state_size] += 1.0
    bench.keep(
        robot,
        SimpleNamespace(configuration=numbers, loads=found.loads, motors=np.array(motors)),
    )


def test_home_is_gone_to_from_where_the_motors_are_measured(bench):
    """Commands began at home, with motors that were measured elsewhere."""
    measured = [3.1, 0.55]
    bench.measure(measured)
    slow = 0.1  # so that it matters little if the first commands are not heard
    bench.start("start_from:=home", f"max_speed:={slow}", until="")
    bench.until_said("commands go from where the motors are measured, (3.1, 0.55), to home")
    assert "start_from is home, as for a simulation" in bench.process.output()
    bench.until_heard(20)
    assert HOME[0] + 0.2 < bench.commands[0][0] <= measured[0]
    assert bench.longest_step() * STEP <= 1.001 * slow / RATE


def test_home_is_not_gone_to_by_a_way_on_which_the_robot_would_snap(bench):
    """Nothing guards that way: commands went along it at once, at full speed."""
    robot = load_robot("rfrfr")
    start = stable_elsewhere(robot)
    bench.keep(robot, solve_forward(robot, start.motors + [0.3, 0.2], start=start))
    bench.start("start_from:=home")
    said = bench.process.output()
    assert "commands go from the last ones, (2.89, 0.75), to home at max_speed, not yet: " in said
    bench.until_heard()
    bench.spin(0.5)
    np.testing.assert_allclose(bench.commands, len(bench.commands) * [[2.89, 0.75]], atol=1e-12)


def test_a_robot_that_has_to_be_measured_is_not_paused_for_a_way_home_that_it_does_not_take(bench):
    """Its last state is no equilibrium, and the way home from its last commands is barred."""
    keep_no_equilibrium(bench, [6.2, -3.0])
    bench.measure([2.7, 0.4])
    bench.start(until="")
    bench.until_said("where it is measured, motors (2.7, 0.4)")
    bench.until_said("ready")
    assert "not yet" not in bench.process.output()
    bench.send(2.75, 0.4)
    bench.until_at([2.75, 0.4])


def test_home_is_gone_to_from_the_last_commands_though_their_equilibrium_is_none(bench):
    """Nothing was known then, and the first command went home at once."""
    keep_no_equilibrium(bench)
    bench.start("start_from:=home")
    assert "commands go from the last ones, (2.7, 0.4), to home" in bench.process.output()
    bench.until_at(HOME)
    assert bench.longest_step() <= 1.0 + 2e-5


def test_a_state_of_the_robot_that_is_no_equilibrium_is_not_as_if_nothing_were_known(bench):
    """Its motors are somewhere: a node of another version that began at home would let them jump."""
    keep_no_equilibrium(bench)
    bench.start("autostart:=false", until="")
    bench.change(Transition.TRANSITION_CONFIGURE)
    assert "is not used: start: expected an equilibrium" in bench.process.output()
    assert not change(bench.client, Transition.TRANSITION_ACTIVATE)
    assert "nothing publishes measured_joint_states" in bench.process.output()


def softer(content):
    content["rod"]["young_modulus"] = 0.999 * float(content["rod"]["young_modulus"])


@pytest.mark.parametrize(
    "before", [lambda: load_robot("rfrfr", modes=6), lambda: changed_robot("rfrfr", softer)]
)
def test_another_description_begins_where_the_motors_were_sent_last(bench, before):
    """A calibrated robot led its motors home with the first command, a radian at once."""
    last, described = [3.6, -0.4], before()
    bench.keep(described, solve_forward(described, last))
    bench.start()
    assert "is of another description" in bench.process.output()
    assert "where the last commands were, (3.6, -0.4)" in bench.process.output()
    bench.until_at(last)
    bench.process.stop()
    kept = bench.kept(described)  # the description may have been the wrong one
    np.testing.assert_array_equal(kept.last().commands, last)
    kept.close()
    bench.start()
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(3.5, -0.3)
    bench.until_at([3.5, -0.3])
    assert bench.longest_step() <= 1.0 + 2e-5
    assert np.abs(bench.commands[0] - last).max() <= STEP * (1.0 + 2e-5)


def test_last_commands_that_another_description_does_not_explain_are_measured_first(bench):
    described = load_robot("rfrfr", modes=6)
    found = solve_forward(described, [2.7, 0.4])
    kept = bench.kept(described)
    kept.keep(found, np.array([20.0, 0.55]))
    kept.close()
    bench.start("autostart:=false", until="")
    bench.change(Transition.TRANSITION_CONFIGURE)
    said = "the last commands, under another description, were (20, 0.55), where the branch of home"
    assert said in bench.process.output()
    assert not change(bench.client, Transition.TRANSITION_ACTIVATE)
    assert "nothing publishes measured_joint_states" in bench.process.output()


def test_the_state_of_another_robot_is_left_aside_with_a_word(bench):
    bench.keep(changed_robot("rfrfr", lambda content: content.update(name="another")))
    bench.start()
    assert "the last state is not used" in bench.process.output()
    assert "is of another robot" in bench.process.output()
    assert "nothing is known of where the robot is" in bench.process.output()
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.spin(1.5)
    assert not bench.commands  # none before the first motion, which begins at home
    bench.send(*HOME)
    bench.until_at(HOME)  # wherever the motors are: this was said to be reached, and nothing sent
    bench.send(2.7, 0.4)
    bench.until_at([2.7, 0.4])
    assert np.abs(bench.commands[0] - HOME).max() <= STEP * (1.0 + 2e-5)
    assert bench.longest_step() <= 1.0 + 2e-5


def test_a_measurement_that_comes_late_places_a_robot_that_has_not_moved(bench):
    """Its publisher was discovered after the node was active, or started later."""
    bench.start("moved_tolerance:=0.0", "max_lead:=0.0")  # it goes on saying the same
    assert "nothing is known of where the robot is" in bench.process.output()
    bench.measure([3.2, -0.1])
    bench.client.spin_until(lambda: "where it is measured" in bench.process.output())
    bench.until_heard()
    assert all(np.array_equal(command, [3.2, -0.1]) for command in bench.commands)
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(3.0, 0.1)
    bench.until_at([3.0, 0.1])
    bench.spin(0.5)
    np.testing.assert_array_equal(bench.commands[-1], [3.0, 0.1])  # placed once, not again
    assert bench.process.output().count("where it is measured") == 1
    assert bench.longest_step() <= 1.0 + 2e-5


def test_a_late_measurement_that_nothing_explains_makes_the_node_inactive(bench):
    bench.start()
    bench.measure([20.0, 0.55])
    bench.client.spin_until(
        lambda: "deactivated: the robot is measured at motors (20, 0.55)" in bench.process.output(),
        timeout=60.0,
    )
    state = bench.client.call(GetState, "/cpr_node/get_state", GetState.Request())
    assert state.current_state.label == "inactive"
    assert not bench.commands


def test_a_last_state_that_cannot_be_read_does_not_begin_at_home(bench):
    """The node of before still had the file, and the first command led home at once."""
    bench.keep(load_robot("rfrfr"))
    another = bench.kept(load_robot("rfrfr"))  # of the same name: two do not share a file
    bench.start(until="")
    bench.process.process.wait(timeout=60.0)
    assert bench.process.process.returncode == 1
    said = bench.process.output()
    assert "where the robot is will not be kept in" in said
    assert "the last state cannot be read" in said
    assert "nothing publishes measured_joint_states" in said
    bench.start("start_from:=home")
    another.close()
    assert not bench.commands


@pytest.mark.parametrize("start_from", ["measured", "home"])
def test_a_file_that_another_node_had_is_kept_as_soon_as_it_is_free(bench, start_from):
    """It stayed as that one had left it, and the next node began there; the robot was elsewhere."""
    place = {"measured": (2.9, 0.3), "home": (2.8, 0.5)}[start_from]
    bench.keep(load_robot("rfrfr"))
    another = bench.kept(load_robot("rfrfr"))
    if start_from == "measured":
        bench.measure(place)
    bench.start(f"start_from:={start_from}", until="")
    bench.until_said("ready")
    assert "every second" in bench.process.output()
    another.close()
    if start_from == "home":  # nothing is known before it moves
        bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
        bench.send(*place)
    bench.until_at(place)
    bench.until_said("is kept in")
    bench.kill()
    bench.measure_no_more()
    bench.spin(0.3)
    bench.start()
    assert f"where it was last, motors ({place[0]}, {place[1]})" in bench.process.output()


def test_a_last_state_on_a_disk_that_is_away_does_not_begin_at_home(bench):
    """The first command led home at once, and it was another node that had the file."""
    kept = bench.file.parent.with_name("disk")
    bench.keep(load_robot("rfrfr"))
    bench.file.parent.rename(kept)
    bench.file.parent.symlink_to(kept)
    bench.start()
    assert "where it was last" in bench.process.output()
    bench.until_heard()
    bench.kill()
    bench.ended, bench.commands = [], []
    kept.rename(kept.with_name("away"))
    bench.start(until="")
    bench.process.process.wait(timeout=60.0)
    assert bench.process.process.returncode == 1
    said = bench.process.output()
    assert f"a link that leads nowhere: '{bench.file.parent}'" in said
    assert "the last state cannot be read" in said
    assert not bench.commands


def spoil_both_slots(content):
    for place in (200, len(content) - 200):
        content[place] ^= 1
    return content


@pytest.mark.parametrize(
    "damaged", [spoil_both_slots, lambda content: content[:400], lambda _: b""]
)
def test_a_damaged_file_lets_no_command_go_out_before_the_robot_is_measured(bench, damaged):
    """Nothing was known then, and the first command was that of home: 61 ticks' ways at once."""
    bench.start()
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(2.9, 0.3)
    bench.until_at([2.9, 0.3])
    bench.kill()
    bench.ended, bench.commands = [], []
    content = damaged(bytearray(bench.file.read_bytes()))
    bench.file.write_bytes(content)
    for start_from in ("auto", "last"):
        bench.start(f"start_from:={start_from}", until="")
        bench.process.process.wait(timeout=60.0)
        assert bench.process.process.returncode == 1
        said = bench.process.output()
        assert f"{bench.file} cannot be read" in said
        assert "may be removed once the motors are at home" in said
        assert ("start_from:=home" in said) is (start_from == "auto")
    assert bench.file.read_bytes() == content
    assert not bench.commands
    bench.measure([2.9, 0.3])
    bench.start("start_from:=measured", until="")
    bench.until_said("where it is measured, motors (2.9, 0.3)")
    bench.until_heard()
    bench.kill()
    bench.measure_no_more()
    bench.spin(0.3)
    bench.start()
    assert "where it was last, motors (2.9, 0.3)" in bench.process.output()
    bench.until_heard()
    assert all(np.array_equal(command, [2.9, 0.3]) for command in bench.commands)


def test_home_is_begun_at_over_a_damaged_file_if_the_operator_says_so(bench):
    bench.file.parent.mkdir()
    bench.file.write_bytes(b"")
    bench.start("start_from:=home")
    assert f"{bench.file} cannot be read" in bench.process.output()
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(2.7, 0.4)
    bench.until_at([2.7, 0.4])
    bench.kill()
    bench.start()
    assert "where it was last, motors (2.7, 0.4)" in bench.process.output()


def test_a_full_disk_is_told_once_and_neither_ends_the_node_nor_stops_the_motion(bench):
    """It was SIGBUS at the first motion."""
    bench.file.parent.mkdir()
    bench.file.symlink_to("/dev/full")
    bench.start("start_from:=home")
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    for motors in ([2.7, 0.4], [2.6, 0.5]):
        bench.send(*motors)
        bench.until_at(motors)
        bench.spin(1.2)
    said = bench.process.output()
    assert (
        said.count("No space left on device; unless that ends, the robot has to be measured") == 1
    )
    assert "Traceback" not in said
    assert bench.longest_step() <= 1.0 + 2e-5


def test_what_others_do_to_the_file_neither_ends_the_node_nor_is_it_forgotten_where_it_is(bench):
    """Truncated, it ended the node at the next step; removed, nothing was known after a restart."""
    bench.start()
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(2.7, 0.4)
    bench.until_at([2.7, 0.4])
    bench.file.write_bytes(b"")
    bench.send(2.8, 0.3)
    bench.until_at([2.8, 0.3])
    bench.until_said("was not as this node left it")
    bench.file.unlink()
    bench.file.mkdir()  # nothing can be kept there
    bench.until_said("where the robot is cannot be kept in")
    for motors in ([2.75, 0.35], [2.8, 0.3]):
        bench.send(*motors)
        bench.until_at(motors)
        bench.spin(1.2)
    said = bench.process.output()
    assert said.count("where the robot is cannot be kept in") == 1
    assert said.count("was not as this node left it") == 1
    bench.file.rmdir()
    bench.client.spin_until(
        lambda: bench.process.output().count("was not as this node left it") == 2
    )
    with pytest.raises(BlockingIOError, match="another node of this name"):
        bench.kept(load_robot("rfrfr"))
    assert bench.process.process.poll() is None
    bench.kill()
    bench.start()
    assert "where it was last, motors (2.8, 0.3)" in bench.process.output()
    bench.until_heard()
    assert bench.longest_step() <= 1.0 + 2e-5


def test_a_robot_that_moves_is_not_placed_by_a_measurement(bench):
    """Where nobody moves motors but the node: a load may hold them off their command."""
    bench.start("moved_tolerance:=0.0", "max_lead:=0.0")
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(2.7, 0.4)
    bench.until_at([2.7, 0.4])
    bench.measure([3.2, -0.1])
    node = bench.client.node
    bench.client.spin_until(lambda: node.count_subscribers("/measured_joint_states") > 0)
    bench.until_heard(2)
    assert "where it is measured" not in bench.process.output()
    np.testing.assert_array_equal(bench.commands[-1], [2.7, 0.4])

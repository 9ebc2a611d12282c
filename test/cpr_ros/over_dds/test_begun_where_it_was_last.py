# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A node begins where the robot was last, and no command is far from the one before."""

import os
import random
import signal

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from cpr_msgs.msg import Equilibrium
from cpr_msgs.srv import SolveForward
from helpers.branches import stable_elsewhere
from helpers.drive import changed_robot
from helpers.node_process import change
from helpers.robot_bench import HOME, STEP
from lifecycle_msgs.msg import Transition
from sensor_msgs.msg import JointState

from cpr_core import load_robot, solve_forward, solve_home, solve_inverse
from cpr_ros.messages.equilibrium_messages import fill_equilibrium
from cpr_ros.messages.frames import Frames

pytestmark = pytest.mark.waits(seconds=40)

#: At which a node is ended or taken through its life; five ways, one after the other. The variable asks
#: for more of them.
MOMENTS = int(os.environ.get("CPR_MOMENTS", "5"))


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
    np.testing.assert_array_equal(kept.last().motors, last)
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

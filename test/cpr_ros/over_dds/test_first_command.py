# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A setpoint that comes at rest is commanded before it is solved, over real DDS."""

import numpy as np
import pytest
from cpr_msgs.msg import StabilityMetrics
from helpers.driver import Driver
from helpers.node_process import running_node
from std_msgs.msg import Float64MultiArray

from cpr_core import kinemato_statics, load_robot, solve_home, solve_inverse

HOME = np.array([2.59, 0.55])
TICK = 1.0 / 200.0


def new_commands(drive, before):
    """Without those that say the last one again, once a second."""
    commands = [np.array(message.data) for message in drive.all(Float64MultiArray)]
    return [command for command in commands if command.tolist() != before.tolist()]


def first_held_up(drive, before, send, held_up, looked):
    """The first command of a setpoint that is not solved before that command has come."""
    drive.until(lambda: drive.metrics.state == StabilityMetrics.STATE_IDLE)
    drive.client.spin_until(looked.exists)
    drive.forget()
    held_up.touch()
    send()
    drive.client.spin_until(lambda: len(new_commands(drive, before)) > 0)
    drive.spin(0.1)
    first, *others = new_commands(drive, before)
    assert others == []  # they are solved first
    held_up.unlink()
    return first


def arrives_in_ticks(drive, before, target):
    """Wait for the last command, within a tick's way of the one before as all are."""
    drive.client.spin_until(lambda: np.abs(new_commands(drive, before)[-1] - target).max() < 1e-9)
    sent = np.array([before, *new_commands(drive, before)])
    assert np.abs(np.diff(sent, axis=0)).max() <= TICK * (1.0 + 1e-5)


def send_held_up(drive, before, target, held_up, looked):
    """Send a motor setpoint that is not solved before its first command has come."""
    first = first_held_up(drive, before, lambda: drive.send_motors(*target), held_up, looked)
    way = target - before
    step = way * min(1.0, TICK / np.abs(way).max())
    np.testing.assert_allclose(first, before + step, rtol=0.0, atol=1e-12)
    arrives_in_ticks(drive, before, target)


@pytest.fixture
def placed(tmp_path):
    """A node that knows where its motors are: its driver, and the files that hold it up and tell."""
    arguments = "robot:=rfrfr", "start_from:=home", "max_speed:=1.0"
    with running_node(tmp_path, *arguments, module="helpers.held_up_node") as running:
        drive, held_up = Driver(running.client), running.process.home / "held_up"
        try:
            drive.send_motors(*HOME)
            drive.client.spin_until(lambda: drive.all(Float64MultiArray))
            yield drive, held_up, running.process.home / "looked_around"
        finally:
            held_up.unlink(missing_ok=True)
            drive.close()


def test_the_first_command_comes_while_the_node_has_not_solved_it_yet(placed):
    drive, *files = placed
    send_held_up(drive, HOME, HOME + [0.001, -0.002], *files)
    send_held_up(drive, HOME + [0.001, -0.002], HOME + [0.3, -0.2], *files)


def test_so_does_the_first_one_towards_a_pose(placed):
    """A tenth of a tick's way along the tangent."""
    drive, *files = placed
    home = solve_home(load_robot("rfrfr"))
    pose = home.pose + [0.05, -0.02]
    first = first_held_up(drive, HOME, lambda: drive.send_platform(*pose), *files)
    way = kinemato_statics(home).motors_by_pose @ [0.05, -0.02]
    step = 0.1 * TICK * way / np.abs(way).max()
    np.testing.assert_allclose(first, HOME + step, rtol=0.0, atol=1e-9)
    arrives_in_ticks(drive, HOME, solve_inverse(home.robot, pose).motors)

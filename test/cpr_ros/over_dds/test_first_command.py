# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A motor setpoint that comes at rest is commanded before it is solved, over real DDS."""

import numpy as np
from cpr_msgs.msg import StabilityMetrics
from helpers.driver import Driver
from helpers.node_process import running_node
from std_msgs.msg import Float64MultiArray

HOME = np.array([2.59, 0.55])
TICK = 1.0 / 200.0


def new_commands(drive, before):
    """Without those that say the last one again, once a second."""
    commands = [np.array(message.data) for message in drive.all(Float64MultiArray)]
    return [command for command in commands if command.tolist() != before.tolist()]


def send_held_up(drive, before, target, held_up, looked):
    """Send a setpoint that is not solved before its first command has come."""
    drive.until(lambda: drive.metrics.state == StabilityMetrics.STATE_IDLE)
    drive.client.spin_until(looked.exists)
    drive.forget()
    held_up.touch()
    drive.send_motors(*target)
    drive.client.spin_until(lambda: len(new_commands(drive, before)) > 0)
    drive.spin(0.1)
    first, *others = new_commands(drive, before)
    assert others == []  # they are solved first
    way = target - before
    step = way * min(1.0, TICK / np.abs(way).max())
    np.testing.assert_allclose(first, before + step, rtol=0.0, atol=1e-12)
    held_up.unlink()
    drive.client.spin_until(lambda: new_commands(drive, before)[-1].tolist() == target.tolist())
    sent = np.array([before, *new_commands(drive, before)])
    assert np.abs(np.diff(sent, axis=0)).max() <= TICK * (1.0 + 1e-5)


def test_the_first_command_comes_while_the_node_has_not_solved_it_yet(tmp_path):
    arguments = "robot:=rfrfr", "start_from:=home", "max_speed:=1.0"
    with running_node(tmp_path, *arguments, module="helpers.held_up_node") as running:
        drive, held_up = Driver(running.client), running.process.home / "held_up"
        looked = running.process.home / "looked_around"
        try:
            drive.send_motors(*HOME)  # now it knows where the motors are
            drive.client.spin_until(lambda: drive.all(Float64MultiArray))
            send_held_up(drive, HOME, HOME + [0.001, -0.002], held_up, looked)
            send_held_up(drive, HOME + [0.001, -0.002], HOME + [0.3, -0.2], held_up, looked)
        finally:
            held_up.unlink(missing_ok=True)
            drive.close()

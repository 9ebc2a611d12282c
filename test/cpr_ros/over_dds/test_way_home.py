# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How a robot that is elsewhere is led to home, where the node is to begin there."""

from types import SimpleNamespace

import numpy as np
import pytest
from helpers.branches import stable_elsewhere
from helpers.node_process import change
from helpers.robot_bench import HOME, RATE, STEP
from lifecycle_msgs.msg import Transition

from cpr_core import load_robot, solve_forward

pytestmark = pytest.mark.waits(seconds=20)


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

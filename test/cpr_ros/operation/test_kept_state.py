# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The last state of a robot on disk: what is kept is there again, of one node, at once."""

import os
import pwd
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.kept_states import ROBOT, at

from cpr_core import CprError, load_robot, solve_forward, solve_home
from cpr_ros.operation.kept_state import KeptState, state_folder


def test_nothing_is_known_at_first(file):
    kept = KeptState(file, ROBOT)
    assert kept.last() is None and not kept.problem
    kept.close()


@pytest.mark.parametrize("other", [load_robot("six_rfs"), load_robot("rfrfr", modes=7)])
def test_a_file_in_which_another_robot_never_kept_anything_is_new(file, other):
    """Who started the node without arguments first was told of a last state that there never was."""
    KeptState(file, other).close()
    kept = KeptState(file, ROBOT)
    assert kept.last() is None and kept.last_commands() is None
    assert (kept.problem, kept.damage) == ("", "")
    kept.keep(found := at(0.4), found.motors)
    kept.close()
    again = KeptState(file, ROBOT)
    np.testing.assert_array_equal(again.last_commands(), found.motors)
    again.close()


@pytest.mark.parametrize("measured", [True, False])
def test_whether_the_motors_were_measured_is_kept(file, measured):
    kept, found = KeptState(file, ROBOT), at(0.4)
    kept.keep(found, found.motors, measured)
    kept.close()
    kept = KeptState(file, ROBOT)
    assert kept.last().measured is measured
    np.testing.assert_array_equal(kept.last().motors, found.motors)
    kept.close()


def test_what_was_kept_is_there_again_to_the_last_digit(file):
    wrench = ROBOT.default_loads.with_(wrench_world=[0, 0, 0, 0.3, -0.2, 0])
    for loads in (None, wrench):
        kept = KeptState(file, ROBOT)
        for fraction in (0.0, 0.4, 1.0):
            found = at(fraction, loads)
            kept.keep(found, found.motors + 0.01)
        kept.close()
        kept = KeptState(file, ROBOT)
        last = kept.last()
        kept.close()
        np.testing.assert_allclose(last.equilibrium.state, found.state, rtol=0.0, atol=1e-12)
        np.testing.assert_array_equal(last.motors, found.motors + 0.01)
        np.testing.assert_array_equal(last.equilibrium.loads.wrench_world, found.loads.wrench_world)
        assert loads is not None or last.equilibrium.loads is ROBOT.default_loads


def test_every_load_that_a_request_or_a_message_can_change_is_kept(file):
    kept, home = KeptState(file, ROBOT), solve_home(ROBOT)
    for name, value in (
        ("gravity", [0.1, -0.2, 0.0]),
        ("wrench_world", [0, 0, 0, 0.3, -0.2, 0]),
        ("wrench_body", [0, 0, 0, 0.1, 0.2, 0]),
    ):
        loads = ROBOT.default_loads.with_(**{name: value})
        found = solve_forward(ROBOT, home.motors, loads=loads)
        kept.keep(found, found.motors)
        last = kept.last().equilibrium
        assert last.loads.differences(ROBOT.default_loads) == (name,)
        assert last.loads.differences(loads) == ()
    kept.close()


def test_a_robot_that_was_lost_is_nowhere_until_it_is_found_again(file):
    """Its last equilibrium is not where its motors are: commands would begin there."""
    kept, found = KeptState(file, ROBOT), at(0.4)
    kept.keep(found, found.motors)
    kept.keep(found, None)
    with pytest.raises(CprError, match="measured where no equilibrium explained them"):
        kept.last()
    assert kept.last_commands() is None
    kept.keep(found, found.motors)
    np.testing.assert_array_equal(kept.last().motors, found.motors)
    kept.close()


def test_keeping_takes_some_microseconds(file):
    kept, found = KeptState(file, ROBOT), at(0.3)
    times = []
    for _ in range(2000):
        begin = time.perf_counter()
        kept.keep(found, found.motors)
        times.append(time.perf_counter() - begin)
    kept.close()
    assert np.median(times) < 100e-6


def test_the_last_commands_are_known_though_the_equilibrium_is_none(file):
    """They are where the motors are: what begins at home has to go from them."""
    found = at(0.6)
    numbers = found.configuration.copy()
    numbers[: ROBOT.state_size] += 1.0
    kept = KeptState(file, ROBOT)
    assert kept.last_commands() is None
    kept.keep(SimpleNamespace(configuration=numbers, loads=found.loads), found.motors)
    with pytest.raises(CprError, match="expected an equilibrium"):
        kept.last()
    np.testing.assert_array_equal(kept.last_commands(), found.motors)
    kept.close()


def test_two_nodes_do_not_share_a_file(file):
    kept = KeptState(file, ROBOT)
    with pytest.raises(BlockingIOError, match="another node of this name keeps its state there"):
        KeptState(file, ROBOT)
    kept.close()
    KeptState(file, ROBOT).close()


def test_a_killed_process_leaves_its_last_state(file):
    """It writes as fast as it can and tells what it wrote; killed, at most the next one is there."""
    program = f"""
import os, sys
from pathlib import Path
import numpy as np
from cpr_core import load_robot, solve_home
from cpr_ros.operation.kept_state import KeptState
robot = load_robot("rfrfr")
home = solve_home(robot)
for _ in sys.stdin:
    pid = os.fork()
    if pid == 0:
        kept = KeptState(Path({str(file)!r}), robot)
        print(os.getpid(), flush=True)
        for number in range(10**9):
            kept.keep(home, np.full(2, float(number)))
            os.write(1, b"%d\\n" % number)  # at once: print writes twice where Python is unbuffered
    os.waitpid(pid, 0)
    print("killed", flush=True)
"""
    with subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as original:
        for count in (1, 50, 333):
            print(file=original.stdin, flush=True)
            pid = int(original.stdout.readline())
            for _ in range(count):
                told = int(original.stdout.readline())
            os.kill(pid, signal.SIGKILL)
            while (line := original.stdout.readline()) != "killed\n":
                told = int(line)
            kept = KeptState(file, ROBOT)
            last = kept.last()
            kept.close()
            assert last.motors[0] in (told, told + 1)
            np.testing.assert_allclose(last.equilibrium.motors, solve_home(ROBOT).motors)


def test_the_folder_is_that_of_ros(monkeypatch, tmp_path):
    monkeypatch.setenv("ROS_HOME", str(tmp_path))
    assert state_folder("") == tmp_path / "cpr_ros"
    assert state_folder("/var/lib/x").as_posix() == "/var/lib/x"
    monkeypatch.delenv("ROS_HOME")
    monkeypatch.setenv("HOME", "/home/me")
    assert state_folder("").as_posix() == "/home/me/.ros/cpr_ros"


@pytest.mark.parametrize("given", ["", "~/robot", "~nobody-at-all/robot"])
def test_a_folder_of_a_user_without_a_home_is_told(monkeypatch, given):
    """A container with the number of a user that nobody has listed: there was a traceback."""
    monkeypatch.delenv("ROS_HOME", raising=False)
    monkeypatch.delenv("HOME")
    monkeypatch.setattr(pwd, "getpwuid", {}.__getitem__)
    for parameter in ("state_directory", "map_directory"):
        with pytest.raises(
            CprError, match=f"^{parameter}: expected a folder, got '{given}': Could"
        ):
            state_folder(given, parameter)

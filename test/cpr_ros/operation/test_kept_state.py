# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The last state of a robot on disk."""

import errno
import os
import signal
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from helpers.tracked_robots import tracked
from helpers.yaml_content import yaml_content

from cpr_core import CprError, load_robot, solve_forward, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_ros.operation.kept_state import KeptState, state_folder

ROBOT = load_robot("rfrfr")


@pytest.fixture
def file(tmp_path):
    return tmp_path / "folder" / "node.state"


def at(fraction, loads=None):
    motors = solve_home(ROBOT).motors + fraction * np.array([0.2, -0.3])
    return solve_forward(ROBOT, motors, loads=loads)


def test_nothing_is_known_at_first(file):
    kept = KeptState(file, ROBOT)
    assert kept.last() is None and not kept.problem
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
        np.testing.assert_array_equal(last.commands, found.motors + 0.01)
        np.testing.assert_array_equal(last.equilibrium.loads.wrench_world, found.loads.wrench_world)
        assert loads is not None or last.equilibrium.loads is ROBOT.default_loads


def test_a_robot_that_was_lost_is_nowhere_until_it_is_found_again(file):
    """Its last equilibrium is not where its motors are: commands would begin there."""
    kept, found = KeptState(file, ROBOT), at(0.4)
    kept.keep(found, found.motors)
    kept.keep(found, None)
    with pytest.raises(CprError, match="measured where no equilibrium explained them"):
        kept.last()
    assert kept.last_commands() is None
    kept.keep(found, found.motors)
    np.testing.assert_array_equal(kept.last().commands, found.motors)
    kept.close()


@pytest.mark.parametrize("byte", range(0, 400, 7))
def test_half_a_slot_counts_for_nothing(file, byte):
    kept = KeptState(file, ROBOT)
    for fraction in (0.3, 0.6):
        kept.keep(at(fraction), at(fraction).motors)
    newest = kept._turn
    kept.close()
    content = bytearray(file.read_bytes())
    slot = (len(content) - 56) // 2
    place = 56 + (newest % 2) * slot + byte % slot
    content[place] ^= 0x41
    file.write_bytes(content)
    kept = KeptState(file, ROBOT)
    last = kept.last()
    kept.close()
    expected = at(0.6) if byte % slot in range(12, 16) else at(0.3)  # the padding means nothing
    np.testing.assert_allclose(last.commands, expected.motors, rtol=0.0, atol=1e-12)


def test_another_robot_or_description_is_told(file):
    KeptState(file, ROBOT).close()
    content = yaml_content(shipped_robots()["rfrfr"].read_text())
    content["rod"]["length"] *= 1.01
    for other in (load_robot("rfrfr", modes=6), load_robot(yaml.safe_dump(content))):
        kept = KeptState(file, ROBOT)
        kept.keep(at(0.5), at(0.5).motors)
        kept.close()
        kept = KeptState(file, other)
        assert "another robot or description" in kept.problem
        assert kept.last() is None
        kept.close()


def test_what_another_description_left_stays_until_something_new_is_kept(file):
    """One start with the wrong parameters must not cost the last state."""
    kept = KeptState(file, ROBOT)
    for fraction in (0.3, 0.6):
        kept.keep(at(fraction), at(fraction).motors)
    kept.close()
    # A comment makes it another description: of the same size, so that old slots would pass for new.
    same_size = load_robot(shipped_robots()["rfrfr"].read_text() + "# edited\n")
    others = (load_robot("rfrfr", modes=6), same_size, load_robot("rfrfr", modes=3))
    for other in others:
        kept = KeptState(file, other)
        assert "another robot or description" in kept.problem
        assert kept.last() is None
        kept.close()
    kept = KeptState(file, ROBOT)
    assert not kept.problem
    np.testing.assert_array_equal(kept.last().commands, at(0.6).motors)
    kept.close()
    for other in others:
        kept = KeptState(file, other)
        home = solve_home(other)
        kept.keep(home, home.motors + 0.01)
        kept.close()
        kept = KeptState(file, other)
        np.testing.assert_array_equal(kept.last().commands, home.motors + 0.01)
        kept.close()
        kept = KeptState(file, ROBOT)  # the robot has been elsewhere since
        assert "another robot or description" in kept.problem
        assert kept.last() is None
        kept.close()


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
import sys
from pathlib import Path
import numpy as np
from cpr_core import load_robot, solve_home
from cpr_ros.operation.kept_state import KeptState
robot = load_robot("rfrfr")
home, kept = solve_home(robot), KeptState(Path({str(file)!r}), robot)
for number in range(10**9):
    kept.keep(home, np.full(2, float(number)))
    print(number, flush=True)
"""
    for count in (1, 50, 333):
        process = subprocess.Popen(
            [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True
        )
        for _ in range(count):
            told = int(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
        rest = process.stdout.read().split()
        process.wait()
        told = int(rest[-1]) if rest else told
        kept = KeptState(file, ROBOT)
        last = kept.last()
        kept.close()
        assert last.commands[0] in (told, told + 1)
        np.testing.assert_allclose(last.equilibrium.motors, solve_home(ROBOT).motors)


def test_the_folder_is_that_of_ros(monkeypatch, tmp_path):
    monkeypatch.setenv("ROS_HOME", str(tmp_path))
    assert state_folder("") == tmp_path / "cpr_ros"
    assert state_folder("/var/lib/x").as_posix() == "/var/lib/x"
    monkeypatch.delenv("ROS_HOME")
    monkeypatch.setenv("HOME", "/home/me")
    assert state_folder("").as_posix() == "/home/me/.ros/cpr_ros"


def test_where_a_tracker_is_does_not_matter_and_all_else_does(file):
    """A camera that was calibrated is no other robot: its motors stand where they stood."""
    robots = [
        tracked("rfrfr"),
        tracked("rfrfr", [0.1, 0.2, 1.5, np.pi, 0.0, 0.0], [0.0, 0.0, 0.01, 0.0, 0.0, 0.0]),
        tracked("rfrfr").with_parameters({"rod.young_modulus": 200e9}),
    ]
    for robot, known in zip(robots, (False, True, False), strict=True):
        kept = KeptState(file, robot)
        assert (kept.last() is not None) is known
        assert bool(kept.problem) is (robot is robots[2])
        if robot is robots[0]:
            home = solve_home(robot)
            kept.keep(home, home.motors + 0.01)
        kept.close()


def test_a_disk_that_is_full_is_told_before_anything_is_written(tmp_path, monkeypatch):
    """The file had a hole, and the first motion ended the process with SIGBUS."""
    kept = KeptState(tmp_path / "whole.state", ROBOT)
    kept.close()
    whole = (tmp_path / "whole.state").stat()
    assert 512 * whole.st_blocks >= whole.st_size > 0

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(OSError, match="No space left"):
        KeptState(tmp_path / "other.state", ROBOT)

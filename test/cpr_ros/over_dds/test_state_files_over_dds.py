# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Files of the last state that are damaged, locked or away, and disks that are full."""

import fcntl
import os

import numpy as np
import pytest

from cpr_core import load_robot

pytestmark = pytest.mark.waits(seconds=50)


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


def test_where_no_file_can_be_made_the_operator_says_where_the_robot_is(bench):
    """Killed and started again it went home at once, wherever its robot was."""
    bench.file.parent.touch()
    bench.start(until="")
    bench.process.process.wait(timeout=60.0)
    assert bench.process.process.returncode == 1
    said = bench.process.output()
    assert "start_from:=home, where its motors have to be then" in said
    assert "where the robot is cannot be kept" in said and str(bench.file.parent) in said
    assert bench.commands == []
    bench.start("start_from:=home")
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(2.7, 0.4)
    bench.until_at([2.7, 0.4])


def test_a_disk_that_turns_read_only_does_not_send_the_next_node_back(bench):
    """It began where the robot was before that, and its first command led 0.8 rad back at once."""
    bench.keep(load_robot("rfrfr"))
    disk = os.memfd_create("disk", os.MFD_ALLOW_SEALING)
    os.pwrite(disk, bench.file.read_bytes(), 0)
    bench.file.unlink()
    bench.file.symlink_to(f"/proc/{os.getpid()}/fd/{disk}")
    bench.start()
    bench.client.spin_until(lambda: bench.setpoints.get_subscription_count() > 0)
    bench.send(2.7, 0.4)
    bench.until_at([2.7, 0.4])
    # At rest: a file that is being written is not sealed (EBUSY).
    fcntl.fcntl(disk, fcntl.F_ADD_SEALS, fcntl.F_SEAL_WRITE | fcntl.F_SEAL_SHRINK)
    bench.send(3.5, -0.3)
    bench.until_said("what is in it is old")
    # One step, said again as it is once a second at rest: all that went out has been heard.
    bench.client.spin_until(
        lambda: bench.commands[-1][0] > 2.7 and np.array_equal(*bench.commands[-2:])
    )
    stopped = len(bench.commands)
    bench.send(3.5, -0.3)
    bench.spin(1.2)
    assert len({tuple(command) for command in bench.commands[stopped - 1 :]}) == 1

    def mended():
        bench.file.unlink()
        bench.file.write_bytes(os.pread(disk, 10_000, 0))
        os.close(disk)

    bench.kill(mended)
    bench.start()
    bench.until_heard()
    while not np.array_equal(bench.commands[-1], [3.5, -0.3]):
        bench.send(3.5, -0.3)  # again: the node that was killed may have got the first
        bench.spin(0.2)
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

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The last state of a robot on disk."""

import errno
import fcntl
import os
import shutil
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from helpers.tracked_robots import tracked
from helpers.yaml_content import shipped_content

from cpr_core import CprError, load_robot, solve_forward, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_ros.operation.kept_state import KeptState, state_folder
from cpr_ros.operation.locked_file import link_to_nowhere

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
    np.testing.assert_array_equal(kept.last().commands, found.motors)
    kept.close()


@pytest.fixture(scope="module")
def lives(tmp_path_factory):
    """Files by what was kept in them, with the commands that may be found in a damaged one."""
    file = tmp_path_factory.mktemp("lives") / "node.state"
    commands, lives = [], {}
    for fraction in (None, 0.3, 0.6, 0.9):
        kept = KeptState(file, ROBOT)
        if fraction is not None:
            kept.keep(at(fraction), at(fraction).motors)
            commands.append(at(fraction).motors)
        kept.close()
        lives[len(commands)] = file.read_bytes(), commands[-2:]
    return lives


def changed(content, places, to):
    content = bytearray(content)
    for place in places:
        content[place] = to(content[place])
    return bytes(content)


def half(content, number):
    """Places of the header, or of a slot."""
    slot = (len(content) - HEADER) // 2
    return range(HEADER + number * slot, HEADER + (number + 1) * slot)


HEADER = 92
#: What may happen to a file; each gives some damaged ones.
DAMAGES = {
    "cut": lambda content: [content[:length] for length in range(len(content))],
    "longer": lambda content: [content + bytes(1), content + bytes(4096), 2 * content],
    "flipped": lambda content: [
        changed(content, [place], lambda byte, bit=place % 8: byte ^ (1 << bit))
        for place in range(len(content))
    ],
    "zeros": lambda content: [
        changed(content, range(begin, end), lambda _: 0)
        for begin in range(0, len(content), 20)
        for end in (begin + 20, begin + 200, len(content))
        if end <= len(content)
    ],
    "zeros but for the header": lambda content: [content[:HEADER] + bytes(len(content) - HEADER)],
    "one in every slot": lambda content: [
        changed(
            content, [half(content, 0)[place], half(content, 1)[-1 - place]], lambda byte: byte ^ 4
        )
        for place in range(0, len(half(content, 0)), 3)
    ],
    "random": lambda content: [
        np.random.default_rng(seed).bytes(length)
        for seed in range(9)
        for length in (len(content), 77)
    ],
    "of an earlier version": lambda content: [b"cpr_ros state 1\n" + content[16:]],
}


@pytest.mark.parametrize("count", range(4))
@pytest.mark.parametrize("damage", DAMAGES)
def test_what_is_damaged_is_the_last_state_the_one_before_or_refused(file, lives, damage, count):
    """Nothing was known then, and the first command led to home at once."""
    content, commands = lives[count]
    file.parent.mkdir()
    for damaged in DAMAGES[damage](content):
        if damaged == content:
            continue
        file.write_bytes(damaged)
        kept = KeptState(file, ROBOT)
        assert not kept.problem  # it is not left aside as one of another robot
        if kept.damage:
            assert f"{file} cannot be read, " in kept.damage
            with pytest.raises(CprError, match="may be removed once the motors are at home"):
                kept.last()
            assert kept.last_commands() is None
        else:
            assert any(np.array_equal(kept.last().commands, known) for known in commands)
        kept.close()
        assert file.read_bytes() == damaged


def test_one_slot_is_enough(file, lives):
    """A state that was being written when the process was killed costs only itself."""
    content, commands = lives[3]
    file.parent.mkdir()
    for number, known in ((0, commands[1]), (1, commands[0])):
        file.write_bytes(changed(content, half(content, number), lambda _: 0))
        kept = KeptState(file, ROBOT)
        np.testing.assert_array_equal(kept.last().commands, known)
        kept.close()


@pytest.mark.parametrize("damage", [b"", bytes(5000), b"cpr_ros state 1\n" + bytes(700)])
def test_a_damaged_file_is_made_anew_when_the_robot_is_placed(file, damage):
    file.parent.mkdir()
    file.write_bytes(damage)
    kept = KeptState(file, ROBOT)
    assert kept.damage and not kept.mend()
    assert file.read_bytes() == damage
    kept.keep(at(0.6), at(0.6).motors)
    assert not kept.damage
    for _ in range(2):
        np.testing.assert_array_equal(kept.last().commands, at(0.6).motors)
        kept.close()
        kept = KeptState(file, ROBOT)
    kept.close()


def test_a_file_has_its_name_when_it_is_whole_or_not_at_all(file, monkeypatch):
    """Half of one would be a damaged one."""

    def killed(_file, content, place):
        assert not file.exists()
        os_pwrite(_file, content[:100], place)
        raise KeyboardInterrupt

    os_pwrite = os.pwrite
    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr(os, "pwrite", killed)
        KeptState(file, ROBOT)
    assert not file.exists()
    kept = KeptState(file, ROBOT)
    assert kept.last() is None and not kept.damage
    assert list(file.parent.iterdir()) == [file]
    kept.close()


def test_where_no_links_are_possible_there_is_a_file_too(file, monkeypatch):
    def impossible(*_):
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "link", impossible)
    for _ in range(2):
        kept = KeptState(file, ROBOT)
        assert kept.last() is None and not kept.damage
        kept.close()
    assert list(file.parent.iterdir()) == [file]


def overtaken(call, faster):
    """A call before which somebody does something, once; they may call it too."""
    done = []

    def overtaken_call(*arguments):
        if not done:
            done.append(True)
            faster()
        return call(*arguments)

    return overtaken_call


def test_of_two_nodes_that_make_a_file_at_once_one_is_refused(file, monkeypatch):
    """A renaming would have taken away the file of the first."""
    others = []
    faster = overtaken(os.link, lambda: others.append(KeptState(file, ROBOT)))
    monkeypatch.setattr(os, "link", faster)
    with pytest.raises(BlockingIOError, match="another node of this name"):
        KeptState(file, ROBOT)
    assert not others[0].mend()
    assert list(file.parent.iterdir()) == [file]
    others[0].close()


def test_a_file_that_lost_its_name_before_it_was_locked_is_not_taken(file, monkeypatch):
    """Its lock would keep nobody away."""
    KeptState(file, ROBOT).close()
    others = []

    def make_it_anew():
        file.unlink()
        others.append(KeptState(file, ROBOT))

    monkeypatch.setattr(fcntl, "flock", overtaken(fcntl.flock, make_it_anew))
    with pytest.raises(BlockingIOError, match="another node of this name"):
        KeptState(file, ROBOT)
    others[0].close()


@pytest.mark.parametrize("written", [92, 100, 300, 500, 700])
def test_a_file_that_was_half_taken_over_has_no_state_of_another_robot(file, monkeypatch, written):
    """Of the same size: its slots would be where those of this robot are."""
    for fraction in (0.3, 0.6):
        kept = KeptState(file, ROBOT)
        kept.keep(at(fraction), at(fraction).motors)
        kept.close()
    other, os_pwrite = ROBOT.with_parameters({"rod.density": 7801.0}), os.pwrite
    kept, home = KeptState(file, other), solve_home(other)
    with monkeypatch.context() as patched, pytest.raises(OSError, match="No space left"):
        patched.setattr(os, "pwrite", lambda file, text, at: os_pwrite(file, text[:written], at))
        kept.keep(home, home.motors)
    kept.close()
    kept = KeptState(file, other)
    assert "its checksums are wrong" in kept.damage
    kept.close()


def remove(file):
    file.unlink()


def truncate(file):
    file.write_bytes(b"")


def replace(file):
    other = file.with_name("other")
    other.write_bytes(file.read_bytes())
    other.rename(file)


def remove_folder(file):
    shutil.rmtree(file.parent)


def move(file):
    file.rename(file.with_name("moved"))


def spoil_slot(file):
    file.write_bytes(changed(file.read_bytes(), [300, 700], lambda byte: byte ^ 1))


OTHERS = [remove, truncate, replace, remove_folder, move, spoil_slot]


@pytest.mark.parametrize("change", OTHERS)
@pytest.mark.parametrize("then_kept", [0, 1, 2])
def test_what_others_do_to_the_file_is_noticed_and_mended(file, change, then_kept):
    """It ended the process with SIGBUS at the next step, or nothing was known afterwards."""
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    assert not kept.mend()
    change(file)
    for fraction in (0.6, 0.9)[:then_kept]:
        kept.keep(at(fraction), at(fraction).motors)
    assert kept.mend() or (change is spoil_slot and then_kept == 2)
    assert not kept.mend()
    with pytest.raises(BlockingIOError):  # the lock is that of the file that is there
        KeptState(file, ROBOT)
    kept.close()
    kept = KeptState(file, ROBOT)
    expected = at((0.3, 0.6, 0.9)[then_kept]).motors
    np.testing.assert_array_equal(kept.last().commands, expected)
    kept.close()


@pytest.mark.parametrize("linked", ["file", "folder"])
def test_where_a_link_leads_the_file_is_made_anew_too(file, linked):
    """It was another node's for ever: the link itself had the name."""
    disk = file.parent.with_name("disk")
    disk.mkdir()
    if linked == "folder":
        file.parent.symlink_to(disk)
    else:
        KeptState(disk / file.name, ROBOT).close()
        file.parent.mkdir()
        file.symlink_to(disk / file.name)
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    (disk / file.name).unlink()
    assert kept.mend() and not kept.mend()
    kept.close()
    assert file.is_symlink() is (linked == "file")
    kept = KeptState(file, ROBOT)
    np.testing.assert_array_equal(kept.last().commands, at(0.3).motors)
    kept.close()


@pytest.mark.parametrize("linked", ["file", "folder"])
def test_a_link_that_is_led_elsewhere_is_followed(file, linked):
    """The disk is replaced, say: the next start looks where the link leads then."""
    disks = [file.parent.with_name(name) for name in ("first", "second")]
    for disk in disks:
        disk.mkdir()
        KeptState(disk / file.name, ROBOT).close()
    link = file.parent if linked == "folder" else file
    targets = [disk if linked == "folder" else disk / file.name for disk in disks]
    link.parent.mkdir(exist_ok=True)
    link.symlink_to(targets[0])
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    link.unlink()
    link.symlink_to(targets[1])
    kept.keep(at(0.6), at(0.6).motors)
    assert kept.mend() and not kept.mend()
    kept.close()
    kept = KeptState(file, ROBOT)
    np.testing.assert_array_equal(kept.last().commands, at(0.6).motors)
    kept.close()


@pytest.mark.parametrize("linked", ["file", "folder", "above"])
def test_a_link_that_leads_nowhere_is_no_new_file(tmp_path, linked):
    """What it leads to may be away for now, and know where the robot is."""
    file = tmp_path / "above" / "folder" / "node.state"
    link = {"file": file, "folder": file.parent, "above": file.parent.parent}[linked]
    link.parent.mkdir(parents=True, exist_ok=True)
    link.symlink_to(tmp_path / "away" / "state")
    assert link_to_nowhere(file) == link
    with pytest.raises(FileNotFoundError, match="a link that leads nowhere") as caught:
        KeptState(file, ROBOT)
    assert caught.value.filename == str(link)
    assert not (tmp_path / "away").exists()


def test_links_that_go_in_a_circle_are_no_new_file_either(file):
    file.parent.mkdir()
    file.symlink_to(file)
    assert link_to_nowhere(file) is None
    with pytest.raises(OSError, match="levels of symbolic links"):
        KeptState(file, ROBOT)


@pytest.mark.parametrize("then_kept", [1, 2])
def test_a_node_killed_after_its_file_was_truncated_is_not_one_that_knows_nothing(file, then_kept):
    """Before it was mended."""
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    truncate(file)
    for fraction in (0.6, 0.9)[:then_kept]:
        kept.keep(at(fraction), at(fraction).motors)
    kept.close()
    kept = KeptState(file, ROBOT)
    assert "does not begin as a file of this version" in kept.damage
    kept.close()


def test_a_removed_file_that_another_node_has_made_again_is_left_to_it(file):
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    file.unlink()
    other = KeptState(file, ROBOT)
    with pytest.raises(BlockingIOError, match="another node of this name"):
        kept.mend()
    kept.keep(at(0.6), at(0.6).motors)  # to nobody's harm
    assert other.last() is None
    other.close()
    assert kept.mend()
    kept.close()
    kept = KeptState(file, ROBOT)
    np.testing.assert_array_equal(kept.last().commands, at(0.6).motors)
    kept.close()


@pytest.mark.parametrize("written", [None, 0, 30])
def test_what_could_not_be_written_is_an_error_and_is_written_later(file, monkeypatch, written):
    """With a memory map it was SIGBUS."""
    os_pwrite = os.pwrite

    def full(target, content, place):
        if written is None:
            raise OSError(errno.ENOSPC, "No space left on device")
        return os_pwrite(target, content[:written], place) if written else 0

    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    with monkeypatch.context() as patched:
        patched.setattr(os, "pwrite", full)
        for _ in range(3):
            with pytest.raises(OSError, match="No space left"):
                kept.keep(at(0.6), at(0.6).motors)
        with pytest.raises(OSError, match="No space left"):
            kept.mend()
    assert kept.mend()
    kept.close()
    kept = KeptState(file, ROBOT)
    np.testing.assert_array_equal(kept.last().commands, at(0.6).motors)
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


def test_another_robot_or_description_is_told(file):
    KeptState(file, ROBOT).close()
    content = shipped_content("rfrfr")
    content["rod"]["length"] *= 1.01
    for other in (load_robot("rfrfr", modes=6), load_robot(yaml.safe_dump(content))):
        kept = KeptState(file, ROBOT)
        kept.keep(at(0.5), at(0.5).motors)
        kept.close()
        kept = KeptState(file, other)
        assert "another description" in kept.problem
        assert kept.last() is None
        kept.close()


def renamed(name, old="rfrfr", new="other"):
    content = shipped_content(name)
    content["name"] = new
    return load_robot(yaml.safe_dump(content))


def test_motors_stand_where_they_were_sent_whatever_is_said_of_their_robot(file):
    """A calibration moved them home with the next command, one radian at once."""
    calibrated = ROBOT.with_parameters({"rod.density": 7801.0})
    for other in (calibrated, load_robot("rfrfr", modes=6), load_robot("rfrfr", modes=3)):
        kept = KeptState(file, ROBOT)
        for fraction in (0.2, 0.5):
            kept.keep(at(fraction), at(fraction).motors + 0.01)
        assert kept.commands_before is None
        kept.close()
        kept = KeptState(file, other)
        np.testing.assert_array_equal(kept.commands_before, at(0.5).motors + 0.01)
        np.testing.assert_array_equal(kept.last_commands(), at(0.5).motors + 0.01)
        home = solve_home(other)
        kept.keep(home, home.motors)
        assert kept.commands_before is None
        np.testing.assert_array_equal(kept.last_commands(), home.motors)
        kept.close()


def test_motors_that_were_lost_are_lost_for_another_description_too(file):
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.5), None)
    kept.close()
    kept = KeptState(file, load_robot("rfrfr", modes=6))
    assert np.isnan(kept.commands_before).all()
    assert kept.last_commands() is None
    kept.close()


@pytest.mark.parametrize(
    "other", [lambda: renamed("rfrfr"), lambda: renamed("three_rfs", new="rfrfr")]
)
def test_motors_of_another_robot_tell_nothing(file, other):
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.5), at(0.5).motors)
    kept.close()
    kept = KeptState(file, other())
    assert "another robot" in kept.problem
    assert kept.commands_before is None and kept.last_commands() is None
    kept.close()


@pytest.mark.parametrize("length", [0, 1, 8])
def test_a_cut_file_of_another_description_tells_nothing(file, length):
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.5), at(0.5).motors)
    kept.close()
    file.write_bytes(file.read_bytes()[: HEADER + length])
    kept = KeptState(file, load_robot("rfrfr", modes=6))
    assert kept.commands_before is None and kept.last_commands() is None
    kept.close()


def test_a_comment_is_no_other_description(file):
    """Commands jumped home after somebody had noted something in the file."""
    text = shipped_robots()["rfrfr"].read_text()
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.5), at(0.5).motors)
    kept.close()
    for same in (text + "# edited\n", "# edited\n" + text, text.replace(", ", ",   ")):
        assert same != text
        kept = KeptState(file, load_robot(same))
        assert not kept.problem
        np.testing.assert_array_equal(kept.last().commands, at(0.5).motors)
        kept.close()


def test_what_another_description_left_stays_until_something_new_is_kept(file):
    """One start with the wrong parameters must not cost the last state."""
    kept = KeptState(file, ROBOT)
    for fraction in (0.3, 0.6):
        kept.keep(at(fraction), at(fraction).motors)
    kept.close()
    # A description of the same size, so that old slots would pass for new.
    same_size = ROBOT.with_parameters({"rod.density": 7801.0})
    others = (load_robot("rfrfr", modes=6), same_size, load_robot("rfrfr", modes=3))
    for other in others:
        kept = KeptState(file, other)
        assert "another description" in kept.problem
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
        assert "another description" in kept.problem
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
    """Also where there is a file: it may have holes."""
    kept = KeptState(tmp_path / "whole.state", ROBOT)
    kept.close()
    whole = (tmp_path / "whole.state").stat()
    assert 512 * whole.st_blocks >= whole.st_size > 0

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", full)
    for name in ("whole.state", "other.state"):
        with pytest.raises(OSError, match="No space left"):
            KeptState(tmp_path / name, ROBOT)
    assert [file.name for file in tmp_path.iterdir()] == ["whole.state"]

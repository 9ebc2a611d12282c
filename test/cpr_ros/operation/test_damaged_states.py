# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A file of the last state that is damaged, cut or half written: it never seems to know nothing."""

import os

import numpy as np
import pytest
from helpers.kept_states import HEADER, ROBOT, at, changed_bytes

from cpr_core import CprError, solve_home
from cpr_ros.operation.kept_state import KeptState


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


def half(content, number):
    """Places of the header, or of a slot."""
    slot = (len(content) - HEADER) // 2
    return range(HEADER + number * slot, HEADER + (number + 1) * slot)


#: What may happen to a file; each gives some damaged ones.
DAMAGES = {
    "cut": lambda content: [content[:length] for length in range(len(content))],
    "longer": lambda content: [content + bytes(1), content + bytes(4096), 2 * content],
    "flipped": lambda content: [
        changed_bytes(content, [place], lambda byte, bit=place % 8: byte ^ (1 << bit))
        for place in range(len(content))
    ],
    "zeros": lambda content: [
        changed_bytes(content, range(begin, end), lambda _: 0)
        for begin in range(0, len(content), 20)
        for end in (begin + 20, begin + 200, len(content))
        if end <= len(content)
    ],
    "zeros but for the header": lambda content: [content[:HEADER] + bytes(len(content) - HEADER)],
    "one in every slot": lambda content: [
        changed_bytes(
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
        file.unlink(missing_ok=True)  # to shorten one that is there waits for the disk, 20 s in all
        file.write_bytes(damaged)
        kept = KeptState(file, ROBOT)
        assert not kept.problem  # it is not left aside as one of another robot
        if kept.damage:
            assert f"{file} cannot be read, " in kept.damage
            with pytest.raises(CprError, match="may be removed once the motors are at home"):
                kept.last()
            assert kept.last_commands() is None
        else:
            assert any(np.array_equal(kept.last().motors, known) for known in commands)
        kept.close()
        assert file.read_bytes() == damaged


def test_one_slot_is_enough(file, lives):
    """A state that was being written when the process was killed costs only itself."""
    content, commands = lives[3]
    file.parent.mkdir()
    for number, known in ((0, commands[1]), (1, commands[0])):
        file.write_bytes(changed_bytes(content, half(content, number), lambda _: 0))
        kept = KeptState(file, ROBOT)
        np.testing.assert_array_equal(kept.last().motors, known)
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
        np.testing.assert_array_equal(kept.last().motors, at(0.6).motors)
        kept.close()
        kept = KeptState(file, ROBOT)
    kept.close()


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


def test_a_damaged_file_that_was_removed_as_it_may_be_is_there_as_soon_as_something_is_kept(file):
    """A node that was killed before it looked after its file left none."""
    file.parent.mkdir()
    file.write_bytes(bytes(500))
    kept = KeptState(file, ROBOT)
    assert "may be removed" in kept.damage
    file.unlink()
    kept.keep(at(0.6), at(0.6).motors)
    kept.close()
    kept = KeptState(file, ROBOT)
    np.testing.assert_array_equal(kept.last().motors, at(0.6).motors)
    kept.close()

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a node says of where its robot was, by what there is instead of a file with that."""

import errno
import os
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.drive import robot

from cpr_core import load_robot, solve_forward
from cpr_ros.operation.kept_state import KeptState, KnownPlace
from cpr_ros.operation.place_memory import PlaceMemory

ROBOT = robot("rfrfr")


@pytest.fixture
def file(tmp_path):
    return tmp_path / "cpr_node.state"


@pytest.fixture
def said():
    return []


@pytest.fixture
def remember(file, said):
    """Open the memory of a node."""
    opened = []

    def made():
        log = SimpleNamespace(warning=said.append, info=said.append)
        opened.append(PlaceMemory(file, ROBOT, log))
        return opened[-1]

    yield made
    for memory in opened:
        memory.close()


def place(motor):
    found = solve_forward(ROBOT, [motor, 0.4])
    return KnownPlace(found, found.motors)


def kept_by(file, of, motors):
    """A file in which another node has kept where its robot is; it has it still."""
    other, found = KeptState(file, of), solve_forward(of, motors)
    other.keep(found, found.motors)
    return other


def full(monkeypatch):
    monkeypatch.setattr(os, "pwrite", lambda *_: 0)


def read_only(monkeypatch):
    def refused(*_):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(os, "pwrite", refused)
    monkeypatch.setattr(os, "ftruncate", refused)


def closed(monkeypatch):
    def refused(path, **_):
        raise PermissionError(path)

    monkeypatch.setattr(os, "stat", refused)


@pytest.mark.parametrize("there", ["taken", "leads nowhere", "closed"])
def test_where_a_file_that_cannot_be_read_may_know_more_the_robot_is_lost(
    file, remember, said, monkeypatch, there
):
    other = kept_by(file, ROBOT, [2.7, 0.4])
    if there == "leads nowhere":  # the disk of its target is away for now
        file.unlink()
        file.symlink_to(file.with_name("away"))
    elif there == "closed":
        closed(monkeypatch)
    memory = remember()
    assert memory.lost.startswith("the last state cannot be read")
    assert memory.last() is None and memory.last_commands() is None
    assert len(said) == 1 and "tried again every second" in said[0]
    other.close()


@pytest.mark.parametrize("there", ["a file for its folder", "no space"])
def test_where_there_can_be_no_file_nobody_knows(file, remember, said, monkeypatch, there):
    """A node that was killed began at home again, wherever its robot was."""
    if there == "no space":
        full(monkeypatch)
    else:
        file.parent.rmdir()
        file.parent.touch()
    assert remember().lost.startswith("where the robot is cannot be kept")
    assert len(said) == 1 and "will not be kept" in said[0]


def test_a_damaged_file_is_told_and_the_robot_lost(file, remember, said):
    file.write_bytes(bytes(700))
    assert "is damaged" in remember().lost
    assert len(said) == 1 and "the last state is not used" in said[0]


def test_a_file_of_another_description_is_told_and_its_commands_are_known(file, remember, said):
    kept_by(file, load_robot("rfrfr", modes=7), [2.7, 0.4]).close()
    memory = remember()
    assert memory.lost == ""
    assert len(said) == 1 and "is of another description" in said[0]
    np.testing.assert_array_equal(memory.commands_before, [2.7, 0.4])


def test_a_place_that_is_passed_over_is_not_written_but_the_next_is(file, remember):
    kept_by(file, ROBOT, [3.0, 0.3]).close()
    memory, elsewhere = remember(), place(2.7)
    before = file.read_bytes()
    memory.pass_over(elsewhere)
    memory.keep(elsewhere)
    assert file.read_bytes() == before
    memory.keep(place(2.8))
    assert file.read_bytes() != before


def test_what_others_do_to_the_file_is_told_and_what_cannot_be_mended_once(
    file, remember, said, monkeypatch
):
    memory, here = remember(), place(2.7)
    memory.keep(here)
    whole = file.read_bytes()
    file.unlink()
    memory.look_after_file(here)
    assert file.read_bytes() == whole
    assert len(said) == 1 and "it is made anew" in said[0]
    file.unlink()
    full(monkeypatch)
    for _ in range(3):
        memory.look_after_file(here)
    assert len(said) == 2 and "cannot be kept" in said[1]


def test_what_cannot_be_written_any_more_is_not_left_for_the_next_start(
    file, remember, said, monkeypatch
):
    """The next node began where the robot had been before the disk was full, and jumped."""
    memory = PlaceMemory(file, ROBOT, SimpleNamespace(warning=said.append))
    memory.keep(place(2.7))
    with monkeypatch.context() as disk:
        full(disk)
        memory.keep(place(2.8))
    assert "has to be measured when the node starts again" in said[-1]
    assert memory.outdated == ""
    memory.close()
    assert file.stat().st_size == 0
    assert "cannot be read" in remember().lost


def test_a_removed_file_that_cannot_be_made_anew_is_said_to_leave_nothing(
    file, remember, said, monkeypatch
):
    memory, last = remember(), place(2.7)
    memory.keep(last)
    file.unlink()
    full(monkeypatch)
    memory.look_after_file(last)
    assert said[-1].endswith(
        "the robot has to be measured when the node starts again, or is taken to be at home"
    )
    assert memory.outdated == ""


def test_what_can_neither_be_written_nor_taken_away_is_outdated_until_it_can(
    file, remember, said, monkeypatch
):
    last = place(2.8)
    memory = PlaceMemory(file, ROBOT, SimpleNamespace(warning=said.append))
    memory.keep(place(2.7))
    with monkeypatch.context() as disk:
        read_only(disk)
        memory.keep(last)
        memory.look_after_file(last)
        assert "Read-only file system; what is in it is old" in memory.outdated
        assert len(said) == 1 and "nothing moves that is not measured" in said[0]
    memory.look_after_file(last)
    assert memory.outdated == ""
    memory.close()
    np.testing.assert_array_equal(remember().last_commands(), last.motors)


def test_a_file_that_is_as_it_should_be_is_left_so_where_its_folder_is_closed(
    file, remember, said, monkeypatch
):
    memory, last = remember(), place(2.7)
    memory.keep(last)
    whole = file.read_bytes()
    with monkeypatch.context() as folder:
        closed(folder)
        memory.look_after_file(last)
    assert len(said) == 1 and "cannot be kept" in said[0]
    assert memory.outdated == "" and file.read_bytes() == whole


def test_only_what_is_missed_four_times_in_a_row_is_made_anew(file, remember):
    """The node that has it may be about to mend it."""
    other = kept_by(file, ROBOT, [3.0, 0.3])
    memory, here = remember(), place(2.7)
    memory.keep(here)
    for looks in (3, 4):
        file.unlink()
        for number in range(1, looks + 1):
            memory.look_after_file(here)
            assert file.exists() == (number == 4)
        if looks == 3:
            assert other.mend()
            memory.look_after_file(here)
    other.close()

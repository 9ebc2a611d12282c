# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A state file that could not be had at the start, without ROS."""

import os
import time
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from cpr_core import load_robot, solve_forward, solve_home
from cpr_ros.operation import place_memory
from cpr_ros.operation.kept_state import KeptState, KnownPlace
from cpr_ros.operation.place_memory import PlaceMemory

ROBOT = load_robot("rfrfr")


def at(*motors):
    return solve_forward(ROBOT, motors)


def closed_folder(path, **options):
    raise PermissionError(path)


class Late:
    """What a node remembers whose file another one has."""

    def __init__(self, folder):
        self.said = []
        self.file = folder / "cpr_node.3.state"
        self.other = KeptState(self.file, ROBOT)
        log = SimpleNamespace(warning=self.said.append, info=self.said.append)
        self.memory, self.place = PlaceMemory(self.file, ROBOT, log), None

    def others(self, *motors, before=0.0):
        """The other node moves, some time before now [s]."""
        found = at(*motors)
        self.other.keep(found, found.motors)
        moment = time.time() - before
        os.utime(self.file, (moment, moment))

    def moves(self, *motors):
        found = at(*motors)
        self.place = KnownPlace(found, found.motors)
        self.memory.keep(self.place)

    def look_after_file(self):
        self.memory.look_after_file(self.place)

    def kept(self):
        """What is in the file, as the next start has it."""
        kept = KeptState(self.file, ROBOT)
        last = kept.last()
        kept.close()
        return None if last is None else last.motors.tolist()


@pytest.fixture
def late(tmp_path):
    return Late(tmp_path)


def test_a_place_that_could_not_be_kept_is_kept_later(late):
    late.others(3.0, 0.3, before=10.0)
    late.moves(2.7, 0.4)
    late.look_after_file()
    late.other.close()
    late.look_after_file()
    assert "is kept in" in late.said[-1]
    late.moves(2.8, 0.4)
    late.memory.close()
    assert late.kept() == [2.8, 0.4]


def test_whoever_wrote_later_knows_better(late, monkeypatch):
    """A node that is inactive has its place of before."""
    late.moves(2.7, 0.4)
    late.others(3.4, -0.2, before=-1.0)
    late.other.close()
    late.look_after_file()
    assert late.kept() == [3.4, -0.2]
    monkeypatch.setattr(place_memory, "KeptState", None)  # it is not opened again
    late.look_after_file()
    monkeypatch.undo()
    assert late.kept() == [3.4, -0.2] and len(late.said) == 1
    os.utime(late.file, (time.time() - 10.0,) * 2)
    late.moves(2.8, 0.4)  # it moves on
    late.look_after_file()
    late.memory.close()
    assert late.kept() == [2.8, 0.4]


@pytest.mark.parametrize("ahead", [-3600.0, 3600.0])
def test_no_clock_tells_who_knows_better(late, ahead):
    """It was set meanwhile, or the disk has one of its own: the place of now was never kept."""
    late.others(3.0, 0.3, before=-ahead)
    late.moves(2.7, 0.4)
    late.other.close()
    late.look_after_file()
    late.memory.close()
    assert late.kept() == [2.7, 0.4]


@pytest.mark.parametrize("ahead", [-3600.0, 3600.0])
def test_whoever_wrote_later_knows_better_by_any_clock(late, ahead):
    late.moves(2.7, 0.4)
    late.others(3.4, -0.2, before=-ahead)
    late.other.close()
    late.look_after_file()
    assert late.kept() == [3.4, -0.2]


@pytest.mark.parametrize(("before", "expected"), [(-1.0, [3.4, -0.2]), (10.0, [2.7, 0.4])])
def test_where_nobody_could_look_the_clock_tells(late, monkeypatch, before, expected):
    """The folder was closed then."""
    late.others(3.4, -0.2, before=before)
    with monkeypatch.context() as closed:
        closed.setattr(os, "stat", closed_folder)
        late.moves(2.7, 0.4)
    late.other.close()
    late.look_after_file()
    late.memory.close()
    assert late.kept() == expected


def test_where_nothing_is_known_nothing_is_made(late):
    """An empty file would be that of a robot that never moved: it begins at home."""
    late.other.close()
    late.file.unlink()
    late.look_after_file()
    assert not late.file.exists() and len(late.said) == 1
    late.moves(2.7, 0.4)
    late.place, place = None, late.place
    for _ in range(5):
        late.look_after_file()
    assert not late.file.exists()
    late.place = place
    for _ in range(5):  # for as long as a node that has it may take to mend it
        late.look_after_file()
    late.memory.close()
    assert late.kept() == [2.7, 0.4]


def test_an_empty_file_knows_nothing_better(late):
    """Another node has made it since, and its robot never moved."""
    late.moves(2.7, 0.4)
    late.other.close()
    late.file.unlink()
    KeptState(late.file, ROBOT).close()
    late.look_after_file()
    late.memory.close()
    assert late.kept() == [2.7, 0.4]


def test_to_open_a_file_is_not_to_write_it(late):
    """The other node is configured again, say, and does not move."""
    late.others(3.0, 0.3, before=10.0)
    written = late.file.stat().st_mtime_ns
    late.moves(2.7, 0.4)
    late.other.close()
    KeptState(late.file, ROBOT).close()
    assert late.file.stat().st_mtime_ns == written
    late.look_after_file()
    late.memory.close()
    assert late.kept() == [2.7, 0.4]


def test_a_file_that_is_removed_is_left_to_the_node_that_has_it(late):
    """It was made anew with a place of before, and that node could not mend it any more."""
    late.moves(2.7, 0.4)
    late.others(3.4, -0.2, before=-1.0)
    late.file.unlink()
    late.look_after_file()
    assert late.other.mend()
    os.utime(late.file, (time.time() + 1.0,) * 2)
    for _ in range(5):
        late.look_after_file()
    late.other.close()
    late.look_after_file()
    assert late.kept() == [3.4, -0.2]


@pytest.mark.parametrize("what", ["another robot", "another description", "damaged"])
def test_what_is_not_of_this_robot_is_left_alone(late, what):
    late.other.close()
    late.file.unlink()
    if what == "damaged":
        late.file.write_bytes(bytes(700))
    else:
        robot = load_robot("six_rfs") if what == "another robot" else load_robot("rfrfr", modes=7)
        home = solve_home(robot)
        other = KeptState(late.file, robot)
        other.keep(home, home.motors)
        other.close()
    os.utime(late.file, (1.0, 1.0))
    content = late.file.read_bytes()
    late.moves(2.7, 0.4)
    late.look_after_file()
    assert late.file.read_bytes() == content and len(late.said) == 1
    KeptState(late.file, ROBOT).close()  # it is free for whoever else has it


def test_a_full_disk_is_not_said_to_keep_it(late, monkeypatch):
    late.other.close()
    late.moves(2.7, 0.4)
    monkeypatch.setattr(os, "pwrite", lambda *_: 0)
    os.utime(late.file, (1.0, 1.0))
    late.look_after_file()
    assert "cannot be kept" in late.said[-1]
    assert np.all(["is kept in" not in said for said in late.said])


def test_a_disk_that_fails_again_is_told_again(late, monkeypatch):
    late.other.close()
    late.moves(2.7, 0.4)
    late.look_after_file()
    for number in (1, 2):
        with monkeypatch.context() as full:
            full.setattr(os, "pwrite", lambda *_: 0)
            late.moves(2.7, 0.4 + 0.1 * number)
            late.moves(2.8, 0.4 + 0.1 * number)
            assert sum("cannot be kept" in said for said in late.said) == number
        late.look_after_file()
    late.memory.close()
    assert late.kept() == pytest.approx([2.8, 0.6])


def test_only_another_place_is_written(late):
    """Commands under way belong to the equilibrium of before, and a solution has those of before."""
    late.other.close()
    late.moves(2.7, 0.4)
    late.look_after_file()
    first, second = at(2.7, 0.4), at(2.7, 0.4)
    motors, contents = first.motors, []
    for place in (
        (first, motors),
        (first, motors.copy()),
        (first, motors + 0.1),
        (second, motors + 0.1),
        (second, None),
        (second, None),
    ):
        late.memory.keep(KnownPlace(*place))
        contents.append(late.file.read_bytes())
    new = [last != before for before, last in pairwise(contents)]
    assert new == [False, True, True, True, False]

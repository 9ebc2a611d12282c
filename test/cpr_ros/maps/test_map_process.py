# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A map in the making as the node sees it, with a process that does as it is told."""

import os
import signal
import subprocess
from multiprocessing.connection import Connection
from types import SimpleNamespace

import pytest
from helpers.map_orders import small_order
from helpers.workspace_cases import small_map

from cpr_core.workspace import summary_of
from cpr_core.workspace.map_files import unfinished_file
from cpr_ros.maps import map_process
from cpr_ros.maps.map_order import MapFailure, MapState
from cpr_ros.maps.map_process import MapProcess
from cpr_ros.maps.map_worker import PATIENCE


class Worker:
    """In place of a process: its end of the connection, and how it ended."""

    pid = 4711

    def __init__(self, command, *, pass_fds, start_new_session, **options):
        assert start_new_session
        assert int(command[-1]) in pass_fds
        self.connection = Connection(os.dup(int(command[-1])))
        self.status = None

    def die(self, status):
        self.status = status
        self.connection.close()

    def poll(self):
        return self.status

    def kill(self):
        if self.status is None:
            self.die(-signal.SIGKILL)

    def wait(self, timeout=None):
        if self.status is None:
            raise subprocess.TimeoutExpired("worker", timeout)
        return self.status


class Watched:
    """A map that is ordered, and the end of its worker."""

    def __init__(self, order):
        self.process = MapProcess(order)
        self.worker = self.process._process
        self.unfinished = unfinished_file(order.file, Worker.pid)

    def told(self, *messages):
        """Whether there is a new state after the worker has said something."""
        for message in messages:
            self.worker.connection.send(message)
        return self.process.look(0.0)


@pytest.fixture
def watched(monkeypatch, tmp_path):
    system = SimpleNamespace(Popen=Worker, TimeoutExpired=subprocess.TimeoutExpired)
    monkeypatch.setattr(map_process, "subprocess", system)
    return Watched(small_order(tmp_path / "map.nc"))


def test_the_newest_state_counts(watched):
    states = [MapState(done, done + 1, 117, 0.0) for done in range(3)]
    assert not watched.told()
    assert watched.process.state is None
    assert watched.told(*states)
    assert watched.process.state == states[-1]
    assert not watched.told()
    assert not watched.process.ended


@pytest.mark.parametrize(
    "resulting",
    [lambda: summary_of(small_map(), 0.0), lambda: MapFailure(ZeroDivisionError, "zero", "")],
    ids=["summary", "failure"],
)
def test_with_its_result_it_ends_and_leaves_nothing_unfinished(watched, resulting):
    result = resulting()
    watched.unfinished.write_text("half a map")
    assert watched.told(MapState(116, 117, 117, 1.0), result)
    assert watched.process.result == result
    assert watched.process.ended
    assert watched.worker.status == -signal.SIGKILL
    assert watched.process.death == ""
    assert not watched.unfinished.exists()


@pytest.mark.parametrize(("status", "death"), [(-signal.SIGSEGV, "SIGSEGV"), (3, "status 3")])
def test_how_it_died_is_told(watched, status, death):
    watched.unfinished.write_text("half a map")
    watched.told(MapState(1, 2, 117, 0.0))
    watched.worker.die(status)
    assert not watched.told()
    assert watched.process.ended
    assert watched.process.death == death
    assert watched.process.result is None
    assert not watched.unfinished.exists()


def test_it_is_told_once_to_stop_and_has_time_to_save(watched):
    process, connection = watched.process, watched.worker.connection
    process.stop(10.0)
    process.stop(10.0 + PATIENCE)
    assert connection.recv() == "stop"
    assert not connection.poll()
    process.look(10.0 + PATIENCE)
    assert not process.ended
    process.look(10.2 + PATIENCE)
    assert process.ended
    assert process.death == ""


def test_an_end_that_was_asked_for_is_no_death(watched):
    watched.process.stop(10.0)
    watched.worker.die(1)
    watched.process.look(10.0)
    assert watched.process.ended
    assert watched.process.death == ""


def test_whoever_is_told_to_stop_may_be_gone(watched):
    watched.worker.die(0)
    watched.process.stop(10.0)
    watched.process.look(10.0)
    assert watched.process.ended


@pytest.mark.parametrize("saves", [False, True])
def test_the_end_of_the_node_waits_for_what_can_be_saved_and_no_longer(watched, saves):
    """What it hears of is the end of the connection."""
    if saves:
        watched.worker.status = 0
    watched.process.close()
    with pytest.raises(EOFError):
        watched.worker.connection.recv()
    assert watched.process.ended
    assert watched.worker.status == (0 if saves else None)
    watched.process.close()


def test_a_file_is_that_of_the_map_once_it_is_put_in_the_place_of_the_one_before(watched, tmp_path):
    file = tmp_path / "map.nc"
    assert not watched.process.written
    file.write_text("a map")
    assert watched.process.written
    later = Watched(small_order(file))
    assert not later.process.written
    assert Watched(small_order(file, resume=True)).process.written
    (tmp_path / "new").write_text("a map")
    (tmp_path / "new").replace(file)
    assert later.process.written
    file.unlink()
    assert not later.process.written

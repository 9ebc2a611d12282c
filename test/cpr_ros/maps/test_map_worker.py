# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the process of a map does with its order, without a process."""

import gc
import io
import multiprocessing
import os
import pickle
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.map_orders import small_order
from helpers.workspace_cases import rfrfr, small_map

from cpr_core import NoInverseSolution
from cpr_core.workspace import pose_grid, summary_of
from cpr_core.workspace.flood import Progress
from cpr_core.workspace.map_files import unfinished_file
from cpr_core.workspace.store import read_map
from cpr_ros.maps import map_worker, map_worker_start
from cpr_ros.maps.map_order import MapFailure, MapState


@pytest.mark.parametrize(("begun", "resume"), [(False, False), (True, False), (False, True)])
def test_who_is_told_to_stop_has_time_to_save_what_there_is(monkeypatch, tmp_path, begun, resume):
    """While kernels were compiled a cancelled map was waited for as long as one that has to be saved."""
    order, slept, left = small_order(tmp_path / "map.nc", resume=resume), [], []
    monkeypatch.setattr(map_worker.time, "sleep", slept.append)
    monkeypatch.setattr(os, "_exit", left.append)
    unfinished = unfinished_file(order.file, os.getpid())
    unfinished.write_text("half")
    ended, making = threading.Event(), threading.Event()
    if begun:
        making.set()
    node, worker = multiprocessing.Pipe()
    node.send("stop")
    map_worker._listen(worker, order, ended, making)
    assert ended.is_set() and left == [1] and not unfinished.exists()
    assert slept == ([map_worker.PATIENCE] if begun or resume else [])


@pytest.fixture
def answers(monkeypatch):
    """What is sent to the node that orders a map."""
    niceness = []
    monkeypatch.setattr(map_worker, "_listen", lambda *node: None)  # it ends its process
    monkeypatch.setattr(os, "nice", niceness.append)

    def answered(order):
        stdin = SimpleNamespace(buffer=io.BytesIO(pickle.dumps(order)))
        monkeypatch.setattr(map_worker.sys, "stdin", stdin)
        node, worker = multiprocessing.Pipe()
        with node:
            assert map_worker.main([str(os.dup(worker.fileno()))]) == 0
            worker.close()
            told = []
            while True:
                try:
                    told.append(node.recv())
                except EOFError:
                    break
        assert niceness == [map_worker.NICENESS]
        return told

    return answered


def test_an_order_is_answered_by_states_and_a_summary_of_the_map_in_the_file(answers, tmp_path):
    order = small_order(tmp_path / "map.nc")
    *states, summary = answers(order)
    found = read_map(order.file, rfrfr())
    np.testing.assert_array_equal(found.reached, small_map().reached)
    assert summary == summary_of(found, order.threshold)
    assert all(isinstance(state, MapState) for state in states)
    assert [state.done for state in states] == sorted(state.done for state in states)
    assert {state.total for state in states} == {117}
    assert states[0].rate == 0.0
    assert states[-1].reached == summary.reached


def test_the_rate_of_a_map_that_is_gone_on_with_counts_what_is_new(answers, tmp_path, monkeypatch):
    """Not what was in its file: the rest would seem to be done in no time."""
    small, times = small_map(), iter([10.0, 12.0])

    def gone_on(*order, progress, **options):
        for done in (100, 110):
            progress(Progress(done, 115, 117))
        return small

    monkeypatch.setattr(map_worker, "map_workspace", gone_on)
    monkeypatch.setattr(map_worker.time, "monotonic", lambda: next(times))
    *states, _ = answers(small_order(tmp_path / "map.nc"))
    assert [(state.done, state.rate) for state in states] == [(100, 0.0), (110, 5.0)]


def test_a_map_that_cannot_be_made_is_answered_by_the_reason_alone(answers, tmp_path):
    far = pose_grid(rfrfr(), {"x": (5.0, 5.1), "y": (5.0, 5.1)}, resolution=0.1)
    (answer,) = answers(small_order(tmp_path / "map.nc", grid=far))
    assert isinstance(answer, MapFailure)
    assert answer.kind is NoInverseSolution
    assert "cells of the grid is reached" in answer.message
    assert list(tmp_path.iterdir()) == []


def test_an_order_that_nobody_foresaw_is_answered_too(answers, tmp_path, capsys):
    """With the traceback in the log, as the node cannot show it."""
    (answer,) = answers(small_order(tmp_path / "map.nc", start=None))
    assert isinstance(answer, MapFailure)
    assert answer.kind is AttributeError
    assert f"AttributeError: {answer.message}" in capsys.readouterr().err


def test_garbage_is_looked_for_in_what_comes_after_the_imports(monkeypatch):
    looked, frozen = [], []

    def make(arguments):
        looked.append((arguments, gc.isenabled(), len(frozen)))
        return 7

    monkeypatch.setattr(map_worker, "main", make)
    monkeypatch.setattr(gc, "freeze", lambda: frozen.append(gc.isenabled()))
    assert map_worker_start.main(["3"]) == 7
    assert looked == [(["3"], True, 1)]
    assert frozen == [False]

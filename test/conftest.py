# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Tests in several processes at once: kernels compiled before, files of a node kept together."""

from __future__ import annotations

import os

# Other cores have workers of their own; and what tests start would make threads of BLAS that wait
# busily, a fifth of its processor time. This has to be known before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import gc
import sys
import tempfile
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any

import pytest
from helpers.browser import NO_BROWSER, running_browser
from helpers.compiled_kernels import compile_beside, compile_kernels
from helpers.own_tree import find_this_tree
from helpers.room import Room
from helpers.scheduling import (  # noqa: F401 (hooks)
    pytest_collection_modifyitems,
    pytest_xdist_auto_num_workers,
    pytest_xdist_make_scheduler,
    waits,
)
from hypothesis import settings

#: What nodes of tests keep is not what those of the user keep.
_ROS_HOME = tempfile.TemporaryDirectory()
os.environ["ROS_HOME"] = _ROS_HOME.name
find_this_tree()  # by whatever tests start
#: Python is started some two hundred times, and takes a fifth longer where it may not keep bytecode.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# No test is about time, as the machine may be busy; what a property draws is the same in every run.
settings.register_profile("any machine", deadline=None, derandomize=True)
settings.load_profile("any machine")

# What is collected stays: looking for garbage in it is a third of collecting, and a tenth of the tests.
gc.disable()


@pytest.hookimpl(tryfirst=True)
def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the kernels once, before workers start that would all do it; on two cores at a time."""
    if getattr(session.config.option, "numprocesses", None):
        compile_beside()


@pytest.hookimpl(trylast=True)
def pytest_collection_finish(session: pytest.Session) -> None:
    """Look for garbage from now on, in what is new."""
    gc.freeze()
    gc.enable()


def pytest_unconfigure(config: pytest.Config) -> None:
    """End with a line that says which tests had no browser, and what they want."""
    terminal = config.pluginmanager.get_plugin("terminalreporter")
    skipped = [] if terminal is None else terminal.stats.get("skipped", [])
    missing = [report for report in skipped if NO_BROWSER in str(report.longrepr)]
    if missing:
        files = sorted({Path(report.fspath).name for report in missing})
        line = f"NOT RUN: {len(missing)} tests of pages ({', '.join(files)}): {NO_BROWSER}"
        terminal.write_line(line)


@pytest.fixture(scope="session")
def browser():
    """One browser for all pages of a worker."""
    with running_browser() as found:
        yield found


@pytest.fixture(scope="session")
def compiled(request: pytest.FixtureRequest) -> None:
    """For a test that allows no time for compiling; before workers start it is done for all of them."""
    if not hasattr(request.config, "workerinput"):
        compile_kernels()


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Tell every worker where all of them meet; the folder goes with the process that starts them."""
    node.workerinput["room"] = _ROS_HOME.name


@pytest.fixture(scope="session")
def _room(request: pytest.FixtureRequest) -> Room:
    """The same for all workers of a run."""
    folder = getattr(request.config, "workerinput", {}).get("room", _ROS_HOME.name)
    return Room(Path(folder) / "room_of_tests")


@pytest.fixture(scope="module", autouse=True)
def _alone(request: pytest.FixtureRequest, _room: Room):
    """Files marked as ``alone`` run as a whole, while no other worker has a node or a page."""
    alone = request.node.get_closest_marker("alone") is not None
    with _room.entered(alone=True) if alone else nullcontext():
        yield alone


@pytest.fixture(autouse=True)
def _with_others(request: pytest.FixtureRequest, _room: Room, _alone: bool):
    """Tests that wait are not together with those alone; those that compute take nobody's time.

    They have what processor time is left: a node or a page is held up by none of them.
    """
    computes = hasattr(request.config, "workerinput") and not waits(request.path)
    if hasattr(os, "SCHED_IDLE"):
        with suppress(PermissionError):  # not everybody may take it back
            os.sched_setscheduler(
                0, os.SCHED_IDLE if computes else os.SCHED_OTHER, os.sched_param(0)
            )
    with nullcontext() if _alone or computes else _room.entered(alone=False):
        yield

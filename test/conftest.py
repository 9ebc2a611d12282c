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
from contextlib import nullcontext
from pathlib import Path

import pytest
from helpers.browser import NO_BROWSER, running_browser
from helpers.compiled_kernels import compile_beside, compile_kernels
from helpers.own_tree import find_this_tree
from helpers.room import Room
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

#: Folders whose tests wait for most of their time, for a node or a page.
_WAITING = ("over_dds", "viewing")
#: Folders whose files begin with what takes long: a node, a page, compiled kernels, references.
_TOGETHER = (*_WAITING, "kernels", "verification")
#: Processor time of a slow test that does not say it [s].
_SLOW = 10.0


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


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Three more than cores: tests of nodes and pages wait for most of their time."""
    return _cores() + 3


def _cores() -> int:
    return len(os.sched_getaffinity(0))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with tests that are to be alone, go on with what waits, then the longest first."""
    alone = {item.path for item in items if item.get_closest_marker("alone")}
    items.sort(
        key=lambda item: (
            item.path not in alone,
            not _waits(item.path),
            item.path.parent.name not in _TOGETHER,
            -max(_seconds(item.get_closest_marker(mark)) for mark in ("slow", "waits")),
        )
    )


def _waits(file: Path) -> bool:
    """Whether the tests of a file wait for most of their time."""
    return file.parent.name in _WAITING


def _seconds(mark: pytest.Mark | None) -> float:
    """How long a test takes, or its file, roughly."""
    return mark.kwargs.get("seconds", _SLOW) if mark else 0.0


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """Files of tests that share what takes long are not taken apart; tests alone stay together.

    As many workers as there are cores compute, the others have tests that wait for nodes and pages, as
    long as there are any. The mark ``xdist_group`` would say which belong together, but pytest-xdist 3.8
    does not see it with pytest 9.2.
    """
    from xdist.scheduler import LoadScopeScheduling

    folder = Path(__file__).parent / "cpr_ros" / "over_dds"
    alone = {file.name for file in folder.glob("test_*.py") if "mark.alone(" in file.read_text()}

    def waits(scope: str) -> bool:
        return scope == "alone" or _waits(Path(scope.partition("::")[0]))

    class ByRole(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            if Path(file).parent.name not in _TOGETHER:
                return nodeid
            return "alone" if file.rpartition("/")[2] in alone else file

        def mark_test_complete(self, node: object, item_index: int, duration: float = 0) -> None:
            super().mark_test_complete(node, item_index, duration)
            units = self.assigned_work[node]
            for done in [scope for scope, tests in units.items() if all(tests.values())]:
                del units[done]  # else all of them are counted after every test

        def _assign_work_unit(self, node: object) -> None:
            if _computes(node.gateway.id, len(self.nodes)):
                computing = (scope for scope in self.workqueue if not waits(scope))
                if (longest := next(computing, None)) is not None:
                    self.workqueue.move_to_end(longest, last=False)
            super()._assign_work_unit(node)

    config.option.loadscopereorder = False
    return ByRole(config, log)


def _computes(worker: str, workers: int) -> bool:
    """Whether a worker has tests that compute from the beginning: the last ones do."""
    return workers > _cores() and int(worker.removeprefix("gw")) >= workers - _cores()


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


@pytest.fixture(scope="session")
def _room(request: pytest.FixtureRequest) -> Room:
    """The same for all workers of a run."""
    run = getattr(request.config, "workerinput", {}).get("testrunuid", f"process_{os.getpid()}")
    return Room(Path(tempfile.gettempdir()) / f"cpr_ros_tests_{run}")


@pytest.fixture(scope="module", autouse=True)
def _alone(request: pytest.FixtureRequest, _room: Room):
    """Files marked as ``alone`` run as a whole, while no other worker has a node or a page."""
    alone = request.node.get_closest_marker("alone") is not None
    with _room.entered(alone=True) if alone else nullcontext():
        yield alone


@pytest.fixture(autouse=True)
def _with_others(request: pytest.FixtureRequest, _room: Room, _alone: bool):
    """Tests that wait are not together with those alone; those that compute take nobody's time.

    They have what processor time is left from then on: a node or a page is held up by none of them.
    """
    computes = hasattr(request.config, "workerinput") and not _waits(request.path)
    if computes and hasattr(os, "SCHED_IDLE"):
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    with nullcontext() if _alone or computes else _room.entered(alone=False):
        yield

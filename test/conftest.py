# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Tests in several processes at once: kernels compiled before, modules of a node kept together."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from helpers.everything import EVERYTHING
from helpers.room import Room
from threadpoolctl import threadpool_limits

#: What nodes of tests keep is not what those of the user keep.
_ROS_HOME = tempfile.TemporaryDirectory()
os.environ["ROS_HOME"] = _ROS_HOME.name


@pytest.hookimpl(tryfirst=True)
def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the kernels once, before workers start that would all do it; on two cores at a time.

    Whatever else had to be compiled afterwards, `cpr compile` has forgotten; tests would fill the gap.
    """
    if not getattr(session.config.option, "numprocesses", None):
        return
    folders = (session.config.rootpath, Path(__file__).parent, os.environ.get("PYTHONPATH", ""))
    path = os.pathsep.join(str(folder) for folder in folders if str(folder))
    with subprocess.Popen(
        [sys.executable, "-m", "helpers.compiled_beside"], env=os.environ | {"PYTHONPATH": path}
    ) as beside:
        compiling = [sys.executable, "-m", "cpr_core.command_line", "compile"]
        told = subprocess.run(compiling, check=True, stdout=subprocess.PIPE, text=True).stdout
        if "kernels compiled in" in told:
            everything = [sys.executable, "-c", EVERYTHING]
            left = subprocess.run(everything, check=True, stdout=subprocess.PIPE, text=True).stdout
            assert json.loads(left) == [], f"`cpr compile` has left out {left}"
    assert beside.returncode == 0, "what `cpr compile` comes to last was not compiled beside it"


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with tests that are to be alone: the tests that others begin with are short to wait for."""
    alone = {item.path for item in items if item.get_closest_marker("alone")}
    items.sort(key=lambda item: item.path not in alone)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """One worker runs all tests that start nodes: two nodes at work leave no core to those who watch.

    The mark ``xdist_group`` would say the same, but pytest-xdist 3.8 does not see it with pytest 9.2.
    """
    from xdist.scheduler import LoadScopeScheduling

    class NodesTogether(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return "nodes" if "/over_dds/" in nodeid else nodeid

    return NodesTogether(config, log)


@pytest.fixture(scope="session", autouse=True)
def _one_blas_thread_in_a_worker(request: pytest.FixtureRequest):
    """Other cores have workers of their own, from which waiting threads of BLAS would keep them."""
    with threadpool_limits(1 if hasattr(request.config, "workerinput") else None, user_api="blas"):
        yield


@pytest.fixture(scope="session")
def _room(request: pytest.FixtureRequest) -> Room:
    """The same for all workers of a run."""
    run = getattr(request.config, "workerinput", {}).get("testrunuid", f"process_{os.getpid()}")
    return Room(Path(tempfile.gettempdir()) / f"cpr_ros_tests_{run}")


@pytest.fixture(autouse=True)
def _alone_or_with_others(request: pytest.FixtureRequest, _room: Room):
    """Tests marked as ``alone`` run while no other worker runs a test."""
    with _room.entered(alone=request.node.get_closest_marker("alone") is not None):
        yield

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Which worker runs which test, and when: the hooks of pytest-xdist for these tests."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

#: Folders whose tests wait for most of their time, for a node, a page or a process that is begun.
_WAITING = ("over_dds", "viewing", "process", "middleware")
#: Folders whose files begin with what takes long: a node, a page, compiled kernels, references.
_TOGETHER = (*_WAITING, "kernels", "verification")
#: Processor time of a slow test that does not say it [s].
_SLOW = 10.0


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
            not waits(item.path),
            item.path.parent.name not in _TOGETHER,
            -max(_seconds(item.get_closest_marker(mark)) for mark in ("slow", "waits")),
        )
    )


def waits(file: Path) -> bool:
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

    folder = Path(__file__).parents[1] / "cpr_ros" / "over_dds"
    alone = {file.name for file in folder.glob("test_*.py") if "mark.alone(" in file.read_text()}

    def unit_waits(scope: str) -> bool:
        return scope == "alone" or waits(Path(scope.partition("::")[0]))

    class ByRole(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            if Path(file).parent.name not in _TOGETHER:
                return nodeid
            return "alone" if file.rpartition("/")[2] in alone else file

        def mark_test_complete(self, node: Any, item_index: int, duration: float = 0) -> None:
            super().mark_test_complete(node, item_index, duration)
            units = self.assigned_work[node]
            for done in [scope for scope, tests in units.items() if all(tests.values())]:
                del units[done]  # else all of them are counted after every test

        def remove_node(self, node: Any) -> str | None:
            """Take away a worker that crashed; others run what it had left, but not what crashed it.

            Of itself pytest-xdist 3.8 runs that again, until no worker may be started any more.
            """
            units = self.assigned_work.pop(node)
            left = [(tests, name) for tests in units.values() for name in tests if not tests[name]]
            if not left:
                return None
            tests, crashed = left[0]
            tests[crashed] = True
            self.workqueue.update(
                {scope: tests for scope, tests in units.items() if not all(tests.values())}
            )
            for other in self.nodes:
                self._reschedule(other)
            return crashed

        def _assign_work_unit(self, node: Any) -> None:
            if _computes(node.gateway.id, len(self.nodes)):
                computing = (scope for scope in self.workqueue if not unit_waits(scope))
                if (longest := next(computing, None)) is not None:
                    self.workqueue.move_to_end(longest, last=False)
            super()._assign_work_unit(node)

    config.option.loadscopereorder = False
    return ByRole(config, log)


def _computes(worker: str, workers: int) -> bool:
    """Whether a worker has tests that compute from the beginning: the last ones do."""
    return workers > _cores() and int(worker.removeprefix("gw")) >= workers - _cores()

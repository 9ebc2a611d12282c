# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Fixtures: one node of a robot for a test module, and a client in its domain; or one for a test."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.driver import Driver
from helpers.node_process import TIME_LIMIT, Running, running_node
from helpers.robot_bench import RobotBench


def _run(tmp_path_factory: pytest.TempPathFactory, robot: str) -> Iterator[Running]:
    folder = tmp_path_factory.mktemp(robot)
    values = (f"robot:={robot}", "max_speed:=4", "map_anywhere:=true", f"time_limit:={TIME_LIMIT}")
    with running_node(folder, *values) as running:
        yield running


@pytest.fixture(scope="module")
def six_rfs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    yield from _run(tmp_path_factory, "six_rfs")


@pytest.fixture(scope="module")
def rfrfr(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    yield from _run(tmp_path_factory, "rfrfr")


@pytest.fixture(scope="module")
def four_rfr(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    yield from _run(tmp_path_factory, "four_rfr")


@pytest.fixture(scope="module")
def planar_body(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    yield from _run(tmp_path_factory, "planar_body")


@pytest.fixture
def drive(rfrfr: Running) -> Iterator[Driver]:
    """The planar robot, idle at home."""
    driver = Driver(rfrfr.client)
    driver.go_home()
    driver.forget()
    try:
        yield driver
    finally:
        driver.close()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[RobotBench]:
    """A robot whose node the test starts and ends."""
    made = RobotBench(tmp_path)
    yield made
    made.close()

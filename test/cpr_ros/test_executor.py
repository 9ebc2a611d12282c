# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Which executor of rclpy the node spins in."""

import sys

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor

from cpr_ros.node_run import _light_executor

EVENTS = "rclpy.experimental.events_executor"


@pytest.fixture
def _ros():
    rclpy.init()
    yield
    rclpy.try_shutdown()


@pytest.mark.usefixtures("_ros")
def test_one_that_waits_for_events_where_rclpy_has_it():
    executor = _light_executor()
    assert not isinstance(executor, SingleThreadedExecutor)
    assert "EventsExecutor" in type(executor).__name__
    executor.shutdown()


@pytest.mark.usefixtures("_ros")
def test_the_ordinary_one_with_an_rclpy_that_has_no_other(monkeypatch):
    monkeypatch.setitem(sys.modules, EVENTS, None)
    executor = _light_executor()
    assert isinstance(executor, SingleThreadedExecutor)
    executor.shutdown()

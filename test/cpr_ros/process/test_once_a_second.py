# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is logged once a second at most."""

from pathlib import Path

from rclpy.clock import Clock
from rclpy.impl.rcutils_logger import Throttle
from rclpy.logging import get_logger
from rclpy.time import Time

import cpr_ros
from cpr_ros.process.once_a_second import ONCE_A_SECOND


class SetBack(Clock):
    """The clock of the computer, which somebody sets back by an hour again and again."""

    hour = 100

    def now(self):
        self.hour -= 1
        return Time(seconds=3600 * self.hour)


def test_errors_are_logged_after_the_clock_was_set_back(monkeypatch):
    """None was for as long as it was set back."""
    monkeypatch.setitem(Throttle.params, "throttle_time_source_type", SetBack())
    at_once = ONCE_A_SECOND | {"throttle_duration_sec": 1e-9}
    logger = get_logger("set_back")
    assert [logger.error("an error", **at_once) for _ in range(3)] == [True] * 3


def test_everything_that_is_logged_once_a_second_is_so():
    folder = Path(cpr_ros.__file__).parent
    using = [file.name for file in folder.rglob("*.py") if "throttle" in file.read_text()]
    assert using == ["once_a_second.py"]

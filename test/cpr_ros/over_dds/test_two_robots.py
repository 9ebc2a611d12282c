# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Two robots on one machine, as docs/node.md says it: apart by namespace and prefix of their frames."""

import re
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from cpr_msgs.msg import StabilityMetrics
from geometry_msgs.msg import PoseStamped
from helpers.driver import Driver
from helpers.node_process import Client, NodeProcess, free_domain
from sensor_msgs.msg import JointState
from visualization_msgs.msg import MarkerArray

HOME = [2.59, 0.55]
PAGE = Path(__file__).parents[3] / "docs" / "node.md"
SIDES = ("left", "right")


def documented() -> dict[str, list[str]]:
    """Arguments of the two commands of the docs, by side."""
    commands = re.findall(
        r"^\.venv/bin/cpr_node --ros-args (.*__ns:=/(\w+).*)$", PAGE.read_text(), re.M
    )
    return {side: arguments.split() for arguments, side in commands}


@contextmanager
def running(folder: Path, domain: int, end: signal.Signals) -> Iterator[dict[str, Driver]]:
    """Both nodes until they are ended in a way, and who drives them; what they keep is in one folder."""
    processes = {
        side: NodeProcess(
            folder / f"{side}.log",
            domain,
            [*arguments, "-p", f"state_directory:={folder}", "-p", "max_speed:=4"],
        )
        for side, arguments in documented().items()
    }
    client = None
    try:
        for process in processes.values():
            process.wait_for_log("ready")
        client = Client(domain)
        yield {side: Driver(client, namespace=f"/{side}") for side in processes}
    finally:
        if client is not None:
            client.close()
        statuses = {process.stop(end) for process in processes.values()}
    assert statuses == {-end if end == signal.SIGKILL else 0}


def frames_of(driver: Driver, side: str) -> set[str]:
    """Of all that a node publishes with a frame."""
    driver.until(lambda: True)
    (markers,) = driver.client.messages(MarkerArray, f"/{side}/cpr_node/leg_markers", 1)
    newest = [driver.all(kind)[-1] for kind in (StabilityMetrics, JointState, PoseStamped)]
    return {message.header.frame_id for message in [*markers.markers, *newest]}


def test_they_share_a_machine_and_nothing_else(tmp_path):
    assert tuple(documented()) == SIDES
    domain = free_domain()
    with running(tmp_path, domain, signal.SIGKILL) as drivers:
        left, right = drivers["left"], drivers["right"]
        left.send_motors(2.65, 0.5)
        left.until(lambda: np.array_equal(left.motors, [2.65, 0.5]))
        right.until(lambda: len(right.all(JointState)) > 5)
        np.testing.assert_array_equal(right.motors, HOME)
        for side, driver in drivers.items():
            assert frames_of(driver, side) == {f"{side}/base"}
        right.pause(True)
        right.until_state(StabilityMetrics.STATE_PAUSED)
        left.send_motors(2.6, 0.5)
        left.until(lambda: np.array_equal(left.motors, [2.6, 0.5]))
    with running(tmp_path, domain, signal.SIGINT) as drivers:
        for side, place in (("left", [2.6, 0.5]), ("right", HOME)):
            drivers[side].until(lambda: True)
            np.testing.assert_array_equal(drivers[side].motors, place)
        drivers["right"].pause(True)
        drivers["right"].until_state(StabilityMetrics.STATE_PAUSED)

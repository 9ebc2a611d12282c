# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The side of somebody who wants a map: goals out, feedback and a result in."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

from cpr_msgs.action import MapWorkspace
from cpr_msgs.msg import MapAxis
from rclpy.action import ActionClient

from helpers.node_process import TIMEOUT, Client

#: A map may have to wait for its kernels to be compiled.
MAP_TIMEOUT = 300.0
#: Maps of the RFRFR robot: 117 cells; some seconds in one thread; not done before a test is.
SMALL = {"x": (-0.6, 0.6, 0.1), "y": (-0.1, 0.7, 0.1)}
MEDIUM = {"x": (-0.9, 0.9, 0.01), "y": (-1.0, 1.0, 0.01)}
LONG = {"x": (-0.9, 0.9, 0.002), "y": (-1.0, 1.0, 0.002)}


class MapClient:
    """A client of ``~/map_workspace``."""

    def __init__(self, client: Client) -> None:
        self.client = client
        self.feedback: list[MapWorkspace.Feedback] = []
        self._action = ActionClient(client.node, MapWorkspace, "/cpr_node/map_workspace")
        assert self._action.wait_for_server(TIMEOUT)

    def close(self) -> None:
        self._action.destroy()

    def send(self, file: Path | str, axes: Any = None, **fields: Any) -> Any:
        goal = MapWorkspace.Goal(
            axes=[
                MapAxis(name=name, first=first, last=last, resolution=step)
                for name, (first, last, step) in (SMALL if axes is None else axes).items()
            ],
            file=str(file),
            **fields,
        )
        self.feedback = []
        sent = self._action.send_goal_async(
            goal, feedback_callback=lambda message: self.feedback.append(message.feedback)
        )
        self.client.spin_until(sent.done)
        assert sent.result().accepted
        return sent.result()

    def result(self, handle: Any) -> Any:
        """Status and result."""
        answer = handle.get_result_async()
        self.client.spin_until(answer.done, MAP_TIMEOUT)
        return answer.result().status, answer.result().result

    def make(self, file: Path | str, axes: Any = None, **fields: Any) -> Any:
        return self.result(self.send(file, axes, **fields))

    def cancel(self, handle: Any) -> int:
        """How many goals are being cancelled."""
        answer = handle.cancel_goal_async()
        self.client.spin_until(answer.done)
        return len(answer.result().goals_canceling)

    def until_done(self, cells: int) -> None:
        """Wait until the map has come so far."""
        self.client.spin_until(
            lambda: bool(self.feedback) and self.feedback[-1].done >= cells, MAP_TIMEOUT
        )


def workers_of(process: int) -> list[int]:
    """Processes that make maps for a node."""
    shown = subprocess.run(
        ["ps", "-o", "pid=,args=", "--ppid", str(process)], capture_output=True, text=True
    )
    return [int(line.split()[0]) for line in shown.stdout.splitlines() if "map_worker" in line]


def lives(process: int) -> bool:
    """Whether a process runs; a zombie does not."""
    shown = subprocess.run(
        ["ps", "-o", "stat=", "-p", str(process)],
        capture_output=True,
        text=True,
        env=os.environ | {"LC_ALL": "C"},
    ).stdout.strip()
    return bool(shown) and not shown.startswith("Z")

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The side of somebody who wants a map: goals out, feedback and a result in."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cpr_msgs.action import MapWorkspace
from cpr_msgs.msg import MapAxis

from helpers.goal_client import GoalClient
from helpers.node_process import Client

#: A map may have to wait for its kernels to be compiled.
MAP_TIMEOUT = 300.0
#: Maps of the RFRFR robot: 117 cells; some seconds in one thread; in one thread not done before a test
#: is; nor on all cores. Of one that is ended all cells are written: of the last three 15, 94 and 377 MB.
SMALL = {"x": (-0.6, 0.6, 0.1), "y": (-0.1, 0.7, 0.1)}
MEDIUM = {"x": (-0.9, 0.9, 0.01), "y": (-1.0, 1.0, 0.01)}
LONG = {"x": (-0.9, 0.9, 0.004), "y": (-1.0, 1.0, 0.004)}
HUGE = {"x": (-0.9, 0.9, 0.002), "y": (-1.0, 1.0, 0.002)}


def map_axes(axes: Mapping[str, tuple[float, float, float]]) -> list[MapAxis]:
    """Axes by their names, from a first number to a last one in steps."""
    return [
        MapAxis(name=name, first=first, last=last, resolution=step)
        for name, (first, last, step) in axes.items()
    ]


class MapClient(GoalClient):
    """A client of ``~/map_workspace``."""

    def __init__(self, client: Client) -> None:
        super().__init__(client, MapWorkspace, "/cpr_node/map_workspace")

    def send(self, file: Path | str, axes: Any = None, **fields: Any) -> Any:
        given = map_axes(SMALL if axes is None else axes)
        return super().send(axes=given, file=str(file), **fields)

    def result(self, handle: Any) -> Any:
        """Status and result."""
        done = super().result(handle, MAP_TIMEOUT)
        return done.status, done.result

    def make(self, file: Path | str, axes: Any = None, **fields: Any) -> Any:
        return self.result(self.send(file, axes, **fields))

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

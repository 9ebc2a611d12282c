# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a slider event costs on the page of a robot, and how many updates a second are sent.

    .venv/bin/python -m benchmarks.viewing --seconds 10

Python's side only, with a client that listens as a browser does: requests that move a motor of the 6-RFS
robot a little, each until the scene is handed over; then 30 requests a second, at rest and while a map
is made beside it in another process on all cores, counted by what arrives.
"""

from __future__ import annotations

import argparse
import multiprocessing
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import cpr_core
from cpr_core.viewing.handled_robot import HandledRobot
from cpr_core.viewing.page import Page

#: Requests that are timed, and of a motor from one to the next [rad].
COUNT, STEP = 400, 0.002
RATE = 30.0


def listen(address: str, arrived: Any) -> None:
    """Receive everything in a process of its own, as a browser does; counts messages."""
    import viser
    from websockets.sync.client import connect

    protocol = [f"viser-v{viser.__version__}"]
    with connect(address.replace("http", "ws"), subprotocols=protocol, max_size=None) as socket:  # type: ignore[arg-type]
        for _ in socket:
            arrived.value += 1


def event_times(page: Page) -> tuple[np.ndarray, float]:
    """Of every request: time from asking to what is drawn being handed over, mean processor time [s]."""
    home, times = page.equilibrium.motors, []
    drawn, act = threading.Event(), page._act

    def act_and_tell(action: Callable[[HandledRobot], Any]) -> None:
        act(action)
        drawn.set()

    page._act = act_and_tell  # type: ignore[method-assign]
    used = time.process_time()
    for number in range(COUNT):
        at = float(home[0] + STEP * (number % 50))

        def move(handled: HandledRobot, at: float = at) -> bool:
            return handled.move_motor(0, at)

        drawn.clear()
        begin = time.perf_counter()
        page.do("motor", move)
        drawn.wait()
        times.append(time.perf_counter() - begin)
        time.sleep(1.0 / RATE / 2.0)
    used = time.process_time() - used
    page._act = act  # type: ignore[method-assign]
    return np.array(times), used / COUNT


def updates(page: Page, arrived: Any, seconds: float) -> tuple[float, float]:
    """Requests done, and messages that arrived, a second."""
    home, done = page.equilibrium.motors, 0
    before = arrived.value
    begin = time.monotonic()
    while (now := time.monotonic() - begin) < seconds:
        at = float(home[0] + 0.2 * np.sin(now))

        def move(handled: HandledRobot, at: float = at) -> None:
            nonlocal done
            handled.move_motor(0, at)
            done += 1

        page.do("motor", move)
        time.sleep(1.0 / RATE - (time.monotonic() - begin) % (1.0 / RATE))
    return done / seconds, (arrived.value - before) / seconds


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=10.0, help="of every count of updates")
    options = parser.parse_args()
    robot = cpr_core.load_robot("six_rfs")
    page = cpr_core.view(robot)
    processes = multiprocessing.get_context("spawn")
    arrived = processes.Value("i", 0)
    listener = processes.Process(target=listen, args=(page.address, arrived), daemon=True)
    listener.start()
    while not arrived.value:
        time.sleep(0.1)
    times, used = event_times(page)
    print(
        f"slider event: median {1e3 * np.median(times):.2f} ms, 95 % below "
        f"{1e3 * np.quantile(times, 0.95):.2f} ms; processor time with bars and sending "
        f"{1e3 * used:.2f} ms (mean)"
    )
    rest = updates(page, arrived, options.seconds)
    print(f"at rest: {rest[0]:.1f} updates a second, {rest[1]:.1f} messages arrive")
    with tempfile.TemporaryDirectory() as folder:
        mapping = [sys.executable, "-m", "cpr_core.command_line", "workspace", "six_rfs", "--slice"]
        mapping += ["x=-0.3:0.3", "y=-0.3:0.3", "z=0.6:1.0", "--resolution", "0.02"]
        with subprocess.Popen(
            [*mapping, "--out", str(Path(folder) / "map.nc")],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        ) as made:
            time.sleep(5.0)
            busy = updates(page, arrived, options.seconds)
            print(f"beside a map: {busy[0]:.1f} updates a second, {busy[1]:.1f} messages arrive")
            if made.poll() is not None:
                print("the map was done before: the last line is of a machine at rest")
            made.terminate()
    page.close()
    listener.terminate()
    return 0


if __name__ == "__main__":
    sys.exit(main())

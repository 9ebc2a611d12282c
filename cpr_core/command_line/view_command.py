# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Command ``cpr view``: a robot in the browser, until it is interrupted."""

from __future__ import annotations

import argparse
import json
import signal
import threading
from functools import partial
from pathlib import Path

from ..description.loads import Loads
from ..model.robot import Robot
from ..solving.geometrico_statics import solve_forward
from ..solving.home import solve_home
from ..viewing.view import view
from .answer import Answer
from .argument_types import count

__all__ = ["add_view_options"]


def add_view_options(parser: argparse.ArgumentParser) -> None:
    """Options of ``cpr view``."""
    parser.set_defaults(run=_view)
    parser.add_argument(
        "--map",
        type=Path,
        metavar="FILE",
        help="a map of cpr workspace --out to lay into the scene",
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="where to listen; 127.0.0.1: heard by this machine only; 0.0.0.0: whoever reaches it "
        "may move the robot on the page; default %(default)s",
    )
    parser.add_argument(
        "--port",
        type=partial(count, most=65535),
        default=8080,
        metavar="N",
        help="port of the page; 0: any that is free; default %(default)s",
    )


def _view(robot: Robot, loads: Loads | None, options: argparse.Namespace) -> Answer:
    """Show the page until the command is interrupted."""
    from ..viewing.server import check_viewer

    check_viewer()  # before kernels are compiled for the way to the start
    start = None
    if options.motors is not None or loads is not None:
        motors = solve_home(robot).motors if options.motors is None else options.motors
        start = solve_forward(robot, motors, loads=loads)
    page = view(robot, start, map_file=options.map, host=options.host, port=options.port)
    # A flag, for an exception could end up anywhere, and be lost there.
    enough = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: enough.set())
    try:
        if options.json:
            told = {"robot": robot.description.name, "address": page.address}
            print(json.dumps(told), flush=True)
        else:
            print(f"{robot.description.name}: look at {page.address} (Ctrl-C ends)", flush=True)
        enough.wait()
    finally:
        page.close()
    return Answer("", True)

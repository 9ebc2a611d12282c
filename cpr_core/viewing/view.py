# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""``cpr_core.view``: a robot in the browser, from Python or a notebook."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..model.equilibrium import Equilibrium
from ..model.robot import Robot, checked_robot
from ..solving.trace import Trace

if TYPE_CHECKING:
    from .page import Page

__all__ = ["view"]


def view(
    robot: Robot,
    start: Equilibrium | None = None,
    *,
    map_file: str | Path | None = None,
    way: Trace | None = None,
    host: str = "127.0.0.1",
    port: int = 0,
) -> Page:
    """Open a page on which a robot can be looked at and moved; needs the extra ``view``.

    The page is there until ``close()`` or the end of the process: ``page.address`` says where,
    ``page.equilibrium`` where the robot is on it, ``page.show(equilibrium)`` puts it elsewhere.

    Args:
        robot: The robot.
        start: Where to begin; default home.
        map_file: A map of the robot to lay into the scene, as ``map_workspace`` writes it.
        way: A path to play.
        host: Address to listen at: of this machine only, unless another is named. Whoever reaches the
            page moves the robot on it.
        port: Port; 0: any that is free.

    Raises:
        MissingViewer: viser is not installed.
        InvalidRequest: The address cannot be had, or start, map or path are not of this robot.
    """
    from .page import Page
    from .server import check_viewer

    check_viewer()
    return Page(checked_robot(robot), start, host=host, port=port, map_file=map_file, way=way)

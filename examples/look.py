# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot in the browser, with a path to play: the same lines work in a notebook.

    .venv/bin/python examples/look.py

Drag the robot on the page; Enter here prints where it is. An empty input ends it (Ctrl-D).
"""

from __future__ import annotations

import sys

import cpr_core


def main() -> int:
    """Open the page and tell where the robot is whenever Enter is pressed."""
    robot = cpr_core.load_robot("six_rfs")
    home = cpr_core.solve_home(robot)
    raised = home.pose
    raised[2] += 0.05
    page = cpr_core.view(robot, way=cpr_core.trace(robot, pose=raised))
    print(f"look at {page.address}; Enter tells where the robot is, Ctrl-D ends", flush=True)
    for _ in sys.stdin:
        equilibrium = page.equilibrium
        print(
            f"motors {equilibrium.motors}, platform {equilibrium.platform_position}, "
            f"margin {equilibrium.margin:.3f}"
        )
    page.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())

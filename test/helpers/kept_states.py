# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is kept of a robot in its file: equilibria on a way of it, and files with other bytes."""

import numpy as np

from cpr_core import load_robot, solve_forward, solve_home

ROBOT = load_robot("rfrfr")
#: Bytes of a file before its slots.
HEADER = 92


def at(fraction, loads=None):
    """An equilibrium on a way from home."""
    motors = solve_home(ROBOT).motors + fraction * np.array([0.2, -0.3])
    return solve_forward(ROBOT, motors, loads=loads)


def changed_bytes(content, places, to):
    """The same with other bytes at some places."""
    content = bytearray(content)
    for place in places:
        content[place] = to(content[place])
    return bytes(content)

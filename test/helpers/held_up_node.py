# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A cpr_node that solves no ticks while there is a file ``held_up`` in ROS_HOME.

It makes one ``looked_around`` there at rest, when it knows that any first step is free.
"""

import os
import time
from pathlib import Path

from cpr_ros.following.first_step import FirstStep
from cpr_ros.following.setpoint_following import SetpointFollower
from cpr_ros.node import CprNode
from cpr_ros.node_run import run

_HELD_UP, _LOOKED = (Path(os.environ["ROS_HOME"], name) for name in ("held_up", "looked_around"))
_tick, _wait, _look = SetpointFollower.tick, FirstStep.wait, FirstStep.look


def tick(follower, *arguments):
    while _HELD_UP.exists():
        time.sleep(0.001)
    return _tick(follower, *arguments)


def wait(first_step):
    _LOOKED.unlink(missing_ok=True)
    _wait(first_step)


def look(first_step, current, now):
    _look(first_step, current, now)
    if first_step._free:
        _LOOKED.touch()


if __name__ == "__main__":
    SetpointFollower.tick, FirstStep.wait, FirstStep.look = tick, wait, look
    run(CprNode)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Everything a node imports, and the machine code it calls."""

import importlib
import inspect

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import cpr_ros.node_run  # noqa: F401
from cpr_core import kinemato_statics, leg_shapes, load_robot, solve_home, solve_inverse
from cpr_ros.warming import USED_LATER

for _module in (*USED_LATER, "rosidl_generator_py"):  # the last one by the first message
    importlib.import_module(_module)

_home = solve_home(load_robot("rfrfr", modes=2))
solve_inverse(_home.robot, _home.pose, start=_home)
leg_shapes(_home)
kinemato_statics(_home).smallest_singular_value("forward")
_home.margin  # noqa: B018  kept in the process

# When rclpy logs first it looks for the file of every module.
inspect.getmodule(inspect.currentframe())

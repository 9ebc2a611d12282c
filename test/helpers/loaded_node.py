# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Everything a node imports, and the machine code it calls."""

import gc
import importlib
import inspect
import sys

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import cpr_ros.node_run  # noqa: F401
from cpr_core import (
    error_of,
    kinemato_statics,
    leg_shapes,
    load_robot,
    solve_home,
    solve_inverse,
)
from cpr_ros.warming import USED_LATER

for _module in (*USED_LATER, "rosidl_generator_py"):  # the last one by the first message
    importlib.import_module(_module)
_support = importlib.import_module("rclpy.type_support")

# What the middleware needs of messages, services and actions, which it loads by the first of each.
for _name, _module in list(sys.modules.items()):
    for _kind in vars(_module).values() if _name.startswith(("cpr_ros.", "rclpy.")) else ():
        if hasattr(type(_kind), "__import_type_support__"):
            _support.check_for_type_support(_kind)

_home = solve_home(load_robot("rfrfr", modes=2))
solve_inverse(_home.robot, _home.pose, start=_home)
leg_shapes(_home)
kinemato_statics(_home).smallest_singular_value("forward")
_home.margin  # noqa: B018  kept in the process
error_of(_home)

# When rclpy logs first it looks for the file of every module.
inspect.getmodule(inspect.currentframe())
# To look for garbage in all this is a third of what a copy does, and it would copy every page.
gc.collect()
gc.freeze()

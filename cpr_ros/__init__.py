# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""ROS 2 node of the library cpr_core."""

import os
import sys
from contextlib import suppress
from pathlib import Path


def _find_ros_of_this_environment() -> None:
    """Let a ROS 2 installed from wheels work in a bare shell; a sourced ROS 2 is left alone."""
    prefix = Path(sys.prefix)
    if not (prefix / "share/ament_index/resource_index/packages/rclpy").exists():
        return
    paths = [path for path in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if path]
    if str(prefix) not in paths:
        os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join([str(prefix), *paths])
    # The shell may name a middleware that is not among the wheels.
    if not (prefix / f"lib/lib{os.environ.get('RMW_IMPLEMENTATION')}.so").exists():
        os.environ["RMW_IMPLEMENTATION"] = "rmw_fastrtps_cpp"
    # ROS writes its logs below the home directory, and says so itself where there is none.
    with suppress(RuntimeError):
        os.environ.setdefault("HOME", str(Path.home()))


def _keep_linear_algebra_on_one_thread() -> None:
    """The matrices here are small: more threads gain nothing, and waiting for one costs up to 0.1 s."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")


_find_ros_of_this_environment()
_keep_linear_algebra_on_one_thread()

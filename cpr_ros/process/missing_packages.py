# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What to install where a program of cpr_ros finds a package missing. Imports nothing that could be."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["what_is_missing_told"]

#: What cpr_ros itself needs, ROS aside.
_NEEDED = ("cpr_core", "numpy", "scipy", "numba", "yaml", "jsonschema", "threadpoolctl", "tqdm")


@contextmanager
def what_is_missing_told(program: str) -> Iterator[None]:
    """End a program, with status 1, where an import in this context does not find its package."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise SystemExit(f"{program}: {_what_to_install(error)}") from None


def _what_to_install(error: ModuleNotFoundError) -> str:
    """The error, and in a second line what brings the package."""
    name = (error.name or "").partition(".")[0]
    if name == "cpr_msgs":
        how = (
            "build ./msg_defs of the clone: pip install ./msg_defs, or colcon build, and source it"
        )
    elif name in _NEEDED:
        how = "install cpr_ros with what it needs: pip install . in the clone"
    else:
        how = (
            "it needs ROS 2: source one (source /opt/ros/jazzy/setup.bash), or install its "
            "wheels from the clone (make setup; or pip install ./msg_defs '.[ros]')"
        )
    return f"{error}\n{how}"

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Which files maps may be written to, told before hours are spent on them."""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from pathlib import Path
from typing import get_args

import scipy

from ..errors import InvalidRequest
from ..model.robot import Robot
from .borders import BorderKind
from .grid import Grid
from .workspace_map import WorkspaceMap

__all__ = [
    "MapNotWritten",
    "check_axis_names",
    "check_replaceable",
    "check_writable",
    "unfinished_file",
]

#: Bytes of the name of a file at most, on all usual file systems.
_LONGEST_NAME = 255
#: Largest variable of such a file.
_MOST_BYTES = 2**31 - 1
#: Names that a file has of its own, dimensions and variables: no axis may be called like them.
_DIMENSIONS = "axis column eigenvalue end entry limit motor rod row side way xyz"
_VARIABLES = """
bending_strain branch_sign edge_fraction edges efforts eigenvalues_locked energy forward_margin
index_free index_locked inverse_condition_number inverse_margin inverse_side largest_eigenvalue_size
limit_margin motors order platform_position platform_rotation smallest_eigenvalue_size state usable
within_limits
"""
OWN_NAMES = frozenset(f"{_DIMENSIONS} {_VARIABLES}".split())
_OF_BORDERS = ("after", "before", "cells", "point", "points", "segment", "segments")


class MapNotWritten(InvalidRequest):
    """A map was made, but could not be written to its file.

    Attributes:
        found: The map, as far as it was made.
    """

    def __init__(self, file: Path, found: WorkspaceMap, problem: str) -> None:
        """Name the file and why."""
        super().__init__("file", f"{file}: cannot be written: {problem}")
        self.found = found


def check_axis_names(grid: Grid) -> None:
    """Whether the axes of a map are told apart from all else in its file.

    Raises:
        InvalidRequest: One is called like something of the file's own.
    """
    own = OWN_NAMES | {f"{kind}_{part}" for kind in get_args(BorderKind) for part in _OF_BORDERS}
    taken = [name for name in grid.axis_names if name in own]
    if taken:
        raise InvalidRequest(
            "grid",
            f"expected axes with other names in a file, {', '.join(taken)} is what a map has there "
            "of its own",
        )


def check_writable(file: Path, robot: Robot, grid: Grid) -> None:
    """Whether a map can be written to a file, before hours are spent on it.

    Raises:
        InvalidRequest: It cannot.
    """
    check_axis_names(grid)
    folder = file.absolute().parent
    try:
        with suppress(FileNotFoundError):
            file.lstat()  # tells of names that no file can have
    except (OSError, ValueError) as error:
        raise InvalidRequest(
            "file", f"expected the name of a file, got {str(file)!r:.300}: {error!s:.300}"
        ) from None
    if not folder.is_dir():
        raise InvalidRequest("file", f"expected a file in a folder that exists, got {file}")
    if file.is_dir():
        raise InvalidRequest("file", f"expected a file, {file} is a folder")
    if not os.access(folder, os.W_OK):
        raise InvalidRequest("file", f"expected a folder that can be written to, got {file}")
    largest = grid.size * max(9, len(robot.kernel_arrays.unit)) * 8
    if largest > _MOST_BYTES:
        raise InvalidRequest(
            "file",
            f"expected at most {_MOST_BYTES // (largest // grid.size):,} cells of this robot in a "
            f"file, got {grid.size:,}",
        )


def check_replaceable(file: Path) -> None:
    """Whether another map may be put in the place of a file: only where there is a map, or nothing.

    A map so damaged that it cannot be told from something else is not replaced either.

    Raises:
        InvalidRequest: It is something else, or cannot be read.
    """
    if not os.path.lexists(file):
        return
    try:
        known = file.is_file() and _is_map(file)  # to open a pipe takes until somebody writes to it
    except PermissionError as error:
        raise InvalidRequest("file", f"expected a file that can be read, got {error}") from None
    if not known:
        raise InvalidRequest(
            "file", f"expected a map, {file} is none and is not replaced; name another file"
        )


def _is_map(file: Path) -> bool:
    try:
        with scipy.io.netcdf_file(file, "r", mmap=True) as source:  # without reading its arrays
            return "cpr_map_format" in source._attributes
    except PermissionError:
        raise
    except Exception:  # damaged headers lead the reader anywhere
        return False


def unfinished_file(file: Path, process: int) -> Path:
    """Where a process writes a map before it is put in its place."""
    name = f".{file.name}.{process}"
    if len(os.fsencode(name)) > _LONGEST_NAME:
        name = f".{hashlib.sha256(os.fsencode(file.name)).hexdigest()}.{process}"
    return file.with_name(name)

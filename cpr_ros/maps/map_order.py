# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What travels between the node and the process that makes a map."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cpr_core import Equilibrium, Loads
from cpr_core.workspace import Grid

__all__ = ["MapFailure", "MapOrder", "MapState"]


@dataclass(frozen=True)
class MapOrder:
    """A map to make.

    Attributes:
        start: Equilibrium whose branch is mapped.
        loads: Loads in force.
        grid: The grid.
        tolerance: Borders are refined to this, in units of the axes; 0: not refined.
        threshold: Cells whose inverse condition number of H_r is below are counted.
        workers: Threads; 0: one per core.
        file: NetCDF file to write, absolute.
        resume: Whether to go on with the map in the file, if there is one.
        objective: What is least in every cell of a redundant robot; None: the default.
    """

    start: Equilibrium
    loads: Loads
    grid: Grid
    tolerance: float
    threshold: float
    workers: int
    file: Path
    resume: bool
    objective: str | None


@dataclass(frozen=True)
class MapState:
    """How far a map is.

    Attributes:
        done: Cells left for all their neighbours.
        reached: Cells reached.
        total: Cells of the grid.
        rate: Cells done in a second; 0 at the beginning.
    """

    done: int
    reached: int
    total: int
    rate: float


@dataclass(frozen=True)
class MapFailure:
    """Why there is no map; an error itself may hold half a robot and does not travel well.

    Attributes:
        kind: Class of the error.
        message: For a person.
        argument: What was wrong about the order, if that is known.
    """

    kind: type[Exception]
    message: str
    argument: str

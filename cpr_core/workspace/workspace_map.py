# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A map of a workspace: everything known of every cell of a grid."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
import scipy
from numpy.typing import NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..kernels.limit_kernel import ROUNDING
from ..kernels.record_layout import INDEX_FREE, INDEX_LOCKED
from ..kernels.square_problem import Configuration
from ..model.equilibrium import Equilibrium
from ..model.equilibrium_steps import equilibrium_at
from ..model.robot import Robot
from ..validation import cached_array, cached_property, checked_count, read_only
from .borders import Border
from .cell_layout import FORWARD_MARGIN, INVERSE_MARGIN, LARGEST_EIGENVALUE, NEAREST_EIGENVALUE
from .grid import Grid
from .map_limits import limit_margins, limit_names, map_strains

__all__ = ["CellArrays", "EdgeState", "WorkspaceMap", "equilibrium_of"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]


class EdgeState(IntEnum):
    """What is known of the way from a cell to a neighbour."""

    UNTRIED = 0  # nobody has gone there, or the cell has no such neighbour
    PASSED = 1  # it leads to the neighbour as it is in the map
    BLOCKED = 2  # the branch ends on the way: an inverse (or, of motors, a forward) singularity
    FLIPPED = 3  # the sign of the problem changes on the way, and no walk leads around
    DISAGREES = 4  # it leads to another equilibrium than the one the map has there


@dataclass(frozen=True, eq=False)
class CellArrays:
    """Arrays of M cells; those of cells that were not reached are NaN or 0.

    Attributes:
        order: When a cell was reached, from 0; -1: not reached, (M,).
        state: States, (M, N).
        rotation: R_p in the world, (M, 3, 3).
        position: p_p in the world, (M, 3) [m].
        signs: Index locked, index free, side of the inverse singularity, sign of the branch, (M, 4), see
            `cell_layout`.
        efforts: Motor efforts, (M, n) [N m or N].
        energy: Potential energy, (M,) [J].
        eigenvalues: Smallest eigenvalues of H_r, motors held, ascending, (M, 4) [J].
        measures: Smallest and largest absolute eigenvalue [J], smallest singular values of the forward
            and of the inverse problem, (M, 4), see `cell_layout`.
        edges: ``EdgeState`` of the ways to the neighbours, as ``Grid.neighbours``, (M, 2 D).
        edge_fraction: How far the branch could be followed there, (M, 2 D).
    """

    order: Integers
    state: Floats
    rotation: Floats
    position: Floats
    signs: Integers
    efforts: Floats
    energy: Floats
    eigenvalues: Floats
    measures: Floats
    edges: Integers
    edge_fraction: Floats

    def copied(self) -> CellArrays:
        """The same in memory of its own, to be written to."""
        return CellArrays(*(values.copy() for values in vars(self).values()))

    def shown(self) -> CellArrays:
        """Views that nobody can write to; what is written to these arrays is seen in them."""
        return CellArrays(*(read_only(values.view()) for values in vars(self).values()))


@dataclass(frozen=True, eq=False, repr=False)
class WorkspaceMap:
    """A grid of equilibria on one branch; arrays are flat, ``values.reshape(grid.shape)`` is a picture.

    Attributes:
        robot: The robot.
        loads: Loads in force.
        grid: The grid.
        cells: Everything known of the cells.
        expanded: How many cells were left for all their neighbours, in the order they were reached.
        borders: Borders, refined.
        objective: What is least in every cell of a robot with more motors than controlled coordinates:
            ``least_effort``, ``greatest_margin``, or ``least_motion`` from motor positions; else empty.
        tolerance: What the borders are to be refined to, in units of the axes; 0: they need not be.
        refined_to: What they are refined to; infinite where they are not, or it is not known.
    """

    robot: Robot
    loads: Loads
    grid: Grid
    cells: CellArrays
    expanded: int
    borders: tuple[Border, ...] = ()
    objective: str = ""
    tolerance: float = 0.0
    refined_to: float = math.inf

    def __repr__(self) -> str:
        return (
            f"<WorkspaceMap of {self.robot.description.name}: {self.reached.sum()} of "
            f"{self.grid.size} cells reached, {'' if self.complete else 'not '}complete>"
        )

    def __post_init__(self) -> None:
        """Show the cells, which a map on its way goes on to write to."""
        object.__setattr__(self, "cells", self.cells.shown())

    @property
    def complete(self) -> bool:
        """Whether all that can be reached was reached, and the borders refined to the tolerance."""
        return self.explored and self.refined(self.tolerance)

    @property
    def explored(self) -> bool:
        """Whether all that can be reached was reached."""
        return self.expanded == int(self.reached.sum())

    def refined(self, tolerance: float) -> bool:
        """Whether the borders are as exact as a tolerance asks, which asks nothing if it is 0."""
        return tolerance == 0.0 or self.refined_to <= tolerance

    @cached_array
    def reached(self) -> Flags:
        """Cells that continuous branches lead to, (M,)."""
        return self.cells.order >= 0

    @cached_array
    def motors(self) -> Floats:
        """Motor positions, (M, n) [rad or m]."""
        return self.cells.state[:, self.robot.kernel_arrays.motor_index :]

    @property
    def index_locked(self) -> Integers:
        """Stability index with the motors held, (M,); -1 where not reached."""
        return self.cells.signs[:, INDEX_LOCKED]

    @property
    def index_free(self) -> Integers:
        """Stability index with the motors at constant effort, (M,); -1 where not reached."""
        return self.cells.signs[:, INDEX_FREE]

    @cached_array
    def inverse_condition_number(self) -> Floats:
        """Smallest over largest absolute eigenvalue of H_r, motors held, (M,)."""
        measures = self.cells.measures
        return measures[:, NEAREST_EIGENVALUE] / measures[:, LARGEST_EIGENVALUE]

    @property
    def forward_margin(self) -> Floats:
        """Smallest singular value of the forward problem, (M,), as ``KinematoStatics.singularity``."""
        return self.cells.measures[:, FORWARD_MARGIN]

    @property
    def inverse_margin(self) -> Floats:
        """Smallest singular value of the inverse problem, (M,); NaN where there is no such problem."""
        return self.cells.measures[:, INVERSE_MARGIN]

    @cached_array
    def strains(self) -> Floats:
        """Largest bending strain of every rod, (M, R), see `bending_strains`."""
        return map_strains(self.robot, self.cells.state)

    @cached_array
    def limit_margins(self) -> Floats:
        """How far the limits are, negative where they do not hold, (M, K), K as ``limit_names``."""
        return limit_margins(self.robot, self.cells.state, self.cells.efforts)

    @cached_array
    def within_limits(self) -> Flags:
        """Reached cells where all limits of motors and rods hold, (M,)."""
        return self.reached & np.all(self.limit_margins >= -ROUNDING, axis=1)

    @property
    def energy_criterion_applies(self) -> bool:
        """Whether energy decides stability: not under loads without a potential."""
        return self.robot.has_potential(self.loads)

    @cached_array
    def usable(self) -> Flags:
        """Cells to which the robot can go from the first one, stable and within its limits, (M,).

        None where energy does not decide what is stable, as ``Equilibrium.stable``.
        """
        good = self.within_limits & (self.index_locked == 0)
        if not self.energy_criterion_applies:
            return np.zeros_like(good)
        cell, column = np.nonzero(self.cells.edges == EdgeState.PASSED)
        neighbour = self.grid.neighbours[cell, column]
        both = good[cell] & good[neighbour]
        graph = scipy.sparse.coo_array(
            (np.ones(both.sum(), np.int8), (cell[both], neighbour[both])),
            shape=(len(good), len(good)),
        )
        labels = scipy.sparse.csgraph.connected_components(graph, directed=False)[1]
        return good & (labels == labels[self.first])

    @cached_property
    def first(self) -> int:
        """Flat number of the first cell."""
        return int(np.flatnonzero(self.cells.order == 0)[0])

    @cached_array
    def disagreements(self) -> Integers:
        """Pairs of neighbours, (P, 2): from the first the way leads to another equilibrium."""
        cell, column = np.nonzero(self.cells.edges == EdgeState.DISAGREES)
        return np.stack([cell, self.grid.neighbours[cell, column]], axis=1)

    @cached_property
    def limit_names(self) -> tuple[str, ...]:
        """Names of the limits, (K,)."""
        return limit_names(self.robot)

    def place(self, cell: int) -> Floats:
        """Numbers of a cell along the axes, (D,).

        Raises:
            InvalidRequest: No flat number of a cell.
        """
        return self.grid.places(np.array([self._checked(cell)]))[0]

    def equilibrium(self, cell: int) -> Equilibrium:
        """The equilibrium of a cell, to go on from.

        Args:
            cell: Flat number.

        Raises:
            InvalidRequest: No cell, one that was not reached, or one that a damaged file has spoilt.
        """
        if not self.reached[self._checked(cell)]:
            raise InvalidRequest("cell", f"expected a cell that was reached, got {cell}")
        found = equilibrium_of(self.robot, self.loads, self.cells, cell)
        if not found.converged:
            raise InvalidRequest("cell", f"the map is damaged: cell {cell} is no equilibrium")
        return found

    def _checked(self, cell: int) -> int:
        return checked_count("cell", cell, 0, self.grid.size - 1)

    def with_borders(self, borders: tuple[Border, ...], refined_to: float) -> WorkspaceMap:
        """The same with other borders."""
        return replace(self, borders=borders, refined_to=refined_to)


def equilibrium_of(robot: Robot, loads: Loads, cells: CellArrays, cell: int) -> Equilibrium:
    """The equilibrium of a cell."""
    place = Configuration(cells.state[cell], cells.rotation[cell], cells.position[cell])
    return equilibrium_at(robot, loads, robot.load_arrays(loads), place)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What was found of a map so far, and how it grows by the next batch of cells."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..model.configurations import SAME_EQUILIBRIUM, configuration_distance, configuration_rows
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..solving.continuation import Walk
from ..solving.not_reached import NoForwardSolution, NoInverseSolution, NotReached
from ..solving.objectives import objective_of
from ..solving.redundant_walk import walk_to
from .batch_kernel import Analyses, Arrivals, Ways
from .batches import (
    EIGENVALUES,
    Crew,
    Task,
    analyses_and_arrivals,
    arrivals_of,
    cells_at,
    joined,
    no_guesses,
)
from .borders import Border
from .cell_layout import MEASURE_COUNT, SIGN_COUNT
from .cell_problem import cell_problem
from .first_cell import (
    first_cells,
    held_elsewhere,
    place_of,
    reached_cells_near,
    signs_at_equilibrium,
    step_fractions,
    target_of_cell,
    without_limits,
)
from .grid import Grid
from .redundant_ways import RedundantWays
from .refinement import ends_of_branches
from .way_kernel import ARRIVED, FLIPPED
from .workspace_map import CellArrays, EdgeState, WorkspaceMap, equilibrium_of

__all__ = ["Flood", "Progress"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Cells left at once: a checkpoint is possible after each such batch.
_BATCH = 2048
#: Cells of a map that is gone on with of which one has to be found again.
_LOOKED_FOR = 10


@dataclass(frozen=True)
class Progress:
    """How far a map is.

    Attributes:
        done: Cells left for all their neighbours.
        reached: Cells reached.
        total: Cells of the grid; not all of them can be reached in general.
    """

    done: int
    reached: int
    total: int


class Flood:
    """A map on its way: batch by batch, from the cells that were reached to their neighbours.

    Attributes:
        robot: The robot.
        grid: What is imposed.
        problem: What is solved in every cell.
        cells: What was found.
        done: Number of cells that were left for all their neighbours.
        objective: What is least in every cell, in words; empty: nothing is free.
        arrive: How refined borders reach what is between cells.
    """

    def __init__(
        self,
        robot: Robot,
        grid: Grid,
        start: Equilibrium,
        loads: Loads,
        tolerance: float,
        objective: str | None,
    ) -> None:
        self.robot, self.grid, self.start, self.loads = robot, grid, start, loads
        self.problem = cell_problem(robot, loads, grid)
        self.free = without_limits(robot)
        self.tolerance = tolerance
        self.cells = _empty_cells(robot, grid)
        self.borders: tuple[Border, ...] = ()
        self.refined_to = math.inf
        self.queue = np.zeros(0, np.int64)
        self.done = 0
        self.longest, self.smallest = step_fractions(robot, grid, tolerance)
        self.aim = objective_of(start, grid.given, objective)
        self.objective = "" if self.aim is None else str(self.aim)
        self.same = SAME_EQUILIBRIUM if self.aim is None else self.aim.same
        self.leave: Task[tuple[Analyses, Arrivals]] = analyses_and_arrivals
        self.arrive: Task[Arrivals] = arrivals_of
        if self.aim is not None:
            ways = RedundantWays(self.free, loads, self.aim)
            self.leave, self.arrive = ways.analyses_and_arrivals, ways.arrivals

    @property
    def reached(self) -> int:
        """Number of cells reached."""
        return len(self.queue)

    @property
    def progress(self) -> Progress:
        """How far this is."""
        return Progress(self.done, self.reached, self.grid.size)

    def take(self, found: WorkspaceMap, crew: Crew) -> None:
        """Go on with an unfinished map.

        Raises:
            InvalidRequest: The start is not on its branch.
            Cancelled: Before that was known.
        """
        self.cells, self.done = found.cells.copied(), found.expanded
        self.borders, self.refined_to = found.borders, found.refined_to
        reached = np.flatnonzero(found.reached)
        self.queue = reached[np.argsort(found.cells.order[reached])]
        if not self.reached:
            return
        # A way there may be blocked though the branch is the same: any cell found again tells it.
        start = replace(self.start, robot=self.free)
        near = reached_cells_near(self.grid, place_of(start, self.grid), found.reached)
        for cell in list(dict.fromkeys([found.first, *near]))[:_LOOKED_FOR]:
            crew.check()
            if self._is_found_again(start, cell):
                return
        problem = "expected a start that leads to a cell of it as it was found: another branch?"
        raise InvalidRequest("file", f"{problem}; name another file")

    def _is_found_again(self, start: Equilibrium, cell: int) -> bool:
        """Whether a walk leads to a cell as the map has it."""
        walk = self._walk_to_cell(start, cell)
        return walk.arrived and self._is_as_found(cell, walk.last)

    def _is_as_found(self, cell: int, last: Equilibrium) -> bool:
        """Whether a walk to a cell ended at the equilibrium that the map has there."""
        end = self._arrived(last)
        return bool(self._distance(np.array([cell]), end, np.array([0]))[0] < self.same)

    def begin(self) -> None:
        """Walk from the start to the nearest cell that can be reached."""
        start = replace(self.start, robot=self.free)
        place = place_of(start, self.grid)
        tried = first_cells(self.grid, place)
        for cell in tried:
            walk = self._walk_to_cell(start, cell)
            if walk.arrived:
                self._accept_walk(cell, walk.last)
                return
        raise self._none_reached(walk, len(tried))

    def _none_reached(self, last_walk: Walk, tried: int) -> NotReached:
        """The error of a start from which no cell that was tried is reached."""
        event = last_walk.events[-1]
        failure = NoForwardSolution if self.grid.given == "motors" else NoInverseSolution
        held = held_elsewhere(self.start, self.grid)
        return failure(
            f"start: none of {tried} cells of the grid is reached from it, the last because "
            f"{event.message} at {100.0 * event.fraction:.1f} % of the way; give a start nearer to "
            f"the grid, or move the grid{held and '; '}{held}",
            event.fraction,
            last_walk.last,
            event,
        )

    def leave_some(self, crew: Crew) -> None:
        """Analyse the next cells and go from them to all neighbours not tried yet."""
        batch = self.queue[self.done : self.done + _BATCH]
        neighbours = self.grid.neighbours[batch]
        wanted = (neighbours >= 0) & (self.cells.edges[batch] == EdgeState.UNTRIED)
        origin, column = np.nonzero(wanted)
        target = neighbours[origin, column]
        ways = self._ways(origin, column, target, self._guesses(batch, origin, column, target))
        cells = cells_at(self.grid, self.cells, batch)
        pieces = crew.results(self.leave, self.problem, cells, ways)
        analyses, arrivals = zip(*pieces, strict=True)
        self.cells.eigenvalues[batch] = np.concatenate([part.eigenvalues for part in analyses])
        self.cells.measures[batch] = np.concatenate([part.measures for part in analyses])
        self._arrive(batch[origin], column, target, joined(list(arrivals)))
        self.done += len(batch)

    def follow_again(self, crew: Crew) -> None:
        """Follow the branch again to where it ends, in steps as small as the tolerance asks.

        A map from a file may have been explored, as a whole or in part, in steps for a coarser one. What
        finer steps lead on to is entered, and cells they reach are to be left too.
        """
        if self.aim is not None:  # walks end where they end, whatever the tolerance
            return
        sources, columns = ends_of_branches(self.grid, self.cells)
        for first in range(0, len(sources), _BATCH):
            source, column = sources[first : first + _BATCH], columns[first : first + _BATCH]
            batch, origin = np.unique(source, return_inverse=True)
            target = self.grid.neighbours[source, column]
            # Guesses would be of no use: with equal steps the ends are the same.
            guesses = no_guesses(len(origin), self.cells.state.shape[1])
            ways = self._ways(origin, column, target, guesses)
            cells = cells_at(self.grid, self.cells, batch)
            arrivals = joined(list(crew.results(self.arrive, self.problem, cells, ways)))
            known = self.cells.edge_fraction[source, column]
            farthest = np.maximum(arrivals.fraction, known)
            self._arrive(source, column, target, arrivals._replace(fraction=farthest))

    def _ways(self, origin: Integers, column: Integers, target: Integers, guesses: Floats) -> Ways:
        """Ways from cells of a batch, by their numbers in it, to neighbours by the columns of these."""
        return Ways(
            origin=origin,
            targets=self.grid.kernel_coordinates(self.grid.places(target)),
            longest=self.longest[column // 2],
            smallest=self.smallest[column // 2],
            guesses=guesses,
        )

    def _guesses(
        self, batch: Integers, origin: Integers, column: Integers, target: Integers
    ) -> Floats:
        """What is expected at the ends of ways: straight on from the neighbour behind."""
        mine = self.cells
        found = no_guesses(len(origin), mine.state.shape[1])
        along = np.flatnonzero(mine.edges[batch[origin], column ^ 1] == EdgeState.PASSED)
        source = batch[origin[along]]
        behind = self.grid.neighbours[source, column[along] ^ 1]
        axis = column[along] // 2
        places = [self.grid.places(cells) for cells in (behind, source, target[along])]
        before, after = (
            np.take_along_axis(last - first, axis[:, None], axis=1)
            for first, last in itertools.pairwise(places)
        )
        factor = after / before
        turn = _transposed(mine.rotation[behind]) @ mine.rotation[source]
        ahead = mine.rotation[source] @ turn
        # The rounding of three factors would triple from cell to cell: one step back to a rotation.
        ahead = 0.5 * ahead @ (3.0 * np.eye(3) - _transposed(ahead) @ ahead)
        found[along] = configuration_rows(
            mine.state[source] + factor * (mine.state[source] - mine.state[behind]),
            ahead,
            mine.position[source] + factor * (mine.position[source] - mine.position[behind]),
        )
        return found

    def _arrive(
        self, source: Integers, column: Integers, target: Integers, arrivals: Arrivals
    ) -> None:
        """Enter where ways ended: the first that reaches a cell makes it, the others are compared."""
        edges, back = self.cells.edges, column ^ 1
        known = edges[source, column]
        edges[source, column] = np.where(
            arrivals.status == FLIPPED, EdgeState.FLIPPED, EdgeState.BLOCKED
        )
        self.cells.edge_fraction[source, column] = arrivals.fraction
        arrived = np.flatnonzero(arrivals.status == ARRIVED)
        new = arrived[self.cells.order[target[arrived]] < 0]
        _, first = np.unique(target[new], return_index=True)
        makers = new[np.sort(first)]
        self._accept(target[makers], arrivals, makers)
        same = self._distance(target[arrived], arrivals, arrived) < self.same
        passed, differing = arrived[same], arrived[~same]
        edges[source[passed], column[passed]] = EdgeState.PASSED
        edges[target[passed], back[passed]] = EdgeState.PASSED
        self.cells.edge_fraction[target[passed], back[passed]] = 1.0
        edges[source[differing], column[differing]] = EdgeState.DISAGREES
        for way in np.flatnonzero(arrivals.status == FLIPPED).tolist():
            if edges[source[way], column[way]] == EdgeState.FLIPPED:  # not passed the other way
                self._walk(int(source[way]), int(column[way]), int(target[way]))
        if np.any(edges[source, column] != known):  # the borders are of what was known before
            self.refined_to = math.inf

    def _walk(self, source: int, column: int, target: int) -> None:
        """Let the general walk decide where only the sign of the problem stands against a step."""
        start = equilibrium_of(self.free, self.loads, self.cells, source)
        walk = self._walk_to_cell(start, target)
        fractions = self.cells.edge_fraction
        if walk.stopped is not None:  # it may have gone on over where branches cross
            fractions[source, column] = max(fractions[source, column], walk.stopped.fraction)
            return
        fractions[source, column] = 1.0
        if self.cells.order[target] < 0:
            self._accept_walk(target, walk.last)
        elif not self._is_as_found(target, walk.last):
            self.cells.edges[source, column] = EdgeState.DISAGREES
            return
        self.cells.edges[source, column] = EdgeState.PASSED
        self.cells.edges[target, column ^ 1] = EdgeState.PASSED
        self.cells.edge_fraction[target, column ^ 1] = 1.0

    def _walk_to_cell(self, start: Equilibrium, cell: int) -> Walk:
        target = target_of_cell(self.grid, self.problem, cell, start)
        return walk_to(start, target, self.loads, objective=self.aim)

    def _accept(self, cells: Integers, arrivals: Arrivals, ways: Integers) -> None:
        """Cells that were reached for the first time."""
        mine = self.cells
        mine.order[cells] = self.reached + np.arange(len(cells))
        mine.state[cells], mine.rotation[cells] = arrivals.state[ways], arrivals.rotation[ways]
        mine.position[cells], mine.signs[cells] = arrivals.position[ways], arrivals.signs[ways]
        mine.efforts[cells], mine.energy[cells] = arrivals.efforts[ways], arrivals.energy[ways]
        self.queue = np.concatenate([self.queue, cells])

    def _accept_walk(self, cell: int, last: Equilibrium) -> None:
        """A cell that a walk reached."""
        self._accept(np.array([cell]), self._arrived(last), np.array([0]))

    def _arrived(self, last: Equilibrium) -> Arrivals:
        """The end of a walk as that of a way."""
        return Arrivals(
            status=np.array([ARRIVED]),
            fraction=np.ones(1),
            state=last.state[None],
            rotation=last.platform_rotation[None],
            position=last.platform_position[None],
            signs=signs_at_equilibrium(self.problem, last)[None],
            efforts=last.efforts[None],
            energy=np.array([last.energy]),
        )

    def _distance(self, cells: Integers, arrivals: Arrivals, ways: Integers) -> Floats:
        """Largest dimensionless difference between cells and the ends of ways to them."""
        mine = self.cells
        found, others = (
            configuration_rows(part.state[rows], part.rotation[rows], part.position[rows])
            for part, rows in ((mine, cells), (arrivals, ways))
        )
        return configuration_distance(self.robot, found, others)

    def as_map(self) -> WorkspaceMap:
        """What was found so far."""
        return WorkspaceMap(
            robot=self.robot,
            loads=self.loads,
            grid=self.grid,
            cells=self.cells,
            expanded=self.done,
            borders=self.borders,
            objective=self.objective,
            tolerance=self.tolerance,
            refined_to=self.refined_to,
        )


def _transposed(matrices: Floats) -> Floats:
    return np.transpose(matrices, (0, 2, 1))


def _empty_cells(robot: Robot, grid: Grid) -> CellArrays:
    """Cells of which nothing is known."""
    count, size, ways = grid.size, len(robot.kernel_arrays.unit), 2 * len(grid.shape)

    def unknown(*shape: int) -> Floats:
        return np.full((count, *shape), np.nan)

    return CellArrays(
        order=np.full(count, -1),
        state=unknown(size),
        rotation=unknown(3, 3),
        position=unknown(3),
        signs=np.full((count, SIGN_COUNT), -1),
        efforts=unknown(robot.motor_count),
        energy=unknown(),
        eigenvalues=unknown(EIGENVALUES),
        measures=unknown(MEASURE_COUNT),
        edges=np.full((count, ways), EdgeState.UNTRIED, np.int64),
        edge_fraction=np.zeros((count, ways)),
    )

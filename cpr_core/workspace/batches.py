# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Batches of cells as tasks of an executor: in threads, processes or on other machines."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..kernels.workspace_arrays import workspace
from ..model.configurations import configuration_rows
from .batch_kernel import Analyses, Arrivals, Cells, Ways, analyse_cells, leave_cells
from .cell_layout import MEASURE_COUNT, SIGN_COUNT
from .cell_problem import CellProblem
from .grid import Grid
from .workspace_map import CellArrays

__all__ = [
    "EIGENVALUES",
    "Cancelled",
    "Crew",
    "Task",
    "analyses_and_arrivals",
    "analyses_of",
    "arrivals_of",
    "cell_rows",
    "cells_at",
    "joined",
    "no_guesses",
]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Result = TypeVar("Result")
#: What an executor does with cells and the ways from them.
Task = Callable[[CellProblem, Cells, Ways], Result]

#: Smallest eigenvalues kept for every cell.
EIGENVALUES = 4
#: Pieces of a batch at most, and cells of a piece at least.
_PIECES, _SMALLEST_PIECE = 8, 8


class Cancelled(Exception):
    """The caller asked to stop."""


def analyses_and_arrivals(
    problem: CellProblem, cells: Cells, ways: Ways
) -> tuple[Analyses, Arrivals]:
    """Analyse cells and go from them to their neighbours; a task of an executor."""
    return analyses_of(problem, cells), arrivals_of(problem, cells, ways)


def analyses_of(problem: CellProblem, cells: Cells) -> Analyses:
    """Analyse cells."""
    count = len(cells.state)
    analyses = Analyses(np.empty((count, EIGENVALUES)), np.empty((count, MEASURE_COUNT)))
    analyse_cells(problem, cells, workspace(problem.robot), analyses)
    return analyses


def arrivals_of(problem: CellProblem, cells: Cells, ways: Ways) -> Arrivals:
    """Go from cells to targets; a task of an executor."""
    count, size = len(ways.origin), cells.state.shape[1]
    arrivals = Arrivals(
        status=np.empty(count, np.int64),
        fraction=np.empty(count),
        state=np.empty((count, size)),
        rotation=np.empty((count, 3, 3)),
        position=np.empty((count, 3)),
        signs=np.empty((count, SIGN_COUNT), np.int64),
        efforts=np.empty((count, size - problem.robot.motor_index)),
        energy=np.empty(count),
    )
    leave_cells(problem, cells, ways, workspace(problem.robot), arrivals)
    return arrivals


@dataclass(frozen=True)
class Crew:
    """Who does tasks, and who may stop them.

    Attributes:
        executor: Where they run; None: here, one after another.
        cancelled: Whether to stop, asked several times a second; None: never.
    """

    executor: Executor | None = None
    cancelled: Callable[[], bool] | None = None

    def check(self) -> None:
        """Go on unless it is to be stopped.

        Raises:
            Cancelled: It is.
        """
        if self.cancelled is not None and self.cancelled():
            raise Cancelled

    def results(
        self, task: Task[Result], problem: CellProblem, cells: Cells, ways: Ways
    ) -> Iterator[Result]:
        """Results of a task for consecutive pieces of a batch, in order.

        Raises:
            Cancelled: It is to be stopped; what had not begun is not done.
        """
        count = len(cells.state)
        length = max(_SMALLEST_PIECE, -(-count // _PIECES))
        pieces = [_piece(cells, ways, first, first + length) for first in range(0, count, length)]
        if self.executor is None:
            for piece in pieces:
                self.check()
                yield task(problem, *piece)
            return
        waiting = [self.executor.submit(task, problem, *piece) for piece in pieces]
        try:
            for future in waiting:
                while self.cancelled is not None and not future.done():
                    self.check()
                    _wait(future)
                yield future.result()
        finally:
            for future in waiting:
                future.cancel()


def cells_at(grid: Grid, known: CellArrays, numbers: Integers) -> Cells:
    """Some cells of a map as the kernels read them."""
    return Cells(
        grid.kernel_coordinates(grid.places(numbers)),
        known.state[numbers],
        known.rotation[numbers],
        known.position[numbers],
        known.signs[numbers],
    )


def cell_rows(cells: Cells, which: Any) -> Cells:
    """Some of the cells, by their numbers, by flags, or a slice."""
    return Cells(*(values[which] for values in cells))


def no_guesses(count: int, size: int) -> Floats:
    """Guesses of ways of whose ends nothing is expected; ``size`` is that of a state."""
    shapes = (size,), (3, 3), (3,)
    return configuration_rows(*(np.full((count, *shape), np.nan) for shape in shapes))


def joined(parts: list[Arrivals]) -> Arrivals:
    """Arrivals of consecutive pieces as one."""
    return Arrivals(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def _wait(future: Future[Result]) -> None:
    try:
        future.result(timeout=0.1)
    except TimeoutError:
        return


def _piece(cells: Cells, ways: Ways, first: int, last: int) -> tuple[Cells, Ways]:
    """Some of the cells, and the ways that start there; the ways are in the order of their cells."""
    begin, end = np.searchsorted(ways.origin, [first, last])
    which: Any = slice(begin, end)
    some = Ways(*(values[which] for values in ways))
    return cell_rows(cells, slice(first, last)), some._replace(origin=some.origin - first)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Flooding a grid from one equilibrium, cell by cell along continuous branches."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import nullcontext
from pathlib import Path

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..solving.geometrico_statics import checked_start
from ..validation import checked_count, checked_number, checked_time
from .batches import Cancelled, Crew
from .flood import Flood, Progress
from .grid import Grid
from .refinement import refined_borders
from .slices import check_grid
from .workspace_map import WorkspaceMap

__all__ = ["map_workspace"]


def map_workspace(
    robot: Robot,
    grid: Grid,
    *,
    start: Equilibrium | None = None,
    loads: Loads | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    tolerance: float = 1e-5,
    file: str | Path | None = None,
    resume: bool = True,
    checkpoint_every: float = 30.0,
    progress: Callable[[Progress], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    objective: str | None = None,
) -> WorkspaceMap:
    """Explore a grid from one equilibrium, along the branch it is on.

    Every cell is reached from a neighbour that was reached before: straight, in steps of which every
    Newton correction contracts and the sign of the problem stays; where only the sign changes the walk
    of ``solve_inverse`` and ``solve_forward`` decides. All pairs of neighbours are tried, so that most
    cells are reached by several ways, which have to agree. Unstable equilibria and such beyond limits
    are mapped too. The result does not depend on how many workers there are, or where they are. All
    parameters but robot and grid are independent options, given by name.

    Args:
        robot: The robot.
        grid: What is imposed, from :func:`pose_grid` or :func:`motor_grid`.
        start: Equilibrium to start from; default home. A walk leads from there to the nearest cell.
        loads: Loads; default those of the start.
        executor: Where batches run (threads, processes, ``dask.distributed.Client.get_executor()``);
            default threads.
        workers: Number of threads without ``executor``, default one per core; 0: none at all.
        tolerance: Borders are refined to this, in units of the axes; 0: not refined. Ways to cells are
            followed in steps as small, too: next to folds a coarser one may reach fewer.
        file: NetCDF file to write the map to, every ``checkpoint_every`` seconds and at the end.
        resume: Go on with the map in ``file`` if there is one; it must be of the same robot, loads,
            grid, objective and branch. One that is complete, its borders refined to ``tolerance`` or
            finer, is returned as it is. Without, only a map is replaced.
        checkpoint_every: Longest time between two checkpoints, beside that of one batch [s].
        progress: Called before the first and after every batch.
        cancelled: Asked several times a second; if it says so, the unfinished map is returned, with
            the borders ``file`` had.
        objective: For redundant robots and poses, as in ``solve_inverse``: what is least in every cell;
            least motion is meant from the start.

    Returns:
        The map. ``complete`` is false if it was cancelled; what was found is in ``file``.

    Raises:
        InvalidRequest: A grid of another robot, loads that do not fit, a file of another map or of none,
            or that cannot be written.
        NoInverseSolution, NoForwardSolution: No cell of the grid is reached from the start.
    """
    # Long, for half of it is what the parameters mean; then one loop, to be stopped anywhere.
    start = checked_start(robot, start)
    loads = start.loads if loads is None else loads
    if checked_number("tolerance", tolerance) < 0.0:
        raise InvalidRequest("tolerance", f"expected a positive number or 0, got {tolerance}")
    if workers is not None:
        checked_count("workers", workers, least=0)
    if executor is not None and not isinstance(executor, Executor):
        raise InvalidRequest("executor", f"expected an Executor, got {executor!r:.200}")
    checkpoint_every = checked_time(checkpoint_every, "checkpoint_every")
    check_grid(robot, grid)
    flood = Flood(robot, grid, start, loads, tolerance, objective)
    if file is not None:
        from .store import write_map

        file = Path(file)
        try:
            known = _taken_from(file, flood, resume, Crew(cancelled=cancelled))
        except Cancelled:
            return flood.as_map()
        if known is not None and flood.reached and known.complete and known.refined(tolerance):
            return known
    if flood.reached == 0:
        flood.begin()
    saved = time.monotonic()

    threads = executor is None and workers != 0
    own = ThreadPoolExecutor(workers or os.cpu_count()) if threads else None
    crew = Crew(executor if executor is not None else own, cancelled)
    with own if own is not None else nullcontext():
        try:
            if progress is not None and flood.done < flood.reached:
                progress(flood.progress)
            if flood.done and not flood.as_map().refined(tolerance):
                flood.follow_again(crew)
            while flood.done < flood.reached:
                flood.leave_some(crew)
                if progress is not None:
                    progress(flood.progress)
                if file is not None and time.monotonic() - saved > checkpoint_every:
                    write_map(flood.as_map(), file)
                    saved = time.monotonic()
            found = flood.as_map()
            if not found.refined(tolerance):
                borders = refined_borders(found, flood.problem, tolerance, crew, flood.arrive)
                found = found.with_borders(borders, tolerance)
        except Cancelled:
            found = flood.as_map()
    if file is not None:
        write_map(found, file)
    return found


def _taken_from(file: Path, flood: Flood, resume: bool, crew: Crew) -> WorkspaceMap | None:
    """Go on with the map of a file; returns it, or None where a new one is to be made.

    Raises:
        InvalidRequest: The file is of another map, of none, or cannot be written.
        Cancelled: Before it was known whether the start is on its branch.
    """
    from .map_files import check_replaceable, check_writable
    from .store import read_flood

    check_writable(file, flood.robot, flood.grid)
    if not (resume and file.exists()):
        check_replaceable(file)
        return None
    known = read_flood(file, flood.robot, flood.loads, flood.grid, flood.objective)
    flood.take(known, crew)
    return known

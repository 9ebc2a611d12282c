# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Maps over places where branches cross: the sign of the problem changes there, and walks go on."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cpr_core import NoInverseSolution, load_robot, solve_inverse
from cpr_core.solving.limits import margins
from cpr_core.workspace import EdgeState, map_workspace, pose_grid
from cpr_core.workspace.first_cell import without_limits


@cache
def tilted():
    """The 3-PRS robot tilted until its rods bow to the side: where they begin to, branches cross."""
    robot = load_robot("three_prs")
    grid = pose_grid(robot, {"z": (0.2, 0.6), "pitch": (-1.0, 1.0)}, resolution=0.04)
    return map_workspace(robot, grid, workers=0)


def walked(cell, place):
    """The end of a walk from a cell to a place, whatever motors and rods bear."""
    found = tilted()
    start = replace(found.equilibrium(cell), robot=without_limits(found.robot))
    z, pitch = place
    end = solve_inverse(start.robot, [z, 0.0, pitch], start=start)
    return replace(end, robot=found.robot)


def crossing_ways():
    """Cells and their neighbours, both reached, on two sides of a crossing."""
    found = tilted()
    cell, column = np.nonzero(found.cells.edges[:, 1::2] != EdgeState.UNTRIED)
    neighbour = found.grid.neighbours[cell, 2 * column + 1]
    sides = found.cells.signs[:, -1]
    crossing = found.reached[neighbour] & (sides[cell] != sides[neighbour])
    return list(zip(cell[crossing].tolist(), neighbour[crossing].tolist(), strict=True))


def test_ways_that_a_walk_passes_are_passed_whatever_was_reached_before():
    """Only those to cells not reached yet had been walked; the others were ends of the branch."""
    found, ways = tilted(), crossing_ways()
    assert len(ways) > 4
    for cell, neighbour in ways:
        column = found.grid.neighbours[cell].tolist().index(neighbour)
        end = walked(cell, found.place(neighbour))
        np.testing.assert_allclose(end.motors, found.motors[neighbour], rtol=0.0, atol=1e-8)
        assert found.cells.edges[cell, column] == EdgeState.PASSED
    (ends,) = (border for border in found.borders if border.kind == "singularity")
    assert not {tuple(sorted(pair)) for pair in ends.cells.tolist()} & {*ways}
    for pair in ends.cells[::9].tolist():
        with pytest.raises(NoInverseSolution):
            walked(pair[0], found.place(pair[1]))


def told(kind, equilibrium):
    """What a border of some kind separates, of an equilibrium."""
    if kind == "limits":
        return np.sum(margins(equilibrium) < 0.0)
    return equilibrium.index_locked if kind == "stability" else equilibrium.index_free


def test_borders_behind_a_crossing_are_where_they_are():
    """They had been where the branches cross, where no limit is near and no index changes."""
    found, ways, looked_at = tilted(), crossing_ways(), 0
    for border in found.borders:
        for number, (cell, neighbour) in enumerate(border.cells.tolist()):
            if border.kind == "singularity" or (cell, neighbour) not in ways:
                continue
            beside = 1e-4 * np.sign(found.place(neighbour) - found.place(cell))
            sides = [walked(cell, border.points[number] + way * beside) for way in (-1.0, 1.0)]
            values = [told(border.kind, side) for side in sides]
            assert values == [border.before[number], border.after[number]], border.kind
            looked_at += 1
    assert looked_at > 5


def test_branches_end_where_walks_end_behind_a_crossing():
    """They had been said to end where branches cross, over which walks go on to a fold."""
    robot = load_robot("three_rfs")
    grid = pose_grid(robot, {"z": (0.74, 0.84), "pitch": (0.0, 0.3)}, resolution=0.05)
    found, behind = map_workspace(robot, grid, workers=0), 0
    (ends,) = (border for border in found.borders if border.kind == "singularity")
    for point, (cell, neighbour) in zip(ends.points, ends.cells.tolist(), strict=True):
        first, last = found.place(cell), found.place(neighbour)
        z, pitch = last
        start = replace(found.equilibrium(cell), robot=without_limits(robot))
        with pytest.raises(NoInverseSolution) as refusal:
            solve_inverse(start.robot, [z, 0.0, pitch], start=start)
        reached = first + refusal.value.fraction * (last - first)
        np.testing.assert_allclose(point, reached, rtol=0.0, atol=2e-5)
        column = found.grid.neighbours[cell].tolist().index(neighbour)
        behind += int(found.cells.edges[cell, column] == EdgeState.FLIPPED)
    assert behind > 1

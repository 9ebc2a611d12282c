# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Maps of workspaces: grids of equilibria flooded from one start, with their borders."""

from .borders import Border
from .flooding import map_workspace
from .grid import Grid
from .slices import motor_grid, pose_grid
from .summary import MapSummary, summary_of
from .workspace_map import EdgeState, WorkspaceMap

__all__ = [
    "Border",
    "EdgeState",
    "Grid",
    "MapSummary",
    "WorkspaceMap",
    "map_workspace",
    "motor_grid",
    "pose_grid",
    "summary_of",
]

"""Maps of workspaces: grids of equilibria flooded from one start, with their borders."""

from .borders import Border
from .flooding import map_workspace
from .grid import Grid, motor_grid, pose_grid
from .workspace_map import EdgeState, WorkspaceMap

__all__ = [
    "Border",
    "EdgeState",
    "Grid",
    "WorkspaceMap",
    "map_workspace",
    "motor_grid",
    "pose_grid",
]

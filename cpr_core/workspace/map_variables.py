# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is in the file of a map: its variables and attributes, by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.record_layout import INDEX_FREE, INDEX_LOCKED, INVERSE_SIGN
from ..version import __version__
from .borders import Border, BorderKind
from .cell_layout import (
    BRANCH_SIGN,
    FORWARD_MARGIN,
    INVERSE_MARGIN,
    LARGEST_EIGENVALUE,
    NEAREST_EIGENVALUE,
)
from .map_files import check_axis_names
from .stored_values import as_json, robot_as_json
from .workspace_map import WorkspaceMap

__all__ = [
    "FORMAT",
    "KINDS",
    "MEASURE_COLUMNS",
    "SIGN_COLUMNS",
    "STORED",
    "Variable",
    "attributes_of",
    "variables_of",
]

#: Version of the layout of the file.
FORMAT = 1
#: Kinds of borders, in their order.
KINDS: tuple[BorderKind, ...] = ("stability", "stability_free", "limits", "singularity")

#: Variables that are columns of the signs and the measures of the cells.
SIGN_COLUMNS = {
    "index_locked": INDEX_LOCKED,
    "index_free": INDEX_FREE,
    "inverse_side": INVERSE_SIGN,
    "branch_sign": BRANCH_SIGN,
}
MEASURE_COLUMNS = {
    "smallest_eigenvalue_size": NEAREST_EIGENVALUE,
    "largest_eigenvalue_size": LARGEST_EIGENVALUE,
    "forward_margin": FORWARD_MARGIN,
    "inverse_margin": INVERSE_MARGIN,
}
#: Variables a map is read from; the others follow from them.
STORED = (
    "order",
    "state",
    "platform_rotation",
    "platform_position",
    *SIGN_COLUMNS,
    "efforts",
    "energy",
    "eigenvalues_locked",
    *MEASURE_COLUMNS,
    "edges",
    "edge_fraction",
)


@dataclass(frozen=True, eq=False)
class Variable:
    """An array with named dimensions."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attributes: dict[str, str]


def variables_of(found: WorkspaceMap) -> dict[str, Variable]:
    """Everything in the file by name."""
    grid, cells, robot = found.grid, found.cells, found.robot
    check_axis_names(grid)
    variables = {
        name: Variable((name,), values, {"units": unit})
        for name, values, unit in zip(grid.axis_names, grid.values, grid.axis_units, strict=True)
    }

    def add(name: str, values: NDArray[Any], dims: str, units: str, meaning: str) -> None:
        if values.size:  # NetCDF has no dimensions without length
            variables[name] = Variable(
                (*grid.axis_names, *dims.split()),
                values.reshape(*grid.shape, *values.shape[1:]),
                {"units": units, "long_name": meaning},
            )

    def add_column(name: str, units: str, meaning: str) -> None:
        add(name, columns[name], "", units, meaning)

    units = {motor.unit for motor in robot.description.motors}
    columns: dict[str, NDArray[Any]] = {
        **{name: cells.signs[:, place].astype(np.int16) for name, place in SIGN_COLUMNS.items()},
        **{name: cells.measures[:, place] for name, place in MEASURE_COLUMNS.items()},
    }
    usable = found.usable if np.any(found.reached) else np.zeros(grid.size, bool)
    meaning = "way to a neighbour: 0 untried 1 passed 2 blocked 3 flipped 4 disagrees"
    add("order", cells.order.astype(np.int32), "", "1", "when a cell was reached, -1: not reached")
    add("motors", found.motors, "motor", " or ".join(sorted(units)), "motor positions")
    add("efforts", cells.efforts, "motor", "N m or N", "motor efforts")
    add("platform_position", cells.position, "xyz", "m", "platform origin in the world")
    add("platform_rotation", cells.rotation, "row column", "1", "platform in the world")
    add("energy", cells.energy, "", "J", "potential energy")
    add_column("index_locked", "1", "stability index, motors held, -1: not reached")
    add_column("index_free", "1", "stability index, motors at constant effort")
    add_column("inverse_side", "1", "sign of the determinant of the inverse problem")
    add_column("branch_sign", "1", "sign that tells branches apart")
    add("eigenvalues_locked", cells.eigenvalues, "eigenvalue", "J", "smallest of H_r, motors held")
    add_column("smallest_eigenvalue_size", "J", "smallest absolute one of H_r")
    add_column("largest_eigenvalue_size", "J", "largest absolute one of H_r")
    add("inverse_condition_number", found.inverse_condition_number, "", "1", "of H_r, motors held")
    add_column("forward_margin", "1", "smallest singular value, forward problem")
    add_column("inverse_margin", "1", "smallest singular value, inverse problem")
    add("bending_strain", found.strains, "rod", "1", "largest of every rod")
    add("limit_margin", found.limit_margins, "limit", "1", "distance from limits, negative: beyond")
    add("within_limits", found.within_limits.astype(np.int8), "", "1", "all limits hold")
    add("usable", usable.astype(np.int8), "", "1", "reached stable and within limits all the way")
    add("state", cells.state, "entry", "SI", "leg coordinates, multipliers, (platform,) motors")
    add("edges", cells.edges.astype(np.int8), "way", "1", meaning)
    add("edge_fraction", cells.edge_fraction, "way", "1", "how far the branch was followed there")
    for border in found.borders:
        variables |= _border_variables(border)
    return variables


def _border_variables(border: Border) -> dict[str, Variable]:
    kind = border.kind
    point = f"{kind}_point"
    meaning = f"where the {kind} border is crossed, numbers along the axes"
    parts = {
        "points": Variable((point, "axis"), border.points, {"long_name": meaning}),
        "cells": Variable((point, "side"), border.cells.astype(np.int32), {}),
        "before": Variable((point,), border.before.astype(np.int32), {}),
        "after": Variable((point,), border.after.astype(np.int32), {}),
        "segments": Variable((f"{kind}_segment", "end"), border.segments.astype(np.int32), {}),
    }
    return {f"{kind}_{name}": part for name, part in parts.items() if part.values.size}


def attributes_of(found: WorkspaceMap) -> dict[str, Any]:
    """What the file says of the whole map."""
    return {
        "title": f"workspace of {found.robot.description.name}",
        "source": f"cpr_core {__version__}",
        "cpr_map_format": FORMAT,
        "robot": found.robot.description.name,
        "robot_file": found.robot.description.text,
        "robot_description": robot_as_json(found.robot),
        "loads": as_json(found.loads),
        "grid": as_json(found.grid),
        "motor_names": ", ".join(found.robot.motor_names),
        "limit_names": ", ".join(found.limit_names),
        "border_kinds": " ".join(border.kind for border in found.borders),
        "objective": found.objective,
        "tolerance": float(found.tolerance),
        "refined_to": float(found.refined_to),
        "expanded": found.expanded,
        "complete": int(found.complete),
    }

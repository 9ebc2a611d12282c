# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Orders of a small map, as a node gives them to the process that makes it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from cpr_core import solve_home
from cpr_ros.maps.map_order import MapOrder
from helpers.workspace_cases import rfrfr, small_grid


def small_order(file: Path, **fields: Any) -> MapOrder:
    """The map of 117 cells, in one thread; with other fields."""
    home = solve_home(rfrfr())
    order = MapOrder(
        start=home,
        loads=home.loads,
        grid=small_grid(),
        tolerance=0.0,
        threshold=0.02,
        workers=1,
        file=file,
        resume=False,
        objective=None,
    )
    return replace(order, **fields)

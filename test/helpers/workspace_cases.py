# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Small maps that several tests look at."""

from functools import cache

import numpy as np
import yaml

from cpr_core import load_robot
from cpr_core.workspace import map_workspace, pose_grid


@cache
def rfrfr(modes=5):
    return load_robot("rfrfr", modes=modes)


@cache
def six_rfs():
    return load_robot("six_rfs", modes=3)


def content_of_rfrfr():
    """Content of its description, to change."""
    return yaml.safe_load(rfrfr().description.text.replace("e9 ", ".0e+9 "))


def small_grid():
    """117 cells of the RFRFR robot, across a stability border and the end of the workspace."""
    return pose_grid(rfrfr(), {"x": [-0.6, 0.6], "y": [-0.1, 0.7]}, resolution=0.1)


@cache
def small_map():
    return map_workspace(rfrfr(), small_grid(), workers=0)


def just_beyond(found, cell, other):
    """A place a millionth of the way behind a neighbour.

    Some cells are on the border of the workspace to rounding: (-0.6, 0.6) is a rod's length from the
    second base. Whether such a place itself is reached is chance.
    """
    first, last = found.place(cell), found.place(other)
    return first + (1.0 + 1e-6) * (last - first)


def arrays_of(found):
    """All arrays of a map by name."""
    arrays = {name: getattr(found.cells, name) for name in found.cells.__dataclass_fields__}
    for border in found.borders:
        for name in ("points", "cells", "before", "after", "segments"):
            arrays[f"{border.kind}_{name}"] = getattr(border, name)
    return arrays


def assert_same(found, expected):
    """Two maps are the same, bit for bit."""
    mine, others = arrays_of(found), arrays_of(expected)
    assert mine.keys() == others.keys()
    for name, values in mine.items():
        assert values.shape == others[name].shape, name
        assert values.dtype == others[name].dtype, name
        assert np.array_equal(
            np.ascontiguousarray(values).view(np.uint8),
            np.ascontiguousarray(others[name]).view(np.uint8),
        ), name
    assert found.expanded == expected.expanded

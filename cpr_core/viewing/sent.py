# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is sent of a handle on the page: all that is new and nothing else, places to the last digit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["put", "send_new"]

Floats = NDArray[np.float64]

#: More than what viser takes for the same.
_NEAR = 1e-4


def send_new(handle: Any, **values: Any) -> None:
    """Set properties of a handle, those that change: what is set is sent, also where it is the same."""
    for name, value in values.items():
        if getattr(handle, name) != value:
            setattr(handle, name, value)


def put(node: Any, position: Floats, quaternion: Floats | None = None) -> None:
    """Put a node exactly somewhere.

    viser sends no place that is within a hundred-thousandth of the one before: so it is told another
    place first. Called within ``server.atomic()``, only the last one is seen.

    Args:
        node: A node of the scene.
        position: (3,) [m].
        quaternion: w x y z; None: it is not turned.
    """
    if _hidden(position, node.position):
        node.position = position + 1.0 + np.abs(position)
    node.position = position
    if quaternion is not None:
        if _hidden(quaternion, node.wxyz):
            node.wxyz = -quaternion
        node.wxyz = quaternion


def _hidden(new: Floats, old: Floats) -> bool:
    """Whether a change is one that viser does not send, or nearly so; in plain numbers, for speed."""
    before, after = old.tolist(), new.tolist()
    return before != after and all(
        abs(last - first) < _NEAR * (1.0 + abs(first))
        for first, last in zip(before, after, strict=True)
    )

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a node of the scene is, to the last digit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["put"]

Floats = NDArray[np.float64]


def put(node: Any, position: Floats, quaternion: Floats | None = None) -> None:
    """Put a node exactly somewhere.

    viser sends no place that is within a hundred-thousandth of the one before: so it is told another
    place first. Called within ``server.atomic()``, only the last one is seen.

    Args:
        node: A node of the scene.
        position: (3,) [m].
        quaternion: w x y z; None: it is not turned.
    """
    if not np.array_equal(node.position, position):
        node.position = position + 1.0 + np.abs(position)
        node.position = position
    if quaternion is not None and not np.array_equal(node.wxyz, quaternion):
        node.wxyz = -quaternion
        node.wxyz = quaternion

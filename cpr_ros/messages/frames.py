# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Frames that messages name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Frames"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Frames:
    """Names of the frames the node knows.

    Attributes:
        base: Frame fixed in space, in which the description is written.
        platform: Frame of the platform.
        rotation_to_base: Rotation from another frame to the base frame, (3, 3), or None if it is not
            known; None where nobody knows other frames.
        tracker: Frame of the tracker, where the description of the robot has one.
    """

    base: str
    platform: str
    rotation_to_base: Callable[[str], Floats | None] | None = None
    tracker: str = "tracker"

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What may be compared with a measurement, and where it stands in a row of numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.twist_layout import ANGULAR, LINEAR
from ..model.robot import Robot

__all__ = ["KINDS", "OF_TWIST", "POSE", "Kind", "joined", "kinds_of"]

Floats = NDArray[np.float64]


class Kind(NamedTuple):
    """Something that is measured and compared.

    Attributes:
        unit: In words.
        names: What its numbers are called in a robot.
    """

    unit: str
    names: Callable[[Robot], Sequence[str]]


#: What is compared, in the order of a row, by the names that measurements, standard deviations,
#: derivatives and, but for the pose, equilibria have for it.
KINDS = {
    "position": Kind("m", lambda robot: "xyz"),
    "rotation": Kind("rad", lambda robot: "xyz"),
    "motors": Kind("rad or m", lambda robot: robot.motor_names),
    "efforts": Kind("N m or N", lambda robot: robot.motor_names),
}
#: Position and rotation in a row, which begins with them, and what of them a component of a twist moves.
POSE, OF_TWIST = slice(0, 6), np.empty(6, np.int64)
OF_TWIST[LINEAR], OF_TWIST[ANGULAR] = range(3), range(3, 6)


def kinds_of(robot: Robot) -> NDArray[np.str_]:
    """The kind of every number of a row, (M,)."""
    return np.repeat(list(KINDS), [len(kind.names(robot)) for kind in KINDS.values()])


def joined(robot: Robot, values: Mapping[str, Floats | None]) -> Floats:
    """A row (M,), or columns (M, P), of what every kind has; NaN for a kind that is None."""
    pairs = [(kind, values[name]) for name, kind in KINDS.items()]
    return np.concatenate(
        [
            np.full(len(kind.names(robot)), np.nan) if value is None else value
            for kind, value in pairs
        ]
    )

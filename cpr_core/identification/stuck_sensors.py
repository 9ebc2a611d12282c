# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Sensors and motor readings that show the same in all rows, where they should not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ..lie import quaternion_from_rotation
from ..model.equilibrium import Equilibrium
from .compared import ComparedRow, measured_numbers, predicted_numbers
from .compared_layout import KINDS, kinds_of
from .measurement_doubts import FEWEST_ROWS

__all__ = ["stuck_doubts"]

Floats = NDArray[np.float64]

#: A sensor that shows the same is stuck where predictions differ by so many standard deviations.
_DIFFERENT = 10.0


def stuck_doubts(
    rows: Sequence[ComparedRow], described: Sequence[Equilibrium], answer: Sequence[Equilibrium]
) -> tuple[str, ...]:
    """Sensors and motors that seem to be stuck, one line each.

    Args:
        rows: How rows are compared.
        described: Their equilibria, of the robot as it is described.
        answer: The same of the robot that was found: a tracker elsewhere than described tells others.
    """
    robot, found = described[0].robot, []
    predicted = [
        after if row.measurement.frame == "tracker" else before
        for row, before, after in zip(rows, described, answer, strict=True)
    ]
    for name, place, values, foretold, deviation in _columns(rows, predicted):
        if len(values) < FEWEST_ROWS or np.ptp(values) > 0.0:
            continue
        if np.ptp(foretold) > _DIFFERENT * deviation:
            found.append(
                f"{name}{place} is {values[0]:g} in all {len(values)} rows, though it should vary by "
                f"{np.ptp(foretold):.3g}: a sensor that is stuck?"
            )
    driven = [
        row.measurement.motors
        for row in rows
        if row.problem == "motors" and row.measurement.motors is not None
    ]
    if len(driven) >= FEWEST_ROWS:
        ranges = np.ptp(np.array(driven), axis=0)
        for number in np.flatnonzero(ranges == 0.0) if ranges.any() else ():
            found.append(
                f"motors: {robot.motor_names[number]} is {driven[0][number]:g} in all {len(driven)} "
                "rows, while others move: a reading that is stuck?"
            )
    return tuple(found)


def _columns(
    rows: Sequence[ComparedRow], predicted: Sequence[Equilibrium]
) -> Iterator[tuple[str, str, Floats, Floats, float]]:
    """What was compared column by column: its name, measured, predicted, standard deviation."""
    robot = predicted[0].robot
    shown = [
        (row, measured_numbers(robot, row.measurement), predicted_numbers(row.measurement, found))
        for row, found in zip(rows, predicted, strict=True)
    ]
    names = [name for kind in KINDS.values() for name in kind.names(robot)]
    for place, (kind, name) in enumerate(zip(kinds_of(robot), names, strict=True)):
        if kind == "rotation":  # looked at as quaternions
            continue
        values, foretold, deviations = [], [], [0.0]
        for row, numbers, expected in shown:
            if place in row.places:
                foretold.append(float(expected[place]))
                values.append(float(numbers[place]))
                deviations.append(float(row.deviations[row.places == place][0]))
        title = "position " if kind == "position" else f"{kind}: "
        yield title, name, np.array(values), np.array(foretold), max(deviations)
    turns = [row.deviations[row.kinds == "rotation"] for row in rows]
    deviation = max(map(float, np.concatenate(turns)), default=0.0)
    if deviation > 0.0:
        pairs = [
            (row.measurement, row.measurement.predicted_pose(equilibrium))
            for row, equilibrium in zip(rows, predicted, strict=True)
        ]
        poses = [
            (measured.quaternion_wxyz, quaternion_from_rotation(rotation))
            for measured, (_, rotation) in pairs
            if measured.quaternion_wxyz is not None
        ]
        own, other = np.array(poses).transpose(1, 0, 2)
        for axis, name in enumerate("wxyz"):
            yield "quaternion ", name, own[:, axis], other[:, axis], deviation

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What residuals say of stated standard deviations, and of other units that would explain them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..description.other_units import in_other_units
from ..errors import CprError
from ..model.equilibrium import Equilibrium
from ..solving.geometrico_statics import solve_forward
from .compared import ComparedRow
from .compared_layout import KINDS
from .effort_doubts import BETTER, other_efforts
from .measurement_doubts import unit_doubt
from .measurements import changed_measurement
from .wrench_estimate import consistency_of

__all__ = ["fit_doubts", "kind_doubts"]

#: Residuals over stated deviations that are too small, and fewest degrees of freedom to say so.
_BELOW, _FREE = 1.0 / 1.6, 8
#: Those that are too large, by squares and by robust losses, whose scale is known less well: intervals
#: are as much too narrow.
_ABOVE, _ABOVE_ROBUST = 1.25, 1.6
#: Residuals are as large by chance in so few cases where they are doubted.
_CHANCE = 1e-3
#: Share of the squares that one row has which is to be looked at.
_MOST = 0.5
#: Residuals of one kind over their stated deviations that are no care, which states a little too much.
_FAR_BELOW = 0.1


def fit_doubts(
    rows: Sequence[ComparedRow],
    described: Sequence[Equilibrium],
    fit: float,
    freedom: int,
    refused: str = "",
    *,
    robust: bool = False,
    left: Sequence[float] = (),
) -> list[str]:
    """What residuals say of the standard deviations that were stated, and of units.

    Args:
        rows: How rows were compared.
        described: Their equilibria, of the robot as it is described.
        fit: Root mean square of the residuals in standard deviations.
        freedom: Degrees of freedom.
        refused: Why there was no robot with some parameters that were tried, if so.
        robust: Whether the fit is that of a robust loss.
        left: Squares that are left of the rows, to name the worst.
    """
    if freedom >= _FREE and fit <= _BELOW:
        return [
            f"residuals are {fit:.2g} times what the standard deviations say: these may be too large"
        ]
    if freedom < 1 or not fit >= (_ABOVE_ROBUST if robust else _ABOVE):
        return []
    if consistency_of(freedom * fit**2, freedom) > _CHANCE:
        return []
    robot = described[0].robot
    pairs = [(row, unit_doubt(robot, row.measurement)) for row in rows]
    units = [f"{row.measurement.label}: {doubt}" for row, doubt in pairs if doubt][:1]
    if not units and (doubt := _other_efforts(rows, described) or _other_unit(rows, described)):
        units = [doubt]
    return [
        f"residuals are {fit:.3g} times as large as the standard deviations say: outliers, standard "
        "deviations that are too small, or a robot that differs in more than these parameters"
        + _worst(rows, left),
        *units,
        *([f"on the way there were no robots: {refused}"] if refused else []),
    ]


def _worst(rows: Sequence[ComparedRow], left: Sequence[float]) -> str:
    """Which row has most of the squares that are left, in words; empty: none has."""
    share = max(left, default=0.0) / (sum(left) or 1.0)
    if len(left) * _MOST <= 1.0 or share < _MOST:
        return ""
    worst = rows[max(range(len(left)), key=lambda number: left[number])]
    return f"; {worst.measurement.label} has {100.0 * share:.0f} % of the squares"


def kind_doubts(
    rows: Sequence[ComparedRow], found: Sequence[Equilibrium], determined: int
) -> list[str]:
    """Of which kinds of measurements the standard deviations are far above what is left of them.

    They count for next to nothing then, and the others, whose deviations are right, hide it in the sum.

    Args:
        rows: How rows were compared.
        found: Their equilibria, with the parameters found.
        determined: How many parameters they determine.
    """
    pairs = zip(rows, found, strict=True)
    left = np.concatenate([row.differences(each) / row.deviations for row, each in pairs])
    kinds = np.concatenate([row.kinds for row in rows])
    doubts = []
    for kind, about in KINDS.items():
        own = left[kinds == kind]
        freedom = len(own) - determined
        if freedom >= _FREE and (fit := float(np.sqrt(own @ own / freedom))) <= _FAR_BELOW:
            doubts.append(
                f"{kind}: residuals are {fit:.2g} times what their standard deviation says: it may be "
                f"too large, or in another unit than {about.unit}"
            )
    return doubts


def _other_efforts(rows: Sequence[ComparedRow], described: Sequence[Equilibrium]) -> str:
    """As which other efforts those that are compared fit much better; empty: as none."""
    pairs = [
        (row, row.measurement.efforts, found)
        for row, found in zip(rows, described, strict=True)
        if row.measurement.efforts is not None and (row.kinds == "efforts").any()
    ]
    if not pairs:
        return ""
    measured = np.array([efforts for _, efforts, _ in pairs])
    modelled = np.array([found.efforts for _, _, found in pairs])
    before = np.linalg.norm([np.linalg.norm(row.residual(found)) for row, _, found in pairs])
    for reading in other_efforts(described[0].robot, measured, modelled):
        left = []
        for row, efforts, found in pairs:
            meant = changed_measurement(row.measurement, efforts=reading.factors * efforts)
            other = replace(row, measurement=meant)
            left.append(np.linalg.norm(other.residual(found)))
        if np.linalg.norm(left) < BETTER * before:
            return reading.doubt
    return ""


def _other_unit(rows: Sequence[ComparedRow], described: Sequence[Equilibrium]) -> str:
    """In which other unit the motors of the worst row fit much better; empty: in none."""
    sizes = [
        np.linalg.norm(row.residual(found)) for row, found in zip(rows, described, strict=True)
    ]
    worst = int(np.argmax(sizes))
    row, found = rows[worst], described[worst]
    motors, robot = row.measurement.motors, found.robot
    if row.problem != "motors" or motors is None:
        return ""
    for meant, doubt in in_other_units(robot.description, motors):
        try:
            other = solve_forward(robot, meant, loads=found.loads)
        except CprError:
            continue
        if np.linalg.norm(row.residual(other)) < BETTER * sizes[worst]:
            return f"{row.measurement.label}: {doubt}"
    return ""

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measurements in other units, another order of numbers or another frame, before an answer is sought."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..description.doubted_requests import quaternion_order_doubt, request_doubt
from ..description.other_units import DEGREES, MILLIMETRES
from ..errors import InvalidRequest, distinct
from ..lie import quaternion_from_rotation
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from .effort_doubts import THOUSAND, other_efforts
from .measurements import Measurement, StandardDeviations
from .tracker_rates import of_tracker

__all__ = [
    "FEWEST_ROWS",
    "check_measured",
    "deviation_doubts",
    "frame_doubts",
    "plane_doubt",
    "unit_doubt",
]

Floats = NDArray[np.float64]
#: A measurement and its equilibrium.
Pair = tuple[Measurement, Equilibrium]

#: Fewest rows of which something can be said together.
FEWEST_ROWS = 3
#: Standard deviation of a pose, in rod lengths or radians, with which nobody measures.
_VAGUE = 0.1
#: How far out of its plane a planar robot may be measured: in standard deviations, and in rod lengths or
#: radians. What is farther by both is of another frame, or of another order of numbers.
_OUT_OF_PLANE, _NEAR_PLANE = 10.0, 0.02


def unit_doubt(robot: Robot, row: Measurement) -> str:
    """What looks wrong with the units of a row; empty: nothing."""
    position = row.position if row.frame == "world" else None  # trackers may be anywhere
    given = [
        values if values is not None and np.isfinite(values).all() else None
        for values in (row.motors, position)
    ]
    return request_doubt(robot.description, *given)


def plane_doubt(
    robot: Robot,
    position: Floats | None,
    rotation: Floats | None,
    position_deviation: float,
    rotation_deviation: float,
) -> str:
    """Why a measured pose is not in the plane of a planar robot, which drops what leads out of it.

    Args:
        robot: Any robot.
        position: Of the platform, (3,), NaN for what was not measured [m]; None: not measured.
        rotation: Of the platform, (3, 3); None: not measured.
        position_deviation: Standard deviation of the position [m].
        rotation_deviation: Standard deviation of the rotation [rad].

    Returns:
        In words; empty: it is in the plane, or the robot has none.
    """
    if not robot.planar:
        return ""
    if position is not None:
        near = max(_OUT_OF_PLANE * position_deviation, _NEAR_PLANE * robot.mean_length)
        if abs(position[2]) > near:
            z = float(position[2])
            height, most = distinct(z, math.copysign(near, z), fewest=3)
            return (
                f"z is {height} m, of a robot in the plane z = 0: expected at most {most.lstrip('-')}, "
                "in the frame of the description"
            )
    if rotation is not None and not robot.description.point_platform:
        tilt = float(np.arctan2(np.hypot(rotation[0, 2], rotation[1, 2]), rotation[2, 2]))
        near = max(_OUT_OF_PLANE * rotation_deviation, _NEAR_PLANE)
        if tilt > near:
            by, most = distinct(tilt, near, fewest=3)
            return (
                f"the orientation leads out of the plane z = 0 of this robot by {by} rad: "
                f"expected at most {most}, a turn about z"
            )
    return ""


def check_measured(
    rows: Sequence[Measurement], predicted: Sequence[Equilibrium], deviations: StandardDeviations
) -> None:
    """Whether measurements are in the units, the order and the plane that are expected.

    Args:
        rows: Checked measurements.
        predicted: Their equilibria.
        deviations: Of the measurements.

    Raises:
        InvalidRequest: They are not; names the first such row.
    """
    pairs = list(zip(rows, predicted, strict=True))
    _check_far_positions(pairs)
    _check_quaternions(pairs)
    exactness = deviations.position or 0.0, deviations.rotation or 0.0
    for row, equilibrium in pairs:
        doubt = plane_doubt(equilibrium.robot, row.position, row.rotation, *exactness)
        if doubt and row.frame == "world":
            raise InvalidRequest(row.label, doubt)
    _check_sizes(pairs)


def _check_far_positions(pairs: Sequence[Pair]) -> None:
    """Whether positions that are farther than a rod length from where they should be are in metres."""
    for row, equilibrium in pairs:
        robot, position = equilibrium.robot, row.position
        if position is not None and row.frame == "world" and np.isfinite(position).all():
            far = np.linalg.norm(position - equilibrium.platform_position) > robot.mean_length
            doubt = request_doubt(robot.description, None, position) if far else ""
            if doubt:
                raise InvalidRequest(row.label, doubt)


def _check_quaternions(pairs: Sequence[Pair]) -> None:
    """Whether most quaternions begin with w."""
    doubts = [
        (row, quaternion_order_doubt(given, quaternion_from_rotation(row.predicted_pose(found)[1])))
        for row, found in pairs
        if (given := row.quaternion_wxyz) is not None
    ]
    doubtful = [(row, doubt) for row, doubt in doubts if doubt]
    if 2 * len(doubtful) > len(doubts):
        row, doubt = doubtful[0]
        more = f", as in {len(doubtful)} of {len(doubts)} rows" if len(doubts) > 1 else ""
        raise InvalidRequest(row.named("quaternion_wxyz"), f"{doubt}{more}")


def _check_sizes(pairs: Sequence[Pair]) -> None:
    """Whether positions and efforts are not about a thousand times as large or small as predicted."""
    in_world, in_tracker = (
        [
            (row.position, row.predicted_pose(equilibrium)[0])
            for row, equilibrium in pairs
            if row.frame == frame
        ]
        for frame in ("world", "tracker")
    )
    efforts = [(row.efforts, equilibrium.efforts) for row, equilibrium in pairs]
    for name, unit, compared in (
        ("position", "m", in_world),
        ("position", "m", _from_the_middle(in_tracker)),
        ("efforts", "N m or N", efforts),
    ):
        ratio = _ratio(compared)
        for times in (ratio, 1.0 / ratio):
            if THOUSAND[0] < times < THOUSAND[1]:
                many = "times as large as" if times is ratio else "times smaller than"
                problem = f"about {times:.0f} {many} predicted: another unit? expected {unit}"
                if name == "efforts":
                    problem += _as_other_efforts(pairs)
                raise InvalidRequest(f"measurements: {name}", problem)


def _as_other_efforts(pairs: Sequence[Pair]) -> str:
    """What else than another unit efforts look like, to go on with in words; empty: nothing."""
    compared = [(row.efforts, found.efforts) for row, found in pairs if row.efforts is not None]
    measured, modelled = (np.array(each) for each in zip(*compared, strict=True))
    readings = other_efforts(pairs[0][1].robot, measured, modelled)
    return "".join(f"; {reading.doubt}" for reading in readings)


def _from_the_middle(
    pairs: Sequence[tuple[Floats | None, Floats]],
) -> list[tuple[Floats | None, Floats]]:
    """Places from the medians of those measured, as how far they are depends on the tracker."""
    seen = [(place, predicted) for place, predicted in pairs if place is not None]
    if len(seen) < FEWEST_ROWS:
        return []
    middles = [np.nanmedian(np.array(each), axis=0) for each in zip(*seen, strict=True)]
    return [(place - middles[0], predicted - middles[1]) for place, predicted in seen]


def _ratio(pairs: Sequence[tuple[Floats | None, Floats]]) -> float:
    """Typical size of what was measured over that of what was predicted; 1 where neither tells."""
    sizes = [
        (abs(value), abs(foretold))
        for measured, predicted in pairs
        if measured is not None
        for value, foretold in zip(measured, predicted, strict=True)
        if np.isfinite(value)
    ]
    if not sizes:
        return 1.0
    measured_size, predicted_size = np.median(np.array(sizes), axis=0)
    told = measured_size > 0.0 and predicted_size > 0.0
    return float(measured_size / predicted_size) if told else 1.0


def frame_doubts(rows: Sequence[Measurement], paths: Sequence[str]) -> tuple[str, ...]:
    """Numbers of the tracker that are to be found by rows of which none is in its frame, in a line."""
    if not any(map(of_tracker, paths)) or any(row.frame == "tracker" for row in rows):
        return ()
    return (
        "no row is in the tracker's frame, so nothing tells its numbers: expected columns tracker:x ... "
        "in place of x ..., or measurements with frame='tracker'",
    )


def deviation_doubts(robot: Robot, deviations: StandardDeviations) -> tuple[str, ...]:
    """Which standard deviations of a pose look like another unit, before anything is measured."""
    pairs = (
        ("position", "m", robot.mean_length, MILLIMETRES),
        ("rotation", "rad", 1.0, DEGREES),
    )
    return tuple(
        f"{kind}: a standard deviation of {given:g} {unit} {doubt}"
        for kind, unit, natural, doubt in pairs
        if (given := getattr(deviations, kind) or 0.0) >= _VAGUE * natural
    )

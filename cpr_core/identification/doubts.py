# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measurements that look like other units, another order of numbers, or a sensor that is stuck.

Before an answer is looked for (``check_measured``), and in what it leaves of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from ..description.doubted_requests import quaternion_order_doubt, request_doubt
from ..description.other_units import DEGREES, MILLIMETRES, in_other_units
from ..errors import CprError, InvalidRequest, distinct
from ..lie import quaternion_from_rotation
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..solving.geometrico_statics import solve_forward
from .compared import ComparedRow, measured_numbers, predicted_numbers
from .compared_layout import KINDS, kinds_of
from .effort_doubts import BETTER, THOUSAND, other_efforts
from .measurements import Measurement, StandardDeviations, changed_measurement
from .tracker_rates import of_tracker

__all__ = [
    "check_measured",
    "deviation_doubts",
    "fit_doubts",
    "frame_doubts",
    "kind_doubts",
    "measured_doubts",
    "plane_doubt",
    "unit_doubt",
]

Floats = NDArray[np.float64]

#: Fewest rows of which something can be said together.
_FEW = 3
#: A sensor that shows the same is stuck where predictions differ by so many standard deviations.
_DIFFERENT = 10.0
#: Residuals over stated deviations, either way, that are beyond chance; fewest degrees of freedom.
_BEYOND, _FREE = 1.6, 8
#: With fewer of them residuals are so large by chance in so few cases where they are doubted.
_CHANCE = 1e-3
#: Residuals of one kind over their stated deviations that are no care, which states a little too much.
_FAR_BELOW = 0.1
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
    exactness = deviations.position or 0.0, deviations.rotation or 0.0
    for row, equilibrium in zip(rows, predicted, strict=True):
        robot, position = equilibrium.robot, row.position
        if position is not None and row.frame == "world" and np.isfinite(position).all():
            far = np.linalg.norm(position - equilibrium.platform_position) > robot.mean_length
            doubt = request_doubt(robot.description, None, position) if far else ""
            if doubt:
                raise InvalidRequest(row.label, doubt)
    poses = [
        row.predicted_pose(equilibrium) for row, equilibrium in zip(rows, predicted, strict=True)
    ]
    pairs = [
        (row, quaternion_order_doubt(row.quaternion_wxyz, quaternion_from_rotation(rotation)))
        for row, (_, rotation) in zip(rows, poses, strict=True)
        if row.quaternion_wxyz is not None
    ]
    doubtful = [(row, doubt) for row, doubt in pairs if doubt]
    if 2 * len(doubtful) > len(pairs):
        row, doubt = doubtful[0]
        more = f", as in {len(doubtful)} of {len(pairs)} rows" if len(pairs) > 1 else ""
        raise InvalidRequest(row.named("quaternion_wxyz"), f"{doubt}{more}")
    for row, equilibrium in zip(rows, predicted, strict=True):
        doubt = plane_doubt(equilibrium.robot, row.position, row.rotation, *exactness)
        if doubt and row.frame == "world":
            raise InvalidRequest(row.label, doubt)
    positions = [(row.position, position) for row, (position, _) in zip(rows, poses, strict=True)]
    in_world, in_tracker = (
        [pair for row, pair in zip(rows, positions, strict=True) if row.frame == frame]
        for frame in ("world", "tracker")
    )
    efforts = [(row.efforts, found.efforts) for row, found in zip(rows, predicted, strict=True)]
    for name, unit, both in (
        ("position", "m", in_world),
        ("position", "m", _from_the_middle(in_tracker)),
        ("efforts", "N m or N", efforts),
    ):
        ratio = _ratio(both)
        for seen in (ratio, 1.0 / ratio):
            if THOUSAND[0] < seen < THOUSAND[1]:
                many = "times as large as" if seen is ratio else "times smaller than"
                problem = f"about {seen:.0f} {many} predicted: another unit? expected {unit}"
                if name == "efforts":
                    problem += _as_other_efforts(rows, predicted)
                raise InvalidRequest(f"measurements: {name}", problem)


def _as_other_efforts(rows: Sequence[Measurement], predicted: Sequence[Equilibrium]) -> str:
    """What else than another unit efforts look like, to go on with in words; empty: nothing."""
    pairs = [
        (row.efforts, found.efforts)
        for row, found in zip(rows, predicted, strict=True)
        if row.efforts is not None
    ]
    measured, modelled = (np.array(each) for each in zip(*pairs, strict=True))
    readings = other_efforts(predicted[0].robot, measured, modelled)
    return "".join(f"; {reading.doubt}" for reading in readings)


def _from_the_middle(
    pairs: Sequence[tuple[Floats | None, Floats]],
) -> list[tuple[Floats | None, Floats]]:
    """Places from the medians of those measured, as how far they are depends on the tracker."""
    found = [(place, other) for place, other in pairs if place is not None]
    if len(found) < _FEW:
        return []
    middles = [np.nanmedian(np.array(each), axis=0) for each in zip(*found, strict=True)]
    return [(place - middles[0], other - middles[1]) for place, other in found]


def _ratio(pairs: Sequence[tuple[Floats | None, Floats]]) -> float:
    """Typical size of what was measured over that of what was predicted; 1 where neither tells."""
    sizes = [
        (abs(value), abs(other))
        for row, prediction in pairs
        if row is not None
        for value, other in zip(row, prediction, strict=True)
        if np.isfinite(value)
    ]
    if not sizes:
        return 1.0
    seen, foretold = np.median(np.array(sizes), axis=0)
    return float(seen / foretold) if seen > 0.0 and foretold > 0.0 else 1.0


def frame_doubts(rows: Sequence[Measurement], paths: Sequence[str]) -> tuple[str, ...]:
    """Numbers of the tracker that are to be found by rows of which none is in its frame, in a line."""
    if not any(map(of_tracker, paths)) or any(row.frame == "tracker" for row in rows):
        return ()
    return (
        "no row is in the tracker's frame, so nothing tells its numbers: expected columns tracker:x ... "
        "in place of x ..., or measurements with frame='tracker'",
    )


def measured_doubts(
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
        if len(values) < _FEW or np.ptp(values) > 0.0:
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
    if len(driven) >= _FEW:
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


def fit_doubts(
    rows: Sequence[ComparedRow],
    described: Sequence[Equilibrium],
    fit: float,
    freedom: int,
    refused: str = "",
) -> list[str]:
    """What residuals say of the standard deviations that were stated, and of units.

    Args:
        rows: How rows were compared.
        described: Their equilibria, of the robot as it is described.
        fit: Root mean square of the residuals in standard deviations.
        freedom: Degrees of freedom.
        refused: Why there was no robot with some parameters that were tried, if so.
    """
    if freedom >= _FREE and fit <= 1.0 / _BEYOND:
        return [
            f"residuals are {fit:.2g} times what the standard deviations say: these may be too large"
        ]
    if freedom < 1 or not fit >= _BEYOND:
        return []
    if freedom < _FREE and scipy.special.gammaincc(0.5 * freedom, 0.5 * freedom * fit**2) > _CHANCE:
        return []
    robot = described[0].robot
    pairs = [(row, unit_doubt(robot, row.measurement)) for row in rows]
    units = [f"{row.measurement.label}: {doubt}" for row, doubt in pairs if doubt][:1]
    if not units and (doubt := _other_efforts(rows, described) or _other_unit(rows, described)):
        units = [doubt]
    return [
        f"residuals are {fit:.3g} times as large as the standard deviations say: outliers, standard "
        "deviations that are too small, or a robot that differs in more than these parameters",
        *units,
        *([f"on the way there were no robots: {refused}"] if refused else []),
    ]


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

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a tracker is that nobody has measured: roughly, from what it tells and where the robot is.

Calibration then begins near its answer, and what looks wrong with units is seen. X, Y, A and B as in
``description/tracker.py``. How X is turned is tried in several ways: as orientations have it (Shah, J.
Mechanisms Robotics 5 (3), 031007, 2013), as positions do (Kabsch, Acta Cryst. A32, 922, 1976), and as
the axes of a cube are. Places and the marker's turn are linear then, and all is made better together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from ..description.tracker import Tracker
from ..errors import InvalidRequest
from ..lie import projected_rotation, rotation_exp, rotation_log
from ..model.equilibrium import Equilibrium
from .effort_doubts import THOUSAND
from .measurements import Measurement, StandardDeviations
from .tracker_rows import TrackerRows

__all__ = ["aligned_tracker"]

Floats = NDArray[np.float64]

#: Fields of a tracker by the paths of its parameters.
_FIELDS = {
    "tracker.position": "position",
    "tracker.rotation_vector": "rotation_vector",
    "tracker.marker.position": "marker_position",
    "tracker.marker.rotation_vector": "marker_rotation_vector",
}
#: Fewest rows that say how a frame is turned.
_FEW = 3
#: Singular values below this part of the largest are those of places in a line, or of a platform that
#: does not turn.
_NONE = 1e-6
#: So many starts are made better.
_BEST = 4
#: Weight of numbers that stay, per metre or radian, in standard deviations: where rows do not tell them.
_HOLD = 0.1
#: Steps of making it better, each of all numbers.
_TRIED = 100
#: How far inside of bounds numbers are begun with, part of what is between: on them they would stay.
_INSIDE = 0.05
#: Farthest that a marker is from its platform, in rod lengths: beyond is another unit.
_FAR = 10.0


def aligned_tracker(
    rows: Sequence[Measurement],
    predicted: Sequence[Equilibrium],
    paths: Sequence[str],
    deviations: StandardDeviations,
    limits: Floats,
) -> Mapping[str, float]:
    """Those numbers of the tracker that are to be found, as they fit the robot as it is described.

    Args:
        rows: Checked measurements.
        predicted: Their equilibria, of one robot.
        paths: Of all parameters that are to be found.
        deviations: Of the measurements.
        limits: Lowest and highest values of all parameters, (2, P).

    Returns:
        Values by path; none where nothing of the tracker is to be found, or rows do not tell it.

    Raises:
        InvalidRequest: Distances are a thousand times what they should be, or a thousandth.
    """
    robot = predicted[0].robot
    tracker, free = robot.description.tracker, _free_numbers(paths)
    point = robot.description.point_platform
    pairs = [
        (row, equilibrium)
        for row, equilibrium in zip(rows, predicted, strict=True)
        if row.frame == "tracker"
    ]
    if tracker is None or not free or len(pairs) < _FEW:
        return {}
    seen = TrackerRows(
        np.array([_or_none(row.position, (3,)) for row, _ in pairs]),
        np.array([_or_none(None if point else row.rotation, (3, 3)) for row, _ in pairs]),
        np.array([equilibrium.platform_position for _, equilibrium in pairs]),
        np.array([equilibrium.platform_rotation for _, equilibrium in pairs]),
        1.0 / (deviations.position or 1.0),
        1.0 / (deviations.rotation or 1.0),
    )
    starts = _starts(tracker, seen, free)
    if not starts:
        return {}
    costs = [float(np.abs(seen.differences(each)).sum()) for each in starts]
    ends = {path: limits[:, number] for number, path in enumerate(paths)}
    order = np.argsort(costs)[:_BEST]
    best = [_improved(starts[number], tracker, seen, free, ends) for number in order]
    found, _ = min(best, key=lambda pair: pair[1])
    _check_unit(seen, found, "tracker.marker.position" in free, robot.mean_length)
    return {
        f"{path}[{axis}]": float(vector[axis])
        for path, axes in free.items()
        for vector in [getattr(found, _FIELDS[path])]
        for axis in axes
    }


def _free_numbers(paths: Sequence[str]) -> dict[str, list[int]]:
    """Axes of the vectors of a tracker that are to be found, by their paths."""
    each = {path: [axis for axis in range(3) if f"{path}[{axis}]" in paths] for path in _FIELDS}
    return {path: axes for path, axes in each.items() if axes}


def _or_none(value: Floats | None, shape: tuple[int, ...]) -> Floats:
    """What was measured, NaN where it was not."""
    return np.full(shape, np.nan) if value is None else value


def _starts(tracker: Tracker, seen: TrackerRows, free: Mapping[str, list[int]]) -> list[Tracker]:
    """Trackers to begin with; none where rows do not say how a tracker is turned that is to be found."""
    if len(free.get("tracker.rotation_vector", ())) < 3:
        return [_placed(tracker, seen, free)]
    rotations = []
    if seen.placed.sum() >= _FEW:
        measured, markers = (
            each[seen.placed] - each[seen.placed].mean(axis=0)
            for each in (seen.marker_positions, seen.markers(tracker))
        )
        spread = np.linalg.svd(measured, compute_uv=False)
        if spread[1] > _NONE * spread[0]:
            rotations.append(projected_rotation(markers.T @ measured))
    if seen.oriented.sum() >= _FEW:
        rotations.append(_turned_as(tracker, seen, free))
    if not rotations:
        return []
    rotations += list(scipy.spatial.transform.Rotation.create_group("O").as_matrix())
    return [
        _placed(replace(tracker, rotation_vector=rotation_log(rotation)), seen, free)
        for rotation in rotations
    ]


def _turned_as(tracker: Tracker, seen: TrackerRows, free: Mapping[str, list[int]]) -> Floats:
    """How the tracker is turned, as orientations have it: R_X A = B R_Y of every row, (3, 3)."""
    own, measured = seen.platform_rotations[seen.oriented], seen.marker_rotations[seen.oriented]
    if len(free.get("tracker.marker.rotation_vector", ())) < 3:
        return projected_rotation(
            np.einsum("nij,jk,nlk->il", own, tracker.marker_rotation, measured)
        )
    # Entry by entry R_Y = B^T R_X A is linear in R_X: on the right one the mean is as large as can be.
    whole = np.einsum("nji,nkl->iljk", own, measured).reshape(9, 9)
    _, _, right = np.linalg.svd(whole)
    rotation = right[0].reshape(3, 3)
    return projected_rotation(rotation * np.sign(np.linalg.det(rotation)))


def _placed(tracker: Tracker, seen: TrackerRows, free: Mapping[str, list[int]]) -> Tracker:
    """The tracker with its place and its marker where they fit how it is turned."""
    measured, places, turns = (
        each[seen.placed]
        for each in (seen.marker_positions, seen.platform_positions, seen.platform_rotations)
    )
    rotated, marker = measured @ tracker.rotation.T, tracker.marker_position
    if len(measured) and len(free.get("tracker.marker.position", ())) == 3:
        # With middles taken off the place of the tracker is gone.
        lacking = rotated - places - turns @ marker
        lacking = lacking - lacking.mean(axis=0)
        matrix = (turns - turns.mean(axis=0)).reshape(-1, 3)
        marker = marker + np.linalg.lstsq(matrix, lacking.ravel(), rcond=_NONE)[0]
    position = tracker.position
    if len(measured) and len(free.get("tracker.position", ())) == 3:
        position = np.median(places + turns @ marker - rotated, axis=0)
    turn = tracker.marker_rotation_vector
    if seen.oriented.any() and len(free.get("tracker.marker.rotation_vector", ())) == 3:
        own, measured = seen.platform_rotations[seen.oriented], seen.marker_rotations[seen.oriented]
        turn = rotation_log(
            projected_rotation(np.einsum("nji,jk,nkl->il", own, tracker.rotation, measured))
        )
    return replace(tracker, position=position, marker_position=marker, marker_rotation_vector=turn)


def _improved(
    start: Tracker,
    described: Tracker,
    seen: TrackerRows,
    free: Mapping[str, list[int]],
    limits: Mapping[str, Floats],
) -> tuple[Tracker, float]:
    """All numbers made better together, whatever is wrong in some rows; and how well they fit."""
    places = [(path, axis) for path, axes in free.items() for axis in axes]
    low, high = np.array([limits[f"{path}[{axis}]"] for path, axis in places]).T
    wanted = np.clip([getattr(described, _FIELDS[path])[axis] for path, axis in places], low, high)
    vectors = {field.name: getattr(start, field.name).copy() for field in fields(Tracker)}
    for path in free:
        if path.endswith("rotation_vector"):
            vector = getattr(described, _FIELDS[path]).copy()
            for (other, axis), value in zip(places, wanted, strict=True):
                if other == path:
                    vector[axis] = value
            vectors[_FIELDS[path]] = _near(vectors[_FIELDS[path]], vector)

    def at(values: Floats) -> Tracker:
        changed = {name: vector.copy() for name, vector in vectors.items()}
        for (path, axis), value in zip(places, values, strict=True):
            changed[_FIELDS[path]][axis] = value
        return Tracker(**changed)

    begin = np.array([vectors[_FIELDS[path]][axis] for path, axis in places])
    bounded = np.isfinite(low) & np.isfinite(high)
    room = np.zeros(len(places))
    room[bounded] = _INSIDE * (high - low)[bounded]
    begin = np.clip(begin, low + room, high - room)

    columns = [3 * list(_FIELDS).index(path) + axis for path, axis in places]

    def residual(values: Floats) -> Floats:
        return np.concatenate([seen.differences(at(values)), _HOLD * (values - begin)])

    def rates(values: Floats) -> Floats:
        return np.concatenate([seen.rates(at(values))[:, columns], _HOLD * np.eye(len(values))])

    found = scipy.optimize.least_squares(
        residual,
        begin,
        rates,
        bounds=(low, high),
        loss="soft_l1",
        x_scale="jac",
        max_nfev=_TRIED,
    )
    return at(found.x), float(found.cost)


def _check_unit(seen: TrackerRows, tracker: Tracker, marker_found: bool, length: float) -> None:
    """Whether distances are those of the robot.

    Raises:
        InvalidRequest: They are not.
    """
    arm = float(np.linalg.norm(tracker.marker_position))
    if marker_found and arm > _FAR * length:
        problem = f"the marker would be {arm:.3g} m from the platform"
        raise InvalidRequest("measurements: position", f"{problem}: another unit? expected m")
    if seen.placed.sum() < _FEW:
        return
    sizes = [
        float(np.median(np.abs(each - np.median(each, axis=0))))
        for each in (seen.marker_positions[seen.placed], seen.markers(tracker)[seen.placed])
    ]
    if not all(sizes):
        return
    ratio = sizes[0] / sizes[1]
    if any(THOUSAND[0] < each < THOUSAND[1] for each in (ratio, 1.0 / ratio)):
        problem = f"distances in the tracker's frame are {ratio:.3g} times those of the robot"
        raise InvalidRequest("measurements: position", f"{problem}: another unit? expected m")


def _near(vector: Floats, described: Floats) -> Floats:
    """The rotation vector of the same rotation that is nearest to another one, within a turn."""
    vector = rotation_log(rotation_exp(vector))
    angle = float(np.linalg.norm(vector))
    other = vector * (1.0 - 2.0 * np.pi / angle) if angle > 0.0 else vector
    return min(vector, other, key=lambda each: float(np.linalg.norm(each - described)))

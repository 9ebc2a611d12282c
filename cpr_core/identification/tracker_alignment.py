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
from dataclasses import dataclass, fields, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from ..description.tracker import Tracker
from ..errors import InvalidRequest
from ..lie import projected_rotation
from ..model.equilibrium import Equilibrium
from .doubts import THOUSAND
from .measurements import Measurement, StandardDeviations

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
#: Farthest that a marker is from its platform, in rod lengths: beyond is another unit.
_FAR = 10.0


@dataclass(frozen=True, eq=False)
class _Rows:
    """What was measured of N rows, and where the platform then should be.

    Attributes:
        told: Positions of the marker, (N, 3) [m].
        turned: Orientations of the marker, (N, 3, 3); NaN where they were not measured.
        places: Of the platform in the world, (N, 3) [m].
        turns: Of the platform in the world, (N, 3, 3).
        weights: One over the standard deviations of positions and rotations.
    """

    told: Floats
    turned: Floats
    places: Floats
    turns: Floats
    weights: tuple[float, float]

    def differences(self, tracker: Tracker) -> Floats:
        """Predicted less measured in standard deviations, those that were measured, (M,)."""
        into = tracker.rotation.T
        markers = self.places + self.turns @ tracker.marker_position
        apart = (markers - tracker.position) @ tracker.rotation - self.told
        seen = np.isfinite(self.turned[:, 0, 0])
        predicted = into @ self.turns[seen] @ tracker.marker_rotation
        turn = scipy.spatial.transform.Rotation.from_matrix(
            predicted @ self.turned[seen].transpose(0, 2, 1)
        ).as_rotvec()
        along, about = self.weights
        return np.concatenate([along * apart.ravel(), about * turn.ravel()])


def aligned_tracker(
    rows: Sequence[Measurement],
    predicted: Sequence[Equilibrium],
    paths: Sequence[str],
    deviations: StandardDeviations,
) -> Mapping[str, float]:
    """Those numbers of the tracker that are to be found, as they fit the robot as it is described.

    Args:
        rows: Checked measurements.
        predicted: Their equilibria, of one robot.
        paths: Of all parameters that are to be found.
        deviations: Of the measurements.

    Returns:
        Values by path; none where nothing of the tracker is to be found, or rows do not tell it.

    Raises:
        InvalidRequest: Distances are a thousand times what they should be, or a thousandth.
    """
    robot = predicted[0].robot
    tracker, free = robot.description.tracker, _free_numbers(paths)
    pairs = [
        (row, equilibrium)
        for row, equilibrium in zip(rows, predicted, strict=True)
        if row.frame == "tracker" and row.position is not None and np.isfinite(row.position).all()
    ]
    if tracker is None or not free or len(pairs) < _FEW:
        return {}
    seen = _Rows(
        np.array([row.position for row, _ in pairs]),
        np.array([_turn(row) for row, _ in pairs]),
        np.array([equilibrium.platform_position for _, equilibrium in pairs]),
        np.array([equilibrium.platform_rotation for _, equilibrium in pairs]),
        (1.0 / (deviations.position or 1.0), 1.0 / (deviations.rotation or 1.0)),
    )
    starts = _starts(tracker, seen, free)
    if not starts:
        return {}
    costs = [float(np.abs(seen.differences(each)).sum()) for each in starts]
    best = [_improved(starts[number], seen, free) for number in np.argsort(costs)[:_BEST]]
    found, _ = min(best, key=lambda pair: pair[1])
    _check_unit(seen, found, "tracker.marker.position" in free, robot.mean_length)
    return {
        f"{path}[{axis}]": float(vector[axis])
        for path, axes in free.items()
        for vector in [_near(path, getattr(found, _FIELDS[path]), tracker)]
        for axis in axes
    }


def _free_numbers(paths: Sequence[str]) -> dict[str, list[int]]:
    """Axes of the vectors of a tracker that are to be found, by their paths."""
    each = {path: [axis for axis in range(3) if f"{path}[{axis}]" in paths] for path in _FIELDS}
    return {path: axes for path, axes in each.items() if axes}


def _turn(row: Measurement) -> Floats:
    """Orientation of the marker, (3, 3), NaN where it was not measured or is a point's."""
    return np.full((3, 3), np.nan) if row.rotation is None else row.rotation


def _starts(tracker: Tracker, seen: _Rows, free: Mapping[str, list[int]]) -> list[Tracker]:
    """Trackers to begin with; none where rows do not say how a tracker is turned that is to be found."""
    if len(free.get("tracker.rotation_vector", ())) < 3:
        return [_placed(tracker, seen, free)]
    markers = seen.places + seen.turns @ tracker.marker_position
    told, there = (each - each.mean(axis=0) for each in (seen.told, markers))
    measured = np.isfinite(seen.turned[:, 0, 0])
    spread = np.linalg.svd(told, compute_uv=False)
    if measured.sum() < _FEW and spread[1] <= _NONE * spread[0]:
        return []
    rotations = [projected_rotation(there.T @ told)]
    if measured.any():
        rotations.append(_turned_as(tracker, seen, measured, free))
    rotations += list(scipy.spatial.transform.Rotation.create_group("O").as_matrix())
    return [
        _placed(replace(tracker, rotation_vector=_vector(rotation)), seen, free)
        for rotation in rotations
    ]


def _turned_as(
    tracker: Tracker, seen: _Rows, measured: NDArray[np.bool_], free: Mapping[str, list[int]]
) -> Floats:
    """How the tracker is turned, as orientations have it: R_X A = B R_Y of every row, (3, 3)."""
    own, told = seen.turns[measured], seen.turned[measured]
    if len(free.get("tracker.marker.rotation_vector", ())) < 3:
        return projected_rotation(np.einsum("nij,jk,nlk->il", own, tracker.marker_rotation, told))
    # Entry by entry R_Y = B^T R_X A is linear in R_X: on the right one the mean is as large as can be.
    whole = np.einsum("nji,nkl->iljk", own, told).reshape(9, 9)
    _, _, right = np.linalg.svd(whole)
    rotation = right[0].reshape(3, 3)
    return projected_rotation(rotation * np.sign(np.linalg.det(rotation)))


def _placed(tracker: Tracker, seen: _Rows, free: Mapping[str, list[int]]) -> Tracker:
    """The tracker with its place and its marker where they fit how it is turned."""
    rotated = seen.told @ tracker.rotation.T
    marker = tracker.marker_position
    if len(free.get("tracker.marker.position", ())) == 3:
        # With middles taken off the place of the tracker is gone.
        turns = seen.turns - seen.turns.mean(axis=0)
        lacking = rotated - seen.places - seen.turns @ marker
        lacking = lacking - lacking.mean(axis=0)
        change = np.linalg.lstsq(turns.reshape(-1, 3), lacking.ravel(), rcond=_NONE)[0]
        marker = marker + change
    position = tracker.position
    if len(free.get("tracker.position", ())) == 3:
        position = np.median(seen.places + seen.turns @ marker - rotated, axis=0)
    turn = tracker.marker_rotation_vector
    measured = np.isfinite(seen.turned[:, 0, 0])
    if measured.any() and len(free.get("tracker.marker.rotation_vector", ())) == 3:
        own, told = seen.turns[measured], seen.turned[measured]
        turn = _vector(projected_rotation(np.einsum("nji,jk,nkl->il", own, tracker.rotation, told)))
    return replace(tracker, position=position, marker_position=marker, marker_rotation_vector=turn)


def _improved(start: Tracker, seen: _Rows, free: Mapping[str, list[int]]) -> tuple[Tracker, float]:
    """All numbers made better together, whatever is wrong in some rows; and how well they fit."""
    places = [(field.name, axis) for field in fields(Tracker) for axis in _axes(field.name, free)]

    def at(values: Floats) -> Tracker:
        vectors = {field.name: getattr(start, field.name).copy() for field in fields(Tracker)}
        for (name, axis), value in zip(places, values, strict=True):
            vectors[name][axis] = value
        return replace(start, **vectors)

    begin = np.array([getattr(start, name)[axis] for name, axis in places])

    def residual(values: Floats) -> Floats:
        return np.concatenate([seen.differences(at(values)), _HOLD * (values - begin)])

    found = scipy.optimize.least_squares(
        residual, begin, loss="soft_l1", x_scale="jac", max_nfev=_TRIED
    )
    return at(found.x), float(found.cost)


def _axes(name: str, free: Mapping[str, list[int]]) -> list[int]:
    """Axes of a field that are to be found."""
    return next((free.get(path, []) for path, field in _FIELDS.items() if field == name), [])


def _check_unit(seen: _Rows, tracker: Tracker, marker_found: bool, length: float) -> None:
    """Whether distances are those of the robot.

    Raises:
        InvalidRequest: They are not.
    """
    arm = float(np.linalg.norm(tracker.marker_position))
    if marker_found and arm > _FAR * length:
        problem = f"the marker would be {arm:.3g} m from the platform"
        raise InvalidRequest("measurements: position", f"{problem}: another unit? expected m")
    sizes = [
        float(np.median(np.abs(each - np.median(each, axis=0))))
        for each in (seen.told, seen.places + seen.turns @ tracker.marker_position)
    ]
    if not all(sizes):
        return
    ratio = sizes[0] / sizes[1]
    if any(THOUSAND[0] < each < THOUSAND[1] for each in (ratio, 1.0 / ratio)):
        problem = f"distances in the tracker's frame are {ratio:.3g} times those of the robot"
        raise InvalidRequest("measurements: position", f"{problem}: another unit? expected m")


def _near(path: str, vector: Floats, described: Tracker) -> Floats:
    """A vector that was found; of a rotation the one nearest to that described, within a turn."""
    if not path.endswith("rotation_vector"):
        return vector
    vector = _vector(scipy.spatial.transform.Rotation.from_rotvec(vector).as_matrix())
    angle, own = float(np.linalg.norm(vector)), getattr(described, _FIELDS[path])
    other = vector * (1.0 - 2.0 * np.pi / angle) if angle > 0.0 else vector
    return min(vector, other, key=lambda each: float(np.linalg.norm(each - own)))


def _vector(rotation: Floats) -> Floats:
    """Rotation vector of a rotation, (3,)."""
    found: Floats = scipy.spatial.transform.Rotation.from_matrix(rotation).as_rotvec()
    return found

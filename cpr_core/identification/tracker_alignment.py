# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a tracker is that nobody has measured: roughly, from what it tells and where the robot is.

Calibration then begins near its answer, and what looks wrong with units is seen. X and Y as in
``description/tracker.py``: X is the rigid motion that fits best (Kabsch, Acta Cryst. A32, 922, 1976).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..description.tracker import Tracker
from ..errors import InvalidRequest
from ..lie import rotation_log
from ..model.equilibrium import Equilibrium
from .doubts import THOUSAND
from .measurements import Measurement

__all__ = ["aligned_tracker"]

Floats = NDArray[np.float64]

#: Fewest places that say how a frame is turned.
_FEW = 3
#: Places in a line, relative to how far they are apart, do not.
_IN_LINE = 1e-6
#: Times that tracker and marker are found in turn.
_TURNS = 20


def aligned_tracker(
    rows: Sequence[Measurement], predicted: Sequence[Equilibrium], paths: Sequence[str]
) -> Mapping[str, float]:
    """Those numbers of the tracker that are to be found, as they fit the robot as it is described.

    Args:
        rows: Checked measurements.
        predicted: Their equilibria, of one robot.
        paths: Of all parameters that are to be found.

    Returns:
        Values by path; none where the place of the tracker is known, or rows do not tell it.

    Raises:
        InvalidRequest: Distances are a thousand times what they should be, or a thousandth.
    """
    tracker = predicted[0].robot.description.tracker
    if tracker is None or not _all_of("tracker", paths):
        return {}
    pairs = [
        (row, equilibrium)
        for row, equilibrium in zip(rows, predicted, strict=True)
        if row.frame == "tracker" and row.position is not None and np.isfinite(row.position).all()
    ]
    told = np.array([row.position for row, _ in pairs]).reshape(-1, 3)
    spread = (
        np.linalg.svd(told - told.mean(axis=0), compute_uv=False) if len(pairs) else np.zeros(3)
    )
    if len(pairs) < _FEW or spread[1] <= _IN_LINE * spread[0]:
        return {}
    found = _fitted(tracker, pairs, told, paths)
    numbers = {
        "tracker.position": found.position,
        "tracker.rotation_vector": _near(found.rotation_vector, tracker.rotation_vector),
        "tracker.marker.position": found.marker_position,
        "tracker.marker.rotation_vector": _near(
            found.marker_rotation_vector, tracker.marker_rotation_vector
        ),
    }
    values = {
        f"{name}[{axis}]": float(vector[axis])
        for name, vector in numbers.items()
        for axis in range(3)
    }
    return {path: values[path] for path in paths if path in values}


def _all_of(
    frame: str, paths: Sequence[str], names: Sequence[str] = ("position", "rotation_vector")
) -> bool:
    """Whether all numbers of fields of a frame are to be found."""
    return all(f"{frame}.{name}[{axis}]" in paths for name in names for axis in range(3))


def _fitted(
    tracker: Tracker,
    pairs: Sequence[tuple[Measurement, Equilibrium]],
    told: Floats,
    paths: Sequence[str],
) -> Tracker:
    """The tracker with what is to be found of it, from positions and, for the marker, orientations."""
    places = np.array([equilibrium.platform_position for _, equilibrium in pairs])
    turns = np.array([equilibrium.platform_rotation for _, equilibrium in pairs])
    _check_unit(told, places + turns @ tracker.marker_position)
    marker_found = _all_of("tracker.marker", paths, ("position",))
    for _ in range(_TURNS if marker_found else 1):
        markers = places + turns @ tracker.marker_position
        rotation = _rotation(told - told.mean(axis=0), markers - markers.mean(axis=0))
        position = markers.mean(axis=0) - rotation @ told.mean(axis=0)
        tracker = replace(tracker, position=position, rotation_vector=rotation_log(rotation))
        if marker_found:
            arms = turns.transpose(0, 2, 1) @ (position + told @ rotation.T - places)[:, :, None]
            tracker = replace(tracker, marker_position=arms[:, :, 0].mean(axis=0))
    seen = [(row.rotation, e.platform_rotation) for row, e in pairs if row.rotation is not None]
    if seen and _all_of("tracker.marker", paths, ("rotation_vector",)):
        turned = np.sum([own.T @ tracker.rotation @ measured for measured, own in seen], axis=0)
        tracker = replace(tracker, marker_rotation_vector=rotation_log(_nearest(turned)))
    return tracker


def _check_unit(told: Floats, markers: Floats) -> None:
    """Whether distances are those of the robot.

    Raises:
        InvalidRequest: They are not.
    """
    ratio = float(np.std(told, axis=0).max() / max(np.std(markers, axis=0).max(), 1e-300))
    if any(THOUSAND[0] < seen < THOUSAND[1] for seen in (ratio, 1.0 / ratio)):
        problem = f"distances in the tracker's frame are {ratio:.3g} times those of the robot"
        raise InvalidRequest("measurements: position", f"{problem}: another unit? expected m")


def _near(vector: Floats, described: Floats) -> Floats:
    """The rotation vector of the same rotation that is nearest to another one, within a turn."""
    angle = float(np.linalg.norm(vector))
    other = vector * (1.0 - 2.0 * np.pi / angle) if angle > 0.0 else vector
    return min(vector, other, key=lambda each: float(np.linalg.norm(each - described)))


def _rotation(told: Floats, markers: Floats) -> Floats:
    """The rotation that takes places nearest to others, both (N, 3) about their middles."""
    return _nearest(markers.T @ told)


def _nearest(matrix: Floats) -> Floats:
    """The rotation with the largest product with a matrix, (3, 3)."""
    left, _, right = np.linalg.svd(matrix)
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    found: Floats = left @ sign @ right
    return found

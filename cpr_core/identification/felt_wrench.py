# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What pushes on the platform, from motor efforts, the platform's pose or both.

The derivation is in docs/derivations.md, "Felt wrenches"; docs/wrench.md shows the use.
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from ..description.loads import Loads
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot, checked_robot
from ..solving.deadline import Deadline
from ..solving.geometrico_statics import checked_start
from .wrench_estimate import WrenchEstimate
from .wrench_measurements import wrench_measurements
from .wrench_search import WrenchSearch

__all__ = ["estimate_wrench"]


def estimate_wrench(
    robot: Robot,
    motors: ArrayLike,
    *,
    efforts: ArrayLike | None = None,
    effort_deviation: ArrayLike | None = None,
    pose: ArrayLike | None = None,
    pose_deviation: ArrayLike | None = None,
    start: Equilibrium | WrenchEstimate | None = None,
    loads: Loads | None = None,
    time_limit: float | None = None,
) -> WrenchEstimate:
    """What pushes on the platform. All parameters but robot and motors are options, given by name.

    Args:
        robot: The robot.
        motors: Measured motor positions in motor order, taken as exact, (n,) [rad or m].
        efforts: Measured motor efforts on the rods in motor order, as ``Equilibrium.efforts`` has them,
            (n,) [N m or N].
        effort_deviation: Their standard deviations, one for all or (n,) [N m or N]; infinite for a motor
            without a sensor.
        pose: Measured pose of the platform, x y z qw qx qy qz in the world, (7,) [m]; of an equilibrium
            ``[*platform_position, *platform_quaternion]``, as its ``pose`` is what the robot controls.
        pose_deviation: Standard deviations of its position [m] and of its rotation [rad], (2,); an
            infinite one is not measured.
        start: The last estimate, which makes the next one quick, or an equilibrium near by; default
            home.
        loads: What acts beside the wrench; default as for the last estimate, or what the description
            names, gravity among it.
        time_limit: Give up after this time [s]; default never.

    Raises:
        InvalidRequest: Wrong lengths, nothing measured, no standard deviations, a pose in other units or
            far out of the plane of a planar robot, or a quaternion in another order.
        InvalidQuaternion: A quaternion far from unit length.
        NonFiniteInput: A NaN or an infinity.
        NotReached: No equilibrium at the measured motors, or none under a wrench that explains the
            measurements, as far as Newton's method sees; or the time allowed was over.
    """
    before = start if isinstance(start, WrenchEstimate) else None
    near = before.equilibrium if before else start
    place = checked_start(checked_robot(robot), near)  # type: ignore[arg-type]
    measured = wrench_measurements(
        robot, motors, efforts, effort_deviation, pose, pose_deviation, place
    )
    if loads is None:
        loads = before.loads if before else robot.default_loads
    if before is not None and loads is before.loads:
        load_arrays = before.unloaded.load_arrays
    else:
        before, load_arrays = None, robot.load_arrays(loads)
    search = WrenchSearch(place, measured, loads, load_arrays, Deadline(time_limit))
    if before is None or before.directions.gain.shape[1] != measured.rows:
        return search.from_afar(place)
    return search.from_last(before)

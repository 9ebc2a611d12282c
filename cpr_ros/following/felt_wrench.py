# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What pushes on the platform, as measured motors tell, and when that cannot be trusted. No ROS here.

One estimate per measurement, from the last one. Where there is none, the reason is kept; after a reason
that took long to find, nothing is looked for during a while, so that ticks come when they are due.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpr_core import CprError, Equilibrium, Robot, WrenchEstimate, estimate_wrench
from cpr_core.errors import distinct
from cpr_core.kernels.twist_layout import FIRST_LINEAR
from cpr_core.model.world_response import effort_units

from .judged_steps import LARGEST_CHANGE
from .motor_history import MotorHistory
from .news import Announced, News
from .steps import change_between
from .watchdog import Watchdog

__all__ = ["FeltWrench", "WrenchSettings"]

Floats = NDArray[np.float64]

#: Longest time of one estimate [s].
_LONGEST = 0.02
#: After an estimate that failed none is tried for this time [s].
_REST = 0.1
#: Standard deviation of measured efforts, in natural units, where nobody gives one.
_DEFAULT_PART = 0.01
#: A measured pose is used if it is no older or newer than the motors by more than this [s].
_SAME_TIME = 0.1
#: After this time without efforts the last estimate is no start for the next one [s].
_FORGET = 0.5
#: A reason that comes back within this time has not been over: speeds tremble around their limit [s].
_SETTLED = 0.2


@dataclass(frozen=True)
class WrenchSettings:
    """What may change while the node runs.

    Attributes:
        effort_deviation: Standard deviation of a measured effort, the part always there [N m, N]; 0:
            a hundredth of the natural unit, E J / l or E J / l^2.
        effort_deviation_relative: The part that grows with it.
        position_deviation: Of a measured pose [m]; 0: the pose is not used.
        rotation_deviation: Of a measured pose [rad]; 0: the pose is not used.
        max_speed: Speed of a motor beyond which inertia may be felt too [rad/s, rod lengths/s].
        consistency: Measurements that are less likely than this contradict each other.
        timeout: Age beyond which measured efforts are stale [s]; 0: never.
    """

    effort_deviation: float
    effort_deviation_relative: float
    position_deviation: float
    rotation_deviation: float
    max_speed: float
    consistency: float
    timeout: float


class FeltWrench:
    """The newest estimate, and why there is none.

    Attributes:
        settings: What may change at any time.
        with_pose: Whether the newest estimate used a measured pose.
    """

    def __init__(self, robot: Robot, settings: WrenchSettings) -> None:
        """Feel nothing yet."""
        self.robot = robot
        self.watchdog = Watchdog(settings.timeout)
        self.settings = settings
        self.with_pose = False
        self._last: WrenchEstimate | None = None
        self._near: Equilibrium | None = None
        self._motors = MotorHistory(robot.motor_units, _SAME_TIME)
        self._pose: tuple[float, Floats] | None = None
        self._reason, self._rests_until = "", 0.0
        self._kind, self._announced = "", Announced(_SETTLED)

    @property
    def settings(self) -> WrenchSettings:
        """What may change at any time."""
        return self._settings

    @settings.setter
    def settings(self, settings: WrenchSettings) -> None:
        self._settings = settings
        self.watchdog.timeout = settings.timeout

    def take_pose(self, pose: Floats, time: float) -> None:
        """Take a measured pose of the whole platform; of a planar robot what is in its plane.

        Args:
            pose: x y z qw qx qy qz in the base frame, (7,) [m].
            time: When it was measured, by its stamp, which may be of a clock that is ahead [s].
        """
        self._pose = time, _in_plane(pose) if self.robot.planar else pose

    def refuse(self, kind: str, reason: str) -> None:
        """Take note of a measurement that tells nothing; reasons of a kind are announced once."""
        self._kind, self._reason, self._last = kind, reason, None

    def take(
        self, motors: Floats, efforts: Floats, time: float, now: float, near: Equilibrium
    ) -> WrenchEstimate | None:
        """Take measured motors; the wrench they tell of, or None, with a reason.

        Args:
            motors: Positions, (n,) [rad or m].
            efforts: Efforts on the rods, (n,) [N m or N].
            time: When they were measured, by their stamp, which may be of a clock that is ahead [s].
            now: Steady time [s].
            near: Where the node has the robot.
        """
        if self.watchdog.age(now) > _FORGET:
            self._last = None
            self._motors.forget()
        if self._near is not None and change_between(self._near, near) > LARGEST_CHANGE:
            self._last = None  # of another branch than the node has the robot on now
        self._near = near
        self.watchdog.feed(now)
        if 0.0 < self.settings.timeout < now - time:
            self.refuse("stale", self._old(now - time))
            return None
        self._motors.take(motors, min(time, now))
        if self._motors.speed > self.settings.max_speed:
            speed, most = distinct(self._motors.speed, self.settings.max_speed)
            self.refuse(
                "speed",
                f"a motor moves at {speed} rad/s or rod lengths/s, more than wrench_max_speed "
                f"{most}: inertia may be felt",
            )
            return None
        if now < self._rests_until:
            return None
        try:
            found = self._estimate(motors, efforts, time, near)
        except CprError as error:
            self.refuse("search", str(error)[:500])
            self._rests_until = now + _REST
            return None
        if found.doubt:
            self.refuse("units", found.doubt)
            self._rests_until = now + _REST
            return None
        doubt = self._doubt(found)
        self._last, self._kind, self._reason = found, "doubt" if doubt else "", doubt
        return None if doubt else found

    def reason(self, now: float) -> str:
        """Why there is no estimate now; empty: there is one."""
        return self._why(now)[1]

    def announcement(self, now: float) -> News:
        """What the log is to be told now."""
        kind, reason = self._why(now)
        warning = f"no wrench is estimated: {reason}" if kind else ""
        return self._announced.news(warning, "the wrench is estimated", kind, now)

    def _why(self, now: float) -> tuple[str, str]:
        """The kind of reason for which there is no estimate, and the reason."""
        if self._kind == "efforts":  # such messages are no measurement, however often they come
            return self._kind, self._reason
        age = self.watchdog.age(now)
        if age < 0.0:
            return "none", "no measured_joint_states with efforts have come"
        if self.watchdog.stale(now):
            return "stale", self._old(age)
        return self._kind, self._reason

    def _old(self, age: float) -> str:
        how_old, timeout = distinct(age, self.settings.timeout)
        return f"the measured efforts are {how_old} s old, more than measured_timeout {timeout} s"

    def _pose_deviation(self, since: float, near: Equilibrium) -> tuple[float, float]:
        """Standard deviations of a measured pose as that of the motors' time [m, rad].

        Args:
            since: Time between the two: the platform moves as far as it did in the last while of this
                length [s].
            near: Where the node has the robot.
        """
        position, rotation = self.settings.position_deviation, self.settings.rotation_deviation
        way = self._motors.way_in_last(since)
        if not way.any():
            return position, rotation
        motion, turns = near.jacobian @ way, near.robot.platform_axes < FIRST_LINEAR
        moved, turned = np.linalg.norm(motion[~turns]), np.linalg.norm(motion[turns])
        return float(np.hypot(position, moved)), float(np.hypot(rotation, turned))

    def _estimate(
        self, motors: Floats, efforts: Floats, time: float, near: Equilibrium
    ) -> WrenchEstimate:
        settings, start, pose, deviations = self.settings, self._last or near, None, None
        if self._pose is not None and min(settings.position_deviation, settings.rotation_deviation):
            since = abs(time - self._pose[0])
            if since <= _SAME_TIME:
                pose, deviations = self._pose[1], self._pose_deviation(since, near)
        always = settings.effort_deviation or _DEFAULT_PART * effort_units(self.robot)
        relative = settings.effort_deviation_relative * np.abs(efforts)
        self.with_pose = pose is not None
        return estimate_wrench(
            self.robot,
            motors,
            efforts=efforts,
            effort_deviation=np.hypot(always, relative),
            pose=pose,
            pose_deviation=deviations,
            start=start,
            time_limit=_LONGEST,
        )

    def _doubt(self, found: WrenchEstimate) -> str:
        """Why an estimate is not to be trusted; empty: it is."""
        if found.equilibrium.index_locked > 0:
            return "the equilibrium that explains the measurements is unstable"
        if not found.directions.count:
            return "nothing of the wrench is felt: the standard deviations are too large for this robot"
        if found.consistency < self.settings.consistency:
            return (
                f"the measurements contradict each other: chi-square {found.chi_square:.3g} of "
                f"{found.degrees_of_freedom} degrees of freedom"
            )
        return ""


def _in_plane(pose: Floats) -> Floats:
    """A pose, (7,), without its height and tilt: cameras hang above the plane, and a little askew."""
    x, y, _, w, _, _, z = pose.tolist()
    size = float(np.hypot(w, z))
    if size == 0.0:
        return pose  # upside down, and refused as such
    return np.array([x, y, 0.0, w / size, 0.0, 0.0, z / size])

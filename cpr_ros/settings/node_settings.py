# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Values of the parameters of the node, and whether they can be used together. No rclpy here."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, fields
from typing import Any

from cpr_core import CprError, Robot
from cpr_core.model.assessment import Threshold, thresholds_problem

from ..closed_loop.pose_loop import LoopSettings
from ..following.felt_wrench import WrenchSettings
from ..following.motion_settings import Settings
from ..messages.urdf import marker_frame
from .parameter_table import THRESHOLDS

__all__ = ["LiveParameters", "Parameters", "live_parameters", "live_problem"]

#: Parameters that are fields of the settings of setpoint following.
_FOLLOWING = ("hysteresis", "max_speed", "setpoint_timeout")
#: Parameters by the fields of the other settings that have their values.
_LOOP = {
    "gain": "loop_gain",
    "max_correction": "loop_max_correction",
    "max_rate": "loop_max_rate",
    "jump": "measured_pose_jump",
    "settling": "measured_pose_settling",
    "timeout": "measured_pose_timeout",
}
_FELT_WRENCH = {
    "effort_deviation": "wrench_effort_deviation",
    "effort_deviation_relative": "wrench_effort_deviation_relative",
    "position_deviation": "wrench_position_deviation",
    "rotation_deviation": "wrench_rotation_deviation",
    "max_speed": "wrench_max_speed",
    "consistency": "wrench_consistency",
    "timeout": "measured_timeout",
}


@dataclass(frozen=True)
class Parameters:
    """Values of the parameters that are fixed at start.

    Attributes:
        robot: Name of a shipped robot, or a file.
        modes: Strain modes per direction; 0 for the description's.
        base_frame: Frame fixed in space.
        platform_frame: Frame of the platform.
        tracker_frame: Frame of the tracker of the description.
        frame_prefix: Stands before the names of all of them.
        autostart: Whether the node configures and activates itself.
        motor_source: ``setpoint`` (the node moves the motors) or ``measured`` (it tracks them).
        start_from: Where the robot is when the node becomes active: ``auto``, ``home``, ``measured``,
            ``last``.
        state_directory: Where the last state is kept; empty: in ROS_HOME.
        map_directory: Where maps are written; empty: in ROS_HOME.
        map_anywhere: Whether maps may be ordered elsewhere.
        tick_rate: Rate of setpoint following [Hz].
        state_rate: Rate of joint states and platform pose at rest; in motion every tick [Hz].
        stability_rate: Rate of the stability stream [Hz].
        diagnostics_rate: Rate of /diagnostics [Hz].
        marker_rate: Rate of the leg markers [Hz].
        marker_color: ``strain`` or ``stability``.
        characteristic_length: Weighs rotations in singular values [m]; None for the mean rod length.
    """

    robot: str
    modes: int
    base_frame: str
    platform_frame: str
    tracker_frame: str
    frame_prefix: str
    autostart: bool
    motor_source: str
    start_from: str
    state_directory: str
    map_directory: str
    map_anywhere: bool
    tick_rate: float
    state_rate: float
    stability_rate: float
    diagnostics_rate: float
    marker_rate: float
    marker_color: str
    characteristic_length: float | None

    @property
    def frames(self) -> tuple[str, str, str]:
        """Names of the frames of base, platform and tracker, without the prefix."""
        return self.base_frame, self.platform_frame, self.tracker_frame

    def check_tracker(self, robot: Robot) -> None:
        """Whether the tracker of a robot, if it has one, has a frame of its own.

        Raises:
            CprError: It has the name of another one.
        """
        if robot.description.tracker is None:
            return
        if not self.tracker_frame:
            raise CprError("tracker_frame: expected a name, no frame at all is the base frame")
        for name in (self.tracker_frame, marker_frame(self.tracker_frame)):
            if name in self.frames[:2]:
                raise CprError(f"tracker_frame: expected frames of its own, {name} is another one")


@dataclass(frozen=True)
class LiveParameters:
    """Values of the parameters that may change at any time.

    Attributes:
        settings: Of setpoint following.
        wrench_timeout: Age beyond which an external wrench acts no more [s]; 0: never.
        measured_timeout: Age beyond which measured motors are stale [s]; 0: never.
        moved_tolerance: Motors measured farther from their last command were moved by others [rad, rod
            lengths]; 0: never.
        max_lead: Commands are ahead of measured motors by what these do at full speed in so long at most
            [s], or in a tick; 0: however far.
        arrived_tolerance: A goal of ``~/move_to`` is reached when every measured motor is so near to its
            command [rad, rod lengths]; 0: wherever they are measured.
        time_limit: Longest time of a request [s].
        loop: Of the correction by measured poses.
        twist_timeout: Age beyond which a twist moves nothing [s].
        felt_wrench: Of the wrench that measured motors tell of.
    """

    settings: Settings
    wrench_timeout: float
    measured_timeout: float
    moved_tolerance: float
    max_lead: float
    arrived_tolerance: float
    time_limit: float
    loop: LoopSettings
    twist_timeout: float
    felt_wrench: WrenchSettings


#: Parameters that are fields of the live ones themselves.
_OWN = tuple(field.name for field in fields(LiveParameters) if field.type == "float")


def live_parameters(value: Callable[[str], Any]) -> LiveParameters:
    """Live parameters from a function that gives the value of a name."""
    thresholds = {
        name: Threshold(value(f"{name}_warning"), value(f"{name}_stop")) for name in THRESHOLDS
    }
    settings = Settings(thresholds=thresholds, **{name: value(name) for name in _FOLLOWING})
    loop = LoopSettings(**{field: value(name) for field, name in _LOOP.items()})
    felt_wrench = WrenchSettings(**{field: value(name) for field, name in _FELT_WRENCH.items()})
    own = {name: value(name) for name in _OWN}
    return LiveParameters(settings=settings, loop=loop, felt_wrench=felt_wrench, **own)


def live_problem(live: LiveParameters, changed: Collection[str] | None = None) -> str:
    """Why live parameters cannot be used; empty if they can.

    Args:
        live: The values.
        changed: Names of those that one call changes; None: all begin to count. Thresholds that come one
            by one, as from a file, may be in the wrong order for a while.
    """
    together = [
        name
        for name in THRESHOLDS
        if changed is None or {f"{name}_warning", f"{name}_stop"} <= set(changed)
    ]
    problem = thresholds_problem(live.settings.thresholds, together)
    if not problem and not live.settings.max_speed > 0.0:
        problem = f"expected a positive max_speed, got {live.settings.max_speed}"
    numbers = {name: getattr(live.settings, name) for name in _FOLLOWING}
    numbers |= {name: getattr(live, name) for name in _OWN}
    numbers |= {name: getattr(live.loop, field) for field, name in _LOOP.items()}
    numbers |= {name: getattr(live.felt_wrench, field) for field, name in _FELT_WRENCH.items()}
    for name, number in numbers.items():
        if not problem and not math.isfinite(number):
            problem = f"expected a finite {name}"
    return problem

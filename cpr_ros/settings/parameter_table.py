# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The parameters of the node as data, without ROS: declared, shown and documented from here."""

from __future__ import annotations

from typing import NamedTuple

from .parameter_entry import DeclaredParameter

__all__ = ["PARAMETERS", "ROS_PARAMETERS", "THRESHOLDS"]


class MeasureThresholds(NamedTuple):
    """Default thresholds of a measure, as the core has them.

    Attributes:
        warning: Motions that make it smaller are slowed down below.
        stop: They are halted below.
        largest: Largest value of both.
        unit: Unit; empty if it has none.
        meaning: What it measures.
    """

    warning: float
    stop: float
    largest: float
    unit: str
    meaning: str


_RATE = (0.1, 1000.0)
_SLOW_RATE = (0.1, 100.0)
_LONG = (0.0, 1e6)

_FIXED = (
    DeclaredParameter("robot", "six_rfs", "", "shipped robot or path of a YAML description"),
    DeclaredParameter("modes", 0, "", "strain modes per direction; 0: as described", (0, 40)),
    DeclaredParameter("base_frame", "base", "", "frame fixed in space"),
    DeclaredParameter("platform_frame", "platform", "", "frame of the platform"),
    DeclaredParameter(
        "tracker_frame",
        "tracker",
        "",
        "frame of measured poses that are those of the marker, as the tracker of the description tells",
    ),
    DeclaredParameter(
        "frame_prefix",
        "",
        "",
        "stands before the names of these frames, such as left/ for one of two robots in a tree",
    ),
    DeclaredParameter("autostart", True, "", "configure and activate without being told"),
    DeclaredParameter(
        "motor_source",
        "setpoint",
        "",
        "setpoint: the node moves the motors; measured: it tracks measured_joint_states",
        choices=("setpoint", "measured"),
    ),
    DeclaredParameter(
        "start_from",
        "auto",
        "",
        "where the robot is when the node becomes active: home; where its motors are measured; where it "
        "was last; auto: measured if something publishes measured_joint_states, else last, else home",
        choices=("auto", "home", "measured", "last"),
    ),
    DeclaredParameter(
        "state_directory",
        "",
        "",
        "where the last state is kept, a file for every node; empty: cpr_ros in ROS_HOME or ~/.ros",
    ),
    DeclaredParameter(
        "map_directory",
        "",
        "",
        "where maps are written that are ordered; empty: cpr_ros/maps in ROS_HOME or ~/.ros",
    ),
    DeclaredParameter(
        "map_anywhere",
        False,
        "",
        "whether who orders a map may name a file outside of map_directory",
    ),
    DeclaredParameter("tick_rate", 200.0, "Hz", "setpoint following", (1.0, 1000.0)),
    DeclaredParameter("state_rate", 50.0, "Hz", "joint states and platform pose at rest", _RATE),
    DeclaredParameter("stability_rate", 20.0, "Hz", "stability stream", _RATE),
    DeclaredParameter("diagnostics_rate", 1.0, "Hz", "/diagnostics", _SLOW_RATE),
    DeclaredParameter("marker_rate", 10.0, "Hz", "leg markers", _SLOW_RATE),
    DeclaredParameter(
        "marker_color",
        "strain",
        "",
        "what colours the legs: bending strain, or stability of the robot",
        choices=("strain", "stability"),
    ),
    DeclaredParameter(
        "characteristic_length",
        0.0,
        "m",
        "weighs rotations against lengths in singular values; 0: mean rod length",
        (0.0, 1000.0),
    ),
)


#: By the measure.
THRESHOLDS = {
    "margin": MeasureThresholds(0.2, 0.05, 1.0, "", "stability margin"),
    "forward_singularity": MeasureThresholds(
        1e-4, 2e-5, 1.0, "", "smallest singular value of the forward problem"
    ),
    "inverse_singularity": MeasureThresholds(
        2e-3,
        5e-4,
        1.0,
        "",
        "smallest singular value of the inverse problem, watched with platform setpoints",
    ),
    "motor_range": MeasureThresholds(
        0.05, 0.0, 10.0, "rad, rod lengths", "distance of a motor from its range"
    ),
    "effort_reserve": MeasureThresholds(0.2, 0.02, 1.0, "", "1 - effort / limit of a motor"),
    "strain_reserve": MeasureThresholds(0.2, 0.05, 1.0, "", "1 - bending strain / limit of a rod"),
}


def _thresholds() -> tuple[DeclaredParameter, ...]:
    """Warning and stop of every measure."""
    return tuple(
        DeclaredParameter(
            f"{name}_{level}",
            default,
            of.unit,
            f"{of.meaning}: {reaction} below",
            (0.0, of.largest),
        )
        for name, of in THRESHOLDS.items()
        for level, default, reaction in (
            ("warning", of.warning, "slow down"),
            ("stop", of.stop, "halt"),
        )
    )


_LIVE = (
    DeclaredParameter(
        "hysteresis", 0.1, "", "of the action: part of the way from stop to warning", (0.0, 1.0)
    ),
    DeclaredParameter(
        "max_speed",
        1.0,
        "rad/s, rod lengths/s",
        "speed no motor exceeds, behind its gear",
        (1e-6, 1000.0),
    ),
    DeclaredParameter(
        "setpoint_timeout", 0.0, "s", "age beyond which a setpoint is not followed; 0: none", _LONG
    ),
    DeclaredParameter(
        "wrench_timeout",
        0.5,
        "s",
        "age beyond which an external wrench acts no more; 0: none",
        _LONG,
    ),
    DeclaredParameter(
        "measured_timeout", 0.5, "s", "age beyond which measured motors are stale; 0: none", _LONG
    ),
    DeclaredParameter(
        "moved_tolerance",
        0.1,
        "rad, rod lengths",
        "motors measured farther from their last command were moved by others, or do not follow: once "
        "they rest the node begins anew where they are; 0: never",
        (0.0, 1000.0),
    ),
    DeclaredParameter(
        "max_lead",
        0.2,
        "s",
        "commands are ahead of measured motors by what these do at full speed in so long at most, or in "
        "a tick: they wait for motors that do not follow; 0: however far",
        _LONG,
    ),
    DeclaredParameter(
        "arrived_tolerance",
        0.02,
        "rad, rod lengths",
        "a goal of ~/move_to is reached when every motor that is measured is so near to its command; 0: "
        "wherever they are measured",
        (0.0, 1000.0),
    ),
    DeclaredParameter(
        "loop_gain",
        1.0,
        "1/s",
        "part of the error in the measured pose that is taken out in a second; 0: none",
        (0.0, 100.0),
    ),
    DeclaredParameter(
        "loop_max_correction",
        0.1,
        "rod lengths, rad",
        "largest correction of a platform setpoint by the measured pose",
        (0.0, 1.0),
    ),
    DeclaredParameter(
        "loop_max_rate", 0.1, "rod lengths/s, rad/s", "speed of that correction", (0.0, 100.0)
    ),
    DeclaredParameter(
        "measured_pose_timeout",
        0.5,
        "s",
        "age beyond which a measured pose is stale; 0: none",
        _LONG,
    ),
    DeclaredParameter(
        "measured_pose_jump",
        0.05,
        "rod lengths, rad",
        "a measured pose farther from the one before is not believed; motion of the platform adds to it",
        (0.0, 100.0),
    ),
    DeclaredParameter(
        "measured_pose_settling",
        1.0,
        "s",
        "how long measured poses have to agree after a jump to be believed again",
        _LONG,
    ),
    DeclaredParameter(
        "twist_timeout",
        0.25,
        "s",
        "age beyond which a twist moves the platform setpoint no more",
        (0.01, 10.0),
    ),
    DeclaredParameter(
        "wrench_effort_deviation",
        0.0,
        "N m, N",
        "standard deviation of a measured effort, the part that is always there; 0: a hundredth of "
        "E J / l for torques, of E J / l^2 for forces",
        (0.0, 1e6),
    ),
    DeclaredParameter(
        "wrench_effort_deviation_relative",
        0.02,
        "",
        "standard deviation of a measured effort, the part that grows with it",
        (0.0, 1.0),
    ),
    DeclaredParameter(
        "wrench_position_deviation",
        0.001,
        "m",
        "standard deviation of a measured pose; 0: wrenches are estimated without it",
        (0.0, 100.0),
    ),
    DeclaredParameter(
        "wrench_rotation_deviation",
        0.005,
        "rad",
        "standard deviation of a measured pose; 0: wrenches are estimated without it",
        (0.0, 3.0),
    ),
    DeclaredParameter(
        "wrench_max_speed",
        0.5,
        "rad/s, rod lengths/s",
        "speed of a measured motor beyond which no wrench is estimated",
        (1e-6, 1000.0),
    ),
    DeclaredParameter(
        "wrench_consistency",
        1e-6,
        "",
        "measurements less likely than this contradict each other: no wrench is estimated; 0: any",
        (0.0, 1.0),
    ),
    DeclaredParameter(
        "time_limit", 0.5, "s", "of a request, which holds up the others", (1e-3, 3600.0)
    ),
)

#: All parameters of the node.
PARAMETERS = (
    *_FIXED,
    *(parameter._replace(live=True) for parameter in (*_thresholds(), *_LIVE)),
)

#: What ROS gives every node beside them.
ROS_PARAMETERS = ("use_sim_time", "start_type_description_service")

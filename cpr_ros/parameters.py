# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Parameters of the node: declaration, ranges and checks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from cpr_core import CprError

from .assessment import Threshold, thresholds_problem
from .setpoint_following import Settings

__all__ = ["LiveParameters", "Parameters", "declare", "live_parameters", "live_problem"]

#: Thresholds of every measure: defaults of warning and stop, largest value, meaning.
_THRESHOLDS = {
    "margin": (0.2, 0.05, 1.0, "stability margin"),
    "forward_singularity": (1e-4, 2e-5, 1.0, "smallest singular value of the forward problem"),
    "inverse_singularity": (
        2e-3,
        5e-4,
        1.0,
        "smallest singular value of the inverse problem, watched with platform setpoints",
    ),
    "motor_range": (0.05, 0.0, 10.0, "distance of a motor from its range [rad, rod lengths]"),
    "effort_reserve": (0.2, 0.02, 1.0, "1 - effort / limit of a motor"),
    "strain_reserve": (0.2, 0.05, 1.0, "1 - bending strain / limit of a rod"),
}


@dataclass(frozen=True)
class Parameters:
    """Values of the parameters that are fixed at start.

    Attributes:
        robot: Name of a shipped robot, or a file.
        modes: Strain modes per direction; 0 for the description's.
        base_frame: Frame fixed in space.
        platform_frame: Frame of the platform.
        autostart: Whether the node configures and activates itself.
        motor_source: ``setpoint`` (the node moves the motors) or ``measured`` (it tracks them).
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
    autostart: bool
    motor_source: str
    tick_rate: float
    state_rate: float
    stability_rate: float
    diagnostics_rate: float
    marker_rate: float
    marker_color: str
    characteristic_length: float | None


@dataclass(frozen=True)
class LiveParameters:
    """Values of the parameters that may change at any time.

    Attributes:
        settings: Of setpoint following.
        wrench_timeout: Age beyond which an external wrench acts no more [s]; 0: never.
        measured_timeout: Age beyond which measured motors are stale [s]; 0: never.
        time_limit: Longest time of a request [s].
    """

    settings: Settings
    wrench_timeout: float
    measured_timeout: float
    time_limit: float


def declare(node: Node) -> Parameters:
    """Declare all parameters of the node and read those that are fixed at start.

    Raises:
        CprError: Values that cannot be used together.
    """

    def fixed(
        name: str,
        default: Any,
        description: str,
        limits: tuple[float, float] | None = None,
        choices: tuple[str, ...] = (),
    ) -> Any:
        value = _declare(node, name, default, description, limits, choices, read_only=True)
        if choices and value not in choices:
            raise CprError(f"{name}: expected {' or '.join(choices)}, got {value!r}")
        return value

    rate = (0.1, 1000.0)
    length = fixed(
        "characteristic_length",
        0.0,
        "weighs rotations against lengths in singular values [m]; 0: mean rod length",
        (0.0, 1000.0),
    )
    parameters = Parameters(
        robot=fixed("robot", "six_rfs", "shipped robot or path of a YAML description"),
        modes=fixed("modes", 0, "strain modes per direction; 0: as described", (0, 40)),
        base_frame=fixed("base_frame", "base", "frame fixed in space"),
        platform_frame=fixed("platform_frame", "platform", "frame of the platform"),
        autostart=fixed("autostart", True, "configure and activate without being told"),
        motor_source=fixed(
            "motor_source",
            "setpoint",
            "setpoint: the node moves the motors; measured: it tracks measured_joint_states",
            choices=("setpoint", "measured"),
        ),
        tick_rate=fixed("tick_rate", 200.0, "setpoint following [Hz]", (1.0, 1000.0)),
        state_rate=fixed("state_rate", 50.0, "joint states and platform pose at rest [Hz]", rate),
        stability_rate=fixed("stability_rate", 20.0, "stability stream [Hz]", rate),
        diagnostics_rate=fixed("diagnostics_rate", 1.0, "/diagnostics [Hz]", (0.1, 100.0)),
        marker_rate=fixed("marker_rate", 10.0, "leg markers [Hz]", (0.1, 100.0)),
        marker_color=fixed(
            "marker_color",
            "strain",
            "what colours the legs: bending strain, or stability of the robot",
            choices=("strain", "stability"),
        ),
        characteristic_length=length or None,
    )
    if parameters.base_frame == parameters.platform_frame:
        raise CprError(
            f"expected two frames, base_frame and platform_frame are {parameters.base_frame}"
        )
    for name, (warning, stop, largest, meaning) in _THRESHOLDS.items():
        limits = (0.0, largest)
        _declare(node, f"{name}_warning", warning, f"{meaning}: slow down below", limits)
        _declare(node, f"{name}_stop", stop, f"{meaning}: halt below", limits)
    for name, default, largest, meaning in (
        ("hysteresis", 0.1, 1.0, "of the action: part of the way from stop to warning"),
        ("max_speed", 1.0, 1000.0, "speed no motor exceeds [rad/s, rod lengths/s]"),
        ("setpoint_timeout", 0.0, 1e6, "age beyond which a setpoint is not followed [s]; 0: none"),
        (
            "wrench_timeout",
            0.5,
            1e6,
            "age beyond which an external wrench acts no more [s]; 0: none",
        ),
        ("measured_timeout", 0.5, 1e6, "age beyond which measured motors are stale [s]; 0: none"),
    ):
        _declare(node, name, default, meaning, (0.0, largest))
    _declare(node, "time_limit", 0.5, "of a request, which holds up the others [s]", (1e-3, 3600.0))
    return parameters


def live_parameters(value: Callable[[str], Any]) -> LiveParameters:
    """Live parameters from a function that gives the value of a name."""
    thresholds = {
        name: Threshold(value(f"{name}_warning"), value(f"{name}_stop")) for name in _THRESHOLDS
    }
    settings = Settings(
        thresholds=thresholds,
        hysteresis=value("hysteresis"),
        max_speed=value("max_speed"),
        setpoint_timeout=value("setpoint_timeout"),
    )
    return LiveParameters(
        settings, value("wrench_timeout"), value("measured_timeout"), value("time_limit")
    )


def live_problem(live: LiveParameters) -> str:
    """Why live parameters cannot be used; empty if they can."""
    problem = thresholds_problem(live.settings.thresholds)
    if not problem and not live.settings.max_speed > 0.0:
        problem = f"expected a positive max_speed, got {live.settings.max_speed}"
    for name in ("max_speed", "hysteresis", "setpoint_timeout"):
        if not problem and not getattr(live.settings, name) < float("inf"):
            problem = f"expected a finite {name}"
    for name in ("wrench_timeout", "measured_timeout", "time_limit"):
        if not problem and not getattr(live, name) < float("inf"):
            problem = f"expected a finite {name}"
    return problem


def _declare(
    node: Node,
    name: str,
    default: Any,
    description: str,
    limits: tuple[float, float] | None,
    choices: tuple[str, ...] = (),
    read_only: bool = False,
) -> Any:
    descriptor = ParameterDescriptor(
        description=description,
        read_only=read_only,
        additional_constraints=" or ".join(choices),
    )
    if limits is not None and isinstance(default, float):
        low, high = limits
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    elif limits is not None:
        first, last = map(int, limits)
        descriptor.integer_range = [IntegerRange(from_value=first, to_value=last)]
    return node.declare_parameter(name, default, descriptor).value

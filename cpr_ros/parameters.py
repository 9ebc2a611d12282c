"""Parameters of the node: declaration, ranges and checks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

__all__ = ["Parameters", "declare", "thresholds_problem"]


@dataclass(frozen=True)
class Parameters:
    """Values of the parameters that are fixed at start.

    Attributes:
        robot: Name of a shipped robot, or a file.
        modes: Strain modes per direction; 0 for the description's.
        base_frame: Frame fixed in space.
        platform_frame: Frame of the platform.
        state_rate: Rate of joint states and platform pose [Hz].
        stability_rate: Rate of the stability stream [Hz].
    """

    robot: str
    modes: int
    base_frame: str
    platform_frame: str
    state_rate: float
    stability_rate: float


def declare(node: Node) -> Parameters:
    """Declare all parameters of the node and read those that are fixed at start."""

    def fixed(
        name: str, default: Any, description: str, limits: tuple[float, float] | None = None
    ) -> Any:
        return _declare(node, name, default, description, limits, read_only=True)

    rate = (0.1, 1000.0)
    parameters = Parameters(
        robot=fixed("robot", "six_rfs", "shipped robot or path of a YAML description"),
        modes=fixed("modes", 0, "strain modes per direction; 0: as described", (0, 40)),
        base_frame=fixed("base_frame", "base", "frame fixed in space"),
        platform_frame=fixed("platform_frame", "platform", "frame of the platform"),
        state_rate=fixed("state_rate", 50.0, "joint states and platform pose [Hz]", rate),
        stability_rate=fixed("stability_rate", 20.0, "stability stream [Hz]", rate),
    )
    margin = (0.0, 1.0)
    _declare(node, "margin_warning", 0.2, "stability margin below which to slow down", margin)
    _declare(node, "margin_stop", 0.05, "stability margin below which to halt", margin)
    return parameters


def thresholds_problem(warning: float, stop: float) -> str:
    """Why a pair of margins cannot be used; empty if it can."""
    if not (math.isfinite(warning) and math.isfinite(stop)):
        return f"expected finite margins, got margin_warning {warning}, margin_stop {stop}"
    if stop >= warning:
        return f"expected margin_stop below margin_warning, got {stop} and {warning}"
    return ""


def _declare(
    node: Node,
    name: str,
    default: Any,
    description: str,
    limits: tuple[float, float] | None,
    read_only: bool = False,
) -> Any:
    descriptor = ParameterDescriptor(description=description, read_only=read_only)
    if limits is not None and isinstance(default, float):
        low, high = limits
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    elif limits is not None:
        first, last = map(int, limits)
        descriptor.integer_range = [IntegerRange(from_value=first, to_value=last)]
    return node.declare_parameter(name, default, descriptor).value

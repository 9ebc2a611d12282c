# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Declaration of the parameters of the node, with their ranges."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from cpr_core import CprError

from .node_settings import LiveParameters, Parameters, live_parameters
from .parameter_calls import as_meant
from .parameter_entry import DeclaredParameter
from .parameter_table import PARAMETERS, ROS_PARAMETERS

__all__ = ["declare", "live_values", "undeclared"]

_NONE: Mapping[str, Parameter] = MappingProxyType({})


def declare(node: Node) -> Parameters:
    """Declare all parameters of the node and read those that are fixed at start.

    Raises:
        CprError: Values that cannot be used together.
    """
    values: dict[str, Any] = {}
    for parameter in PARAMETERS:
        given = node._parameter_overrides
        if parameter.name in given:
            given[parameter.name] = as_meant(given[parameter.name])
        value = node.declare_parameter(
            parameter.name, parameter.default, _descriptor(parameter)
        ).value
        if parameter.choices and value not in parameter.choices:
            expected = " or ".join(parameter.choices)
            raise CprError(f"{parameter.name}: expected {expected}, got {value!r}")
        if not parameter.live:
            values[parameter.name] = value
    values["characteristic_length"] = values["characteristic_length"] or None
    for name in ("frame_prefix", "base_frame", "platform_frame", "tracker_frame"):
        if values[name].startswith("/"):
            raise CprError(f"{name}: frames of tf2 do not begin with /, got {values[name]!r}")
    for name in ("base_frame", "platform_frame"):
        if not values[name]:
            raise CprError(f"{name}: expected the name of a frame, tf2 takes none without")
    parameters = Parameters(**values)
    if parameters.base_frame == parameters.platform_frame:
        raise CprError(
            f"expected two frames, base_frame and platform_frame are {parameters.base_frame}"
        )
    return parameters


def undeclared(node: Node) -> list[str]:
    """Names that a parameter file or a launch file gives this node and it does not know."""
    given = node._parameter_overrides  # rclpy forgets them without a word
    return sorted(
        name for name in given if name not in ROS_PARAMETERS and not node.has_parameter(name)
    )


def live_values(node: Node, changed: Mapping[str, Parameter] = _NONE) -> LiveParameters:
    """Live parameters as they are declared, but for those that a call is about to change."""
    return live_parameters(lambda name: (changed.get(name) or node.get_parameter(name)).value)


def _descriptor(parameter: DeclaredParameter) -> ParameterDescriptor:
    unit = f" [{parameter.unit}]" if parameter.unit else ""
    descriptor = ParameterDescriptor(
        description=f"{parameter.meaning}{unit}",
        read_only=not parameter.live,
        additional_constraints=" or ".join(parameter.choices),
    )
    if parameter.limits is not None and parameter.kind == "double":
        low, high = parameter.limits
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    elif parameter.limits is not None:
        first, last = map(int, parameter.limits)
        descriptor.integer_range = [IntegerRange(from_value=first, to_value=last)]
    return descriptor

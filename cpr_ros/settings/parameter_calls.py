# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Calls that change parameters: every one is answered, numbers are taken however they are written."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.exceptions import ParameterNotDeclaredException
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..process.once_a_second import ONCE_A_SECOND
from .node_arguments import closest
from .parameter_table import PARAMETERS

__all__ = ["answer_parameter_calls", "as_meant"]

#: Parameters that one call may change: ticks wait for it, and the node has some dozens.
_MOST = 100
_DOUBLES = {parameter.name for parameter in PARAMETERS if parameter.kind == "double"}


def as_meant(parameter: Parameter) -> Parameter:
    """The same, but 2 and the word 2e-05 are floating-point numbers where such are expected.

    `ros2 param set` and `load` take a number without a point for an integer, and one with an exponent
    and no point for a word.
    """
    if parameter.name not in _DOUBLES or parameter.type_ not in (
        Parameter.Type.INTEGER,
        Parameter.Type.STRING,
    ):
        return parameter
    try:
        return Parameter(parameter.name, Parameter.Type.DOUBLE, float(parameter.value))
    except ValueError:
        return parameter  # refused by its type


def answer_parameter_calls(node: Node) -> None:
    """Answer calls that rclpy raises for, and then never answers, with no and a reason."""

    def set_each(request: Any, response: Any) -> Any:
        count = len(request.parameters)
        if count > _MOST:
            response.results = [_too_many(count)] * count
        else:
            response.results = [_changed(node, [message]) for message in request.parameters]
        return response

    def set_together(request: Any, response: Any) -> Any:
        count = len(request.parameters)
        response.result = _too_many(count) if count > _MOST else _changed(node, request.parameters)
        return response

    callbacks = {SetParameters: set_each, SetParametersAtomically: set_together}
    for service in node.services:
        service.callback = callbacks.get(service.srv_type, service.callback)


def _too_many(count: int) -> SetParametersResult:
    reason = f"expected at most {_MOST} parameters in a call, got {count}: none is changed"
    return SetParametersResult(successful=False, reason=reason)


def _changed(node: Node, messages: Iterable[ParameterMessage]) -> SetParametersResult:
    """Change parameters together, or none of them."""
    try:
        given = [as_meant(_read(message)) for message in messages]
        for parameter in given:
            if not node.has_parameter(parameter.name):
                name = parameter.name
                raise ValueError(f"unknown parameter {name:.100}{closest(name)}")
        return node.set_parameters_atomically(given)
    except (ValueError, ParameterNotDeclaredException) as error:
        return SetParametersResult(successful=False, reason=str(error))
    except Exception as error:
        reason = f"internal error: {type(error).__name__}: {error}"
        node.get_logger().error(f"parameters: {reason}", **ONCE_A_SECOND)
        return SetParametersResult(successful=False, reason=reason)


def _read(message: ParameterMessage) -> Parameter:
    """A parameter of a message.

    Raises:
        ValueError: Its type is none that ROS has.
    """
    known = [kind.value for kind in Parameter.Type]
    if message.value.type not in known:
        raise ValueError(
            f"{message.name:.100}: expected a type {known[0]} to {known[-1]} of "
            f"rcl_interfaces/ParameterType, got {message.value.type}"
        )
    return Parameter.from_parameter_msg(message)

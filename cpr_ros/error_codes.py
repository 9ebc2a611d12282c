# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Errors of the core and of requests as numbers of cpr_msgs/ErrorCode."""

from __future__ import annotations

from typing import TypeVar

from cpr_msgs.msg import ErrorCode

from cpr_core import (
    CprError,
    InvalidQuaternion,
    InvalidRequest,
    MotorLimitExceeded,
    NoForwardSolution,
    NoInverseSolution,
    NonFiniteInput,
    StrainLimitExceeded,
    TimeLimitExceeded,
    UnstableEquilibrium,
)

__all__ = ["RequestError", "active", "code_of", "error_code"]

_LONGEST_MESSAGE = 1000

InOperation = TypeVar("InOperation")


class RequestError(CprError):
    """A request the node refuses by itself.

    Attributes:
        val: Number of cpr_msgs/ErrorCode.
    """

    def __init__(self, val: int, message: str) -> None:
        """Refuse with a number and a message for a person."""
        self.val = val
        super().__init__(message)


def active(session: InOperation | None) -> InOperation:
    """The robot in operation.

    Raises:
        RequestError: There is none, as the node is not active.
    """
    if session is None:
        raise RequestError(ErrorCode.NOT_READY, "the node is not active: configure and activate it")
    return session


#: Most specific first.
_CODES: tuple[tuple[type[CprError], int], ...] = (
    (NonFiniteInput, ErrorCode.NON_FINITE_INPUT),
    (InvalidQuaternion, ErrorCode.INVALID_QUATERNION),
    (InvalidRequest, ErrorCode.INVALID_ROBOT_STATE),
    (MotorLimitExceeded, ErrorCode.MOTOR_LIMIT),
    (StrainLimitExceeded, ErrorCode.STRAIN_LIMIT),
    (UnstableEquilibrium, ErrorCode.UNSTABLE_EQUILIBRIUM),
    (TimeLimitExceeded, ErrorCode.TIMED_OUT),
    (NoInverseSolution, ErrorCode.NO_IK_SOLUTION),
    (NoForwardSolution, ErrorCode.NOT_CONVERGED),
)


def error_code(error: Exception) -> ErrorCode:
    """The code of an error; FAILURE for one that nobody foresaw."""
    if isinstance(error, RequestError):
        return ErrorCode(val=error.val, message=_shortened(str(error)))
    return code_of(type(error), str(error), getattr(error, "argument", ""))


def code_of(kind: type[Exception], text: str, argument: str = "") -> ErrorCode:
    """The code of an error that happened elsewhere.

    Args:
        kind: Its class.
        text: Its message.
        argument: Name of the argument that was wrong, if it was one.
    """
    if issubclass(kind, InvalidRequest) and argument == "file":
        return ErrorCode(val=ErrorCode.INVALID_FILE, message=_shortened(text))
    for expected, val in _CODES:
        if issubclass(kind, expected):
            return ErrorCode(val=val, message=_shortened(text))
    return ErrorCode(
        val=ErrorCode.FAILURE, message=f"internal error: {kind.__name__}: {_shortened(text)}"
    )


def _shortened(text: str) -> str:
    """A message may repeat what was sent."""
    return text if len(text) <= _LONGEST_MESSAGE else f"{text[:_LONGEST_MESSAGE]}..."

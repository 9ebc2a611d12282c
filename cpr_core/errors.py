"""Errors of the core. Each carries the data a caller needs to act on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .equilibrium import Equilibrium

__all__ = [
    "CprError",
    "DescriptionError",
    "InvalidQuaternion",
    "InvalidRequest",
    "MotorLimitExceeded",
    "NoForwardSolution",
    "NoInverseSolution",
    "NoSolution",
    "NonFiniteInput",
]


class CprError(Exception):
    """Base class of all errors raised by cpr_core.

    Attributes:
        code: Stable name of the kind of error, e.g. for machine-readable output.
    """

    code = "FAILURE"


class DescriptionError(CprError):
    """A robot description cannot be used.

    Attributes:
        source: File, or other origin, of the description.
        field: Path of the offending field, such as ``legs[2].motor.axis``.
        problem: What was found and what was expected.
    """

    code = "INVALID_DESCRIPTION"

    def __init__(self, source: str, field: str, problem: str) -> None:
        """Name where the problem is and what was expected."""
        self.source = source
        self.field = field
        self.problem = problem
        super().__init__(f"{source}: {field}: {problem}" if field else f"{source}: {problem}")


class InvalidRequest(CprError):
    """An argument has the wrong length, name or combination.

    Attributes:
        argument: Name of the argument.
        problem: What was found and what was expected.
    """

    code = "INVALID_ROBOT_STATE"

    def __init__(self, argument: str, problem: str) -> None:
        """Name the argument and what was expected of it."""
        self.argument = argument
        self.problem = problem
        super().__init__(f"{argument}: {problem}")


class NonFiniteInput(InvalidRequest):
    """An argument holds a NaN or an infinity."""

    code = "NON_FINITE_INPUT"


class InvalidQuaternion(InvalidRequest):
    """A quaternion is too far from unit length to be a rotation."""

    code = "INVALID_QUATERNION"


class MotorLimitExceeded(CprError):
    """A motor would have to leave its position range or give more than its effort.

    Attributes:
        motor: Name of the motor.
        quantity: ``position`` or ``effort``.
        value: What it would have to be.
        limits: Lower and upper limit.
    """

    code = "MOTOR_LIMIT"

    def __init__(
        self, motor: str, quantity: str, value: float, limits: tuple[float, float], unit: str
    ) -> None:
        """Name the motor, the value and the limits."""
        self.motor, self.quantity, self.value, self.limits = motor, quantity, value, limits
        lower, upper = limits
        super().__init__(
            f"{motor}: {quantity} {value:.6g} {unit} is outside its limits [{lower:g}, {upper:g}]"
        )


class NoSolution(CprError):
    """No equilibrium was found along the way from the start to the request.

    Attributes:
        fraction: Fraction of the way, in [0, 1], up to which equilibria were found.
        last: Last equilibrium on the way (the start itself with fraction 0).
    """

    code = "NOT_CONVERGED"

    def __init__(self, message: str, fraction: float, last: Equilibrium | None) -> None:
        """Keep how far the solver came."""
        self.fraction = fraction
        self.last = last
        super().__init__(message)


class NoForwardSolution(NoSolution):
    """The requested motors, efforts or loads were not reached."""


class NoInverseSolution(NoSolution):
    """The requested platform coordinates were not reached."""

    code = "NO_IK_SOLUTION"

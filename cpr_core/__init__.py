"""Statics, kinemato-statics and stability of continuum parallel robots."""

from .equilibrium import Equilibrium
from .errors import (
    CprError,
    DescriptionError,
    InvalidQuaternion,
    InvalidRequest,
    NoForwardSolution,
    NoInverseSolution,
    NonFiniteInput,
    NoSolution,
)
from .geometrico_statics import solve_forward, solve_forward_by_effort, solve_inverse
from .loads import Loads
from .robot import Robot, load_robot
from .stability import Spectrum, spectrum

__version__ = "0.1.0"

__all__ = [
    "CprError",
    "DescriptionError",
    "Equilibrium",
    "InvalidQuaternion",
    "InvalidRequest",
    "Loads",
    "NoForwardSolution",
    "NoInverseSolution",
    "NoSolution",
    "NonFiniteInput",
    "Robot",
    "Spectrum",
    "load_robot",
    "solve_forward",
    "solve_forward_by_effort",
    "solve_inverse",
    "spectrum",
]

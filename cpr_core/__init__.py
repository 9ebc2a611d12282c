# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Statics, kinemato-statics and stability of continuum parallel robots."""

from .critical_load import CriticalLoad, critical_load, critical_load_factor
from .equilibrium import Equilibrium
from .errors import (
    CprError,
    DescriptionError,
    DescriptionWarning,
    InvalidQuaternion,
    InvalidRequest,
    MotorLimitExceeded,
    NoForwardSolution,
    NoInverseSolution,
    NonFiniteInput,
    NoSolution,
    NotReached,
    StrainLimitExceeded,
    TimeLimitExceeded,
    UnstableEquilibrium,
)
from .events import PathEvent
from .find_equilibria import FoundEquilibrium, find_equilibria
from .geometrico_statics import (
    restore_equilibrium,
    solve_forward,
    solve_forward_by_effort,
    solve_inverse,
)
from .kinemato_statics import KinematoStatics, Singularity, kinemato_statics
from .loads import DistributedForce, Loads, PointForce
from .robot import Robot, load_robot
from .shape import LegShape, leg_shapes
from .stability import Spectrum, spectrum
from .strain_limits import bending_strains
from .trace import Trace, trace
from .waypoints import trace_through

__version__ = "0.1.0"

__all__ = [
    "CprError",
    "CriticalLoad",
    "DescriptionError",
    "DescriptionWarning",
    "DistributedForce",
    "Equilibrium",
    "FoundEquilibrium",
    "InvalidQuaternion",
    "InvalidRequest",
    "KinematoStatics",
    "LegShape",
    "Loads",
    "MotorLimitExceeded",
    "NoForwardSolution",
    "NoInverseSolution",
    "NoSolution",
    "NonFiniteInput",
    "NotReached",
    "PathEvent",
    "PointForce",
    "Robot",
    "Singularity",
    "Spectrum",
    "StrainLimitExceeded",
    "TimeLimitExceeded",
    "Trace",
    "UnstableEquilibrium",
    "bending_strains",
    "critical_load",
    "critical_load_factor",
    "find_equilibria",
    "kinemato_statics",
    "leg_shapes",
    "load_robot",
    "restore_equilibrium",
    "solve_forward",
    "solve_forward_by_effort",
    "solve_inverse",
    "spectrum",
    "trace",
    "trace_through",
]

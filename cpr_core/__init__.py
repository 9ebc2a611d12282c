# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Statics, kinemato-statics and stability of continuum parallel robots."""

from .critical_load import CriticalLoad, critical_load, critical_load_factor
from .equilibrium import Equilibrium, spectrum
from .errors import CprError, DescriptionError, InvalidQuaternion, InvalidRequest, NonFiniteInput
from .events import PathEvent
from .find_equilibria import FoundEquilibrium, find_equilibria
from .geometrico_statics import (
    solve_forward,
    solve_forward_by_effort,
    solve_inverse,
)
from .home import solve_home
from .kinemato_statics import KinematoStatics, Singularity, kinemato_statics
from .loads import DistributedForce, Loads, PointForce
from .not_reached import (
    MotorLimitExceeded,
    NoForwardSolution,
    NoInverseSolution,
    NoSolution,
    NotReached,
    StrainLimitExceeded,
    TimeLimitExceeded,
    UnstableEquilibrium,
)
from .refining import restore_equilibrium
from .robot import Robot, load_robot
from .shape import LegShape, leg_shapes
from .stability import Spectrum
from .strain_limits import bending_strains
from .targets import given_at
from .trace import Trace, trace
from .version import __version__
from .waypoints import trace_through

__all__ = [
    "CprError",
    "CriticalLoad",
    "DescriptionError",
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
    "__version__",
    "bending_strains",
    "critical_load",
    "critical_load_factor",
    "find_equilibria",
    "given_at",
    "kinemato_statics",
    "leg_shapes",
    "load_robot",
    "restore_equilibrium",
    "solve_forward",
    "solve_forward_by_effort",
    "solve_home",
    "solve_inverse",
    "spectrum",
    "trace",
    "trace_through",
]

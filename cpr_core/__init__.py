# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Statics, kinemato-statics and stability of continuum parallel robots."""

from .description.loads import DistributedForce, Loads, PointForce
from .errors import (
    CprError,
    DescriptionError,
    DescriptionWarning,
    InvalidQuaternion,
    InvalidRequest,
    NonFiniteInput,
    UnknownParameter,
)
from .identification.calibration import calibrate
from .identification.calibration_result import CalibrationResult, CalibrationWarning
from .identification.felt_wrench import estimate_wrench
from .identification.measurement_file import read_measurements, write_poses
from .identification.measurements import Measurement, StandardDeviations
from .identification.proposed_poses import ProposedPoses, propose_poses
from .identification.wrench_estimate import WrenchEstimate
from .model.bending_strain import bending_strains
from .model.equilibrium import Equilibrium, spectrum
from .model.kinemato_statics import Increments, KinematoStatics, kinemato_statics
from .model.linear_problems import Singularity
from .model.robot import Robot
from .model.shape import JointPlace, LegShape, leg_shapes
from .model.stability import Spectrum
from .solving.border_error import border_error
from .solving.chosen_modes import choose_modes
from .solving.continued import continued
from .solving.critical_load import CriticalLoad, critical_load, critical_load_factor
from .solving.discretisation_error import DiscretisationError, error_of
from .solving.events import PathEvent
from .solving.find_equilibria import FoundEquilibrium, find_equilibria
from .solving.geometrico_statics import solve_forward, solve_forward_by_effort, solve_inverse
from .solving.home import solve_home
from .solving.load_robot import load_robot
from .solving.not_reached import (
    MotorLimitExceeded,
    NoForwardSolution,
    NoInverseSolution,
    NoSolution,
    NotReached,
    StrainLimitExceeded,
    TimeLimitExceeded,
    UnstableEquilibrium,
)
from .solving.parameter_derivatives import ParameterDerivatives, derivatives
from .solving.refining import restore_equilibrium
from .solving.trace import Trace, trace
from .solving.waypoints import trace_through
from .version import __version__
from .viewing.view import view

__all__ = [
    "CalibrationResult",
    "CalibrationWarning",
    "CprError",
    "CriticalLoad",
    "DescriptionError",
    "DescriptionWarning",
    "DiscretisationError",
    "DistributedForce",
    "Equilibrium",
    "FoundEquilibrium",
    "Increments",
    "InvalidQuaternion",
    "InvalidRequest",
    "JointPlace",
    "KinematoStatics",
    "LegShape",
    "Loads",
    "Measurement",
    "MotorLimitExceeded",
    "NoForwardSolution",
    "NoInverseSolution",
    "NoSolution",
    "NonFiniteInput",
    "NotReached",
    "ParameterDerivatives",
    "PathEvent",
    "PointForce",
    "ProposedPoses",
    "Robot",
    "Singularity",
    "Spectrum",
    "StandardDeviations",
    "StrainLimitExceeded",
    "TimeLimitExceeded",
    "Trace",
    "UnknownParameter",
    "UnstableEquilibrium",
    "WrenchEstimate",
    "__version__",
    "bending_strains",
    "border_error",
    "calibrate",
    "choose_modes",
    "continued",
    "critical_load",
    "critical_load_factor",
    "derivatives",
    "error_of",
    "estimate_wrench",
    "find_equilibria",
    "kinemato_statics",
    "leg_shapes",
    "load_robot",
    "propose_poses",
    "read_measurements",
    "restore_equilibrium",
    "solve_forward",
    "solve_forward_by_effort",
    "solve_home",
    "solve_inverse",
    "spectrum",
    "trace",
    "trace_through",
    "view",
    "write_poses",
]

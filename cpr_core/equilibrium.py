"""The one value every solve returns."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .arrays import Lanes, LoadArrays, kept_factors
from .bound_robot import factors_bound
from .inertia import Inertia
from .lie import quaternion_from_rotation
from .loads import Loads
from .robot import Robot

if TYPE_CHECKING:
    from .stability import Spectrum

__all__ = ["RESIDUAL_TOLERANCE", "Equilibrium"]

Floats = NDArray[np.float64]

#: Largest dimensionless residual of an equilibrium.
RESIDUAL_TOLERANCE = 1e-10


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A solution of the geometrico-static model, Eq. (32).

    Attributes:
        robot: The robot.
        loads: Loads in force.
        state: Motor, leg and multiplier values in the order of the kernels, read-only, (N,).
        platform_rotation: R_p in the world, (3, 3).
        platform_position: p_p in the world, (3,) [m].
        efforts: Motor efforts tau_a on the rods, (n,) [N m or N].
        residual: Largest dimensionless residual of the model.
        iterations: Newton steps from the start, all path steps together.
        energy: Potential energy without the work of motors and non-conservative loads [J].
        load_arrays: The loads as the kernels see them.
        inertia: Stability indices and the side of the inverse singularity.
        known_factors: The condensed tangent, where the solver has left it.
    """

    robot: Robot
    loads: Loads
    state: Floats = field(repr=False)
    platform_rotation: Floats
    platform_position: Floats
    efforts: Floats
    residual: float
    iterations: int
    energy: float
    load_arrays: LoadArrays = field(repr=False)
    inertia: Inertia
    known_factors: Lanes | None = field(repr=False, default=None)

    def __post_init__(self) -> None:
        for array in (self.state, self.platform_rotation, self.platform_position, self.efforts):
            array.flags.writeable = False

    @property
    def converged(self) -> bool:
        """Whether the residual is below ``RESIDUAL_TOLERANCE``; solvers return nothing else."""
        return self.residual < RESIDUAL_TOLERANCE

    @property
    def motors(self) -> Floats:
        """Motor positions q_a, (n,) [rad or m]."""
        return self.state[self.robot.arrays.motor_index :]

    @property
    def leg_coordinates(self) -> Floats:
        """Leg by leg: passive base coordinate if any, then strain coordinates q_e [1/m]."""
        return self.state[self.robot.elastic_indices]

    @property
    def multipliers(self) -> Floats:
        """Leg by leg: force on the rod tip in the world [N], then joint moments [N m]."""
        return self.state[self.robot.multiplier_indices]

    @cached_property
    def platform_quaternion(self) -> Floats:
        """Orientation of the platform as a unit quaternion (w, x, y, z)."""
        return quaternion_from_rotation(self.platform_rotation)

    @cached_property
    def factors(self) -> Lanes:
        """The condensed tangent, as the kernels keep it."""
        if self.known_factors is not None:
            return self.known_factors
        kept = kept_factors(self.robot.arrays)
        factors_bound(
            self.robot.bound, self.load_arrays, self.state.copy(), self.platform_rotation.copy(),
            self.platform_position.copy(), np.empty(len(self.state)), np.empty(3, np.int64), kept,
        )  # fmt: skip
        return kept

    @cached_property
    def spectrum_locked(self) -> Spectrum:
        """Spectrum of H_r with the motors held."""
        from .stability import spectrum

        return spectrum(self, "locked")

    @cached_property
    def spectrum_free(self) -> Spectrum:
        """Spectrum of H_r with the motors at constant effort, Eq. (48)."""
        from .stability import spectrum

        return spectrum(self, "free")

    @property
    def index_locked(self) -> int:
        """Negative eigenvalues of H_r, motors held: 0 is stable."""
        return self.inertia.index_locked

    @property
    def index_free(self) -> int:
        """Negative eigenvalues of H_r, motors at constant effort: 0 is stable."""
        return self.inertia.index_free

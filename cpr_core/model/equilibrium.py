# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The one value every solve returns."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..description.controlled_coordinates import pose_of
from ..errors import InvalidRequest
from ..kernels.kernel_arrays import Lanes
from ..kernels.record_layout import (
    EFFORT,
    ENERGY,
    INDEX_FREE,
    INDEX_LOCKED,
    RESIDUAL,
    SIGNS,
    STEPS,
)
from ..kernels.square_problem import RESIDUAL_TOLERANCE
from ..lie import quaternion_from_rotation
from ..validation import cached_array, cached_property, checked_word
from .dense_response import DenseResponse, dense_response
from .equilibrium_records import AS_IT_IS, corrected_record
from .linearisation import Linearisation, LinearisedState, Response
from .model_state import ModelState
from .other_names import OF_EQUILIBRIA, OtherNames
from .stability import MotorReading, Spectrum
from .tangent_signs import TangentSigns, tangent_signs_of

__all__ = ["Equilibrium", "check_equilibrium", "firm_margin", "spectrum"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(ModelState, OtherNames):
    """A solution of the geometrico-static model, Eq. (32).

    Attributes:
        robot: The robot.
        loads: Loads in force.
        load_arrays: The loads as the kernels see them.
        record: The solution as the kernels keep it, see `record_layout`; never to be written.
        known_factors: The condensed tangent, where the solver has left it.
        objective: What the freedom of redundant motors was used for (``least_motion``,
            ``least_effort``, ``greatest_margin``), where an inverse problem found it; else empty.
    """

    _other_names: ClassVar[Mapping[str, str]] = OF_EQUILIBRIA
    known_factors: Lanes | None = None
    objective: str = ""

    def __repr__(self) -> str:
        name, motors = self.robot.description.name, np.array2string(self.motors, precision=4)
        position = np.array2string(self.platform_position, precision=4)
        return (
            f"<Equilibrium of {name}: motors {motors}, platform at {position} m, "
            f"index {self.index_locked} locked, {self.index_free} free>"
        )

    def _number(self, at: int) -> float:
        """A number behind the state."""
        return float(self.record[self.robot.state_size + at])

    @property
    def configuration(self) -> Floats:
        """State, R_p row by row and p_p, read-only, (N + 12,): where the robot is, in one piece."""
        size = self.robot.state_size
        return self._part(-size, size + ENERGY)

    @cached_property
    def efforts(self) -> Floats:
        """Motor efforts tau_a on the rods, (n,) [N m or N]."""
        return self._part(EFFORT, self.robot.motor_count)

    @property
    def residual(self) -> float:
        """Largest dimensionless residual of the model."""
        return self._number(RESIDUAL)

    @property
    def iterations(self) -> int:
        """Newton steps from the start, all path steps together."""
        return int(self._number(STEPS))

    @property
    def energy(self) -> float:
        """Potential energy without the work of motors, platform moments and following forces [J].

        In the plane a moment has a potential, moment times angle of the platform, and the energy
        criterion applies; it is left out here all the same, for an angle counts whole turns.
        """
        return self._number(ENERGY)

    @cached_property
    def signs(self) -> TangentSigns:
        """Stability indices and the side of the inverse singularity."""
        return tangent_signs_of(self._part(SIGNS, 3))

    @property
    def converged(self) -> bool:
        """Whether the residual is below ``RESIDUAL_TOLERANCE``; solvers return nothing else."""
        return self.residual < RESIDUAL_TOLERANCE

    @cached_property
    def motors(self) -> Floats:
        """Motor positions q_a, (n,) [rad or m]."""
        return self.state[self.robot.kernel_arrays.motor_index :]

    @property
    def leg_coordinates(self) -> Floats:
        """Leg by leg: passive joints [rad or m], then strain coordinates q_e [1/m]."""
        return self.state[self.robot.elastic_indices]

    @property
    def multipliers(self) -> Floats:
        """Leg by leg: force on the rod tip in the world [N], then joint moments [N m]."""
        return self.state[self.robot.multiplier_indices]

    @cached_array
    def platform_quaternion(self) -> Floats:
        """Orientation of the platform as a unit quaternion (w, x, y, z)."""
        return quaternion_from_rotation(self.platform_rotation)

    @property
    def pose(self) -> Floats:
        """Controlled coordinates in the order of the description, as `solve_inverse` takes them.

        Of a spatial robot with six motors: x y z in the world [m], then qw qx qy qz. Single angles are
        in radians. Empty where the inverse problem has no single solution. The whole platform is
        ``platform_position`` with ``platform_rotation`` or ``platform_quaternion``.
        """
        return self._pose.copy()

    @cached_array
    def _pose(self) -> Floats:
        position, rotation = self.platform_position, self.platform_rotation
        controlled = self.robot.description.controlled
        return pose_of(controlled, position, rotation, lambda: self.platform_quaternion)

    @property
    def factors(self) -> Lanes:
        """The condensed tangent, as the kernels keep it."""
        return self._found_factors if self.known_factors is None else self.known_factors

    @cached_property
    def _found_factors(self) -> Lanes:
        _, factors = corrected_record(self.robot, self.load_arrays, self.record, AS_IT_IS)
        assert factors is not None
        return factors

    def with_iterations(self, iterations: int) -> Equilibrium:
        """The same with another number of Newton steps."""
        record = self.record.copy()
        record[self.robot.state_size + STEPS] = iterations
        return replace(self, record=record)

    @cached_property
    def _linearised(self) -> LinearisedState:
        """What spectra keep, which are kept here: what keeps each other is not given back at once."""
        return LinearisedState(self.robot, self.loads, self.load_arrays, self.record, self.factors)

    @property
    def linearisation(self) -> Linearisation:
        """Margin, smallest eigenvalues, and how platform and efforts answer to motors and wrench."""
        return self._linearised.linearisation

    @cached_property
    def response(self) -> Response:
        """How platform and efforts answer to motors and wrench.

        From the condensed legs, or from the whole tangent where one cannot be condensed.
        """
        condensed = self.linearisation.response
        if condensed is not None:
            return condensed
        return self.dense_response.of_platform(self.robot.platform_indices)

    @cached_property
    def dense_response(self) -> DenseResponse:
        """The same of legs and multipliers too, from the whole tangent: takes longer."""
        return dense_response(self)

    @property
    def jacobian(self) -> Floats:
        """Platform Jacobian ``dSigma_p/dq_a`` at constant loads, (platform, n).

        Rows: body twist at the platform origin, rotation first [rad, m]; columns: motors [rad or m]. Of
        a platform in the plane the rows are its own: rotation about z, x and y; of a point x and y.
        """
        return self.response.jacobian

    @cached_property
    def spectrum_locked(self) -> Spectrum:
        """Spectrum of H_r with the motors held."""
        return Spectrum("locked", self._linearised)

    @cached_property
    def spectrum_free(self) -> Spectrum:
        """Spectrum of H_r with the motors at constant effort, Eq. (48)."""
        return Spectrum("free", self._linearised)

    @property
    def index_locked(self) -> int:
        """Negative eigenvalues of H_r, motors held: 0 is stable."""
        return int(self._number(SIGNS + INDEX_LOCKED))

    @property
    def index_free(self) -> int:
        """Negative eigenvalues of H_r, motors at constant effort: 0 is stable."""
        return int(self._number(SIGNS + INDEX_FREE))

    @property
    def stable(self) -> bool:
        """Whether it is stable with the motors held, and energy decides that.

        False under loads without a potential (moments fixed in space, following wrenches): there
        `index_locked` does not tell.
        """
        return self.index_locked == 0 and self.robot.has_potential(self.loads)

    @property
    def margin(self) -> float:
        """Margin of stability with the motors held: 1 without loads and forces, 0 where stability ends.

        Smallest eigenvalue of H_r relative to the elastic stiffness, dimensionless.
        """
        condensed = self._linearised.condensed_margin
        return self.spectrum_locked.margin if math.isnan(condensed) else condensed


def check_equilibrium(value: object) -> None:
    """Whether this is something a question can be about.

    Raises:
        InvalidRequest: No equilibrium.
    """
    if not isinstance(value, Equilibrium):
        raise InvalidRequest("equilibrium", f"expected an Equilibrium, got {value!r:.200}")


def firm_margin(equilibrium: Equilibrium) -> float:
    """The margin; where there is none, ``Spectrum.firm_margin``: of what has to be watched on a way."""
    margin = equilibrium.margin
    return equilibrium.spectrum_locked.firm_margin if math.isnan(margin) else margin


def spectrum(equilibrium: Equilibrium, motors_are: MotorReading = "locked") -> Spectrum:
    """Spectrum of H_r at an equilibrium.

    Args:
        equilibrium: Where.
        motors_are: ``locked`` (motors held, the reading behind the paper's case studies) or ``free``
            (motors at constant effort, Eq. (48) literally).

    Raises:
        InvalidRequest: No equilibrium, or another reading.
    """
    check_equilibrium(equilibrium)
    locked = checked_word("motors_are", motors_are, ("locked", "free")) == "locked"
    return equilibrium.spectrum_locked if locked else equilibrium.spectrum_free

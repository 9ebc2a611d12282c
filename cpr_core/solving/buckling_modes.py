# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How many strain modes it takes for legs to buckle where continuous ones do.

Shapes in which rods buckle have no amplitude before, so how far a platform is off does not see them. The
derivation is in docs/derivations.md, "Modes that are chosen".
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import scipy
from numpy.typing import NDArray

from ..blas_threads import on_one_blas_thread
from ..model.equilibrium import Equilibrium
from ..model.model_state import evaluate
from ..model.shape import tip_poses
from ..model.stability import null_space_of
from ..model.state_numbers import LegNumbers

__all__ = ["buckling_modes"]

Floats = NDArray[np.float64]

#: Largest error of the force at which a leg buckles, relative.
_EXACT = 0.01
#: Enough for straight uniform rods however they are held: clamped at both ends they take five. How far
#: rods are bent is seen in the platform too.
_MOST = 5


@on_one_blas_thread
def buckling_modes(exact: Equilibrium) -> list[int]:
    """Fewest modes of rods, in each bending direction, with which legs buckle where they do, (rods,).

    Every leg by itself, motors held and the tip as its joint holds it, under a force along its chord.

    Args:
        exact: Equilibrium of a robot that has more modes than it needs.
    """
    robot, pushed = exact.robot, exact.state.copy()
    legs, tips = robot.numbers.legs, tip_poses(robot, exact.state)
    for leg, tip, described in zip(legs, tips, robot.description.legs, strict=True):
        chord = (tip.position - described.base_position)[: leg.forces.stop - leg.forces.start]
        distance = float(np.linalg.norm(chord))
        if distance > 0.0:
            pushed[leg.forces] += robot.kernel_arrays.unit[leg.forces] * chord / distance
    place = exact.platform_rotation, exact.platform_position
    units = (
        np.outer(robot.kernel_arrays.unit, robot.kernel_arrays.unit)
        / robot.kernel_arrays.energy_unit
    )
    tangent = units * evaluate(robot, exact.load_arrays, exact.state, *place).tangent
    stiffened = units * evaluate(robot, exact.load_arrays, pushed, *place).tangent - tangent
    found, first_of_platform = [], robot.numbers.platform_index
    for leg in legs:
        joints = [index for index in leg.coordinates if index is not None]
        passive = [index for index in joints if index < first_of_platform]
        if leg.rods:
            found += [_enough(leg, passive, tangent, stiffened)] * len(leg.rods)
    return found


def _enough(leg: LegNumbers, passive: list[int], tangent: Floats, stiffened: Floats) -> int:
    """Fewest modes of the rods of one leg; matrices dimensionless, (N, N)."""
    many = max(max(rod.element.modes.counts[1:]) for rod in leg.rods)
    most = min(many, _MOST) if all(rod.element.rod.uniform for rod in leg.rods) else many
    with suppress(np.linalg.LinAlgError):
        wanted = _softening(leg, passive, many, tangent, stiffened)
        for modes in range(1, most):
            found = _softening(leg, passive, modes, tangent, stiffened)
            if wanted <= (1.0 + _EXACT) * found:
                return modes
    return most


def _softening(
    leg: LegNumbers, passive: list[int], modes: int, tangent: Floats, stiffened: Floats
) -> float:
    """One over the force along the chord at which a leg with so many modes of bending buckles.

    Raises:
        LinAlgError: It has buckled without one.
    """
    motions = [*passive]
    for rod in leg.rods:
        first = rod.strain.start
        for direction, count in enumerate(rod.element.modes.counts):
            motions += range(first, first + (count if direction == 0 else min(count, modes)))
            first += count
    held = [*range(leg.forces.start, leg.forces.stop), *range(leg.moments.start, leg.moments.stop)]
    free, within = null_space_of(tangent[np.ix_(held, motions)]), np.ix_(motions, motions)
    if not free.shape[1]:
        return 0.0
    stiffness, change = (free.T @ matrix[within] @ free for matrix in (tangent, stiffened))
    return float(np.abs(scipy.linalg.eigh(change, stiffness, eigvals_only=True)).max())

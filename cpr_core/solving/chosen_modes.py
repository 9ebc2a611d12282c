# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The fewest strain modes per rod and direction with which a robot is as exact as is wanted.

Many modes are solved with, then given up one by one, the one that moves the platform least first. The
derivation is in docs/derivations.md, "Modes that are chosen".
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ..description.robot_description import ModeCounts
from ..errors import CprError, InvalidRequest, distinct
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot, checked_robot
from ..rods.strain_basis import DescribedBasis
from ..validation import checked_number
from .buckling_modes import buckling_modes
from .discretisation_error import error_of
from .fewest_modes import fewest_modes
from .geometrico_statics import solve_forward
from .home import solve_home
from .not_reached import MotorLimitExceeded, NotReached, StrainLimitExceeded

__all__ = [
    "TOLD",
    "ComparedModes",
    "choose_modes",
    "compared_modes",
    "equilibria_near_home",
    "exactness_of",
    "with_many_modes",
]

#: Numbers of modes in every direction that are tried for the solution others are compared with.
_MANY = range(6, 25, 2)
#: Part of the tolerance that the solution others are compared with may be wrong by.
_TRUE = 0.1
#: Rounding of solutions [m], and the least tolerance that is above it.
_ROUNDING, _LEAST = 2e-10, 1e-9
#: From this part of the tolerance on an estimated error is told: it leaves out what still more modes
#: change.
TOLD = 0.5
#: How far motors are moved from home, one by one, in their units: at home alone straight rods would need
#: no modes at all.
_PROBE = 0.1
#: Where a limit ends that way, motors are moved by this part of what leads to it: with fewer modes a
#: motor gives more, or a rod bends farther.
_WITHIN = 0.9
#: What modes may be given up for, of the tolerance: at first, and from try to try, as they are given up
#: by what they do to first order only.
_BUDGET, _LESS, _TRIES = 0.9, 0.6, 8


def choose_modes(robot: Robot, tolerance: float) -> Robot:
    """The same robot with the fewest strain modes per rod and direction that are exact enough.

    They are so at home and with every motor moved from there by 0.1 rad (or rod lengths) to either side,
    where limits let it; elsewhere `error_of` tells. Torsion is among them, where rods twist or would
    under a wrench on the platform. Straight legs buckle within a hundredth of where continuous ones do.

    Args:
        robot: The robot; its own numbers of modes do not matter.
        tolerance: Largest distance of the platform from where continuous rods would hold it [m].

    Raises:
        InvalidRequest: The tolerance is none, or the basis says itself how many modes it has.
        CprError: 24 modes in every direction are not enough, or there is no home.
    """
    checked_robot(robot)
    tolerance = checked_number("tolerance", tolerance)
    if tolerance < _LEAST:
        least, given = distinct(_LEAST, tolerance, fewest=6)
        raise InvalidRequest("tolerance", f"expected at least {least} m, got {given}")
    bases = (rod.modes.basis for rod in robot.description.rods)
    if any(isinstance(basis, DescribedBasis) and basis.modes is not None for basis in bases):
        raise InvalidRequest(
            "modes", "they cannot be chosen: B-splines have as many modes as degree and knots say"
        )
    even = all(element.rod.uniform for element in robot.description.rods)
    bending = [] if even else _bending_of_uneven(robot)
    exact = with_many_modes(robot, tolerance, max(bending, default=_MANY[0]))
    # What they are wrong by themselves is taken off, where that is more than is looked at.
    allowed = tolerance - max(0.0, exactness_of(exact) - max(_TRUE * tolerance, _ROUNDING))
    budget, bending = _BUDGET * allowed, bending or buckling_modes(exact[0])
    for _ in range(_TRIES):
        found = _with_counts(robot, fewest_modes(exact, budget, bending))
        if _is_met(found, exact, allowed):
            return found
        budget *= _LESS
    return exact[0].robot


def _bending_of_uneven(robot: Robot) -> list[int]:
    """Fewest modes of bending with which rods that are not the same all along buckle where they do.

    It takes many for that, which where the platform is does not show. Empty where there is no home with
    so many: monomials are hardly independent then.
    """
    torsion = 0 if robot.planar else 2
    counts = [(torsion, 0 if robot.planar else _MANY[-1], _MANY[-1])]
    try:
        home = solve_home(_with_counts(robot, counts * len(robot.description.rods)))
    except CprError:
        return []
    return buckling_modes(home)


def equilibria_near_home(robot: Robot) -> tuple[Equilibrium, ...]:
    """Home, and the stable equilibria around it: every motor moved by 0.1 of its unit to either side.

    Where a limit of a motor or rod is nearer, almost to that.

    Raises:
        CprError: There is no home.
    """
    found = [home := solve_home(robot)]
    for step in np.kron(np.diag(_PROBE * robot.motor_units), [[-1.0], [1.0]]):
        with suppress(NotReached):
            try:
                found.append(solve_forward(robot, home.motors + step, start=home, stable_only=True))
            except (MotorLimitExceeded, StrainLimitExceeded) as error:
                inside = home.motors + _WITHIN * error.fraction * step
                found.append(solve_forward(robot, inside, start=home, stable_only=True))
    return tuple(found)


def with_many_modes(
    robot: Robot, tolerance: float, fewest: int = _MANY[0]
) -> tuple[Equilibrium, ...]:
    """Equilibria near home with as many modes as it takes to compare others with.

    Their own error is a tenth of the tolerance; half of it where 24 modes in every direction have more.

    Args:
        robot: The robot.
        tolerance: [m].
        fewest: Modes in every direction that are tried first.

    Raises:
        CprError: They have more than that.
    """
    description, error = robot.description, np.inf
    for modes in (modes for modes in _MANY if modes >= fewest):
        counts = (0, 0, modes) if description.planar else (modes, modes, modes)
        found = equilibria_near_home(_with_counts(robot, [counts] * len(description.rods)))
        error = max(error_of(equilibrium).distance for equilibrium in found)
        if error <= max(_TRUE * tolerance, _ROUNDING):
            return found
    if error <= TOLD * tolerance:
        return found
    jumps = any(not element.rod.profile.uniform for element in description.rods)
    raise CprError(
        f"{tolerance:g} m is not met near home: the error of {_MANY[-1]} modes in every direction is "
        f"about {error:.2g} m, and half the tolerance is wanted"
        + ("; a rod with a jump of its stiffness wants to be two rods in a chain" if jumps else "")
    )


def exactness_of(exact: Sequence[Equilibrium]) -> float:
    """How exact equilibria to compare others with are themselves, by estimate and rounding [m]."""
    return max(_ROUNDING, *(error_of(equilibrium).distance for equilibrium in exact))


@dataclass(frozen=True, eq=False)
class ComparedModes:
    """How exact a robot is near home.

    Attributes:
        robot: The robot.
        estimated: Largest error of the platform position that `error_of` tells [m].
        true: Largest distance of the platform from where many modes hold it [m].
        solve_time: Median processor time of a solution [s].
    """

    robot: Robot
    estimated: float
    true: float
    solve_time: float


def compared_modes(robot: Robot, exact: Sequence[Equilibrium]) -> ComparedModes:
    """Compare a robot with equilibria of the same robot that has many modes.

    Raises:
        NotReached: It has no equilibrium at the motors of one of them.
    """
    home = solve_home(robot)
    estimated, true, times = 0.0, 0.0, []
    for wanted in exact:
        begin = time.thread_time()
        found = solve_forward(robot, wanted.motors, start=home)
        times.append(time.thread_time() - begin)
        away = float(np.linalg.norm(found.platform_position - wanted.platform_position))
        true, estimated = max(true, away), max(estimated, error_of(found).distance)
    return ComparedModes(robot, estimated, true, float(np.median(times)))


def _with_counts(robot: Robot, counts: Sequence[ModeCounts]) -> Robot:
    return robot.with_description(robot.description.with_mode_counts(counts))


def _is_met(robot: Robot, exact: Sequence[Equilibrium], tolerance: float) -> bool:
    """Whether a robot is as exact as is wanted, by comparison and by its own estimate."""
    try:
        found = compared_modes(robot, exact)
    except NotReached:
        return False
    return found.true <= tolerance and found.estimated <= TOLD * tolerance

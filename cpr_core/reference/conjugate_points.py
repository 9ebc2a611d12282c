# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Conjugate points of rods and of robots of rods (Till & Rucker), an independent test of stability.

Cut every rod at the same normalised arc length u and clamp it there. Equilibrium is stable with
motors locked where no u in (0, 1) lets the tip parts [u, 1] move: the number of such u, with
multiplicity, is the number of negative eigenvalues of H_r (Morse index).

A variation of the tip parts is given by its terminal data, the platform's twist and the turn and
force variation of every tip (a spherical tip takes no moment), subject to the linearised balance of
the platform. Integrated towards the base by (b) of ``rod_integration``, they make at u the columns of

    Y = (dp, dtheta),   Z = (dn, dm - dtheta x m / 2)

leg by leg, as many as there are rows: Y(u) = b(u) is square and det b(u) = 0 at a conjugate point.

Y and Z are conjugate: Y^T Z is symmetric (the tests check it). So with orthonormal columns W = Y + i Z
is unitary, and the eigenvalues of W W^T do not depend on the basis. An eigenvalue -1 is a singular
value 0 of b(u), of the same multiplicity, and eigenvalues pass -1 in one direction only (the Maslov
index). So conjugate points between two sections are counted by how many eigenvalues went through -1,
and no double zero, where det b(u) has no sign change, can be missed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg, optimize

from ..blas_threads import on_one_blas_thread
from ..errors import InvalidRequest
from ..validation import cached_property
from .continuous_equilibrium import ContinuousEquilibrium
from .morse_index import index_falls
from .rod_integration import STEPS, RodTrajectory, force, integrate, moment, transitions
from .shooting_robot import balance_rows, check_robot, force_per_length, shooting_knows

__all__ = ["JacobiFields", "conjugate_points", "robot_fields", "rod_fields"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Cells of (0, 1) in which conjugate points are looked for first.
CELLS = 64
#: Tip parts shorter than this are not looked at: so short a rod does not buckle.
_SHORTEST = 0.01
#: Cells are split until the phases together turn by less than this [rad], so that none is lost in 2 pi.
LARGEST_TURN = 0.8
#: Conjugate points closer than this in u are one of higher multiplicity.
COINCIDENT = 1e-6
#: Turns of Y + i Z, one after the other until no phase is next to pi [rad].
_TURNS = tuple(0.4 + 0.618 * number for number in range(8))
#: Tangents of half a phase beyond this lose digits of the others.
_STEEP = 1e3


class Signature(NamedTuple):
    """What tells of the conjugate points before a section: sum of the phases, determinant of b(u)."""

    phase: float
    determinant: float


@dataclass(frozen=True, eq=False)
class JacobiFields:
    """All variations of the tip parts of rods that obey the terminal conditions.

    Attributes:
        rods: The rods from tip to base.
        terminal: Terminal data (dp, dtheta, dm, dn) rod by rod, a column for every variation, (12 L, n).
        units: E J / l of every rod, (L,) [J].
        position_rows: Components of (dp, dtheta) there are, in every rod; n = L len(position_rows).
    """

    rods: tuple[RodTrajectory, ...] = field(repr=False)
    terminal: Floats = field(repr=False)
    units: Floats
    position_rows: Integers

    def at(self, u: float) -> tuple[Floats, Floats]:
        """Y = b(u) and Z at a section, dimensionless, (n, n) each."""
        (b,), (z,) = self._at_all([u])
        return b, z

    def _at_all(self, sections: Sequence[float] | Floats) -> tuple[Floats, Floats]:
        """The same at several sections, (U, n, n) each."""
        states = np.array([[rod.at(1.0 - u) for rod in self.rods] for u in sections])
        own = self.terminal.reshape(len(self.rods), 12, self.size)
        fields, lengths = transitions(states) @ own, self._lengths
        # - dtheta x m / 2 = m x dtheta / 2
        turned = np.cross(moment(states)[..., None], fields[..., 3:6, :], axis=-2)
        couples = fields[..., 6:9, :] + 0.5 * turned
        places = np.concatenate([fields[..., :3, :] / lengths, fields[..., 3:6, :]], axis=-2)
        # A common unit of work keeps Y and Z conjugate where rods differ.
        wrenches = np.concatenate([fields[..., 9:, :] * lengths, couples], axis=-2) / self.units[0]
        shape, rows = (len(states), -1, self.size), self.position_rows
        return places[..., rows, :].reshape(shape), wrenches[..., rows, :].reshape(shape)

    @cached_property
    def _lengths(self) -> Floats:
        """Of the rods, (L, 1, 1) [m]."""
        return np.array([abs(rod.length) for rod in self.rods])[:, None, None]

    def determinant(self, u: float) -> float:
        """Determinant of b(u), positive near the tip: negative after an odd number of zeros."""
        return float(linalg.det(self.at(u)[0])) * self._orientation

    def determinants(self, sections: Sequence[float] | Floats) -> Floats:
        """The same at several sections, (U,)."""
        found: Floats = np.linalg.det(self._at_all(sections)[0])
        return found * self._orientation

    @cached_property
    def _orientation(self) -> float:
        """Sign near the tip; it depends on the basis of the terminal data."""
        return float(np.sign(linalg.det(self.at(1.0 - _SHORTEST)[0])))

    def singular_values(self, u: float) -> Floats:
        """Singular values of b(u) on orthonormal variations, descending, in [0, 1], (n,)."""
        return linalg.svdvals(linalg.qr(np.vstack(self.at(u)), mode="economic")[0][: self.size])

    @property
    def size(self) -> int:
        """Number n of independent variations."""
        return self.terminal.shape[1]

    def signatures(self, sections: Sequence[float] | Floats) -> list[Signature]:
        """Signatures of several sections."""
        b, z = self._at_all(sections)
        determinants = np.linalg.det(b) * self._orientation
        return list(map(Signature, _phases(b, z).sum(axis=-1).tolist(), determinants.tolist()))


def _phases(b: Floats, z: Floats) -> Floats:
    """Phases of sections, (U, n): W W^T = (1 + i S) / (1 - i S) with S = Z Y^-1.

    S is symmetric, whatever the basis, and its eigenvalues are found in a fifth of the time. They are
    without bound where a phase is next to pi: so all are turned away from there first, with Y + i Z.
    """
    phases = np.empty(b.shape[:-1])
    left = np.arange(len(b))
    for turn in _TURNS:
        cosine, sine = math.cos(turn), math.sin(turn)
        own, other = cosine * b[left] + sine * z[left], cosine * z[left] - sine * b[left]
        transposed = np.linalg.solve(np.swapaxes(own, -1, -2), np.swapaxes(other, -1, -2))
        tangents = np.linalg.eigvalsh(transposed)
        phases[left] = 2.0 * (np.arctan(tangents) + turn)
        left = left[np.abs(tangents).max(axis=-1) > _STEEP]
        if not len(left):
            break
    return np.pi - (np.pi - phases) % (2.0 * np.pi)


def robot_fields(solution: ContinuousEquilibrium) -> JacobiFields:
    """Variations of a robot with legs as in the paper: all share the platform, motors locked.

    Raises:
        InvalidRequest: Legs of another kind, which ``morse_index`` knows.
        InvalidRequest: A load without potential: then there is no energy to have an index.
    """
    robot, loads = solution.robot, solution.loads
    if not robot.has_potential(loads):
        raise InvalidRequest("loads", "expected loads that have a potential")
    check_robot(robot, loads)
    legs, rotation = robot.description.legs, solution.platform_rotation
    count = len(legs)
    tips = [rods[-1].states[-1] for rods in solution.rods]
    # Unknowns: platform twist (6), then the force variation of every tip (3 each), then its turn.
    terminal = np.zeros((12 * count, 6 + 6 * count))
    for number, leg in enumerate(legs):
        x, y, z = rotation @ leg.joint.position
        first, variation = 12 * number, 3 * number
        terminal[first : first + 3, :3] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
        terminal[first : first + 3, 3:6] = np.eye(3)
        terminal[first + 9 : first + 12, 6 + variation : 9 + variation] = np.eye(3)
        turn = 6 + 3 * count + variation
        terminal[first + 3 : first + 6, turn : turn + 3] = np.eye(3)
    balance = np.zeros((6, 6 + 6 * count))
    balance[:, : 6 + 3 * count] = balance_rows(
        robot, loads, rotation, np.array([force(tip) for tip in tips])
    )
    # Every row in its unit, or the null space would not be orthogonal to rounding.
    length, stiffness = legs[0].rod.length, legs[0].rod.rigidities[2]
    unit = np.ones(6 + 6 * count)
    unit[3:6] = length
    unit[6 : 6 + 3 * count] = stiffness / length**2
    rows, moving = np.arange(6), np.arange(6 + 6 * count)
    in_plane = np.arange(6)
    if robot.planar:
        rows = robot.platform_axes
        forces = 6 + (3 * np.arange(count)[:, None] + [0, 1]).ravel()
        turns = 6 + 3 * count + 3 * np.arange(count) + 2
        moving = np.concatenate([rows, forces, turns])
        in_plane = np.array([0, 1, 5])
    free = linalg.null_space((balance * unit)[np.ix_(rows, moving)])
    terminal = (terminal * unit)[:, moving] @ free
    if terminal.shape[1] != count * len(in_plane):
        raise InvalidRequest("robot", "the platform is held by dependent forces")
    rods = tuple(
        integrate(
            (tip[:3], tip[3:12], tip[12:15], tip[15:18]),
            -leg.rod.length,
            leg.rod.rigidities,
            density,
            solution.steps,
        )
        for leg, density, tip in zip(legs, force_per_length(robot, loads), tips, strict=True)
    )
    units = np.array([leg.rod.rigidities[2] / leg.rod.length for leg in legs])
    return JacobiFields(rods, terminal, units, in_plane)


def rod_fields(
    tip: tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike],
    length: float,
    rigidities: Floats,
    free: Sequence[int],
    *,
    planar: bool = False,
) -> JacobiFields:
    """Variations of a single rod, clamped at the section.

    Args:
        tip: Position [m], frame, internal moment [N m] and force [N] at the tip, in the world, (3,),
            (3, 3), (3,), (3,).
        length: Length l [m].
        rigidities: H_a, (3,) [N m^2].
        free: The components of (dp, dtheta, dm, dn), out of 0..11, the tip joint leaves free: six, in
            the plane three. The tip moment has to vanish unless dtheta is held.
        planar: Whether the rod varies in the plane z = 0 only.
    """
    rod = integrate(tip, -length, rigidities, np.zeros(3), STEPS)
    length_unit, couple = length, rigidities[2] / length
    unit = np.repeat([length_unit, 1.0, couple, couple / length], 3)
    rows = np.array([0, 1, 5] if planar else range(6))
    return JacobiFields((rod,), (np.eye(12) * unit)[:, list(free)], np.array([couple]), rows)


@on_one_blas_thread
def conjugate_points(solution: ContinuousEquilibrium | JacobiFields) -> tuple[float, ...]:
    """Conjugate points in (0, 1), ascending; double ones twice.

    Of robots that ``robot_fields`` does not know they are those of ``index_falls``, 0 and 1 included.

    Args:
        solution: An equilibrium of a robot, or the variations of rods.

    Raises:
        InvalidRequest: A load without potential.
        ArithmeticError: Phases and determinant disagree: the rods are not integrated well enough.
    """
    if isinstance(solution, JacobiFields):
        fields = solution
    elif shooting_knows(solution.robot, solution.loads):
        fields = robot_fields(solution)
    else:
        return index_falls(solution)
    sections = np.linspace(0.0, 1.0 - _SHORTEST, CELLS + 1)
    signatures = fields.signatures(sections)
    found: list[float] = []
    for k in range(CELLS):
        found += _between(fields, *sections[k : k + 2], *signatures[k : k + 2])
    return tuple(found)


def _between(
    fields: JacobiFields, low: float, high: float, at_low: Signature, at_high: Signature
) -> list[float]:
    """Conjugate points between two sections, from the signatures there.

    The sum of the phases turns continuously, but for the 2 pi it falls or rises by where a phase goes
    through pi.
    """
    step = at_high.phase - at_low.phase
    count = round(step / (2.0 * np.pi))
    wide = high - low > COINCIDENT
    if wide and (count not in (0, 1) or abs(step - 2.0 * np.pi * count) > LARGEST_TURN):
        middle = 0.5 * (low + high)
        (at_middle,) = fields.signatures([middle])
        return _between(fields, low, middle, at_low, at_middle) + _between(
            fields, middle, high, at_middle, at_high
        )
    if not wide:
        if count < 0:
            raise ArithmeticError(f"a phase turns backwards through pi at u = {low:.6f}")
        if count == 0:
            return []
        nearest = optimize.minimize_scalar(
            lambda u: fields.singular_values(u)[-1],
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-12},
        )
        return [float(nearest.x)] * count
    if (at_low.determinant * at_high.determinant < 0.0) != (count == 1):
        raise ArithmeticError(f"phases and determinant disagree on ({low:.6f}, {high:.6f})")
    if count == 0:
        return []
    return [float(optimize.brentq(fields.determinant, low, high, xtol=1e-13))]

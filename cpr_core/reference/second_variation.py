# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Second variation of the energy of a robot of continuous rods, from the Jacobi fields of its parts.

With x = (dp, dtheta) and y = (dn, dm - dtheta x m / 2), which are conjugate, the variations of a part of
a rod from one end to the other (``chain_steps``) are

    x_1 = A x_0 + B y_0 + e dl,   y_1 = C x_0 + D y_0 + f dl,   dg = r x_0 + s y_0 + kappa dl.

So its second variation, stationary in all but x_0, x_1, dl and the multiplier y_0 of its start, is
G(x_1, y_0, dl) - y_0 . x_0, a quadratic form with the symmetric matrix

        [ C A^-1    D - C A^-1 B    f - C A^-1 e     ]
    G = [ A^-1      -A^-1 B         -A^-1 e          ]
        [ r A^-1    s - r A^-1 B    kappa - r A^-1 e ]

Joints and links lead x on, x_1 = L x_0 + t dq, y_1 = C x_0 + L^-T y_0 + f dq, and add

    x_0 . L^T C x_0 / 2 + x_0 . L^T f dq + (kappa + t . f) dq^2 / 2;

the platform closes the legs with the multipliers of its joints. What is left is a matrix M of finitely
many variables without any mode or quadrature, and by Haynsworth's law

    index = negative eigenvalues of M - number of multipliers + sum of the indices of the parts,

a part held at its end and free at its start. Those are zero: parts are so short that A, the identity in
the limit, stays near it. Wittrick and Williams count eigenfrequencies like this.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from ..lie import skew
from .chain_balance import ChainPoint, tip_joint
from .chain_robot import ChainRobot
from .chain_steps import ChainState, ChainStep, chain_steps, tip_of

__all__ = ["PartTooLong", "SecondVariation", "second_variation"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Largest distance of A from the identity.
_NEAR = 0.8
#: Eigenvalues smaller than this times the largest are those of neutral motions.
_NEUTRAL = 1e-14
#: (dp, dtheta, dm, dn) with dn before dm; its own inverse.
_EXCHANGE: Floats = np.eye(12)[[*range(6), 9, 10, 11, 6, 7, 8]]


class PartTooLong(Exception):
    """A part of a rod may have a conjugate point of its own."""


@dataclass(frozen=True, eq=False)
class SecondVariation:
    """The quadratic form in natural units.

    Attributes:
        matrix: M, symmetric: platform, motors, then leg by leg passive joints, multipliers and rods.
        multipliers: How many of its variables are multipliers.
        motors: Which of its variables are motors.
    """

    matrix: Floats
    multipliers: int
    motors: Integers

    def index(self, *, motors_free: bool) -> int:
        """Negative directions of the energy; eigenvalues that vanish to rounding are not counted."""
        return int(np.sum(self._values(motors_free) < 0.0)) - self.multipliers

    def beyond(self, count: int, *, motors_free: bool) -> float:
        """A number that is negative where ``index`` is larger than a count, and seldom jumps."""
        return float(self._values(motors_free)[self.multipliers + count])

    def _values(self, motors_free: bool) -> Floats:
        """Eigenvalues, ascending, moved so that none that vanishes to rounding is negative."""
        matrix = self.matrix
        if not motors_free:
            matrix = np.delete(np.delete(matrix, self.motors, 0), self.motors, 1)
        values: Floats = linalg.eigvalsh(matrix)
        return values + _NEUTRAL * np.abs(values).max()


def second_variation(model: ChainRobot, point: ChainPoint, sections: Floats) -> SecondVariation:
    """Second variation of a robot in equilibrium.

    Args:
        model: The robot, its rods cut in parts.
        point: The equilibrium.
        sections: For every leg the length of its rods before a section where it is clamped, (L,) [m];
            only what lies beyond varies. At zero nothing is held.

    Raises:
        PartTooLong: Parts have to be shorter.
    """
    robot = model.robot
    platform = len(robot.platform_axes)
    shared = platform + robot.motor_count
    forms = [_LegForm(model, point, *of_leg) for of_leg in enumerate(sections)]
    own = [len(form.matrix) - shared for form in forms]
    matrix, first = np.zeros((shared + sum(own),) * 2), shared
    turns = robot.platform_axes < 3
    axes = robot.platform_axes[turns]
    weight = robot.description.platform_mass * model.loads.gravity / robot.numbers.energy_unit
    lifted = -_second_of_arm(weight, point.rotation @ robot.description.center_of_mass)
    matrix[: turns.sum(), : turns.sum()] = lifted[np.ix_(axes, axes)]
    for form, count in zip(forms, own, strict=True):
        index = np.concatenate([np.arange(shared), first + np.arange(count)])
        matrix[np.ix_(index, index)] += form.matrix
        first += count
    multipliers = sum(form.multipliers for form in forms)
    return SecondVariation(matrix, multipliers, np.arange(platform, shared))


def _held(steps: list[ChainStep], section: float) -> int:
    """How many of the elements of a leg lie before a section."""
    way, held = 0.0, 0
    for number, step in enumerate(steps):
        if step.trajectory is None:
            before = way < section * (1.0 - 1e-9)
        else:
            middle = way + 0.5 * step.trajectory.part_length
            way += step.trajectory.part_length
            before = middle < section
        if before:
            held = number + 1
    return held


def _conjugate(moment: Floats) -> Floats:
    """From (dp, dtheta, dm, dn) to (x, y), (12, 12)."""
    matrix = _EXCHANGE.copy()
    matrix[9:, 3:6] = 0.5 * skew(moment)  # -dtheta x m / 2
    return matrix


def _from_conjugate(moment: Floats) -> Floats:
    """Back from (x, y), (12, 12)."""
    matrix = _EXCHANGE.copy()
    matrix[6:9, 3:6] = -0.5 * skew(moment)
    return matrix


def _second_of_arm(force: Floats, arm: Floats) -> Floats:
    """Symmetric H of force . (turn x (turn x arm)) = turn . H turn, (3, 3)."""
    return 0.5 * (np.outer(force, arm) + np.outer(arm, force)) - force @ arm * np.eye(3)


class _LegForm:
    """The part of M that a leg has, gathered from its section to its tip; shared variables first."""

    def __init__(
        self,
        model: ChainRobot,
        point: ChainPoint,
        number: int,
        section: float,
    ) -> None:
        robot, leg = model.robot, model.legs[number]
        whole = list(chain_steps(leg, point.wrenches[number], point.values, point.nodes))
        steps = whole[_held(whole, section) :]
        shared = [*robot.platform_indices, *robot.motor_indices]
        moved = {step.index for step in steps}
        passive = [index for index in leg.passive if index in moved]
        self.leg, self.plane = leg, model.in_plane
        self.position = self.plane[self.plane < 3]
        self.unit, self.energy = robot.numbers.unit, robot.numbers.energy_unit
        # Natural units of x and y.
        self.x_unit = np.repeat([robot.mean_length, 1.0], 3)
        self.y_unit = self.energy / self.x_unit
        self.column = {int(index): column for column, index in enumerate([*shared, *passive])}
        first = len(self.column) + len(self.position) + len(leg.moments)
        self.joint = np.arange(len(self.column), first)  # multipliers of the tip
        parts = sum(step.trajectory is not None for step in steps)
        size = first + 2 * len(self.plane) * parts
        self.multipliers = len(self.joint) + len(self.plane) * parts
        self.matrix = np.zeros((size, size))
        self.x = np.zeros((6, size))  # of the place that is reached
        self.free = first
        for step in steps:
            (self._rigid if step.trajectory is None else self._part)(step)
        self._close(point, tip_of(leg, point.wrenches[number], whole), robot.platform_axes)

    def _rigid(self, step: ChainStep) -> None:
        """A joint, a link, or what is still in its feed."""
        transition, column, _, stiffness = self._natural(step)
        lead, by_x = transition[:6, :6], transition[6:, :6]
        self._add(self.x, lead.T @ by_x)
        self.x, before = lead @ self.x, self.x
        moved = self.column.get(-1 if step.index is None else step.index)
        if moved is not None:
            across = before.T @ (lead.T @ column[6:])
            self.matrix[:, moved] += across
            self.matrix[moved] += across
            self.matrix[moved, moved] += stiffness + column[:6] @ column[6:]
            self.x[:, moved] += column[:6]

    def _part(self, step: ChainStep) -> None:
        """A part of a rod: its end and the multiplier of its start are new variables."""
        transition, column, row, stiffness = self._natural(step)
        plane, count = self.plane, len(self.plane)
        places, wrenches = transition[plane], transition[6 + plane]
        a, b, c = places[:, plane], places[:, 6 + plane], wrenches[:, plane]
        turning = plane[plane >= 3]
        if np.linalg.norm(transition[np.ix_(turning, turning)] - np.eye(len(turning)), 2) > _NEAR:
            raise PartTooLong
        end = slice(self.free, self.free + count)
        start = slice(end.stop, end.stop + count)
        self.free = start.stop
        inverse = np.array(np.linalg.inv(a), float)
        self._symmetric(end, end, c @ inverse)
        self._symmetric(start, start, -inverse @ b)
        self._coupled(start, end, inverse)
        self.matrix[start] -= self.x[plane]
        self.matrix[:, start] -= self.x[plane].T
        moved = self.column.get(-1 if step.index is None else step.index)
        if moved is not None:
            e, f, r = column[plane], column[6 + plane], row[plane]
            at = slice(moved, moved + 1)
            self._coupled(end, at, (f - c @ inverse @ e)[:, None])
            self._coupled(start, at, (-inverse @ e)[:, None])
            self.matrix[moved, moved] += stiffness - r @ inverse @ e
        self.x = np.zeros_like(self.x)
        self.x[plane, np.arange(end.start, end.stop)] = 1.0

    def _natural(self, step: ChainStep) -> tuple[Floats, Floats, Floats, float]:
        """T, t, r and kappa of a step, in x and y and natural units."""
        to_y, from_y = _conjugate(step.after.moment), _from_conjugate(step.before.moment)
        scale = np.concatenate([self.x_unit, self.y_unit])
        transition = to_y @ step.transition @ from_y * scale / scale[:, None]
        if step.index is None:
            return transition, np.zeros(12), np.zeros(12), 0.0
        unit = self.unit[step.index]
        column = to_y @ step.column / scale * unit
        row = step.row @ from_y * scale * unit / self.energy
        return transition, column, row, step.stiffness * unit**2 / self.energy

    def _close(self, point: ChainPoint, tip: ChainState, platform_axes: Integers) -> None:
        """The tip joint and the platform, Omega and v of which come first among the variables."""
        platform = np.zeros_like(self.x)
        platform[(platform_axes + 3) % 6, np.arange(len(platform_axes))] = (
            1.0  # as x: v, then Omega
        )
        turn, turned = self.x[3:], platform[3:]
        forces, moments = np.split(self.joint, [len(self.position)])
        arm = point.rotation @ self.leg.tip / self.x_unit[0]
        gap = platform[:3] - skew(arm) @ turned - self.x[:3]
        joint = tip_joint(self.leg, point.values[self.leg.moments], point.rotation, tip.frame)
        held = np.vstack([gap[self.position], joint.axes @ (turn - turned)])
        self.matrix[np.concatenate([forces, moments])] += held
        self.matrix[:, np.concatenate([forces, moments])] += held.T
        self._add(turned, _second_of_arm(tip.force / self.y_unit[0], arm))
        self._add(turn, joint.by_tip / self.energy)
        self._add(turned, joint.by_tip / self.energy)
        across = turn.T @ (joint.by_platform / self.energy) @ turned
        self.matrix += across + across.T

    def _add(self, motion: Floats, matrix: Floats) -> None:
        """The form motion . matrix motion / 2."""
        self.matrix += motion.T @ (0.5 * (matrix + matrix.T)) @ motion

    def _symmetric(self, rows: slice, columns: slice, block: Floats) -> None:
        self.matrix[rows, columns] += 0.5 * (block + block.T)

    def _coupled(self, rows: slice, columns: slice, block: Floats) -> None:
        self.matrix[rows, columns] += block
        self.matrix[columns, rows] += block.T

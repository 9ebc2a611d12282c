# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors as a function of time: polynomials between points. No ROS here."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["MotorMotion", "MotorPath"]

Floats = NDArray[np.float64]


class MotorMotion(NamedTuple):
    """Where motors are at a time, and how they move.

    Attributes:
        positions: (n,) [rad or m].
        velocities: (n,) [rad/s or m/s].
        accelerations: (n,) [rad/s^2 or m/s^2].
    """

    positions: Floats
    velocities: Floats
    accelerations: Floats


@dataclass(frozen=True, eq=False)
class MotorPath:
    """Pieces of polynomials, one after the other. Before and behind them the motors rest.

    Attributes:
        breaks: Times at which pieces begin, and the end of the last one, (B + 1,) [s].
        pieces: Coefficients of the powers 0 to 5 of the time since a piece begins, (B, 6, n).
        last: Motors at the end, (n,) [rad or m].
    """

    breaks: Floats
    pieces: Floats
    last: Floats

    @classmethod
    def through(
        cls,
        times: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
    ) -> MotorPath:
        """Through points, by what is known there: straight, cubic or quintic in between.

        Args:
            times: Of the points, increasing, (P,) [s].
            positions: (P, n) [rad or m].
            velocities: (P, n) or None.
            accelerations: (P, n) or None; not without velocities.
        """
        times, q = np.asarray(times, float), np.asarray(positions, float)
        step, way = np.diff(times)[:, None], np.diff(q, axis=0)
        pieces = np.zeros((len(step), 6, q.shape[1]))
        pieces[:, 0] = q[:-1]
        if velocities is None:
            pieces[:, 1] = way / step
            return cls(times, pieces, q[-1])
        v = np.asarray(velocities, float)
        before, after, slope = v[:-1], v[1:], way / step
        pieces[:, 1] = before
        if accelerations is None:
            pieces[:, 2] = (3.0 * slope - 2.0 * before - after) / step
            pieces[:, 3] = (before + after - 2.0 * slope) / step**2
            return cls(times, pieces, q[-1])
        a = np.asarray(accelerations, float)
        first, second = a[:-1] * step, a[1:] * step
        pieces[:, 2] = 0.5 * a[:-1]
        pieces[:, 3] = (10.0 * slope - 6.0 * before - 4.0 * after - 1.5 * first + 0.5 * second) / (
            step**2
        )
        pieces[:, 4] = (-15.0 * slope + 8.0 * before + 7.0 * after + 1.5 * first - second) / step**3
        pieces[:, 5] = (6.0 * slope - 3.0 * (before + after) + 0.5 * (second - first)) / step**4
        return cls(times, pieces, q[-1])

    @classmethod
    def rest(cls, first: float, last: float, motors: Floats) -> MotorPath:
        """The motors at one place from a time to another."""
        pieces = np.zeros((1, 6, len(motors)))
        pieces[0, 0] = motors
        return cls(np.array([first, last]), pieces, np.array(motors, float))

    @property
    def begin(self) -> float:
        """When it begins [s]."""
        return float(self.breaks[0])

    @property
    def end(self) -> float:
        """When it ends [s]."""
        return float(self.breaks[-1])

    def at(self, time: float) -> MotorMotion:
        """The motors at a time [s]."""
        if time >= self.end:
            return _at_rest(self.last)
        if time < self.begin:
            return _at_rest(self.pieces[0, 0])
        number = int(np.searchsorted(self.breaks, time, side="right")) - 1
        return _evaluated(self.pieces[number], time - float(self.breaks[number]))

    def at_end(self) -> MotorMotion:
        """The motors as they arrive: not at rest yet."""
        arriving = _evaluated(self.pieces[-1], float(self.breaks[-1] - self.breaks[-2]))
        return arriving._replace(positions=self.last.copy())

    def positions(self, times: ArrayLike) -> Floats:
        """Motors at many times, (T, n)."""
        times = np.clip(np.asarray(times, float), self.begin, self.end)
        number = np.clip(np.searchsorted(self.breaks, times, "right") - 1, 0, len(self.pieces) - 1)
        since, c = (times - self.breaks[number])[:, None], self.pieces[number]
        found = np.zeros((len(times), self.pieces.shape[2]))
        for power in range(5, -1, -1):
            found = found * since + c[:, power]
        found[times >= self.end] = self.last
        return found

    def speed_bounds(self) -> Floats:
        """What no motor exceeds within a piece, and nears in a short one, (B, n) [rad/s or m/s].

        In a hundredth of the time that the largest speeds themselves take.
        """
        return np.abs(np.einsum("bk,pkn->pbn", _BERNSTEIN, self._rates(slice(None)))).max(axis=1)

    def _rates(self, which: NDArray[np.intp] | slice) -> Floats:
        """Velocities as polynomials of the part of a piece that has passed, (B, 5, n)."""
        step, powers = np.diff(self.breaks)[which, None, None], np.arange(1, 6)[:, None]
        rates: Floats = self.pieces[which, 1:] * powers * step ** (powers - 1)
        return rates

    def largest_speeds(self, which: NDArray[np.intp] | slice = slice(None)) -> Floats:
        """Largest speed of every motor within every piece, or some, (B, n) [rad/s or m/s]."""
        rates = self._rates(which)
        parts = np.concatenate(
            [np.zeros((len(rates), 1, rates.shape[2])), np.ones((len(rates), 1, rates.shape[2]))], 1
        )
        if np.any(rates[:, 1:]):
            parts = np.concatenate([parts, _turning_points(rates)], axis=1)
        speeds = np.zeros_like(parts)
        for power in range(4, -1, -1):
            speeds = speeds * parts + rates[:, None, power]
        return np.abs(speeds).max(axis=1)

    def part(self, first: float, last: float, begin: float) -> MotorPath:
        """What happens from a time to another one, moved so that it begins at a third.

        Where the path ends before, the motors rest at its end.
        """
        inner = self.breaks[(self.breaks > first) & (self.breaks < last)]
        breaks = np.concatenate([[first], inner, [last]])
        pieces = np.zeros((len(breaks) - 1, 6, len(self.last)))
        for number, time in enumerate(breaks[:-1]):
            pieces[number] = self._from(float(time))
        return MotorPath(breaks - first + begin, pieces, self.at(last).positions)

    def then(self, path: MotorPath) -> MotorPath:
        """This one and, from its end on, another one that begins there."""
        breaks = np.concatenate([self.breaks[:-1], path.breaks])
        return MotorPath(breaks, np.concatenate([self.pieces, path.pieces]), path.last)

    def _from(self, time: float) -> Floats:
        """Coefficients of a piece that begins within one of these, (6, n)."""
        found = np.zeros((6, len(self.last)))
        if not self.begin <= time < self.end:
            found[0] = self.at(time).positions
            return found
        number = int(np.searchsorted(self.breaks, time, side="right")) - 1
        since, c = time - self.breaks[number], self.pieces[number]
        for power, binomials in enumerate(_BINOMIALS):
            for other in range(power, 6):
                found[power] += binomials[other] * since ** (other - power) * c[other]
        return found


def _at_rest(motors: Floats) -> MotorMotion:
    return MotorMotion(motors.copy(), np.zeros_like(motors), np.zeros_like(motors))


def _evaluated(piece: Floats, since: float) -> MotorMotion:
    """The motors some time [s] after a piece, (6, n), begins."""
    powers = since ** np.arange(6.0)
    numbers = np.arange(6.0)
    return MotorMotion(
        powers @ piece,
        (numbers[1:] * powers[:-1]) @ piece[1:],
        (numbers[2:] * numbers[1:-1] * powers[:-2]) @ piece[2:],
    )


#: Binomial coefficients: row k, column n is n over k.
_BINOMIALS = tuple(tuple(float(math.comb(n, k)) for n in range(6)) for k in range(6))
#: From the coefficients of a polynomial of degree 4 to those in the Bernstein basis, which bound it
#: between 0 and 1: it stays between the smallest and the largest of them.
_BERNSTEIN = np.array([[math.comb(i, k) / math.comb(4, k) for k in range(5)] for i in range(5)])


def _turning_points(rates: Floats) -> Floats:
    """Where velocities turn within their pieces, as parts of them, (B, 3, n); 0 where they do not.

    Args:
        rates: Coefficients of the velocities, (B, 5, n).
    """
    bends = np.moveaxis(rates[:, 1:], 1, 2)
    size = np.abs(bends).max(axis=2, keepdims=True)
    # A cubic, (B, n, 4), of numbers that are as large as 4.
    slope = np.arange(1, 5) * np.divide(bends, size, out=np.zeros_like(bends), where=size > 0.0)
    found = np.zeros((*slope.shape[:2], 3))
    small = np.abs(slope) < 1e-12
    for degree in (3, 2, 1):
        which = np.logical_and.reduce(small[..., degree + 1 :], axis=-1) & ~small[..., degree]
        cubic = slope[which]
        companion = np.zeros((len(cubic), degree, degree))
        companion[:, range(1, degree), range(degree - 1)] = 1.0
        companion[:, :, -1] = -cubic[:, :degree] / cubic[:, degree, None]
        roots = np.linalg.eigvals(companion)
        # Two roots that meet may come out as a pair that is a little complex.
        found[which, :degree] = np.where(np.abs(roots.imag) < 1e-6, roots.real, 0.0)
    return np.clip(np.moveaxis(found, 2, 1), 0.0, 1.0)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers of a description from measurements: nonlinear least squares on equilibria.

The derivation is in docs/derivations.md, "Calibration"; docs/calibration.md shows the use.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy import linalg

from ..blas_threads import on_one_blas_thread
from ..description.changed_description import named_parameters
from ..description.parameters import checked_paths
from ..errors import DescriptionError, InvalidRequest
from ..model.equilibrium import Equilibrium
from ..model.residual_rates import parameter_scale
from ..model.robot import Robot, checked_robot
from ..solving.not_reached import NotReached
from ..solving.targets import ProblemName
from ..validation import checked_vector
from .calibration_result import CalibrationResult, CalibrationWarning
from .compared import ComparedRow, compared_row
from .doubts import check_measured, fit_doubts, measured_doubts
from .measured_equilibria import first_equilibria, followed
from .measurements import Measurement, StandardDeviations, checked_measurements
from .robust_loss import Loss, checked_loss, loss_width, variance_factor
from .undetermined import unseen_directions, unseen_in_words

__all__ = ["calibrate"]

Floats = NDArray[np.float64]

#: Change of the sum of squares, and of the parameters in natural units, at which nothing is left to do.
_SQUARES, _PARAMETERS = 1e-6, 1e-9
#: Coefficient of a direction above which a parameter is in it.
_IN = 1e-3
#: Residual of rows whose robot or equilibrium does not exist: a trial step is never taken there.
_REFUSED = 1e12
#: Change of the parameters, in natural units, over which derivatives are taken for constant:
#: standard deviations differ by less than a hundredth for it.
_SAME = 1e-2
#: Robots that are tried at most, by one loss.
_TRIED = 60
#: Times that what is not determined is looked for again: it may be other directions at the answer.
_ROUNDS = 3


@on_one_blas_thread
def calibrate(
    robot: Robot,
    measurements: Sequence[Measurement],
    parameters: str | Sequence[str],
    deviations: StandardDeviations,
    *,
    bounds: Mapping[str, Sequence[float]] | None = None,
    loss: Loss = "linear",
    start: Equilibrium | None = None,
    progress: Callable[[float], None] | None = None,
) -> CalibrationResult:
    """Parameters with which a robot does what was measured.

    The weighted sum of squares of all that was measured is made least, from the values of the
    description on. What the measurements do not tell stays as it is.

    Args:
        robot: The robot as it is described.
        measurements: What was measured.
        parameters: Paths of the numbers to find, see ``Robot.parameter_values``.
        deviations: Standard deviations of the measurements, in SI units.
        bounds: Lowest and highest value by path, for those that have any.
        loss: ``linear`` for least squares; ``soft_l1``, ``huber`` or ``cauchy`` where some measurements
            may be grossly wrong.
        start: Equilibrium of this robot whose branch is followed; default home.
        progress: Called with the fraction of what is to be done, roughly.

    Raises:
        InvalidRequest: Measurements that do not fit the robot, that have no equilibrium, that look like
            other units or another order of numbers, or that are fewer numbers than parameters.
        UnknownParameter: There is no such number.
        DescriptionError: No robot is near the described one in a number.

    Warns:
        CalibrationWarning: The answer can be used, but something looks like a mistake.
    """
    checked_robot(robot)
    paths = checked_paths(parameters)
    rows = checked_measurements(robot, measurements)
    loss = checked_loss(loss)
    values = robot.parameter_values(paths)
    limits = _checked_bounds(bounds, paths, values)
    check_measured(robot, rows)
    tell = progress if progress is not None else _silent
    before = first_equilibria(robot, rows, start, lambda done: tell(0.5 * done))
    check_measured(robot, rows, before)
    compared = tuple(
        compared_row(row, equilibrium, deviations)
        for row, equilibrium in zip(rows, before, strict=True)
    )
    numbers = sum(len(row.places) for row in compared)
    if numbers < len(paths):
        expected = f"expected at least as many measured numbers as parameters, {len(paths)}"
        raise InvalidRequest("measurements", f"{expected}, got {numbers}")
    scales = _scales(before[0], paths)
    problem = _Problem(robot, paths, values, scales, compared, before, tell)
    answer = _solution(problem, limits, loss)
    found = _result(problem, answer, loss, measured_doubts(compared, before))
    tell(1.0)
    for doubt in found.doubts:
        warnings.warn(doubt, CalibrationWarning, stacklevel=3)
    return found


def _silent(_: float) -> None:
    """Tell nobody."""


def _checked_bounds(
    bounds: Mapping[str, Sequence[float]] | None, paths: Sequence[str], values: Floats
) -> Floats:
    """Bounds of all parameters, (2, P).

    Raises:
        InvalidRequest: Of no parameter, not two numbers, or a value is not between them.
    """
    found = np.tile([[-np.inf], [np.inf]], len(paths))
    if bounds is not None and not isinstance(bounds, Mapping):
        raise InvalidRequest("bounds", f"expected two numbers by path, got {bounds!r:.80}")
    for path, both in (bounds or {}).items():
        if path not in paths:
            raise InvalidRequest("bounds", f"{path!r:.80} is none of the parameters to be found")
        low, high = checked_vector(f"bounds[{path!r}]", both, 2, "lowest and highest value")
        column = list(paths).index(path)
        if not low < values[column] < high:
            problem = (
                f"expected the described value {values[column]:g} between, got {low:g}, {high:g}"
            )
            raise InvalidRequest(f"bounds[{path!r}]", problem)
        found[:, column] = low, high
    return found


def _scales(equilibrium: Equilibrium, paths: Sequence[str]) -> Floats:
    """Changes of the parameters that mean about as much as a natural unit, (P,)."""
    parameters = named_parameters(equilibrium.robot.description, paths)
    each = [(parameter_scale(equilibrium, parameter), parameter.size) for parameter in parameters]
    return np.array([scale or size or 1.0 for scale, size in each])


@dataclass(eq=False)
class _Problem:
    """What is compared as a function of the parameters' changes in natural units; keeps the last one.

    Attributes:
        robot: As it is described.
        paths: Of the parameters, P.
        values: Of the parameters in the description, (P,).
        scales: Their natural units, (P,).
        rows: How rows are compared.
        before: Equilibria of the rows.
        tell: Called with the fraction of what is to be done, roughly.
        settled: Whether the last descent came to its end.
    """

    robot: Robot
    paths: tuple[str, ...]
    values: Floats
    scales: Floats
    rows: tuple[ComparedRow, ...]
    before: list[Equilibrium]
    tell: Callable[[float], None]

    def __post_init__(self) -> None:
        self._kept: list[tuple[Floats, list[Equilibrium]]] = [
            (np.zeros(len(self.paths)), self.before)
        ]
        self._problems: list[ProblemName] = [row.problem for row in self.rows]
        self._robots = 0
        self.settled = True
        self._rates: tuple[Floats, Floats] | None = None

    def values_at(self, change: Floats) -> Floats:
        """Values of the parameters, (P,)."""
        return self.values + self.scales * change

    def equilibria(self, change: Floats) -> list[Equilibrium]:
        """Equilibria of all rows.

        Raises:
            DescriptionError: There is no such robot.
            NotReached: A branch ends before.
        """
        for known, found in self._kept:
            if np.array_equal(known, change):
                return found
        _, nearest = min(self._kept, key=lambda kept: float(np.abs(kept[0] - change).max()))
        values = dict(zip(self.paths, self.values_at(change).tolist(), strict=True))
        robot = self.robot.with_parameters(values)
        found = followed(nearest, robot, self._problems)
        self._robots += 1
        self.tell(1.0 - 0.5 * 0.8**self._robots)
        self._kept = [self._kept[0], *self._kept[1:][-1:], (change.copy(), found)]
        return found

    def residual(self, change: Floats) -> Floats:
        """What is compared, in standard deviations, (M,); far off where there is no such robot."""
        try:
            pairs = zip(self.rows, self.equilibria(change), strict=True)
        except (DescriptionError, NotReached):
            return np.full(sum(len(row.places) for row in self.rows), _REFUSED)
        return np.concatenate([row.residual(equilibrium) for row, equilibrium in pairs])

    def rates(self, change: Floats) -> Floats:
        """Its derivatives by the changes, here or next to here, (M, P)."""
        if self._rates is None or np.abs(self._rates[0] - change).max() > _SAME:
            pairs = zip(self.rows, self.equilibria(change), strict=True)
            each = [row.rates(equilibrium, self.paths) for row, equilibrium in pairs]
            self._rates = change.copy(), np.vstack(each) * self.scales
        return self._rates[1]


def _solution(problem: _Problem, limits: Floats, loss: Loss) -> Floats:
    """Changes of the parameters with the least loss, (P,).

    Directions in which nothing changes are held by residuals of their own, which want them to stay;
    those are looked for again where they may have changed.
    """
    change = np.zeros(len(problem.paths))
    # Where all residuals are large a robust loss has nearly no curvature, or several minima.
    losses: dict[Loss, tuple[Loss, ...]] = {"linear": (), "cauchy": ("linear", "soft_l1")}
    for easier in losses.get(loss, ("linear",)):
        change = _descended(problem, change, limits, easier)
    return _descended(problem, change, limits, loss)


def _descended(problem: _Problem, change: Floats, limits: Floats, loss: Loss) -> Floats:
    """The same by one loss, from changes that are near."""
    bounds = (limits - problem.values) / problem.scales
    for _ in range(_ROUNDS):
        unseen = unseen_directions(problem.rates(change))
        hold = np.abs(problem.rates(change)).max() * unseen

        def residual(at: Floats, begin: Floats = change, hold: Floats = hold) -> Floats:
            return np.concatenate([problem.residual(at), hold @ (at - begin)])

        def rates(at: Floats, hold: Floats = hold) -> Floats:
            return np.vstack([problem.rates(at), hold])

        found = scipy.optimize.least_squares(
            residual,
            change,
            rates,
            bounds=bounds,
            loss=loss,
            f_scale=loss_width(loss),
            ftol=_SQUARES,
            xtol=_PARAMETERS,
            gtol=None,
            max_nfev=_TRIED,
        )
        change = np.asarray(found.x)
        problem.settled = found.status > 0
        if len(unseen_directions(problem.rates(change))) >= len(unseen):
            break
    return change


def _result(
    problem: _Problem, change: Floats, loss: Loss, doubts: tuple[str, ...]
) -> CalibrationResult:
    """What was found, and how exact it is."""
    residual, rates = problem.residual(change), problem.rates(change)
    unseen = unseen_directions(rates)
    count = len(problem.paths)
    seen = linalg.null_space(unseen) if len(unseen) else np.eye(count)
    known = rates @ seen
    covariance = np.zeros((count, count))
    if known.size:
        covariance = seen @ linalg.inv(known.T @ known) @ seen.T
    freedom = len(residual) - known.shape[1]
    covariance *= variance_factor(loss, residual, known.shape[1])
    covariance *= np.outer(problem.scales, problem.scales)
    for column in np.flatnonzero(np.abs(unseen).max(axis=0, initial=0.0) > _IN):
        covariance[column] = covariance[:, column] = 0.0
        covariance[column, column] = np.inf
    fit = 1.0
    if freedom > 0 and loss == "linear":
        fit = float(np.sqrt(residual @ residual / freedom))
    elif freedom > 0:
        fit = float(np.median(np.abs(residual)) / 0.6745 * np.sqrt(len(residual) / freedom))
    equilibria, values = problem.equilibria(change), problem.values_at(change)
    if not problem.settled:
        text = f"no least sum of squares is found with {_TRIED} robots: these are the last values"
        doubts = (*doubts, text)
    words = unseen_in_words(unseen, problem.scales, problem.paths, values)
    return CalibrationResult(
        equilibria[0].robot,
        problem.paths,
        problem.values,
        values,
        covariance,
        words,
        (*doubts, *fit_doubts(fit, freedom)),
        fit,
        problem.rows,
        tuple(problem.before),
        tuple(equilibria),
    )

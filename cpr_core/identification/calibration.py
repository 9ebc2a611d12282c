# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers of a description from measurements: nonlinear least squares on equilibria.

The derivation is in docs/derivations.md, "Calibration"; docs/calibration.md shows the use.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..blas_threads import on_one_blas_thread
from ..description.parameters import checked_paths
from ..errors import DescriptionWarning, InvalidRequest, distinct
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot, checked_robot
from ..validation import checked_vector
from .calibration_result import CalibrationResult, CalibrationWarning
from .compared import compared_row
from .limit_doubts import limit_doubts
from .measured_equilibria import first_equilibria, followed
from .measurement_doubts import check_measured, frame_doubts
from .measurements import (
    Measurement,
    StandardDeviations,
    checked_deviations,
    checked_measurements,
    driven_by,
)
from .number_doubts import (
    border_doubts,
    bound_doubts,
    hardly_told,
    many_times_larger,
    strayed,
)
from .parameter_problem import TRIED, ParameterProblem, natural_changes, solution
from .repeated_rows import repeated_doubts
from .residual_doubts import fit_doubts, kind_doubts
from .robust_loss import Loss, checked_loss, variance_factor
from .stuck_sensors import stuck_doubts
from .tracker_alignment import aligned_tracker
from .tracker_rates import of_tracker
from .tried_robot import free_robot
from .undetermined import knowledge, unseen_in_words

__all__ = ["calibrate"]

Floats = NDArray[np.float64]


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
    description on. What the measurements do not tell stays as it is. Numbers of the tracker
    begin where they fit the robot as it is described.

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
        InvalidRequest: A start of another robot; measurements that do not fit the robot, that have no
            equilibrium, that look like other units or another order of numbers, that are far out of the
            plane of a planar robot, or that are fewer numbers than parameters.
        InvalidRequest: A parameter that cannot be changed alone, such as a tangent with a normal.
        UnknownParameter: There is no such number.
        DescriptionError: No robot is near the described one in a number.

    Warns:
        CalibrationWarning: The answer can be used, but something looks like a mistake.
    """
    # Long, for half of it is what the parameters mean.
    checked_robot(robot)
    paths = checked_paths(parameters)
    rows, deviations = checked_measurements(robot, measurements), checked_deviations(deviations)
    loss = checked_loss(loss)
    values = robot.parameter_values(paths)
    limits = _checked_bounds(bounds, paths, values)
    tell = progress if progress is not None else lambda _: None
    before = first_equilibria(robot, rows, start, lambda done: tell(0.5 * done))
    aligned, begin = aligned_tracker(rows, before, paths, deviations, limits), values
    outside = np.any((values <= limits[0]) | (values >= limits[1]))
    if aligned or outside:
        pairs = zip(paths, values.tolist(), strict=True)
        begin = np.clip([aligned.get(path, value) for path, value in pairs], *limits)
        beginning = dict(zip(paths, begin.tolist(), strict=True))
        robot = robot.with_parameters(beginning)
        problems = [driven_by(robot, row).problem for row in rows]
        before = followed(before, free_robot(robot), problems)
    check_measured(rows, before, deviations)
    compared = tuple(
        compared_row(row, equilibrium, deviations)
        for row, equilibrium in zip(rows, before, strict=True)
    )
    numbers = sum(len(row.places) for row in compared)
    if numbers < len(paths):
        expected = f"expected at least as many measured numbers as parameters, {len(paths)}"
        raise InvalidRequest("measurements", f"{expected}, got {numbers}")
    problem = ParameterProblem(
        robot=robot,
        paths=paths,
        values=begin,
        scales=natural_changes(before[0], paths),
        rows=compared,
        deviations=deviations,
        before=before,
        tell=tell,
    )
    answer = solution(problem, limits, loss)
    doubts = [
        *frame_doubts(rows, paths),
        *stuck_doubts(compared, before, problem.equilibria(answer)),
        *repeated_doubts(compared),
    ]
    found = _result(problem, answer, limits, loss, doubts)
    found = replace(found, start=values)  # of a tracker it was begun elsewhere
    tell(1.0)
    for doubt in found.doubts:
        warnings.warn(doubt, CalibrationWarning, stacklevel=3)
    return found


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
        if of_tracker(path) and low < high:  # what is described of it is not begun with
            found[:, column] = low, high
            continue
        if not low <= values[column] <= high or low == high:
            value, *ends = distinct(float(values[column]), low, high, fewest=6)
            problem = f"expected the described value {value} between, got {ends[0]}, {ends[1]}"
            raise InvalidRequest(f"bounds[{path!r}]", problem)
        found[:, column] = low, high
    return found


def _result(
    problem: ParameterProblem,
    change: Floats,
    limits: Floats,
    loss: Loss,
    doubts: list[str],
) -> CalibrationResult:
    """What was found, and how exact it is."""
    residual, left = problem.residual(change), problem.squares(change)
    known = knowledge(problem.rates(change), problem.sizes)
    determined = len(problem.paths) - len(known.unseen)
    freedom = len(residual) - determined
    natural = known.covariance(variance_factor(loss, residual, determined))
    hidden = np.isinf(np.diag(natural))
    covariance = natural * np.outer(problem.scales, problem.scales)
    fit = 1.0
    if freedom > 0 and loss == "linear":
        fit = float(np.sqrt(residual @ residual / freedom))
    elif freedom > 0:
        fit = float(np.median(np.abs(residual)) / 0.6745 * np.sqrt(len(residual) / freedom))
    values = problem.values_at(change)
    robot, looks_wrong = _as_described(problem, values)
    equilibria = [replace(each, robot=robot) for each in problem.equilibria(change)]
    if not problem.settled:
        text = f"no least sum of squares is found with {TRIED} robots: these are the last values"
        doubts = [*doubts, text]
    if not problem.weighed:
        text = "the noise of what drives rows is so large that no estimate of it settles"
        doubts = [*doubts, f"{text}: values and standard deviations are rough"]
    deviations = np.sqrt(np.diag(covariance))
    start = np.abs(problem.values)
    described = [row.as_measured() for row in problem.rows]
    sizes = np.where(start > 0.0, start, problem.scales)
    doubts = [
        *doubts,
        *bound_doubts(problem.paths, values, deviations, limits),
        *hardly_told(robot, problem.paths, values, deviations, problem.scales, sizes),
        *(many_times_larger(problem, change, deviations, limits) if loss == "linear" else ()),
        *strayed(problem, change, known.unseen),
        *border_doubts(robot, problem.paths, values, deviations, start),
        *looks_wrong,
        *limit_doubts(problem.rows, equilibria),
        *kind_doubts(problem.rows, equilibria, determined),
        *fit_doubts(
            described,
            problem.before,
            fit,
            freedom,
            problem.refused,
            robust=loss != "linear",
            left=left,
        ),
    ]
    return CalibrationResult(
        robot=robot,
        parameters=problem.paths,
        start=problem.values,
        values=values,
        covariance=covariance,
        undetermined=unseen_in_words(known.unseen, hidden, problem.scales, problem.paths, values),
        doubts=tuple(doubts),
        fit=fit,
        rows=problem.rows,
        before=tuple(replace(each, robot=problem.robot) for each in problem.before),
        after=tuple(equilibria),
    )


def _as_described(problem: ParameterProblem, values: Floats) -> tuple[Robot, list[str]]:
    """The robot with values found, its limits as described, and what looks wrong with it only now."""
    _, known = _warned(problem, problem.values)
    robot, told = _warned(problem, values)
    before = {_about(text) for text in known}
    return robot, [text for text in told if _about(text) not in before]


def _warned(problem: ParameterProblem, values: Floats) -> tuple[Robot, list[str]]:
    """The robot with some values, and what its description is warned of."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", DescriptionWarning)
        robot = problem.robot.with_parameters(
            dict(zip(problem.paths, values.tolist(), strict=True))
        )
    return robot, [str(warning.message) for warning in told]


def _about(warning: str) -> tuple[str, ...]:
    """Which part of which description it is about: numbers in it follow the parameters."""
    return tuple(warning.split(": ")[:2])

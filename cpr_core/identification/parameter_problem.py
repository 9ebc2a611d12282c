# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The least sum of squares over robots with other parameters, each with its equilibria."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..description.changed_description import named_parameters
from ..description.description_paths import Place
from ..errors import DescriptionError, InvalidRequest
from ..kernels.problems import ProblemName
from ..model.equilibrium import Equilibrium
from ..model.residual_rates import parameter_scales
from ..model.robot import Robot
from ..solving.not_reached import NotReached
from .compared import ComparedRow
from .drive_noise import weighed_at
from .measured_equilibria import followed
from .measurements import StandardDeviations
from .mixed_steps import MixedSteps
from .robust_loss import Loss, loss_width
from .tracker_rates import tracker_unit
from .tried_robot import tried_robot
from .undetermined import parameter_sizes, unseen_directions

__all__ = ["TRIED", "ParameterProblem", "natural_changes", "solution"]

Floats = NDArray[np.float64]

#: Change of the sum of squares, and of the parameters in natural units, at which nothing is left to do.
_SQUARES, _PARAMETERS = 1e-6, 1e-9
#: How far from the least sum of squares is next to it, in standard deviations; of measurements that fit
#: better than a tenth of theirs the less. Nearer, rounding hides whether the squares fall.
_DEVIATIONS, _FITS = 1e-3, 0.1
#: Slope of the sum of squares below which scipy looks at none, in standard deviations.
_ROUNDING = float(np.finfo(float).eps)
#: Residuals, in standard deviations, from which robust losses find their least without squares before.
_NEAR = 30.0
#: Residual of rows whose robot or equilibrium does not exist: a trial step is never taken there.
_REFUSED = 1e12
#: How far derivatives are taken for constant on the way: in natural units of the parameters, which may
#: be several times their values, and in standard deviations of all that is compared. The answer moves by
#: less than a hundredth of its standard deviation for it.
_SAME = 1e-2
#: Change of a parameter, in natural units, that some robot has to allow.
_ALONE = 1e-3
#: Robots that are tried at most, by one loss.
TRIED = 60
#: Times that rows are weighed at the answer: the robot may be far from the one that was described, and
#: what drives a row far from what was measured of it.
_WEIGHINGS = 20
#: Steps from one weighing to the next that say where the next one leads.
_MEMORY = 3
#: Times that a descent is begun again: what is not determined may be other directions at the answer, and
#: measurements may turn out to be more exact than they are said to be.
_ROUNDS = 3
#: Part of the way to the other bound that a descent begins off a bound, at most.
_INSIDE = 1e-2


def natural_changes(equilibrium: Equilibrium, paths: Sequence[str]) -> Floats:
    """Changes of parameters that mean about as much as a natural unit, (P,); none is zero.

    Raises:
        UnknownParameter: There is no such number.
        InvalidRequest: What is there cannot be changed, or two paths name the same number.
    """
    robot = equilibrium.robot
    parameters = named_parameters(robot.description, paths)
    owners: dict[Place, str] = {}
    for parameter in parameters:
        for place in parameter.places:
            other = owners.setdefault(place, parameter.path)
            if other != parameter.path:
                problem = f"{other} and {parameter.path} name the same number"
                raise InvalidRequest("parameters", problem)
    scales = parameter_scales(equilibrium, parameters).tolist()
    pairs = zip(scales, parameters, strict=True)
    return np.array(
        [
            tracker_unit(parameter.path, robot.mean_length) or scale or parameter.size or 1.0
            for scale, parameter in pairs
        ]
    )


@dataclass(eq=False)
class ParameterProblem:
    """What is compared as a function of the parameters' changes in natural units; keeps the last one.

    Attributes:
        robot: As it is described.
        paths: Of the parameters, P.
        values: Of the parameters in the description, (P,).
        scales: Their natural units, (P,).
        rows: How rows are compared.
        deviations: Of the measurements.
        before: Equilibria of the rows.
        tell: Called with the fraction of what is to be done, roughly.
        settled: Whether the last descent came to its end.
        weighed: Whether the rows are weighed as they are at the answer, with what their drives were.
        refused: Why there was no robot where the descents went, if so.
    """

    robot: Robot
    paths: tuple[str, ...]
    values: Floats
    scales: Floats
    rows: tuple[ComparedRow, ...]
    deviations: StandardDeviations
    before: list[Equilibrium]
    tell: Callable[[float], None]

    def __post_init__(self) -> None:
        self._kept: list[tuple[Floats, list[Equilibrium]]] = [
            (np.zeros(len(self.paths)), self.before)
        ]
        self._problems: list[ProblemName] = [row.problem for row in self.rows]
        self._robots = 0
        self._each_alone = False  # as far as is known
        self.settled, self.weighed, self.refused = True, True, ""
        self._rates: tuple[Floats, Floats] | None = None

    @property
    def sizes(self) -> Floats:
        """How far the parameters may be from what is described, in natural units, (P,)."""
        return parameter_sizes(self.values, self.scales)

    def values_at(self, change: Floats) -> Floats:
        """Values of the parameters, (P,)."""
        found = self.values + self.scales * change
        # Derivatives of numbers are taken over a part of what they are: next to zero that is rounding.
        found[(np.abs(found) < _PARAMETERS * self.scales) & (change != 0.0)] = 0.0
        return found

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
        found = followed(nearest, tried_robot(self.robot, values), self._problems)
        self._robots += 1
        self.tell(1.0 - 0.5 * 0.8**self._robots)
        self._kept = [self._kept[0], *self._kept[1:][-1:], (change.copy(), found)]
        return found

    def residual(self, change: Floats) -> Floats:
        """What is compared, in standard deviations, (M,); far off where there is no such robot."""
        try:
            pairs = zip(self.rows, self.equilibria(change), strict=True)
        except (DescriptionError, NotReached) as error:
            if isinstance(error, DescriptionError):
                self.refused = f"{error.field}: {error.problem}"
                if not self._each_alone:
                    self._check_alone()
            return np.full(sum(len(row.places) for row in self.rows), _REFUSED)
        return np.concatenate([row.residual(equilibrium) for row, equilibrium in pairs])

    def squares(self, change: Floats) -> list[float]:
        """The squares that are left of every row.

        Raises:
            DescriptionError: There is no such robot.
            NotReached: A branch ends before.
        """
        pairs = zip(self.rows, self.equilibria(change), strict=True)
        return [float(np.sum(row.residual(equilibrium) ** 2)) for row, equilibrium in pairs]

    def _check_alone(self) -> None:
        """Whether every parameter can be changed without the others: asked when a robot is refused.

        Raises:
            InvalidRequest: One cannot, such as a direction that another one has to be across.
        """
        for path, value, scale in zip(self.paths, self.values, self.scales, strict=True):
            refused = ""
            for change in (-_ALONE * scale, _ALONE * scale):
                try:
                    tried_robot(self.robot, {path: value + change})
                    break
                except DescriptionError as error:
                    refused = str(error)
            else:
                raise InvalidRequest("parameters", f"{path} cannot be changed alone: {refused}")
        self._each_alone = True

    def rates(self, change: Floats, *, near: bool = False) -> Floats:
        """Its derivatives by the changes, (M, P).

        Args:
            change: Where.
            near: They may be those of a place so near that they are nearly the same.
        """
        if self._rates is not None:
            place, known = self._rates
            apart = change - place
            far = max(np.abs(apart).max(), np.linalg.norm(known @ apart))
            if far <= (_SAME if near else 0.0):
                return known
        pairs = zip(self.rows, self.equilibria(change), strict=True)
        each = [row.rates(equilibrium, self.paths) for row, equilibrium in pairs]
        found: Floats = np.vstack(each) * self.scales
        self._rates = change.copy(), found
        return found

    def weigh(self, change: Floats, loss: Loss) -> bool:
        """Weigh the rows with what the noise of their drives does to that robot, and with what it was.

        Returns:
            Whether that is nothing new.
        """
        pairs = zip(self.rows, self.equilibria(change), strict=True)
        weighed = [weighed_at(row, at, self.deviations, loss) for row, at in pairs]
        if all(same for _, _, same in weighed):
            return True
        self.rows = tuple(row for row, _, _ in weighed)
        self._kept, self._rates = [(change.copy(), [at for _, at, _ in weighed])], None
        return False

    def unseen(self, change: Floats) -> Floats:
        """Directions in which nothing that is compared changes there, orthonormal rows (K, P)."""
        return unseen_directions(self.rates(change), self.sizes)


def solution(problem: ParameterProblem, limits: Floats, loss: Loss) -> Floats:
    """Changes of the parameters with the least loss, (P,).

    Directions in which nothing changes are held by residuals of their own, which want them to stay;
    those are looked for again where they may have changed.
    """
    change = np.zeros(len(problem.paths))
    # Where all residuals are large a robust loss has nearly no curvature, or several minima.
    losses: dict[Loss, tuple[Loss, ...]] = {"linear": (), "cauchy": ("linear", "soft_l1")}
    for easier in losses.get(loss, ("linear",)):
        if easier == "linear" and np.median(np.abs(problem.residual(change))) < _NEAR:
            continue  # squares would lead away from there, if some rows are grossly wrong
        change = _descended(problem, change, limits, easier)
    bounds, steps = (limits - problem.values) / problem.scales, MixedSteps(_MEMORY)
    for _ in range(_WEIGHINGS):
        found = _descended(problem, change, limits, loss)
        if not problem.settled:
            return found
        # Answers may go to and fro between weights: by steps mixed with those before they do not.
        step = steps.mixed(change, found - change, found - change)
        try:
            change = np.clip(change + step, *bounds)
            same = problem.weigh(change, loss)
        except (DescriptionError, NotReached):  # there is no such robot: of this one there is
            change = found
            same = problem.weigh(change, loss)
        if same:
            return found
    problem.weighed = False
    return found


def _released(
    begin: Floats,
    bounds: Floats,
    residual: Callable[[Floats], Floats],
    rates: Callable[[Floats], Floats],
) -> Floats:
    """Unknowns to begin with, (P,): off bounds that the squares fall from, by a deviation at most.

    The first steps of the method that is used are as small as its beginning is near to a bound.
    """
    low, high = bounds
    at_low, at_high = begin <= low, begin >= high
    if not np.any(at_low | at_high):
        return begin
    slope, inside = residual(begin) @ rates(begin), np.minimum(1.0, _INSIDE * (high - low))
    begin = np.where(at_low & (slope < 0.0), low + inside, begin)
    return np.where(at_high & (slope > 0.0), high - inside, begin)


def _descended(problem: ParameterProblem, change: Floats, limits: Floats, loss: Loss) -> Floats:
    """The same by one loss, from changes that are near."""
    bounds, near = (limits - problem.values) / problem.scales, _DEVIATIONS
    for _ in range(_ROUNDS):
        unseen = problem.unseen(change)
        if len(unseen) == len(change):  # nothing says where to go
            problem.settled = True
            break
        hold = np.abs(problem.rates(change)).max() * unseen
        # Unknowns are counted in the deviations they have where the others are known.
        deviation = 1.0 / np.linalg.norm(np.vstack([problem.rates(change), hold]), axis=0)

        def residual(
            at: Floats, begin: Floats = change, hold: Floats = hold, unit: Floats = deviation
        ) -> Floats:
            return np.concatenate([problem.residual(unit * at), hold @ (unit * at - begin)])

        def rates(
            at: Floats, hold: Floats = hold, unit: Floats = deviation, unseen: Floats = unseen
        ) -> Floats:
            seen = problem.rates(unit * at, near=True)
            # What little they are along the directions is not to be followed, however weak the rest.
            return np.vstack([seen - seen @ unseen.T @ unseen, hold]) * unit

        found = scipy.optimize.least_squares(
            residual,
            _released(change / deviation, bounds / deviation, residual, rates),
            rates,
            bounds=bounds / deviation,
            x_scale=1.0 / deviation,
            loss=loss,
            f_scale=loss_width(loss),
            ftol=_SQUARES,
            xtol=_PARAMETERS,
            gtol=near,
            max_nfev=TRIED,
        )
        moved = deviation * found.x - change
        # Nor is what rounding has made of the rest along them.
        change = np.clip(change + moved - unseen.T @ (unseen @ moved), *bounds)
        problem.settled = found.status > 0
        same = len(problem.unseen(change)) >= len(unseen)
        fit = float(np.sqrt(2.0 * found.cost / len(found.fun)))
        before, near = near, max(_ROUNDING, _DEVIATIONS * min(1.0, fit / _FITS))
        if same and near > 0.5 * before:
            break
    return change

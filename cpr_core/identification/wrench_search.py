# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Newton's method for a wrench on the platform that explains what is measured.

The derivation is in docs/derivations.md, "Felt wrenches".
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..kernels.kernel_arrays import LoadArrays
from ..kernels.natural_units import EFFORT_UNIT, LONGEST_STEP
from ..model.equilibrium import Equilibrium
from ..model.platform_coordinates import six_components
from ..model.world_response import world_response, wrench_units
from ..solving.deadline import Deadline
from ..solving.geometrico_statics import solve_forward
from ..solving.not_reached import NoForwardSolution, NotReached, TimeLimitExceeded
from .effort_doubts import BETTER
from .felt_directions import FeltDirections, felt_directions
from .mixed_steps import MixedSteps
from .pushed_equilibrium import pushed_equilibrium
from .wrench_estimate import WrenchEstimate, consistency_of
from .wrench_measurements import WrenchMeasurements

__all__ = ["WrenchSearch"]

Floats = NDArray[np.float64]

#: A step this small in natural units is the last: its own error is of the order of its square.
_LAST_STEP = 2e-5
#: Longest step, in natural units.
_LONGEST = LONGEST_STEP * EFFORT_UNIT
#: Steps of Newton's method, and halvings of one, before it is given up.
_STEPS, _HALVINGS = 50, 10
#: Why it is given up: near the border of stability, where steps become ever shorter, or beside it.
_BORDER = "no stable equilibrium goes on from one"
_ENDLESS = "the steps of Newton's method did not end, the last is"
_LATE = "the time allowed was over"
#: How the way along what is not felt is gone, one after the other where one leads nowhere: what part of
#: it is taken, and whether steps are mixed.
_WAYS = ((1.0, False), (1.0, True), (0.3, True))
#: Steps that are not mixed and have not become shorter for so long go around the end.
_AROUND = 16
#: Measurements that are less likely by noise alone contradict each other: another sign is looked for.
_CHANCE = 1e-3


@dataclass(frozen=True, eq=False)
class _End:
    """Where Newton's method has ended.

    Attributes:
        found: Where the robot is.
        felt: What is felt there.
        wrench: What pushes on it, in natural units.
        residual: What is left of the measurements before the last step.
        hindrance: Why it did not go on, in words; empty: it has found the wrench.
    """

    found: Equilibrium
    felt: FeltDirections
    wrench: Floats
    residual: Floats
    hindrance: str = ""


class WrenchSearch:
    """Newton's method for one wrench."""

    def __init__(
        self,
        place: Equilibrium,
        measured: WrenchMeasurements,
        loads: Loads,
        load_arrays: LoadArrays,
        deadline: Deadline,
    ) -> None:
        """Nothing is found yet; the loads are what acts beside the wrench."""
        self.robot, self.measured = place.robot, measured
        self.loads, self.load_arrays = loads, load_arrays
        self.units, self.deadline = wrench_units(self.robot), deadline

    def from_afar(self, start: Equilibrium) -> WrenchEstimate:
        """From the measured motors without a wrench."""
        free = pushed_equilibrium(start, self.measured.motors, self.loads, self.load_arrays, None)
        if free is None:
            free = solve_forward(
                self.robot,
                self.measured.motors,
                start=start,
                loads=self.loads,
                time_limit=self.deadline.left,
            )
        return self._newton(free, np.zeros(len(self.units)), self.measured.residual(free), free)

    def from_last(self, last: WrenchEstimate) -> WrenchEstimate:
        """From the last estimate: a step along what it told of, to the motors of now; and another.

        What is felt has hardly changed: it is looked at again only where these have led to.
        """
        felt, measured = last.directions, self.measured
        # It is doubted what units they are, or the motors have come far since; or other efforts before.
        if measured.doubt(last.unloaded) != last.doubt:
            return self.from_afar(last.equilibrium)
        wrench = last.wrench_world[self.robot.platform_axes] / self.units
        residual = measured.residual(last.equilibrium) - measured.by_way(felt.response)
        ahead = felt.step(wrench, residual)
        reached = self._reached(last.equilibrium, ahead)
        if reached is None:
            return self.from_afar(last.equilibrium)
        residual = measured.residual(reached)
        again = felt.step(ahead, residual)
        if _size(again - ahead) > _LAST_STEP:
            nearer = self._reached(reached, again)
            if nearer is not None:
                reached, ahead, residual = nearer, again, measured.residual(nearer)
        return self._newton(reached, ahead, residual, last.unloaded)

    def _newton(
        self, start: Equilibrium, wrench: Floats, residual: Floats, unloaded: Equilibrium
    ) -> WrenchEstimate:
        """Newton's method from an equilibrium under a wrench in natural units.

        Args:
            start: Where to start.
            wrench: Under which it is, in natural units.
            residual: What it leaves of the measurements.
            unloaded: Without a wrench, at these motors or near: what units are doubted from.
        """
        for part, mixes in _WAYS:
            end = self._end(start, wrench, residual, part, mixes)
            if end.hindrance in ("", _LATE) or end.felt.count == len(wrench):
                break
        if end.hindrance:
            raise self._lost(end, self.measured.doubt(unloaded) or self._other_efforts(unloaded))
        return self._estimate(end, unloaded)

    def _end(
        self, found: Equilibrium, wrench: Floats, residual: Floats, part: float, mixes: bool
    ) -> _End:
        """Where Newton's method ends, which takes a part of the way along what is not felt.

        What is felt turns with the wrench: steps go around the end where it turns by more than they
        take back. Mixed with those before they end there too, or where the wrench is not the least.
        """
        felt = felt_directions(self.measured, world_response(found))
        mixed, hindrance = MixedSteps(len(wrench) - felt.count), ""
        shortest, since = np.inf, 0
        for number in range(_STEPS):
            if number:
                felt = felt_directions(self.measured, world_response(found), felt.count)
            step = felt.step(wrench, residual) - wrench
            if _size(step) <= _LAST_STEP:
                return _End(found, felt, wrench + step, residual)
            if _size(step) < shortest:
                shortest, since = _size(step), number
            if felt.count < len(wrench) and not mixes and number - since >= _AROUND:
                break
            if felt.count < len(wrench) and mixes:
                taken = step - (1.0 - part) * (step - felt.gain @ residual)
                step = mixed.mixed(wrench, step, taken)
            fraction, hindrance = min(1.0, _LONGEST / max(_LAST_STEP, _size(step))), _ENDLESS
            for _ in range(_HALVINGS):
                ahead = wrench + fraction * step
                reached = self._reached(found, ahead)
                if self.deadline.over:
                    return _End(found, felt, wrench, residual, _LATE)
                if reached is not None:
                    left = self.measured.residual(reached)
                    # What is not felt may be taken back at the cost of some of the residual.
                    if felt.count < len(ahead) or left @ left <= (1.0 + 1e-6) * residual @ residual:
                        break  # a border that was in the way of the whole step is the hindrance still
                    reached = None
                else:
                    hindrance = _BORDER
                fraction *= 0.5
            if reached is None:
                break
            found, wrench, residual = reached, ahead, left
        return _End(found, felt, wrench, residual, hindrance)

    def _reached(self, start: Equilibrium, wrench: Floats) -> Equilibrium | None:
        """The equilibrium under a wrench in natural units, at the measured motors; None: not near by."""
        return pushed_equilibrium(
            start, self.measured.motors, self.loads, self.load_arrays, self._world(wrench)
        )

    def _world(self, wrench: Floats) -> Floats:
        """A wrench in natural units as a world wrench, (6,) [N m, N]."""
        return six_components(self.robot.platform_axes, wrench * self.units)

    def _estimate(self, end: _End, unloaded: Equilibrium) -> WrenchEstimate:
        """What was found; the last step counts to first order."""
        felt = end.felt
        free, left = self.measured.weights.count - felt.count, felt.left_over(end.residual)
        squares = float(left @ left) if free > 0 else 0.0
        doubt = self.measured.doubt(unloaded)
        if not doubt and consistency_of(squares, free) < _CHANCE:
            doubt = self._other_efforts(unloaded, squares)
        return WrenchEstimate(
            wrench_world=self._world(end.wrench),
            observability=felt.observability,
            equilibrium=end.found,
            chi_square=squares,
            degrees_of_freedom=max(0, free),
            doubt=doubt,
            loads=self.loads,
            directions=felt,
            unloaded=unloaded,
        )

    def _other_efforts(self, unloaded: Equilibrium, squares: float = math.inf) -> str:
        """What efforts that no wrench explains look like, in words; empty: nothing else.

        Args:
            unloaded: Without a wrench, at these motors or near.
            squares: What a wrench leaves of the measurements as they are; infinite: none was found.
        """
        free: Equilibrium | None = unloaded
        if not np.array_equal(unloaded.motors, self.measured.motors):
            free = pushed_equilibrium(
                unloaded, self.measured.motors, self.loads, self.load_arrays, None
            )
        if free is None:
            return ""
        for other, doubt in self.measured.other_efforts(free):
            felt = felt_directions(other, world_response(free))
            left = felt.left_over(other.residual(free))
            if left @ left < BETTER**2 * squares:
                return doubt
        return ""

    def _lost(self, end: _End, doubt: str) -> NotReached:
        """The error where no wrench was found."""
        more = f"; {doubt}" if doubt else ""
        if end.hindrance == _LATE:
            return TimeLimitExceeded(f"wrench: {_LATE}{more}", 0.0, end.found)
        numbers = ", ".join(f"{value:.3g}" for value in self._world(end.wrench))
        text = (
            f"no wrench was found near the start that explains the measurements: {end.hindrance} "
            f"under mx my mz fx fy fz = ({numbers}) N m, N"
        )
        return NoForwardSolution(f"{text}{more}", 0.0, end.found)


def _size(step: Floats) -> float:
    """Largest component; of so few numbers quicker this way."""
    return max(map(abs, step.tolist()), default=0.0)

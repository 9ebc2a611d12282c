# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What pushes on the platform, from motor efforts, the platform's pose or both.

The derivation is in docs/derivations.md, "Felt wrenches"; docs/wrench.md shows the use.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..description.loads import Loads
from ..kernels.kernel_arrays import LoadArrays
from ..kernels.natural_units import EFFORT_UNIT, LONGEST_STEP
from ..lie import turned
from ..model.equilibrium import Equilibrium
from ..model.platform_coordinates import six_components
from ..model.robot import Robot, checked_robot
from ..model.world_response import world_response, wrench_units
from ..solving.deadline import Deadline
from ..solving.geometrico_statics import checked_start, solve_forward
from ..solving.not_reached import NoForwardSolution, NotReached, TimeLimitExceeded
from ..validation import ReadOnlyArrays, cached_property
from .effort_doubts import BETTER
from .felt_directions import FeltDirections, felt_directions
from .mixed_steps import MixedSteps
from .pushed_equilibrium import pushed_equilibrium
from .wrench_measurements import WrenchMeasurements, wrench_measurements

__all__ = ["WrenchEstimate", "estimate_wrench"]

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


@dataclass(frozen=True, eq=False, repr=False)
class WrenchEstimate(ReadOnlyArrays):
    """A wrench on the platform, and how well it is known; b platform coordinates, f of them felt.

    Attributes:
        wrench_world: Moment, then force on the platform at its origin, in world axes, beyond ``loads``;
            of those that explain the measurements equally well the smallest near by, (6,) [N m, N].
        observability: What the measurements tell of the direction that is felt least over what they tell
            of that felt best, in natural units: 1 all alike, 0 where a direction is not felt.
        equilibrium: Where the robot is, at the measured motors under the loads and the wrench.
        chi_square: Sum of the squares of what is left of the measurements, in standard deviations.
        degrees_of_freedom: Measured numbers beyond those the wrench needs: what ``chi_square`` is to be.
        doubt: What looks like another unit in the efforts or, where the measurements contradict each
            other, like the other sign or those behind a gear, in words; empty: nothing.
        loads: What acts beside the wrench.
        directions: What is felt, and what is not.
    """

    wrench_world: Floats
    observability: float
    equilibrium: Equilibrium
    chi_square: float
    degrees_of_freedom: int
    doubt: str
    loads: Loads
    directions: FeltDirections = field(repr=False)
    _load_arrays: LoadArrays = field(repr=False)
    _unloaded: Equilibrium = field(repr=False)

    def __repr__(self) -> str:
        wrench = np.array2string(self.wrench_world, precision=4)
        return f"<WrenchEstimate: {wrench} N m, N in the world; {self.words}>"

    @property
    def covariance(self) -> Floats:
        """Covariance of the wrench in the world, (6, 6) [N^2 m^2, N^2 m, N^2].

        A direction that is not felt has a standard deviation of 1000 natural units (moments E J / l,
        forces E J / l^2) instead of an infinite one, and so have those out of a planar robot's plane.
        """
        return self.directions.covariance

    @property
    def felt(self) -> Floats:
        """Wrenches in the world that are felt, the best first, as rows, (f, 6) [N m, N].

        Their size is 1 N, where moments count over the mean rod length.
        """
        return self.directions.felt

    @property
    def unfelt(self) -> Floats:
        """Wrenches that are not felt, in the same way, (b - f, 6)."""
        return self.directions.unfelt

    @property
    def wrench_body(self) -> Floats:
        """The wrench in the axes of the platform, (6,) [N m, N]."""
        return turned(self.wrench_world, self.equilibrium.platform_rotation.T)

    @cached_property
    def consistency(self) -> float:
        """Probability of a ``chi_square`` as large, had noise alone made it; 1: nothing to tell."""
        return _consistency(self.chi_square, self.degrees_of_freedom)

    @property
    def words(self) -> str:
        """What is not felt, and what is doubted, in words."""
        return "; ".join(filter(None, [self.directions.words, self.doubt]))


def estimate_wrench(
    robot: Robot,
    motors: ArrayLike,
    *,
    efforts: ArrayLike | None = None,
    effort_deviation: ArrayLike | None = None,
    pose: ArrayLike | None = None,
    pose_deviation: ArrayLike | None = None,
    start: Equilibrium | WrenchEstimate | None = None,
    loads: Loads | None = None,
    time_limit: float | None = None,
) -> WrenchEstimate:
    """What pushes on the platform. All parameters but robot and motors are options, given by name.

    Args:
        robot: The robot.
        motors: Measured motor positions in motor order, taken as exact, (n,) [rad or m].
        efforts: Measured motor efforts on the rods in motor order, as ``Equilibrium.efforts`` has them,
            (n,) [N m or N].
        effort_deviation: Their standard deviations, one for all or (n,) [N m or N]; infinite for a motor
            without a sensor.
        pose: Measured pose of the platform, x y z qw qx qy qz in the world, (7,) [m]; of an equilibrium
            ``[*platform_position, *platform_quaternion]``, as its ``pose`` is what the robot controls.
        pose_deviation: Standard deviations of its position [m] and of its rotation [rad], (2,); an
            infinite one is not measured.
        start: The last estimate, which makes the next one quick, or an equilibrium near by; default
            home.
        loads: What acts beside the wrench; default as for the last estimate, or what the description
            names, gravity among it.
        time_limit: Give up after this time [s]; default never.

    Raises:
        InvalidRequest: Wrong lengths, nothing measured, no standard deviations, a pose in other units or
            far out of the plane of a planar robot, or a quaternion in another order.
        InvalidQuaternion: A quaternion far from unit length.
        NonFiniteInput: A NaN or an infinity.
        NotReached: No equilibrium at the measured motors, or none under a wrench that explains the
            measurements, as far as Newton's method sees; or the time allowed was over.
    """
    before = start if isinstance(start, WrenchEstimate) else None
    near = before.equilibrium if before else start
    place = checked_start(checked_robot(robot), near)  # type: ignore[arg-type]
    measured = wrench_measurements(
        robot, motors, efforts, effort_deviation, pose, pose_deviation, place
    )
    if loads is None:
        loads = before.loads if before else robot.default_loads
    if before is not None and loads is before.loads:
        load_arrays = before._load_arrays
    else:
        before, load_arrays = None, robot.load_arrays(loads)
    search = _Search(place, measured, loads, load_arrays, Deadline(time_limit))
    if before is None or before.directions.gain.shape[1] != measured.rows:
        return search.from_afar(place)
    return search.from_last(before)


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


class _Search:
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
        if measured.doubt(last._unloaded) != last.doubt:
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
        return self._newton(reached, ahead, residual, last._unloaded)

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
                        break
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
        if not doubt and _consistency(squares, free) < _CHANCE:
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
            _load_arrays=self.load_arrays,
            _unloaded=unloaded,
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


def _consistency(squares: float, freedom: int) -> float:
    """Probability of a sum of squares as large, had noise alone made it; 1: nothing to tell."""
    if freedom <= 0:
        return 1.0
    return float(scipy.special.gammaincc(0.5 * freedom, 0.5 * squares))


def _size(step: Floats) -> float:
    """Largest component; of so few numbers quicker this way."""
    return max(map(abs, step.tolist()), default=0.0)

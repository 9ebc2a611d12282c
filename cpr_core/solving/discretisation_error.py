# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far an equilibrium is from that of continuous rods: what a richer space would change.

The derivation is in docs/derivations.md, "The error of an answer".
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import CprError
from ..kernels.prepared_robot import newton_step_prepared
from ..kernels.problems import PROBLEMS, ProblemName
from ..lie import rotation_log
from ..model.equilibrium import Equilibrium, check_equilibrium
from ..model.equilibrium_steps import evaluated_again
from ..model.robot import Robot, kept_with_robot
from ..rods.quadrature import rod_grid
from ..rods.rod import StrainModes
from ..validation import cached_array, cached_property
from .held_problem import checked_problem

__all__ = [
    "MORE_MODES",
    "DiscretisationError",
    "embedded",
    "embedded_richer",
    "embedding_of",
    "error_of",
]

Floats = NDArray[np.float64]

#: So many more modes in every direction tell the error: with one more, that of rods whose strain is even
#: or odd along them would not be seen; with two, those of rods bent in waves may cancel at the platform.
MORE_MODES = 4


@dataclass(frozen=True, eq=False, repr=False)
class DiscretisationError:
    """What continuous rods would change in an equilibrium, estimated: theirs minus this one.

    Attributes:
        problem: What is held: ``motors``, ``pose`` or ``efforts``.
        equilibrium: The equilibrium.
    """

    problem: ProblemName
    equilibrium: Equilibrium
    #: The estimate without its signs, for which the tangent has to be factored once more.
    _estimate: Equilibrium

    def __repr__(self) -> str:
        far = f"{self.distance:.3g} m, {self.angle:.3g} rad"
        return f"<DiscretisationError, {self.problem} held: platform {far} from continuous rods'>"

    @cached_property
    def estimate(self) -> Equilibrium:
        """That of continuous rods, estimated: an equilibrium to first order only."""
        return evaluated_again(self._estimate).with_iterations(self._estimate.iterations)

    @cached_array
    def position(self) -> Floats:
        """Change of the platform position in the world, (3,) [m]."""
        return self._estimate.platform_position - self.equilibrium.platform_position

    @cached_array
    def rotation(self) -> Floats:
        """Change of its orientation as a rotation vector in the world, (3,) [rad]."""
        turn = self._estimate.platform_rotation @ self.equilibrium.platform_rotation.T
        return rotation_log(turn)

    @cached_array
    def motors(self) -> Floats:
        """Change of the motor positions, (n,) [rad or m]."""
        return self._estimate.motors - self.equilibrium.motors

    @cached_array
    def efforts(self) -> Floats:
        """Change of the motor efforts, (n,) [N m or N]."""
        change = self._estimate.efforts - self.equilibrium.efforts
        return change * (self.problem != "efforts")

    @property
    def distance(self) -> float:
        """Distance of the platform from where continuous rods would hold it [m]."""
        return float(np.linalg.norm(self.position))

    @property
    def angle(self) -> float:
        """Angle of the platform from how continuous rods would hold it [rad]."""
        return float(np.linalg.norm(self.rotation))


def error_of(equilibrium: Equilibrium, problem: ProblemName = "motors") -> DiscretisationError:
    """Estimate how far an equilibrium is from that of continuous rods.

    One step of Newton's method in a space with four more modes in every direction, in space also in
    those that have none (twice as many where the stiffness varies along a rod, as many as its curvature
    at rest has; B-splines: a knot more in every interval) and the nodes that it needs, from the
    equilibrium as it is. What is below 1e-10 m is rounding of the solution itself.

    Args:
        equilibrium: Any equilibrium.
        problem: What is held: ``motors`` (the error is one of pose and efforts), ``pose`` (of motors and
            efforts) or ``efforts`` (of pose and motors).

    Raises:
        InvalidRequest: No equilibrium, or no problem that this robot has.
        CprError: The equilibrium is singular, so that any small change is a large one.
    """
    check_equilibrium(equilibrium)
    checked_problem(equilibrium.robot, problem)
    return DiscretisationError(
        problem, equilibrium, _newton_step(embedded_richer(equilibrium), problem)
    )


def embedded_richer(equilibrium: Equilibrium) -> Equilibrium:
    """The same configuration and multipliers in the space that tells the error of an equilibrium."""
    robot = equilibrium.robot
    richer, embedding = _richer(robot)
    return _embedded(equilibrium, richer, embedding)


def embedded(equilibrium: Equilibrium, richer: Robot) -> Equilibrium:
    """The same configuration and multipliers, with the strain in the modes of a richer robot.

    Args:
        equilibrium: What is embedded.
        richer: The same robot ``with_richer_modes``.

    Returns:
        No equilibrium yet: only its state and the pose of the platform are known.
    """
    return _embedded(equilibrium, richer, embedding_of(equilibrium.robot, richer))


@kept_with_robot
def _richer(robot: Robot) -> tuple[Robot, Floats]:
    """A richer robot, and states of this one in its numbers, (M, N)."""
    rods, more = robot.description.rods, MORE_MODES
    if not all(element.rod.profile.uniform for element in rods):
        # What jumps leave over falls like one over the number of modes: twice as many see half of it.
        more = max(MORE_MODES, *(max(element.modes.counts) for element in rods))
    for element in rods:
        pairs = zip(element.rod.rest_curvature, element.modes.counts, strict=True)
        # The curvature at rest bends lever arms in waves as long as its own.
        more = max(more, *(len(rest) + 1 - count for rest, count in pairs if count))
    found = robot.with_description(robot.description.with_richer_modes(more))
    return found, embedding_of(robot, found)


def _embedded(equilibrium: Equilibrium, richer: Robot, embedding: Floats) -> Equilibrium:
    size, record = equilibrium.robot.state_size, equilibrium.record
    # What modes cannot take up of the curvature at rest, the rods of both robots have besides.
    elastic = record[:size] - equilibrium.robot.rest_state
    # What is behind the state is the same of both: the pose of the platform, and efforts.
    record = np.concatenate([richer.rest_state + embedding @ elastic, record[size:]])
    return Equilibrium(richer, equilibrium.loads, richer.load_arrays(equilibrium.loads), record)


def embedding_of(robot: Robot, richer: Robot) -> Floats:
    """Changes of the state of a robot in the numbers of a richer one, (M, N)."""
    found = np.zeros((richer.state_size, robot.state_size))
    combinations: dict[Hashable, Floats] = {}  # rods have the same modes, as a rule
    for rod, more in zip(robot.numbers.rods, richer.numbers.rods, strict=True):
        modes, many = rod.element.modes, more.element.modes
        both = modes.identity, many.identity
        if both not in combinations:
            combinations[both] = _combinations(modes, many)
        found[more.strain, rod.strain] = combinations[both]
    new, old = np.flatnonzero(_without_strain(richer)), np.flatnonzero(_without_strain(robot))
    found[new, old] = 1.0
    return found


def _without_strain(robot: Robot) -> NDArray[np.bool_]:
    """Which numbers of the state are no strain coordinates, (N,)."""
    found = np.ones(robot.state_size, np.bool_)
    for rod in robot.numbers.rods:
        found[rod.strain] = False
    return found


def _combinations(modes: StrainModes, richer: StrainModes) -> Floats:
    """Modes as combinations of richer ones: coordinates (m,) to coordinates (M,), (M, m)."""
    grid = rod_grid(4 * max(richer.counts))
    strains = modes.values(grid.nodes).T[..., None] * np.eye(3)[modes.directions][:, None]
    return richer.project(strains, grid).T


def _newton_step(start: Equilibrium, problem: ProblemName) -> Equilibrium:
    """One full step of Newton's method; what comes of it has no signs.

    Raises:
        CprError: The tangent has no inverse there, or the step leads nowhere.
    """
    robot, record = start.robot, np.empty_like(start.record)
    if newton_step_prepared(
        robot.prepared, start.load_arrays, PROBLEMS[problem], start.record, record
    ):
        return Equilibrium(robot, start.loads, start.load_arrays, record)
    raise CprError(f"no estimate of the error: the equilibrium is singular with its {problem} held")

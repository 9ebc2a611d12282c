# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots of continuous Kirchhoff rods, solved by shooting: the paper's Mod. #2, and all others.

Unknowns are the wrenches at the bases of the rods and either the platform or the motors; equations
are the gaps and the moments at the tips and the balance of the platform, Eq. (32) without strain
modes. For robots as those of the paper everything between a start and the equilibria of a path is
compiled (``shooting_kernel``); all other robots are solved from an equilibrium (``chain_shooting``).
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from ..description.loads import Loads
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..solving.not_reached import NoForwardSolution, NoInverseSolution
from ..validation import checked_matrix, checked_vector, read_only
from .chain_shooting import solve_chains
from .continuous_equilibrium import ContinuousEquilibrium
from .shooting_kernel import shoot_along, shoot_at
from .shooting_linearisation import ShootingState
from .shooting_method import ACCURATE, ShootingMethod
from .shooting_robot import (
    check_robot,
    check_square,
    force_per_length,
    integrated_by,
    shooting_knows,
    shooting_of,
)

__all__ = [
    "follow_motors",
    "follow_platform",
    "solve_continuous",
    "solve_continuous_rough",
]

Floats = NDArray[np.float64]

#: How far from its start an equilibrium is another one, in rod lengths and radians: of three modes, too.
_ANOTHER = 0.2
_NONE = read_only(np.zeros(0))


def solve_continuous_rough(
    robot: Robot,
    motors: ArrayLike,
    curvatures: ArrayLike,
    platform_position: ArrayLike,
    platform_rotation: ArrayLike | None = None,
    *,
    loads: Loads | None = None,
    method: ShootingMethod = ACCURATE,
) -> ContinuousEquilibrium:
    """An equilibrium from a rough idea of it; no strain mode plays a part.

    Args:
        robot: The robot.
        motors: Motor positions, exact, (n,) [rad].
        curvatures: Rough strain (torsion, bending about d2, d3) of every rod, (L, 3) [1/m].
        platform_position: Rough position of the platform, (3,) [m].
        platform_rotation: Rough rotation of the platform, (3, 3); default none.
        loads: Loads; default those of the description.
        method: Integration and tolerance.

    Raises:
        InvalidRequest: The robot or a load is not of the kind this method knows; wrong lengths.
        NonFiniteInput: A NaN or an infinity.
        NoForwardSolution: Newton's method does not reach the tolerance.
    """
    loads = robot.default_loads if loads is None else loads
    check_robot(robot, loads)
    count = robot.motor_count
    angles = checked_vector("motors", motors, count)
    strains = checked_vector("curvatures", np.ravel(curvatures), 3 * count).reshape(count, 3)
    place = checked_vector("platform_position", platform_position, 3)
    rotation = np.eye(3) if platform_rotation is None else np.array(platform_rotation, np.float64)
    wrenches = np.zeros((count, 6))
    for number, leg in enumerate(robot.description.legs):
        base = leg.base_at(angles[number])
        wrenches[number, :3] = base.rotation @ (leg.rod.rigidities * strains[number])
        # The tip takes no moment: the force has the arm from base to tip.
        arm = place + rotation @ np.array(leg.joint.position) - base.position
        wrenches[number, 3:] = np.cross(wrenches[number, :3], arm) / (arm @ arm)
    rough = ShootingState(angles, wrenches, rotation, place)
    return _refined(robot, loads, method, rough, motors_held=True)


def solve_continuous(
    equilibrium: Equilibrium,
    held: Literal["motors", "pose"] = "motors",
    *,
    method: ShootingMethod = ACCURATE,
) -> ContinuousEquilibrium:
    """Refine an equilibrium of the strain-mode model into one of continuous rods, whatever the robot.

    Loads and either motor positions or the platform pose stay. Robots as those of the paper are shot
    along compiled, all others element by element.

    Args:
        equilibrium: Where the shooting starts.
        held: What stays. With the motors held the Jacobian is singular where stability is lost with
            motors locked (it is b(0)), so hold the pose there; it needs a motor for each of its
            coordinates.
        method: Integration and tolerance.

    Raises:
        InvalidRequest: A pose is to be held that has not as many coordinates as there are motors; a
            joint of a kind this method does not know.
        NoForwardSolution, NoInverseSolution: Newton's method does not reach the tolerance, or comes
            to another equilibrium, 0.2 rod lengths or radians away.
    """
    robot, loads = equilibrium.robot, equilibrium.loads
    if held == "pose":
        check_square(robot)
    if not shooting_knows(robot, loads):
        found = solve_chains(equilibrium, motors_held=held == "motors", method=method)
        return _near(equilibrium, found)
    axes = robot.kernel_arrays.position_axes
    tip_forces = np.zeros((robot.motor_count, 3))
    tip_forces[:, axes] = equilibrium.multipliers.reshape(-1, len(axes))
    density = force_per_length(robot, loads)
    wrenches = np.array(
        [
            _base_wrench(equilibrium, number, tip_forces[number], density[number])
            for number in range(robot.motor_count)
        ]
    )
    rough = ShootingState(
        equilibrium.motors,
        wrenches,
        equilibrium.platform_rotation,
        equilibrium.platform_position,
    )
    found = _refined(robot, loads, method, rough, motors_held=held == "motors")
    return _near(equilibrium, found)


def _near(start: Equilibrium, found: ContinuousEquilibrium) -> ContinuousEquilibrium:
    """What was found, unless it is another equilibrium than the start."""
    robot = start.robot
    turned = Rotation.from_matrix(found.platform_rotation @ start.platform_rotation.T)
    shifted = np.linalg.norm(found.platform_position - start.platform_position)
    driven = np.abs((found.motors - start.motors) / robot.motor_units).max(initial=0.0)
    away = max(float(turned.magnitude()), float(shifted / robot.mean_length), float(driven))
    if away < _ANOTHER:
        return found
    held_motors = np.array_equal(found.motors, start.motors)
    kind = NoForwardSolution if held_motors else NoInverseSolution
    text = f"shooting: comes to another equilibrium, {away:.2g} rod lengths or radians away"
    raise kind(f"{text}: start with more modes", 0.0, None)


def follow_motors(
    start: ContinuousEquilibrium, motors: ArrayLike, *, method: ShootingMethod | None = None
) -> tuple[ContinuousEquilibrium, ...]:
    """Forward problem along a path of motor positions.

    Args:
        start: Equilibrium whose branch is followed.
        motors: Motor positions one after the other, (K, n) [rad].
        method: Integration and tolerance; default those of the start.

    Raises:
        InvalidRequest: Wrong number of motors.
        NonFiniteInput: A NaN or an infinity.
        NoForwardSolution: The branch does not reach that far.
    """
    count = start.robot.motor_count
    targets = checked_matrix("motors", motors, None, count)
    changes = np.diff(np.vstack([start.motors, targets]), axis=0)
    return _followed(start, changes, method or start.method, motors_held=True)


def follow_platform(
    start: ContinuousEquilibrium,
    positions: ArrayLike,
    rotations: ArrayLike | None = None,
) -> tuple[ContinuousEquilibrium, ...]:
    """Inverse problem along a path of platform poses.

    Args:
        start: Equilibrium whose branch is followed.
        positions: Platform positions one after the other, (K, 3) [m].
        rotations: Platform rotations, (K, 3, 3); default that of the start.

    Raises:
        InvalidRequest: The robot has not as many motors as platform coordinates.
        NonFiniteInput: A NaN or an infinity.
        NoInverseSolution: The branch does not reach that far.
    """
    check_square(start.robot)
    places = checked_matrix("positions", positions, None, 3)
    turns = np.repeat(start.platform_rotation[None], len(places) + 1, axis=0)
    if rotations is not None:
        turns[1:] = rotations
    changes = np.empty((len(places), 6))
    changes[:, :3] = Rotation.from_matrix(turns[1:] @ np.swapaxes(turns[:-1], 1, 2)).as_rotvec()
    changes[:, 3:] = np.diff(np.vstack([start.platform_position, places]), axis=0)
    changes[:, 3:] /= start.robot.mean_length
    return _followed(start, changes, start.method, motors_held=False)


def _refined(
    robot: Robot,
    loads: Loads,
    method: ShootingMethod,
    rough: ShootingState,
    *,
    motors_held: bool,
) -> ContinuousEquilibrium:
    """The equilibrium near a rough state in SI units."""
    shooting, units = shooting_of(robot, loads, method)
    state = units.without_dimensions(rough)
    largest, iterations = shoot_at(shooting, state, motors_held, method.tolerance, 60)
    if not largest < method.tolerance:
        kind = NoForwardSolution if motors_held else NoInverseSolution
        raise kind(f"shooting: residual {largest:.1e} after {iterations} steps", 0.0, None)
    found = units.with_dimensions(state)
    return _equilibrium(robot, loads, method, found, largest, iterations)


def _followed(
    start: ContinuousEquilibrium, changes: Floats, method: ShootingMethod, *, motors_held: bool
) -> tuple[ContinuousEquilibrium, ...]:
    robot, loads, count = start.robot, start.loads, len(changes)
    shooting, units = start.shooting
    if method != start.method:
        shooting = integrated_by(shooting, method)
    state = units.without_dimensions(_state_of(start))
    legs = robot.motor_count
    states = ShootingState(
        np.empty((count, legs)),
        np.empty((count, legs, 6)),
        np.empty((count, 3, 3)),
        np.empty((count, 3)),
    )
    residuals, iterations = np.empty(count), np.zeros(count, np.int64)
    reached = shoot_along(
        shooting, state, motors_held, changes, method.tolerance, states, residuals, iterations
    )
    if reached < count:
        kind = NoForwardSolution if motors_held else NoInverseSolution
        raise kind(f"shooting: {reached} of {count} points reached", reached / count, None)
    found = map(ShootingState, *units.with_dimensions(states))
    return tuple(
        _equilibrium(robot, loads, method, point, residual, used)
        for point, residual, used in zip(
            found, residuals.tolist(), iterations.tolist(), strict=True
        )
    )


def _equilibrium(
    robot: Robot,
    loads: Loads,
    method: ShootingMethod,
    state: ShootingState,
    residual: float,
    iterations: int,
) -> ContinuousEquilibrium:
    """What was found, its state in SI units."""
    return ContinuousEquilibrium(
        robot=robot,
        loads=loads,
        motors=state.motors,
        passive=_NONE,
        platform_rotation=state.rotation,
        platform_position=state.position,
        base_wrenches=state.wrenches,
        residual=residual,
        iterations=iterations,
        method=method,
    )


def _state_of(equilibrium: ContinuousEquilibrium) -> ShootingState:
    """An equilibrium as a state in SI units."""
    return ShootingState(
        equilibrium.motors,
        equilibrium.base_wrenches,
        equilibrium.platform_rotation,
        equilibrium.platform_position,
    )


def _base_wrench(
    equilibrium: Equilibrium, number: int, tip_force: Floats, density: Floats
) -> Floats:
    """Base wrench by statics from the tip force, about the strain-mode shape, (6,) [N m, N].

    The shape enters through the lever arm of the distributed force only; a few hundred small
    rotations from midpoint to midpoint are plenty for a starting guess.
    """
    robot, leg = equilibrium.robot, equilibrium.robot.description.legs[number]
    length, count = leg.rod.length, 200
    strain = equilibrium.state[robot.numbers.legs[number].strain]
    sigma = (np.arange(count) + 0.5) / count
    curvature = leg.modes.strain_at(sigma, strain)
    frame, base, _ = leg.base_at(equilibrium.motors[number])
    tangents = np.empty((count, 3))
    for k, turn in enumerate(Rotation.from_rotvec(curvature * length / count).as_matrix()):
        tangents[k], frame = frame[:, 0], frame @ turn
    arms = np.cumsum(tangents, axis=0) * length / count
    tip = equilibrium.platform_position + equilibrium.platform_rotation @ leg.joint.position
    at_base = np.cross(tip - base, tip_force)
    at_base += np.cross(arms, density).sum(axis=0) * length / count
    return np.concatenate([at_base, tip_force + density * length])

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The home equilibrium: the one a robot begins with, found from what its description knows of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..description.robot_description import HomeGuess
from ..errors import DescriptionError
from ..kernels.limit_kernel import ROUNDING
from ..kernels.square_problem import Configuration
from ..model.equilibrium import Equilibrium
from ..model.model_state import configuration_of, evaluate
from ..model.robot import Robot, checked_robot, kept_with_robot
from ..model.shape import tip_poses
from ..model.stability import DEPENDENT
from .assembly import assemble, settle, turned_over, with_best_multipliers
from .home_doubts import doubt_home
from .limits import check_limits, margins, violated
from .not_reached import MotorLimitExceeded, NoForwardSolution, NotReached
from .refining import refine
from .rough_shape import rough_platforms, rough_state
from .solve_from import solve_from
from .unheld_motions import held_twice, loose_motion

__all__ = ["solve_home"]

Floats = NDArray[np.float64]

#: Position of a motor, in its units, beyond which rounding hides where it is.
_COUNTED = 1e9
#: Misfit of a tip that fits but for it [rad], as where a direction is turned around.
_OPPOSITE = 3.0
#: Misfit of a tip [rod lengths and rad] below which springs have closed its joint.
_FITS = 0.01


def solve_home(robot: Robot) -> Equilibrium:
    """Home equilibrium: assembled without loads, then loaded; found once and kept with the robot.

    Raises:
        InvalidRequest: No robot.
        NoForwardSolution: No equilibrium was found.
        DescriptionError: The loads cannot be borne, or a limit does not hold at home.

    Warns:
        DescriptionWarning: Home is far from the rough pose of the platform, or rods bow to the other
            side or are wound there.
    """
    return _found(checked_robot(robot))


@kept_with_robot
def _found(robot: Robot) -> Equilibrium:
    _check_motors(robot)
    guess, source = robot.description.home, robot.description.source
    if guess.strain is None:
        unloaded, leg = _assembled(robot, guess)
    else:
        unloaded = _from_strain(robot, guess)
        leg = turned_over(unloaded)
    if leg is not None:
        raise NoForwardSolution(
            f"{source}: home: it leads to an equilibrium with the tip joint of {leg} turned over; give "
            "a better platform pose, bow, joints or strain",
            0.0,
            None,
        )
    home = _loaded(robot, guess, unloaded)
    wrong = loose_motion(home) or held_twice(home, DEPENDENT)
    if wrong:
        raise NoForwardSolution(f"{source}: home: {wrong}", 0.0, None)
    doubt_home(guess, unloaded, home)
    return home


def _check_motors(robot: Robot) -> None:
    """Whether the motors can be where home has them: before rods are bent that far.

    Raises:
        DescriptionError: One cannot.
    """
    motors, units = robot.description.motors, robot.motor_units
    positions = robot.description.home.motors
    for number, (motor, at) in enumerate(zip(motors, positions.tolist(), strict=True)):
        slack, limits = ROUNDING * units[number], (motor.limits.lower, motor.limits.upper)
        problem = ""
        if not limits[0] - slack <= at <= limits[1] + slack:
            problem = str(MotorLimitExceeded(motor.name, "position", at, limits, motor.unit))
        elif abs(at) > _COUNTED * units[number]:
            most = f"{_COUNTED * units[number]:g} {motor.unit}"
            problem = f"{motor.name}: expected a position of at most {most}, got {at} {motor.unit}"
        if problem:
            raise DescriptionError(robot.description.source, "home", problem)


def _loaded(robot: Robot, guess: HomeGuess, unloaded: Equilibrium) -> Equilibrium:
    """From the assembled robot to its loads; where these let it buckle, to where it comes to rest."""
    source = robot.description.source
    try:
        loaded = solve_from(unloaded, "motors", guess.motors, loads=robot.default_loads)
    except MotorLimitExceeded as error:
        raise DescriptionError(source, "home", str(error)) from None
    except NotReached as error:
        settled = _settled(robot, unloaded)
        if settled is None:
            borne = "the loads of the description, which grow from none there, are not borne: "
            without = violated(robot, margins(unloaded))  # then it is not the loads
            problem = f"{'' if without else borne}{error}"
            raise DescriptionError(source, "home", problem) from None
        return settled
    if loaded.index_locked <= unloaded.index_locked:
        return loaded
    return _settled(robot, loaded) or loaded


def _assembled(robot: Robot, guess: HomeGuess) -> tuple[Equilibrium, str | None]:
    """From motors with the sides of the rods, rough joints or a rough platform pose.

    Returns:
        The equilibrium, and the name of a leg that is turned over in it, if there is one.
    """
    state, attempts = rough_state(robot, guess), []
    for platform in rough_platforms(robot, guess, state):
        shape = Configuration(state, *platform)
        found = assemble(robot, shape, Loads.none(), guess.platform_position is not None)
        leg = turned_over(found)
        if found.converged and leg is None:
            return found, None
        attempts.append((found, leg))
    found, leg = min(attempts, key=lambda attempt: not attempt[0].converged)
    if not found.converged:
        raise NoForwardSolution(
            f"{robot.description.source}: home: the robot cannot be assembled at these motors: "
            f"{_what_keeps_it_open(found)}",
            0.0,
            None,
        )
    return found, leg


def _what_keeps_it_open(held: Equilibrium) -> str:
    """Why a robot that only springs hold cannot be assembled, in words."""
    size, text = _worst_gap(held.robot, configuration_of(held))
    return (size < _FITS and (loose_motion(held) or held_twice(held, _FITS))) or text


def _settled(robot: Robot, start: Equilibrium) -> Equilibrium | None:
    """Where the robot comes to rest under its loads, if growing loads make it snap or buckle."""
    loads = robot.default_loads
    if not robot.has_potential(loads):
        return None
    found = settle(robot, configuration_of(start), loads)
    if not found.converged or found.index_locked > 0 or turned_over(found) is not None:
        return None
    try:
        check_limits(found)
    except NotReached:
        return None
    return found


def _from_strain(robot: Robot, guess: HomeGuess) -> Equilibrium:
    """From a shape that is known well: Newton's method keeps to it, stable or not."""
    loads, state = Loads.none(), rough_state(robot, guess)
    rough = Configuration(state, *next(rough_platforms(robot, guess, state)))
    place = rough._replace(state=with_best_multipliers(robot, robot.load_arrays(loads), rough))
    found = refine(robot, loads, place, iterations=200, contraction=1.0)
    if found.converged:
        return found
    raise NoForwardSolution(
        f"{robot.description.source}: home: the strain given leads to no equilibrium: "
        f"{_worst_gap(robot, rough)[1]}; "
        + (
            "a leg is straight, or some motion is held by nothing"
            if found.iterations == 0
            else f"given up after {found.iterations} steps"
        ),
        0.0,
        None,
    )


def _worst_gap(robot: Robot, place: Configuration) -> tuple[float, str]:
    """Where a robot fits worst: how badly [rod lengths and rad], and in words."""
    residual = evaluate(robot, robot.load_arrays(Loads.none()), *place).residual
    tips, worst, text = tip_poses(robot, place.state), -1.0, ""
    for numbers, leg, tip in zip(robot.numbers.legs, robot.description.legs, tips, strict=True):
        gap = float(np.linalg.norm(residual[numbers.forces]))
        turn = leg.joint.misalignment(place.platform_rotation, tip.rotation)
        if gap / robot.mean_length + turn > worst:
            worst = gap / robot.mean_length + turn
            text = f"there {leg.name} misses its tip joint by {gap:.3g} m"
            if len(leg.joint.orientation(robot.planar)):
                text += f" and {turn:.3g} rad"
            if turn > _OPPOSITE and gap < _FITS * robot.mean_length:
                text += " (does its tangent, normal or axis point the other way?)"
    return worst, text

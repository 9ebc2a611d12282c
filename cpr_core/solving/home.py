# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The home equilibrium: the one a robot begins with, found from what its description knows of it."""

from __future__ import annotations

import warnings

import numpy as np
import scipy
from numpy.typing import NDArray

from ..description.loads import Loads
from ..description.robot_description import HomeGuess
from ..errors import DescriptionError, DescriptionWarning
from ..kernels.limit_kernel import ROUNDING
from ..kernels.square_problem import Configuration
from ..kernels.twist_layout import ANGULAR, LINEAR
from ..lie import rotation_log
from ..model.equilibrium import Equilibrium, spectrum
from ..model.model_state import configuration_of, evaluate
from ..model.platform_coordinates import six_components
from ..model.robot import Robot, checked_robot, kept_with_robot
from ..model.shape import tip_poses
from ..model.stability import DEPENDENT
from .assembly import assemble, settle, turned_over, with_best_multipliers
from .limits import check_limits, margins, violated
from .not_reached import MotorLimitExceeded, NoForwardSolution, NotReached
from .refining import refine
from .rough_shape import rough_platforms, rough_state
from .solve_from import solve_from

__all__ = ["solve_home"]

Floats = NDArray[np.float64]

#: Eigenvalue of H_r, relative to the largest one, that counts as no stiffness: in equilibrium, and where
#: springs hold the robot, at rest to 1e-6 only.
_NO_STIFFNESS, _NO_STIFFNESS_HELD = 1e-9, 1e-6
#: How much of a motion without stiffness the platform has at least for it to be its own.
_LOOSE = 0.1
#: Distance from the rough pose to the home found that is no roughness any more, in rod lengths.
_ROUGH = 0.5
#: Angle from the rough orientation to the home found that is no roughness any more, and angle by which
#: nobody mounts a rod wound [rad].
_ROUGH_TURN, _WOUND = 0.5, 1.0
#: Position of a motor, in its units, beyond which rounding hides where it is.
_COUNTED = 1e9
#: What turns a rod about itself, or a platform, where a description has it wrong.
_DIRECTIONS = "tangent, normal, axis and axis_in_rod from bases to tips"
#: Misfit of a tip [rod lengths and rad] below which springs have closed its joint.
_FITS = 0.01


def solve_home(robot: Robot) -> Equilibrium:
    """Home equilibrium: assembled without loads, then loaded; found once and kept with the robot.

    Raises:
        InvalidRequest: No robot.
        NoForwardSolution: No equilibrium was found.
        DescriptionError: The loads cannot be borne, or a limit does not hold at home.

    Warns:
        DescriptionWarning: Home is far from the rough pose of the platform, or a rod is wound there.
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
    wrong = _loose_motion(home) or _held_twice(home, DEPENDENT)
    if wrong:
        raise NoForwardSolution(f"{source}: home: {wrong}", 0.0, None)
    _check_distance(guess, home)
    _check_turn(guess, home)
    if guess.strain is None:  # else somebody knows how rods are wound
        _check_winding(unloaded)
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


def _check_distance(guess: HomeGuess, home: Equilibrium) -> None:
    """Whether the rough pose of the platform was a rough one, and no other."""
    if guess.platform_position is None:
        return
    distance = float(np.linalg.norm(guess.platform_position - home.platform_position))
    if distance > _ROUGH * home.robot.mean_length:
        position = ", ".join(f"{value:.4g}" for value in home.platform_position)
        warnings.warn(
            f"{home.robot.description.source}: home.platform.position: the home equilibrium found is "
            f"{distance:.3g} m from there, at ({position}) m: give a better position, or none",
            DescriptionWarning,
            stacklevel=2,
        )


def _check_turn(guess: HomeGuess, home: Equilibrium) -> None:
    """Whether the rough orientation of the platform, if one was written, was a rough one."""
    description = home.robot.description
    if description.point_platform or guess.platform_rotation is None:
        return
    turn = float(np.linalg.norm(rotation_log(guess.platform_rotation.T @ home.platform_rotation)))
    if turn > _ROUGH_TURN:
        quaternion = ", ".join(f"{value:.3g}" for value in home.platform_quaternion)
        warnings.warn(
            f"{description.source}: home.platform.quaternion_wxyz: the home equilibrium "
            f"found is turned by {turn:.3g} rad from there, to ({quaternion}): check {_DIRECTIONS}; "
            "or give a better quaternion, or none",
            DescriptionWarning,
            stacklevel=2,
        )


def _check_winding(unloaded: Equilibrium) -> None:
    """Whether rods are wound before there are loads, as joints at wrong angles do it."""
    robot, state = unloaded.robot, unloaded.state
    windings: dict[str, float] = {}
    for rod, values, rest in zip(robot.numbers.rods, *robot.curvature_stations, strict=True):
        torsion = values[1:-1, 0] @ state[rod.strain] / rod.stretch(state) - rest[1:-1, 0]
        angle = float(rod.length(state)) * float(robot.grid.weights @ torsion)
        leg = robot.description.legs[rod.leg].name
        windings[leg] = max(windings.get(leg, 0.0), angle, key=abs)
    wound = {leg: abs(angle) for leg, angle in windings.items() if abs(angle) > _WOUND}
    if wound:
        worst = max(wound, key=lambda leg: wound[leg])
        more = f" (and {len(wound) - 1} more)" if len(wound) > 1 else ""
        warnings.warn(
            f"{robot.description.source}: home: {worst}{more} is wound by {wound[worst]:.3g} rad "
            f"there, before there are loads: check {_DIRECTIONS}",
            DescriptionWarning,
            stacklevel=2,
        )


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
    return (size < _FITS and (_loose_motion(held) or _held_twice(held, _FITS))) or text


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


def _loose_motion(found: Equilibrium) -> str:
    """What the platform or a joint can do without resistance, in words; empty if all is held.

    What is negligible beside a spring, and not beside rods, is held: the spring is named instead.
    """
    robot = found.robot
    whole = spectrum(found)
    sizes = np.abs(whole.eigenvalues)
    if not len(sizes):
        return ""
    negligible = _NO_STIFFNESS if found.converged else _NO_STIFFNESS_HELD
    loose = _in_words(robot, whole.motions[:, sizes < negligible * sizes.max()])
    stiffness, by_springs = _springs(robot), np.zeros_like(sizes)
    for (_, index), each in zip(robot.passive_joints, stiffness, strict=True):
        by_springs += each * (whole.motions[index] / robot.kernel_arrays.unit[index]) ** 2
    of_rods = np.max(sizes, where=by_springs < 0.5 * sizes, initial=0.0)
    if not loose or np.any(sizes < negligible * of_rods):
        return loose
    stiffest = int(np.argmax(stiffness))
    times = stiffness[stiffest] / robot.kernel_arrays.energy_unit
    return (
        f"the spring of joint {robot.passive_joints[stiffest][0].name} is {times:.1g} times as stiff as "
        "the rods (E J / l), which rounding hides beside it; leave the joint out, or give it a softer "
        "spring"
    )


def _springs(robot: Robot) -> Floats:
    """Stiffness of the springs of the passive joints, per natural unit of their motion [J]."""
    return np.array(
        [
            joint.stiffness * robot.kernel_arrays.unit[index] ** 2
            for joint, index in robot.passive_joints
        ]
    )


def _in_words(robot: Robot, loose: Floats) -> str:
    """Motions of the state without stiffness, columns, as those of the platform or a joint."""
    motions = loose[robot.platform_indices]
    lengths = robot.kernel_arrays.unit[robot.platform_indices]
    moved = np.linalg.norm(motions / lengths[:, None], axis=0)
    if not np.any(moved > _LOOSE):
        return _loose_joint(robot, loose)
    motion = (motions / lengths[:, None])[:, int(moved.argmax())]
    twist = six_components(robot.platform_axes, motion)
    turns = np.linalg.norm(twist[ANGULAR]) > np.linalg.norm(twist[LINEAR])
    part = twist[ANGULAR] if turns else twist[LINEAR]
    axis = ", ".join(f"{value:.2g}" for value in part / np.linalg.norm(part) + 0.0)
    return (
        f"nothing holds the platform: it can {'turn about' if turns else 'move along'} "
        f"({axis}) freely; it needs more legs, or tip joints that hold more"
    )


def _held_twice(held: Equilibrium, negligible: float) -> str:
    """How many motions joints hold that others hold already, in words; empty if there are none."""
    robot = held.robot
    moving = robot.moving_indices
    constraints, unit = robot.multiplier_indices, robot.kernel_arrays.unit
    slopes = unit[constraints, None] * held.tangent[np.ix_(constraints, moving)] * unit[moving]
    sizes = scipy.linalg.svdvals(slopes)
    independent = int(np.sum(sizes > negligible * sizes.max(initial=0.0)))
    if independent == len(constraints):
        return ""
    return (
        f"of the {len(constraints)} constraints of its joints only {independent} are independent "
        "there: some motion is held twice, or a leg is straight; let a tip joint hold less, or "
        "leave a leg out"
    )


def _loose_joint(robot: Robot, motions: Floats) -> str:
    """A passive joint of a leg that some of the motions without stiffness move, in words."""
    for joint, index in robot.passive_joints:
        if np.any(np.abs(motions[index]) > _LOOSE * robot.kernel_arrays.unit[index]):
            return (
                f"nothing holds joint {joint.name}: with the others it moves freely; give it a spring, "
                "or leave it out"
            )
    return ""


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
    return worst, text

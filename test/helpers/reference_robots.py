# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots on which the strain-mode model is compared with continuous rods."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from cpr_core import (
    Equilibrium,
    Robot,
    find_equilibria,
    leg_shapes,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.description.chain import ChainRod
from cpr_core.description.description_file import shipped_robots
from cpr_core.description.joints import RevoluteJoint, Universal
from cpr_core.description.loads import Loads
from cpr_core.rods.rod import StrainModes
from cpr_core.solving.not_reached import NotReached
from helpers.chain_robots import robot_of

_DATA = Path(__file__).parents[1] / "data"
#: Every robot there is a file of: whatever is shipped, and what tests have of their own.
FILES = {path.stem: path for path in (*shipped_robots().values(), *sorted(_DATA.glob("*.yaml")))}


@cache
def reference_robot(name: str, modes: int = 12) -> Robot:
    """A robot out of FILES with modes enough to be compared."""
    return load_robot(str(FILES[name]), modes=modes)


def loaded(robot: Robot) -> Loads:
    """Gravity and a wind that no axis of the robot is along."""
    gravity = [0.3, -9.0, 0.0] if robot.planar else [0.3, -0.2, -9.81]
    wind = [0.05, 0.02, 0.0] if robot.planar else [0.05, -0.03, 0.02]
    return robot.default_loads.with_(gravity=gravity, rod_force=wind)


def walked(robot: Robot, count: int, seed: int) -> Iterator[Equilibrium]:
    """Random configurations about home that can be reached from it; every second one loaded."""
    random, home = np.random.default_rng(seed), solve_home(robot)
    for number in range(count):
        motors = home.motors + 0.25 * random.normal(size=robot.motor_count) * robot.motor_units
        loads = loaded(robot) if number % 2 else robot.default_loads
        try:
            yield solve_forward(robot, motors, start=home, loads=loads)
        except NotReached:
            continue


def met(robot: Robot, count: int, seed: int) -> Iterator[Equilibrium]:
    """Equilibria met from random shapes at random motors, stable or not; every second time loaded."""
    random, home = np.random.default_rng(seed), solve_home(robot)
    for number in range(count):
        motors = home.motors + 0.1 * random.normal(size=robot.motor_count) * robot.motor_units
        loads = loaded(robot) if number % 2 else robot.default_loads
        found = find_equilibria(robot, motors, starts=8, seed=number, loads=loads)
        yield from (each.equilibrium for each in found)


def robot_with(chains: Sequence[str], modes: int = 10, shared: bool = False) -> Robot:
    """The paper's robot with chains out of CHAINS for legs, clamped to the platform where it has them.

    A continuous rod bends and twists in all directions, so there are modes for all.
    """
    description = robot_of(chains, "fixed", shared).description
    places = [leg.joint.position for leg in load_robot("six_rfs").description.legs]
    legs = tuple(
        replace(
            leg,
            joint=replace(leg.joint, position=place),
            elements=tuple(
                replace(element, modes=StrainModes((modes, modes, modes)))
                if isinstance(element, ChainRod)
                else element
                for element in leg.chain
            ),
        )
        for leg, place in zip(description.legs, places, strict=False)
    )
    motors = np.array([0.55 if motor.unit == "m" else 0.3 for motor in description.motors])
    bow = description.home.bow[: len(legs)]
    home = replace(description.home, motors=motors, bow=bow, strain=None)
    return Robot(replace(description, legs=legs, home=home))


def robot_with_tips(tip: str) -> Robot:
    """A robot with two revolute or universal tips, closed where all tips would be clamped."""
    robot = robot_with(("motor", "hub", "sprung motor"), modes=12)
    start = solve_home(robot)
    shapes, legs = leg_shapes(start), list(robot.description.legs)
    for number in (1, 2):
        frame = start.platform_rotation.T @ shapes[number].rotation[-1]
        place, (_, across, along) = legs[number].joint.position, frame.T
        joint = {
            "revolute": RevoluteJoint(place, tuple(along), (0.0, 0.0, 1.0)),
            "universal": Universal(place, tuple(across), (0.0, 0.0, 1.0)),
        }[tip]
        legs[number] = replace(legs[number], joint=joint)
    return Robot(replace(robot.description, legs=tuple(legs)))

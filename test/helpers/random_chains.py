# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Random robots whose legs are chains, made so that everything is at rest in one known place."""

from __future__ import annotations

from copy import deepcopy
from typing import Any, NamedTuple

import numpy as np

from cpr_core import Robot, load_robot
from cpr_core.lie import quaternion_from_rotation, rotation_exp
from cpr_core.model.shape import rod_bases, tip_poses
from cpr_core.solving.rough_shape import rough_state

LENGTH = 0.4


class RandomRobot(NamedTuple):
    """A description, and where it is at rest.

    Attributes:
        content: The description; home knows its motors only.
        position: Platform, (3,) [m].
        rotation: Platform, (3, 3).
        joints: Passive joints as ``home.joints`` takes them [rad].
    """

    content: dict[str, Any]
    position: np.ndarray
    rotation: np.ndarray
    joints: dict[str, Any]


def _numbers(values: Any) -> Any:
    return np.asarray(values, float).tolist()


def _planar_chain(generator: np.random.Generator) -> list[dict[str, Any]]:
    axis, uniform = [0, 0, 1], generator.uniform
    chain: list[dict[str, Any]] = [{"link": [uniform(0.02, 0.12), 0, 0], "mass": 0.01}]
    if generator.random() < 0.5:
        chain.append({"joint": "revolute", "axis": axis})
        if generator.random() < 0.5:
            chain[-1] |= {"stiffness": uniform(0.05, 0.5)}
    chain.append({"rod": {"rest_curvature": {"bending_3": [uniform(-3, 3)]}}})
    if generator.random() < 0.5:
        chain.append({"link": [0.03, 0.0, 0], "mass": 0.005})
        chain.append({"rod": {"length": 0.15, "rest_curvature": {"bending_3": [uniform(-3, 3)]}}})
    return chain


def _spatial_chain(generator: np.random.Generator) -> list[dict[str, Any]]:
    uniform = generator.uniform
    kind = generator.integers(4)
    chain: list[dict[str, Any]] = [
        {"link": [uniform(0.02, 0.15), 0, 0], "tangent": [0, 0, 1], "normal": [0, 1, 0]}
    ]
    if kind == 1:
        chain.append({"joint": "revolute", "axis": [0, 0, 1], "stiffness": uniform(0.05, 0.5)})
    if kind == 2:
        chain.append({"joint": "universal", "axes": [[0, 1, 0], [0, 0, 1]]})
    if kind == 3:
        chain.append({"joint": "revolute", "axis": [0, 1, 0]})
    bend = {name: [uniform(-2.5, 2.5)] for name in ("bending_2", "bending_3")}
    chain.append({"rod": {"rest_curvature": bend}})
    if generator.random() < 0.3:
        chain.append({"link": [0.03, 0.01, 0], "mass": 0.005})
    return chain


def random_chain_robot(
    seed: int, planar: bool, turn: float = 0.5, platform_turn: float = 0.3
) -> RandomRobot:
    """A robot of three or six legs, each with a crank that a motor turns, passive joints and rods.

    Args:
        seed: Which one.
        planar: Whether it lives in the plane.
        turn: How far passive joints are from zero at most [rad].
        platform_turn: How far the platform is turned at most, about every axis [rad].
    """
    generator = np.random.default_rng(seed)
    uniform, count = generator.uniform, 3 if planar else 6
    legs, joints = [], {}
    for number in range(count):
        angle = 2.0 * np.pi * number / count + uniform(-0.3, 0.3)
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        across = np.array([-out[1], out[0], 0.0])
        base: dict[str, Any] = {"position": _numbers((0.5 if planar else 0.25) * out)}
        base["tangent"] = _numbers(-out if planar else out)
        if not planar:
            base["normal"] = _numbers(across)
        axis = [0, 0, 1] if planar else [0, -1, 0]
        motor = {"joint": "revolute", "axis": axis, "motor": f"motor{number + 1}"}
        chain = _planar_chain(generator) if planar else _spatial_chain(generator)
        legs.append({"base": base, "chain": [motor, *chain]})
        legs[-1]["tip"] = {"type": "revolute" if planar else "spherical", "position": [0, 0, 0]}
        for element in chain:
            if "joint" not in element:
                continue
            # Passive joints are the second joint of their leg.
            at = _numbers(uniform(-turn, turn, 2 if element["joint"] == "universal" else None))
            joints[f"leg{number + 1}.joint2"] = at
            if "stiffness" in element:
                element["rest"] = at
    turned = platform_turn * uniform(-1.0, 1.0, 3)
    rotation = rotation_exp(turned * [0, 0, 1] if planar else turned)
    content: dict[str, Any] = {
        "name": f"random {seed}",
        "space": "planar" if planar else "spatial",
        "rod": {
            "length": LENGTH,
            "section": {"shape": "circular", "radius": 0.0015},
            "young_modulus": 110e9,
            "shear_modulus": 42e9,
            "density": 4400.0,
        },
        "strain": {"bending_3": 5} if planar else {"torsion": 2, "bending_2": 4, "bending_3": 4},
        "platform": {"mass": 0.2},
        "legs": legs,
        "controlled": ["x", "y", "angle"] if planar else ["x", "y", "z", "orientation"],
        "home": {"motors": _numbers(uniform(-0.4, 0.4, count)), "joints": joints},
    }
    robot: Robot = load_robot(content)
    tips = [pose.position for pose in tip_poses(robot, rough_state(robot, robot.description.home))]
    position = np.mean(tips, axis=0)
    for leg, tip in zip(legs, tips, strict=True):
        leg["tip"]["position"] = _numbers(rotation.T @ (tip - position))
        if planar:
            leg["tip"]["position"][2] = 0.0
    content = deepcopy(content)
    del content["home"]["joints"]
    return RandomRobot(content, position, rotation, joints)


def rough_pose(robot: RandomRobot, seed: int, distance: float, turn: float) -> dict[str, Any]:
    """The platform at rest, as ``home.platform``, displaced by up to a distance [m] and a turn [rad]."""
    generator = np.random.default_rng(seed)
    planar = robot.content["space"] == "planar"
    shift, turned = generator.uniform(-1, 1, 3), generator.uniform(-1, 1, 3)
    if planar:
        shift, turned = shift * [1, 1, 0], turned * [0, 0, 1]
    rotation = rotation_exp(turn * turned) @ robot.rotation
    return {
        "position": _numbers(robot.position + distance * shift),
        "quaternion_wxyz": _numbers(quaternion_from_rotation(rotation)),
    }


def rough_joints(robot: RandomRobot, seed: int, turn: float) -> dict[str, Any]:
    """The passive joints at rest, as ``home.joints``, displaced by up to a turn [rad]."""
    generator = np.random.default_rng(seed)
    return {
        name: _numbers(np.asarray(at) + generator.uniform(-turn, turn, np.shape(at)))
        for name, at in robot.joints.items()
    }


def sides(robot: RandomRobot) -> list[list[float]]:
    """Sides to which the rods are bent at rest, as ``home.bow``."""
    content = deepcopy(robot.content)
    content["home"]["joints"] = robot.joints
    exact = load_robot(content)
    bases = rod_bases(exact, rough_state(exact, exact.description.home))
    found = []
    for leg, poses in zip(exact.description.legs, bases, strict=True):
        _, bending_2, bending_3 = leg.rods[0].rod.rest_curvature_at(np.array([0.5]))[0]
        found.append(_numbers(poses[0].rotation @ [0.0, -bending_3, bending_2]))  # against r''
    return found

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shipped robots with gears and screws between motors and joints, all different."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot, load_robot
from helpers.chain_robots import as_chains
from helpers.shipped_steps import SHORT_FORM
from helpers.yaml_content import shipped_content

#: Way of a joint per way of its motor: a harmonic drive, a belt, the wrong way round, encoder counts.
_GEARS = (0.01, -0.02, 3.0, 2.0 * math.pi / 2**20, -0.0125, 40.0)
#: Way per turn [m]: of screws, one of them left-handed, and of a belt.
_LEADS = (0.001, -0.002, 0.012, 0.0005, 0.04, 0.005)


class Geared(NamedTuple):
    """A robot, the same with a gear behind every motor, and ways of its joints by theirs, (n,)."""

    plain: Robot
    robot: Robot
    ratios: NDArray[np.float64]


def chains_of(name: str) -> dict[str, Any]:
    """Content of a shipped robot whose legs are chains."""
    if name in SHORT_FORM:
        return as_chains(name, links=False)
    content: dict[str, Any] = shipped_content(name)
    return content


def geared(name: str) -> Geared:
    """A shipped robot with and without gears."""
    plain, content = load_robot(chains_of(name)), chains_of(name)
    motors, ratios = plain.motor_names, np.ones(plain.motor_count)
    for leg in content["legs"]:
        for joint in leg["chain"]:
            if isinstance(motor := joint.get("motor"), str):
                number = motors.index(motor)
                ratios[number] = _geared(joint, number)
    home = content["home"]["motors"]
    content["home"]["motors"] = [at / ratio for at, ratio in zip(home, ratios, strict=True)]
    assert not np.any(ratios == 1.0)
    return Geared(plain, load_robot(content), ratios)


def _geared(joint: dict[str, Any], number: int) -> float:
    """Put a gear or a screw before a joint or a rod; returns its way per way of the motor."""
    if joint.get("joint") == "revolute":
        ratio = joint["ratio"] = _GEARS[number]
    else:
        joint["lead"] = _LEADS[number]
        ratio = joint["lead"] / (2.0 * math.pi)
    limits = joint.get("limits", {})
    if "position" in limits:
        limits["position"] = sorted(end / ratio for end in limits["position"])
    if "speed" in limits:
        limits["speed"] /= abs(ratio)
    if "effort" in limits:
        limits["effort"] *= abs(ratio)
    return ratio

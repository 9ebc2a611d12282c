# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rods that are pulled straight: forces grow without bound, and steps along a branch lead nowhere."""

from __future__ import annotations

import numpy as np

from ..model.equilibrium import Equilibrium

__all__ = ["taut_legs"]

#: Force at a tip joint of a rod that is pulled straight, in E J / l^2: Euler's load is 10.
_TAUT = 1000.0


def taut_legs(equilibrium: Equilibrium) -> str:
    """Legs whose tip joints bear forces as no bent rod does, in words; empty: none."""
    robot, state = equilibrium.robot, equilibrium.state
    unit, described = robot.kernel_arrays.unit, robot.description.legs
    forces = {
        leg.name: float(np.linalg.norm(state[numbers.forces] / unit[numbers.forces]))
        for numbers, leg in zip(robot.numbers.legs, described, strict=True)
    }
    taut = [leg for leg, force in forces.items() if force > _TAUT]
    if not taut:
        return ""
    largest = max(forces.values())
    return f"{', '.join(taut)}: pulled taut, with {largest:.0f} E J / l^2 at the tip joint"

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot that is not as its description says: softer rods, and a payload nobody knows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cpr_core import Robot, load_robot, solve_forward, solve_home
from helpers.yaml_content import shipped_content

#: Payload, [m; f] on the platform [N m, N].
PAYLOADS = {
    "rfrfr": [0.0, 0.0, 0.0, 0.0, -1.0, 0.0],
    "planar_body": [0.0, 0.0, 0.01, 0.0, -0.3, 0.0],
    "three_rfs": [0.0, 0.0, 0.0, 0.0, 0.0, -0.3],
    "six_rfs": [0.0, 0.0, 0.0, 0.0, 0.0, -2.0],
    "four_rfr": [0.0, 0.0, 0.005, 0.0, -0.3, 0.0],
}


def softened(name: str, factor: float = 0.9) -> Robot:
    """A shipped robot whose rods are softer."""
    content = shipped_content(name)
    for modulus in ("young_modulus", "shear_modulus"):
        content["rod"][modulus] = factor * float(content["rod"][modulus])
    return load_robot(content)


class SoftRobot:
    """Ten per cent softer rods and a payload, at home to begin with."""

    def __init__(self, name: str, payload: Sequence[float] | None = None) -> None:
        robot = softened(name)
        home = solve_home(robot)
        wrench = home.loads.wrench_world + (PAYLOADS[name] if payload is None else payload)
        self.equilibrium = solve_forward(
            robot, home.motors, start=home, loads=home.loads.with_(wrench_world=wrench)
        )

    def move_to(self, motors: np.ndarray) -> None:
        """Take motor commands."""
        self.equilibrium = solve_forward(
            self.equilibrium.robot, motors, start=self.equilibrium, loads=self.equilibrium.loads
        )

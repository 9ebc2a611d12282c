# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The two case studies: robots, motor paths of Eq. (53) and their continuous-rod solutions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from cpr_core import Equilibrium, Robot, load_robot, solve_forward, solve_home
from cpr_core.lie import quaternion_from_rotation, rotation_exp, rotation_from_quaternion
from cpr_core.reference.continuous_equilibrium import ContinuousEquilibrium
from cpr_core.reference.continuous_rods import follow_motors, solve_continuous_rough

__all__ = ["RFRFR", "SIX_RFS", "SLICE", "SLICE_ROTATION", "Case", "slice_pose"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """A robot and its path.

    Attributes:
        name: Name of the shipped robot.
        title: Name in the paper.
        first: Motor positions at t = 0 [rad].
        last: Motor positions at t = n_c [rad].
        curvature: Rough curvature of the legs at t = 0, about d2 and d3, by leg [1/m].
        place: Rough platform at t = 0: position [m] and quaternion w x y z.
    """

    name: str
    title: str
    first: tuple[float, ...]
    last: tuple[float, ...]
    curvature: tuple[tuple[float, float], ...]
    place: tuple[float, ...]

    def robot(self, modes: int) -> Robot:
        """The robot with so many modes per bending direction."""
        return _robot(self.name, modes)

    def path(self, count: int = 50) -> Floats:
        """Motor positions for t = 0 to n_c, Eq. (53), (n_c + 1, n) [rad]."""
        first, last = np.array(self.first), np.array(self.last)
        return first + (last - first) * (np.arange(count + 1.0) / count)[:, None]

    def modes_path(self, modes: int, count: int = 50) -> tuple[Equilibrium, ...]:
        """Mod. #1 along the path."""
        robot = self.robot(modes)
        last, points = solve_home(robot), []
        for motors in self.path(count):
            last = solve_forward(robot, motors, start=last)
            points.append(last)
        return tuple(points)

    def continuous_home(self) -> ContinuousEquilibrium:
        """Mod. #2 at the start of the path."""
        return _continuous_home(self)

    def continuous_path(self, count: int = 50) -> tuple[ContinuousEquilibrium, ...]:
        """Mod. #2 along the path, to about 1e-11 m: what errors refer to."""
        return _continuous_path(self, count)


@cache
def _robot(name: str, modes: int) -> Robot:
    return load_robot(name, modes=modes)


@cache
def _continuous_home(case: Case) -> ContinuousEquilibrium:
    curvatures = np.column_stack([np.zeros(len(case.curvature)), case.curvature])
    position, quaternion = np.array(case.place[:3]), np.array(case.place[3:])
    rotation = rotation_from_quaternion(quaternion / np.linalg.norm(quaternion))
    return solve_continuous_rough(case.robot(5), case.first, curvatures, position, rotation)


@cache
def _continuous_path(case: Case, count: int) -> tuple[ContinuousEquilibrium, ...]:
    return follow_motors(case.continuous_home(), case.path(count))


#: Both start with all legs bowed outward, as in Figs. 3 and 9.
RFRFR = Case(
    "rfrfr",
    "RFRFR",
    (2.59, 0.55),
    (5.76, 3.67),
    ((0.0, -2.0), (0.0, 2.0)),
    (0.0, 0.84, 0.0, 1.0, 0.0, 0.0, 0.0),
)
SIX_RFS = Case(
    "six_rfs",
    "6-RFS",
    (5.86, 5.56, 5.86, 5.46, 5.86, 5.26),
    (7.95, 7.65, 4.29, 3.89, 3.77, 3.17),
    ((-2.0, 0.0),) * 6,
    (0.036, 0.013, 0.845, 0.9434, -0.0406, -0.0496, 0.3255),
)

#: Platform of Figs. 12 to 14: height [m] and ZYZ Euler angles.
SLICE = {"z": 0.635, "phi": np.pi / 8, "theta": np.pi / 3, "psi": 0.0}
SLICE_ROTATION = rotation_exp([0.0, 0.0, SLICE["phi"]]) @ rotation_exp([0.0, SLICE["theta"], 0.0])


def slice_pose(x: float, y: float) -> Floats:
    """Controlled coordinates of the 6-RFS robot in the slice z = 0.635 m."""
    return np.array([x, y, SLICE["z"], *quaternion_from_rotation(SLICE_ROTATION)])

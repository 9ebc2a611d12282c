# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Walks of a redundant robot in which some motors are imposed beside the pose.

As many motors are imposed as there are too many: what is left is a square problem and one of the usual
walks. They are chosen anew for every walk, so that the others find the pose as surely as possible.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..kernels.record_layout import INVERSE_SIGN, SIGNS
from ..model.equilibrium import Equilibrium
from ..model.equilibrium_steps import equilibrium_at
from ..model.kinemato_statics import KinematoStatics
from ..model.model_state import configuration_of
from ..model.robot import Robot
from .continuation import Walk, follow
from .deadline import Deadline
from .near_request import solve_near
from .targets import PoseTarget

__all__ = ["HeldWalks", "self_motions"]

Floats = NDArray[np.float64]


@dataclass(eq=False)
class HeldWalks:
    """How all walks of one request are made.

    Attributes:
        stable_only: Stop where the stability index grows above zero.
        deadline: When no walk is begun any more.
        iterations: Newton steps of the walks so far.
    """

    stable_only: bool
    deadline: Deadline
    iterations: int = 0

    def step(
        self,
        start: Equilibrium,
        directions: Floats,
        pose: PoseTarget,
        change: Floats,
        loads: Loads | None = None,
    ) -> Walk:
        """To a pose, with a change of the motors that is exact in those imposed and rough in the others.

        Args:
            start: Equilibrium to start from.
            directions: Self-motions there, see ``self_motions``.
            pose: What the controlled coordinates shall be.
            change: Of the motors, dimensionless, (n,).
            loads: Loads to arrive with; default those of the start.
        """
        robot, loads = start.robot, start.loads if loads is None else loads
        begin = _of(start, robot.holding(_imposed_motors(directions)))
        target = replace(pose, motors=start.motors + change * robot.motor_units)
        if loads is start.loads and not self.deadline.over:
            near = solve_near(begin, target, self.stable_only)
            if near is not None:
                self.iterations += near.iterations
                return Walk(_of_base(near, robot))
        walk = follow(
            begin,
            target,
            loads,
            stable_only=self.stable_only,
            time_limit=self.deadline.left,
        )
        self.iterations += walk.last.iterations
        return _walk_of_base(walk, robot)


def self_motions(model: KinematoStatics) -> Floats:
    """Self-motions of the motors, dimensionless, orthonormal columns, (n, r)."""
    return np.asarray(model.self_motions / model.equilibrium.robot.motor_units[:, None])


def _imposed_motors(directions: Floats) -> tuple[int, ...]:
    """Numbers of the motors to impose, so that the others find the pose as surely as possible.

    Those that move most in self-motions, (n, r), one after the other: what is left of the Jacobian is
    farthest from singular then.
    """
    left, chosen = directions.copy(), list[int]()
    for _ in range(directions.shape[1]):
        motor = int(np.argmax(np.sum(left**2, axis=1)))
        chosen.append(motor)
        row = left[motor] / np.linalg.norm(left[motor])
        left -= np.outer(left @ row, row)
    return tuple(sorted(chosen))


def _of(equilibrium: Equilibrium, robot: Robot) -> Equilibrium:
    """An equilibrium as one of a robot that holds some motors."""
    place = configuration_of(equilibrium)
    return equilibrium_at(robot, equilibrium.loads, equilibrium.load_arrays, place)


def _of_base(equilibrium: Equilibrium, robot: Robot) -> Equilibrium:
    """An equilibrium as one of the robot that holds none: its inverse problem has no determinant."""
    record = equilibrium.record.copy()
    record[robot.state_size + SIGNS + INVERSE_SIGN] = 0.0
    return replace(equilibrium, robot=robot, record=record)


def _walk_of_base(walk: Walk, robot: Robot) -> Walk:
    """A walk as one of the robot that holds no motors."""
    events = tuple(
        replace(event, equilibrium=_of_base(event.equilibrium, robot)) for event in walk.events
    )
    violation = walk.violation
    return replace(
        walk,
        last=_of_base(walk.last, robot),
        events=events,
        violation=None if violation is None else (violation[0], _of_base(violation[1], robot)),
    )

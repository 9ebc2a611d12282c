# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""An equilibrium of a robot of continuous rods."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..lie import quaternion_from_rotation
from ..model.robot import Robot
from ..validation import ReadOnlyArrays, cached_property
from .chain_balance import ChainBalance, ChainPoint, chain_balance, tip_joint
from .chain_robot import ChainRobot, chain_robot
from .chain_steps import ChainState, NodePlace, chain_steps, node_cuts
from .rod_integration import RodTrajectory
from .shooting_linearisation import Shooting
from .shooting_method import ShootingMethod
from .shooting_robot import ShootingUnits, check_robot, shooting_of

__all__ = ["ContinuousEquilibrium"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ContinuousEquilibrium(ReadOnlyArrays):
    """An equilibrium of a robot of continuous rods.

    Attributes:
        robot: The robot; its strain modes play no part.
        loads: Loads in force.
        motors: Motor positions q_a, (n,) [rad or m].
        passive: Passive joints, leg by leg, (P,) [rad or m].
        platform_rotation: R_p in the world, (3, 3).
        platform_position: p_p in the world, (3,) [m].
        base_wrenches: Moment [N m] and force [N] every leg exerts on its base, in the world, (L, 6).
        residual: Largest dimensionless gap or imbalance.
        iterations: Jacobians used.
        method: How it was found.
        nodes: States inside rods from which they are integrated anew.
    """

    robot: Robot
    loads: Loads
    motors: Floats
    passive: Floats
    platform_rotation: Floats
    platform_position: Floats
    base_wrenches: Floats
    residual: float
    iterations: int
    method: ShootingMethod
    nodes: Mapping[NodePlace, ChainState] = field(default_factory=dict)

    @property
    def platform_quaternion(self) -> Floats:
        """Orientation of the platform as a unit quaternion (w, x, y, z)."""
        return quaternion_from_rotation(self.platform_rotation)

    @cached_property
    def efforts(self) -> Floats:
        """Motor efforts tau_a on the legs, (n,) [N m or N]."""
        return self.balance.efforts[self.robot.motor_indices]

    @property
    def steps(self) -> int:
        """Integration steps along every rod."""
        return self.method.steps

    @cached_property
    def shooting(self) -> tuple[Shooting, ShootingUnits]:
        """The robot as the compiled shooting sees it, and its units.

        Raises:
            InvalidRequest: The compiled shooting does not know robots or loads of this kind.
        """
        check_robot(self.robot, self.loads)
        return shooting_of(self.robot, self.loads, self.method)

    @cached_property
    def model(self) -> ChainRobot:
        """The robot as it was integrated."""
        return chain_robot(self.robot, self.loads, self.method, node_cuts(self.nodes))

    @cached_property
    def point(self) -> ChainPoint:
        """All of it, with the multipliers of the tips' orientations that its moments tell."""
        values = np.zeros(self.robot.state_size)
        values[self.robot.motor_indices] = self.motors
        rotation, place = np.array(self.platform_rotation), np.array(self.platform_position)
        values[np.concatenate([leg.passive for leg in self.model.legs])] = self.passive
        for leg, wrench in zip(self.model.legs, self.base_wrenches, strict=True):
            if len(leg.moments):
                *_, last = chain_steps(leg, wrench, values, self.nodes)
                joint = tip_joint(leg, np.zeros(len(leg.moments)), rotation, last.after.frame)
                couple = -last.after.moment
                values[leg.moments] = np.linalg.lstsq(joint.axes.T, couple, rcond=None)[0]
        return ChainPoint(values, np.array(self.base_wrenches), rotation, place, self.nodes)

    @cached_property
    def balance(self) -> ChainBalance:
        """Gaps, imbalance and their derivative; legs from base to tip."""
        return chain_balance(self.model, self.point)

    @cached_property
    def rods(self) -> tuple[tuple[RodTrajectory, ...], ...]:
        """The parts of the rods of every leg from base to tip, with their variations."""
        return tuple(
            tuple(step.trajectory for step in steps if step.trajectory is not None)
            for steps in self.balance.legs
        )

    @cached_property
    def integration_error(self) -> float:
        """Largest gap or imbalance, dimensionless, when integrated with twice the steps."""
        method = replace(self.method, steps=2 * self.steps)
        model = chain_robot(self.robot, self.loads, method, node_cuts(self.nodes))
        return chain_balance(model, self.point).largest

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What has to vanish where a robot of chains is in equilibrium, with its exact derivative.

Leg by leg the gap between tip and platform, the constraints psi_k of the tip's orientation, the moment
at the tip, m + sum mu_k c_k = 0 with d psi_k = c_k . (dtheta - dOmega), and the spring laws of passive
joints; then the balance of the platform about its origin.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..lie import skew
from ..model.robot import Robot
from .chain_robot import ChainRobot, LegModel
from .chain_steps import ChainState, ChainStep, NodePlace, chain_steps, tip_of

__all__ = [
    "ChainBalance",
    "ChainPoint",
    "TipJoint",
    "chain_balance",
    "tip_joint",
    "variable_units",
]

Floats = NDArray[np.float64]


class ChainPoint(NamedTuple):
    """A robot, in equilibrium or not.

    Attributes:
        values: State in the order of the robot, (N,); passive joints, multipliers of orientations and
            motors are taken from it.
        wrenches: Moment and force the legs exert on their bases, in the world, (L, 6).
        rotation: Of the platform, (3, 3).
        position: Of the platform, (3,).
        nodes: States inside rods from which they are integrated anew (multiple shooting): where large
            forces make what comes far behind too sensitive to the base.
    """

    values: Floats
    wrenches: Floats
    rotation: Floats
    position: Floats
    nodes: Mapping[NodePlace, ChainState]


class TipJoint(NamedTuple):
    """Constraints of the orientation of a tip, as many as K.

    Attributes:
        psi: Their values, (K,).
        axes: c_k, (K, 3).
        twisted: N = sum mu_k N_k, (3, 3).
    """

    psi: Floats
    axes: Floats
    twisted: Floats

    @property
    def by_tip(self) -> Floats:
        """Derivative of sum mu_k c_k by turns of the tip, (3, 3)."""
        return self.twisted - np.trace(self.twisted) * np.eye(3)

    @property
    def by_platform(self) -> Floats:
        """Derivative of sum mu_k c_k by turns of the platform, (3, 3)."""
        return np.trace(self.twisted) * np.eye(3) - self.twisted.T


@dataclass(frozen=True, eq=False)
class ChainBalance:
    """What has to vanish, in natural units.

    Attributes:
        residual: (M,).
        jacobian: By the state, the base wrenches of all legs and the nodes, (M, N + 6 L + 12 K).
        legs: The steps along every leg.
        efforts: By state index, (N,) [N m or N]: of motors, and what passive joints lack.
    """

    residual: Floats
    jacobian: Floats
    legs: tuple[list[ChainStep], ...]
    efforts: Floats

    @property
    def largest(self) -> float:
        """Largest gap or imbalance; infinite where something is not finite."""
        largest = float(np.abs(self.residual).max())
        return largest if np.isfinite(self.residual.sum()) else np.inf


def tip_joint(leg: LegModel, mu: Floats, rotation: Floats, tip: Floats) -> TipJoint:
    """Constraints of the orientation of a tip.

    Args:
        leg: The leg.
        mu: Their multipliers, (K,) [N m].
        rotation: Of the platform, (3, 3).
        tip: Frame of the tip, (3, 3).
    """
    products = np.array([tip @ (rotation @ m).T for m in leg.conditions]).reshape(-1, 3, 3)  # N_k
    psi = np.trace(products, axis1=1, axis2=2)
    skewed = products - np.swapaxes(products, 1, 2)  # of v w^T: v x w
    axes = np.column_stack([skewed[:, 1, 2], skewed[:, 2, 0], skewed[:, 0, 1]])
    return TipJoint(psi, axes, np.tensordot(mu, products, 1))


def _platform_wrench(robot: Robot, loads: Loads, rotation: Floats) -> tuple[Floats, Floats]:
    """Wrench of the loads on the platform about its origin, (6,), and its derivative by turns."""
    weight = robot.description.platform_mass * loads.gravity
    center = rotation @ robot.description.center_of_mass
    couple, push = rotation @ loads.wrench_body[:3], rotation @ loads.wrench_body[3:]
    wrench = np.concatenate(
        [
            skew(center) @ weight + loads.wrench_world[:3] + couple,
            weight + loads.wrench_world[3:] + push,
        ]
    )
    turned = np.vstack([skew(weight) @ skew(center) - skew(couple), -skew(push)])
    return wrench, turned


def _node_units(model: ChainRobot) -> Floats:
    length, energy = model.robot.mean_length, model.robot.numbers.energy_unit
    return np.repeat([length, 1.0, energy, energy / length], 3)


def variable_units(model: ChainRobot, nodes: int) -> Floats:
    """Natural units of the state, the base wrenches and so many nodes, (N + 6 L + 12 K,)."""
    own = _node_units(model)
    return np.concatenate(
        [model.robot.numbers.unit, np.tile(own[6:], len(model.legs)), np.tile(own, nodes)]
    )


def _jump(
    reached: ChainState, node: ChainState, motion: Floats, anew: Floats
) -> tuple[Floats, Floats]:
    """What a rod misses a node by, (12,), and its derivative; both motions are (12, ...)."""
    turn = reached.frame @ node.frame.T
    skewed, trace = turn.T - turn, np.trace(turn) * np.eye(3)
    jump = np.concatenate(
        [
            reached.position - node.position,
            0.5 * np.array([skewed[1, 2], skewed[2, 0], skewed[0, 1]]),
            reached.moment - node.moment,
            reached.force - node.force,
        ]
    )
    slope = motion - anew
    slope[3:6] = 0.5 * ((trace - turn) @ motion[3:6] - (trace - turn.T) @ anew[3:6])
    return jump, slope


class _Way(NamedTuple):
    """From the base of a leg to its tip.

    Attributes:
        steps: Along the leg.
        motion: Of the tip by all variables, (12, V): position, turn, moment, force.
        gaps: At every node the rod misses, and its derivative, dimensionless.
        efforts: By state index, (N,) [N m or N].
        by_all: Their derivative by all variables, (N, V).
    """

    steps: list[ChainStep]
    motion: Floats
    gaps: list[tuple[Floats, Floats]]
    efforts: Floats
    by_all: Floats


def chain_balance(model: ChainRobot, point: ChainPoint) -> ChainBalance:
    """Residual and derivative at a point."""
    robot, numbers = model.robot, model.robot.numbers
    units = variable_units(model, len(point.nodes))
    twist = np.zeros((6, len(units)))
    twist[robot.platform_axes, numbers.platform_index + np.arange(len(robot.platform_axes))] = 1.0
    wrench, turned = _platform_wrench(robot, model.loads, point.rotation)
    wrench_by_all = turned @ twist[:3]
    parts: list[tuple[Floats, Floats]] = []
    legs, efforts = [], np.zeros(len(numbers.unit))
    for number, leg in enumerate(model.legs):
        way = _way_to_tip(model, point, number, len(units))
        legs.append(way.steps)
        efforts += way.efforts
        tip, motion = tip_of(leg, point.wrenches[number], way.steps), way.motion
        parts += way.gaps + _at_tip(model, point, leg, tip, motion, twist)
        unit = numbers.unit[leg.passive] / numbers.energy_unit
        parts.append((way.efforts[leg.passive] * unit, way.by_all[leg.passive] * unit[:, None]))
        arm = point.rotation @ leg.tip
        wrench = wrench - np.concatenate([tip.moment + skew(arm) @ tip.force, tip.force])
        of_moment = motion[6:9] + skew(arm) @ motion[9:]
        wrench_by_all[:3] -= of_moment + skew(tip.force) @ skew(arm) @ twist[:3]
        wrench_by_all[3:] -= motion[9:]
    axes = robot.platform_axes
    parts.append(
        ((wrench / robot.wrench_units)[axes], (wrench_by_all / robot.wrench_units[:, None])[axes])
    )
    residual, slopes = (np.concatenate(blocks) for blocks in zip(*parts, strict=True))
    return ChainBalance(residual, slopes * units, tuple(legs), efforts)


def _way_to_tip(model: ChainRobot, point: ChainPoint, number: int, variables: int) -> _Way:
    """What all variables do to a leg, from its base on."""
    leg, size = model.legs[number], len(model.robot.numbers.unit)
    column_of = {place: column for column, place in enumerate(point.nodes)}
    node_units = _node_units(model)
    motion = np.zeros((12, variables))
    motion[6:, size + 6 * number : size + 6 * number + 6] = np.eye(6)
    way = _Way([], motion, [], np.zeros(size), np.zeros((size, variables)))
    for step in chain_steps(leg, point.wrenches[number], point.values, point.nodes):
        way.steps.append(step)
        if step.node is not None and step.reached is not None:
            anew = np.zeros_like(motion)
            first = size + 6 * len(model.legs) + 12 * column_of[step.node]
            anew[:, first : first + 12] = np.eye(12)
            jump, slope = _jump(step.reached, step.before, motion, anew)
            gap = (jump / node_units)[model.in_chain]
            way.gaps.append((gap, (slope / node_units[:, None])[model.in_chain]))
            motion = anew
        if step.index is not None:
            way.efforts[step.index] += step.gradient
            way.by_all[step.index] += step.row @ motion
            way.by_all[step.index, step.index] += step.stiffness
        motion = step.transition @ motion
        if step.index is not None:
            motion[:, step.index] += step.column
    return way._replace(motion=motion)


def _at_tip(
    model: ChainRobot,
    point: ChainPoint,
    leg: LegModel,
    tip: ChainState,
    motion: Floats,
    twist: Floats,
) -> list[tuple[Floats, Floats]]:
    """What the joint between a tip and the platform asks for: place, orientation and couple."""
    robot, energy = model.robot, model.robot.numbers.energy_unit
    turns, plane = ([2], [0, 1]) if robot.planar else ([0, 1, 2], [0, 1, 2])
    arm = point.rotation @ leg.tip
    joint = tip_joint(leg, point.values[leg.moments], point.rotation, tip.frame)
    gap = (tip.position - point.position - arm)[plane] / robot.mean_length
    gap_by_all = (motion[:3] - twist[3:] + skew(arm) @ twist[:3])[plane] / robot.mean_length
    turned = joint.axes @ (motion[3:6] - twist[:3])
    couple = tip.moment + point.values[leg.moments] @ joint.axes
    couple_by_all = joint.by_tip @ motion[3:6] + joint.by_platform @ twist[:3] + motion[6:9]
    couple_by_all[:, leg.moments] += joint.axes.T
    return [
        (gap, gap_by_all),
        (joint.psi, turned),
        (couple[turns] / energy, couple_by_all[turns] / energy),
    ]

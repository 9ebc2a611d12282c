# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From the base of a leg to its tip, element by element, with exact variations.

Every joint, link and part of a rod carries on a state (p, R, m, n) and its variations
w = (dp, dtheta, dm, dn); (m, n) is the wrench that all beyond exerts on all before, about p. With dq of
its coordinate

    w_after = T w + t dq,        dg = r . w + kappa dq,

where g is what the energy gains with q: k (q - rest) - axis . m of a turn, k (q - rest) - axis . n of a
shift, the integral (c) of ``rod_integration`` of a rod that is fed. It vanishes where the joint is
passive and is the effort of its motor otherwise.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.chain import ChainJoint, Link, Turn
from ..lie import rotation_exp, skew
from .chain_robot import FedRod, LegModel, RodModel, RodPart
from .rod_integration import (
    RodTrajectory,
    force,
    frame,
    integrate_part,
    length_variation,
    moment,
    position,
    transition,
)

__all__ = ["ChainState", "ChainStep", "NodePlace", "chain_steps", "node_cuts", "tip_of"]

Floats = NDArray[np.float64]
#: Number of a rod in the robot, and s/l.
NodePlace = tuple[int, float]

#: Rows of dp, dtheta, dm, dn.
_P, _TURN, _M, _N = (slice(3 * i, 3 * i + 3) for i in range(4))


def _none() -> Floats:
    return np.zeros(12)


class ChainState(NamedTuple):
    """A place of a leg: position, frame, and the wrench the part beyond exerts on the part before."""

    position: Floats
    frame: Floats
    moment: Floats
    force: Floats


@dataclass(frozen=True, eq=False)
class ChainStep:
    """What an element does.

    Attributes:
        before, after: States.
        transition: T, (12, 12).
        index: State index of its coordinate; None: it has none.
        column: t, (12,).
        gradient: g, times the way of the joint per way of its coordinate [N m or N].
        row: r, (12,).
        stiffness: kappa.
        trajectory: The part of a rod it is; None: rigid.
        rod: Number of that rod in the robot.
        node: Where it begins at a node, its place.
        reached: State in front of that node.
    """

    before: ChainState
    after: ChainState
    transition: Floats
    index: int | None = None
    column: Floats = field(default_factory=_none)
    gradient: float = 0.0
    row: Floats = field(default_factory=_none)
    stiffness: float = 0.0
    trajectory: RodTrajectory | None = None
    rod: int | None = None
    node: NodePlace | None = None
    reached: ChainState | None = None


def chain_steps(
    leg: LegModel, wrench: Floats, values: Floats, nodes: Mapping[NodePlace, ChainState]
) -> Iterator[ChainStep]:
    """A leg from its base to its tip.

    Args:
        leg: The leg.
        wrench: Moment [N m] and force [N] it exerts on its base, in the world, (6,).
        values: State of the robot, (N,); coordinates of joints and lengths are taken from it.
        nodes: States from which rods go on, whatever is reached there.
    """
    state = ChainState(leg.base_position, leg.base_rotation, wrench[:3], wrench[3:])
    for element, index in leg.elements:
        value = 0.0 if index is None else float(values[index])
        if isinstance(element, RodModel):
            for step in _rod_steps(element, state, index, value, nodes):
                yield step
                state = step.after
            continue
        if isinstance(element, Link):
            step = _link(element, leg.gravity, state)
        elif isinstance(element, Turn):
            step = _turn(element, state, index, value)
        else:
            step = _shift(element, state, index, value)
        yield step
        state = step.after


def node_cuts(nodes: Iterable[NodePlace]) -> dict[int, list[float]]:
    """Where rods have to be cut so that parts begin at nodes: s/l by number of the rod."""
    cuts: dict[int, list[float]] = {}
    for rod, sigma in nodes:
        cuts.setdefault(rod, []).append(sigma)
    return cuts


def tip_of(leg: LegModel, wrench: Floats, steps: list[ChainStep]) -> ChainState:
    """State at the tip of a leg; at its base if it has no element."""
    if steps:
        return steps[-1].after
    return ChainState(leg.base_position, leg.base_rotation, wrench[:3], wrench[3:])


def _turn(joint: ChainJoint, before: ChainState, index: int | None, value: float) -> ChainStep:
    """The axis is the same before and behind."""
    axis = before.frame @ joint.axis
    way = joint.zero + joint.ratio * value
    across = skew(axis)
    turn = rotation_exp(way * axis)
    column, row = np.zeros(12), np.zeros(12)
    column[_TURN] = joint.ratio * axis
    row[_M] = -joint.ratio * axis
    row[_TURN] = -joint.ratio * across @ before.moment
    return ChainStep(
        before,
        before._replace(frame=turn @ before.frame),
        np.eye(12),
        index=index,
        column=column,
        gradient=joint.stiffness * (value - joint.rest) - joint.ratio * float(axis @ before.moment),
        row=row,
        stiffness=joint.stiffness,
    )


def _shift(joint: ChainJoint, before: ChainState, index: int | None, value: float) -> ChainStep:
    axis = before.frame @ joint.axis
    across = skew(axis) @ before.force
    way = (joint.zero + joint.ratio * value) * axis
    after, matrix = _led(before, way, before.force)
    column, row = np.zeros(12), np.zeros(12)
    column[_P] = joint.ratio * axis
    column[_M] = -joint.ratio * across
    row[_N] = -joint.ratio * axis
    row[_TURN] = -joint.ratio * across
    return ChainStep(
        before,
        after,
        matrix,
        index=index,
        column=column,
        gradient=joint.stiffness * (value - joint.rest) - joint.ratio * float(axis @ before.force),
        row=row,
        stiffness=joint.stiffness,
    )


def _link(link: Link, gravity: Floats, before: ChainState) -> ChainStep:
    """The link weighs at its centre: m' = m - d x n' - c x weight, n' = n - weight."""
    weight, center = link.mass * gravity, before.frame @ link.center_of_mass
    after, matrix = _led(before, before.frame @ link.offset, before.force - weight)
    after = after._replace(
        moment=after.moment - skew(center) @ weight, frame=before.frame @ link.rotation
    )
    matrix[_M, _TURN] += skew(weight) @ skew(-center)
    return ChainStep(before, after, matrix)


def _led(before: ChainState, way: Floats, beyond: Floats) -> tuple[ChainState, Floats]:
    """To another point of the same rigid piece, where the force ``beyond`` acts."""
    matrix = np.eye(12)
    back = skew(-way)
    matrix[_P, _TURN] = matrix[_M, _N] = back  # dtheta x d, -d x dn
    matrix[_M, _TURN] = skew(beyond) @ back  # -(dtheta x d) x n
    after = ChainState(before.position + way, before.frame, before.moment + back @ beyond, beyond)
    return after, matrix


def _rod_steps(
    rod: RodModel,
    before: ChainState,
    index: int | None,
    value: float,
    nodes: Mapping[NodePlace, ChainState],
) -> Iterator[ChainStep]:
    length, state, ratio = rod.length, before, rod.element.ratio
    if rod.fed is not None:
        length = rod.fed.rod.length_at(value)
        step = _by_motor(_feed(rod.fed, before, index, length), ratio)
        yield step
        state = step.after
    for part in rod.parts:
        place = (rod.number, part.begin)
        step = _rod_part(rod, part, nodes.get(place, state), before.position, length, index)
        step = _by_motor(step, ratio)
        if place in nodes:
            step = replace(step, node=place, reached=state)
        yield step
        state = step.after


def _by_motor(step: ChainStep, ratio: float) -> ChainStep:
    """A step whose derivatives are by the length of its rod, by the motor that feeds it."""
    if step.index is None or ratio == 1.0:
        return step
    return replace(
        step,
        column=ratio * step.column,
        gradient=ratio * step.gradient,
        row=ratio * step.row,
        stiffness=ratio**2 * step.stiffness,
    )


def _feed(fed: FedRod, before: ChainState, index: int | None, length: float) -> ChainStep:
    """What has not come out weighs where the rod begins; (c) leaves its work to the place of that."""
    weight = (fed.nominal - length) * fed.force
    column, row = np.zeros(12), np.zeros(12)
    column[_N] = row[_P] = fed.force
    return ChainStep(
        before,
        before._replace(force=before.force - weight),
        np.eye(12),
        index=index,
        column=column,
        row=row,
    )


def _rod_part(
    rod: RodModel,
    part: RodPart,
    before: ChainState,
    origin: Floats,
    length: float,
    index: int | None,
) -> ChainStep:
    start = before._replace(force=before.force - part.push)
    whole = integrate_part(start, rod.properties, length, part.tables, origin)
    end = whole.states[-1]
    after = ChainState(position(end), frame(end), moment(end), force(end))
    if index is None:
        return ChainStep(before, after, transition(end), trajectory=whole, rod=rod.number)
    column, effort, later, stiffness = length_variation(end)
    # What has come out is lifted with the part: its weight by l is that of the part over l.
    lifted = (after.force - start.force) / length
    row = np.concatenate([lifted, later])
    return ChainStep(
        before,
        after,
        transition(end),
        index=index,
        column=column,
        gradient=effort,
        row=row,
        stiffness=stiffness,
        trajectory=whole,
        rod=rod.number,
    )

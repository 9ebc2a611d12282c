# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the shooting of chains starts: what an equilibrium of strain modes tells of continuous rods."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..description.chain import Link, Turn
from ..model.equilibrium import Equilibrium
from .chain_balance import ChainPoint, tip_joint
from .chain_robot import ChainRobot, LegModel, RodModel
from .chain_steps import ChainState, NodePlace

__all__ = ["rough_point"]

Floats = NDArray[np.float64]

#: Cells of a rod; small rotations from middle to middle are plenty for a start.
_CELLS = 40
#: Wave number of the force times length of the longest part of a rod that is shot along at once.
_LONGEST = 6.0


class _RoughRod(NamedTuple):
    """A rod in the world, and the number of forces that act in front of it."""

    rod: RodModel
    position: Floats  # ends of the cells, (cells + 1, 3)
    frame: Floats  # ends of the cells, (cells + 1, 3, 3)
    moment: Floats  # in the world, (cells + 1, 3)
    length: float
    forces: int


def rough_point(model: ChainRobot, equilibrium: Equilibrium) -> ChainPoint:
    """The state as it is; wrenches by statics about its shape; nodes in rods under large forces."""
    robot, values = model.robot, np.array(equilibrium.state)
    rotation = np.array(equilibrium.platform_rotation)
    wrenches = np.zeros((len(model.legs), 6))
    nodes: dict[NodePlace, ChainState] = {}
    for number, leg in enumerate(model.legs):
        tip_force = np.zeros(3)
        tip_force[robot.kernel_arrays.position_axes] = values[robot.numbers.legs[number].forces]
        strains = [values[rod.strain] for rod in robot.numbers.legs[number].rods]
        wrenches[number], own = _rough_leg(leg, values, strains, tip_force, rotation)
        nodes |= own
    place = np.array(equilibrium.platform_position)
    return ChainPoint(values, wrenches, rotation, place, nodes)


def _rough_leg(
    leg: LegModel, values: Floats, strains: list[Floats], tip_force: Floats, rotation: Floats
) -> tuple[Floats, dict[NodePlace, ChainState]]:
    """Base wrench from the tip's force and moment and all weights, (6,) [N m, N], and nodes."""
    place, frame = leg.base_position, leg.base_rotation
    places: list[Floats] = []
    pushes: list[Floats] = []
    rods: list[_RoughRod] = []

    def push(at: Floats, force: Floats) -> None:
        places.extend(np.atleast_2d(at))
        pushes.extend(np.atleast_2d(force))

    for element, index in leg.elements:
        value = 0.0 if index is None else float(values[index])
        if isinstance(element, RodModel):
            length = element.length if element.fed is None else element.fed.rod.length_at(value)
            if element.fed is not None:
                push(place, (element.fed.nominal - length) * element.fed.force)
            rod = _rough_rod(element, strains[len(rods)], length, place, frame, len(places))
            rods.append(rod)
            middles = 0.5 * (rod.position[1:] + rod.position[:-1])
            sigma = (np.arange(_CELLS) + 0.5) / _CELLS
            push(middles, element.properties.force(sigma) * length / _CELLS)
            for part in element.parts:
                push(rod.position[round(part.begin * _CELLS)], part.push)
            place, frame = rod.position[-1], rod.frame[-1]
        elif isinstance(element, Link):
            push(place + frame @ element.center_of_mass, element.mass * leg.gravity)
            place, frame = place + frame @ element.offset, frame @ element.rotation
        else:
            way = (element.zero + element.ratio * value) * np.array(element.axis)
            if isinstance(element, Turn):
                frame = frame @ Rotation.from_rotvec(way).as_matrix()
            else:
                place = place + frame @ way
    push(place, tip_force)
    mu = values[leg.moments]
    couple = -mu @ tip_joint(leg, mu, rotation, frame).axes
    forces = np.array(pushes)
    arms = np.array(places) - leg.base_position
    wrench = np.concatenate([couple + np.cross(arms, forces).sum(axis=0), forces.sum(axis=0)])
    nodes: dict[NodePlace, ChainState] = {}
    for rod in rods:
        nodes |= _nodes(rod, forces)
    return wrench, nodes


def _rough_rod(
    rod: RodModel, strain: Floats, length: float, place: Floats, frame: Floats, forces: int
) -> _RoughRod:
    modes, sigma = rod.element.modes, np.arange(2 * _CELLS + 1) / (2 * _CELLS)
    nominal = modes.strain_at(sigma, strain) + rod.element.rod.rest_beyond_at(modes, sigma)
    turns = Rotation.from_rotvec(0.5 * nominal[1::2] * rod.length / _CELLS).as_matrix()
    positions, frames = np.empty((_CELLS + 1, 3)), np.empty((_CELLS + 1, 3, 3))
    positions[0], frames[0] = place, frame
    for cell, half in enumerate(turns):
        middle = frames[cell] @ half
        positions[cell + 1] = positions[cell] + length / _CELLS * middle[:, 0]
        frames[cell + 1] = middle @ half
    ends = sigma[::2]
    elastic = nominal[::2] * rod.length / length - rod.properties.rest_curvature(ends)
    moments = np.einsum("kij,kj->ki", frames, elastic / rod.properties.compliance(ends))
    return _RoughRod(rod, positions, frames, moments, length, forces)


def _nodes(rod: _RoughRod, forces: Floats) -> dict[NodePlace, ChainState]:
    """Nodes so near to each other that errors do not grow much in between."""
    sigma = np.arange(_CELLS + 1) / _CELLS
    compliance = float(rod.rod.properties.compliance(sigma).max())
    beyond = forces[rod.forces :].sum(axis=0)
    waves = np.sqrt(compliance * np.linalg.norm(beyond)) * rod.length
    parts = min(int(np.ceil(waves / _LONGEST)), _CELLS // 2)
    nodes = {}
    for cell in {round(_CELLS * part / parts) for part in range(1, parts)}:
        force = forces[rod.forces + cell :].sum(axis=0)
        node = ChainState(rod.position[cell], rod.frame[cell], rod.moment[cell], force)
        nodes[rod.rod.number, cell / _CELLS] = node
    return dict(sorted(nodes.items()))

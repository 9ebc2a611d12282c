# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rods by themselves: where evenly spaced points of them are, seen from their own bases."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.chain import ChainRod
from ..kernels.rotation_kernel import rotation_steps
from ..lie import rotations_exp
from ..rods.quadrature import MAGNUS_WEIGHTS, RodGrid, integration_to, steps_to
from ..rods.rod import StrainModes
from .robot import Robot

__all__ = ["RodShape", "rod_curvatures", "rods_from_identity"]

Floats = NDArray[np.float64]


class RodShape(NamedTuple):
    """A rod that begins at the origin along the axes of the world."""

    position: Floats  # (P, 3)
    rotation: Floats  # (P, 3, 3)
    length: float


def rods_from_identity(robot: Robot, state: Floats, points: int) -> list[RodShape]:
    """All rods at once, step by step, at evenly spaced points."""
    sampling, rods = _sampling(robot.grid, points), list(robot.numbers.rods)
    steps = sampling.steps
    moments = np.empty((len(rods), len(steps), 3, 3))
    for alike in robot.numbers.alike_rods:
        step_moments = _sampled(alike.modes, sampling).step_moments
        found = state[alike.strain] @ step_moments.reshape(len(step_moments), -1)
        moments[alike.numbers] = found.reshape(-1, len(steps), 3, 3)
    for number, rod in enumerate(rods):
        if not rod.element.modes.hold(rod.element.rod.rest_curvature):
            moments[number] += _at_rest_beyond(rod.element, sampling).step_moments
    nominal = np.array([rod.element.rod.length for rod in rods])
    turns = np.empty((len(rods) * len(steps), 3))
    rotation_steps(moments.reshape(-1, 3, 3), np.outer(nominal, steps).ravel(), turns)
    frames = _products(rotations_exp(turns.reshape(len(rods), -1, 3)))
    positions = sampling.integration @ frames[:, sampling.at_nodes][..., 0]
    lengths = [float(rod.length(state)) for rod in rods]
    return [
        RodShape(length * position, frame, length)
        for length, position, frame in zip(
            lengths, positions, frames[:, sampling.at_places], strict=True
        )
    ]


def rod_curvatures(robot: Robot, state: Floats, points: int) -> list[Floats]:
    """Strain of every rod (torsion, bending about d2, d3) at evenly spaced points, (P, 3) [1/m]."""
    sampling = _sampling(robot.grid, points)
    return [
        _sampled(rod.element.modes, sampling).values @ state[rod.strain] / rod.stretch(state)
        + _at_rest_beyond(rod.element, sampling).values
        for rod in robot.numbers.rods
    ]


def _products(turns: Floats) -> Floats:
    """The identity, and all products of the first rotations: (R, H, 3, 3) to (R, H + 1, 3, 3)."""
    found = np.concatenate([np.broadcast_to(np.eye(3), (len(turns), 1, 3, 3)), turns], axis=1)
    reach = 1  # every product is of so many
    while reach < found.shape[1]:
        found[:, reach:] = found[:, :-reach] @ found[:, reach:]
        reach *= 2
    return found


@dataclass(frozen=True, eq=False)
class _Sampling:
    """Points wanted of a rod, and how the quadrature of equilibria leads to them.

    Attributes:
        places: Where they are, as sigma, (P,).
        steps: Lengths of rotation steps from 0 to 1 that end at every node and every place, (H,).
        step_points: Points of every step, (H, 16).
        at_nodes: Steps up to every node of the quadrature, (K,).
        at_places: Steps up to every place, (P,).
        integration: From values at the nodes to integrals from 0 to the places, (P, K).
    """

    places: Floats
    steps: Floats
    step_points: Floats
    at_nodes: NDArray[np.int64]
    at_places: NDArray[np.int64]
    integration: Floats


@lru_cache(maxsize=64)
def _sampling(grid: RodGrid, points: int) -> _Sampling:
    places = np.linspace(0.0, 1.0, points)
    ends = np.union1d(grid.stops, places)  # of the steps, the origin before them
    return _Sampling(
        places,
        *steps_to(ends[1:]),
        np.searchsorted(ends, grid.nodes),
        np.searchsorted(ends, places),
        integration_to(places, grid.edges, grid.panel_nodes),
    )


class _Sampled(NamedTuple):
    """Shape functions of a rod where its shape is wanted."""

    step_moments: Floats  # (m, H, 3, 3): moments of the three strain components over rotation steps
    values: Floats  # (P, 3, m)


@lru_cache(maxsize=64)
def _sampled(modes: StrainModes, sampling: _Sampling) -> _Sampled:
    """They are the same for rods of the same modes, and in every configuration."""
    points, one_hot = sampling.step_points, np.eye(3)[modes.directions].T
    steps = modes.values(points.ravel()).reshape(*points.shape, modes.total)
    moments = np.einsum("mk,hkj,cj->jhmc", MAGNUS_WEIGHTS, steps, one_hot)
    return _Sampled(moments, modes.values(sampling.places)[:, None, :] * one_hot)


class _AtRest(NamedTuple):
    """Curvature at rest of a rod beyond its modes where its shape is wanted."""

    step_moments: Floats  # (H, 3, 3): its moments over rotation steps, by component
    values: Floats  # (P, 3)


@lru_cache(maxsize=64)
def _at_rest_beyond(element: ChainRod, sampling: _Sampling) -> _AtRest:
    """It is the same in every configuration."""
    rod, modes = element.rod, element.modes
    steps = rod.rest_beyond_steps(modes, sampling.step_points)
    return _AtRest(steps, rod.rest_beyond_at(modes, sampling.places))

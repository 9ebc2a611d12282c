# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Gauss-Legendre panels on [0, 1] with their integration matrix and the grid of the rotation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

__all__ = [
    "MAGNUS_WEIGHTS",
    "SAME_STATION",
    "RodGrid",
    "distinct_stations",
    "integration_to",
    "rod_grid",
    "steps_to",
]

Floats = NDArray[np.float64]

# The curvature of a rotation step enters by its moments. Sixteen points integrate them exactly up to
# degree 29, so that a rod that bends in a plane is turned exactly.
_POINTS, _WEIGHTS = 0.5 * np.array(legendre.leggauss(16))
#: (3, 16): from values at the points of a step to its moments, ``magnus`` in rotation_kernel.
MAGNUS_WEIGHTS = _WEIGHTS * np.array(
    [2.25 - 15.0 * _POINTS**2, 12.0 * _POINTS, 180.0 * _POINTS**2 - 15.0]
)

#: Stations s/l nearer to each other than this are one: 0.3 is 0.1 + 0.2, and the nodes of a panel
#: between them would coincide.
SAME_STATION = 1e-9


def distinct_stations(stations: Iterable[float]) -> tuple[float, ...]:
    """Interior stations s/l, increasing; of those that are one the first, none that is an end."""
    found = [0.0]
    for station in sorted(stations):
        if found[-1] + SAME_STATION <= station <= 1.0 - SAME_STATION:
            found.append(station)
    return tuple(found[1:])


@dataclass(frozen=True, eq=False)
class RodGrid:
    """Where a rod is evaluated, in normalised arc length sigma.

    Attributes:
        nodes: Quadrature nodes, increasing, shape (K,).
        weights: Quadrature weights, sum 1, shape (K,).
        integration: ``integration[k, j]``: weight of node j in the integral from 0 to node k, (K, K).
        panel_nodes: Nodes of every panel.
        edges: Where panels begin and end, from 0 to 1.
        stops: Where rotation steps end, from 0 to 1, shape (G,).
        steps: Their lengths, shape (G,).
        step_points: Points of every step, those of ``MAGNUS_WEIGHTS``, shape (G, 16).
        step_node: Node at which a step ends, or -1 (a breakpoint or the tip), shape (G,).
    """

    nodes: Floats
    weights: Floats
    integration: Floats
    panel_nodes: int
    edges: Floats
    stops: Floats
    steps: Floats
    step_points: Floats
    step_node: NDArray[np.int64]


@lru_cache(maxsize=128)
def rod_grid(
    nodes_per_panel: int, breakpoints: tuple[float, ...] = (), substeps: int = 1
) -> RodGrid:
    """Panels of Gauss-Legendre nodes between breakpoints.

    The integration matrix is spectral: it integrates exactly, from 0 to each node, whatever is a
    polynomial of degree below ``nodes_per_panel`` on every panel. Rotations go from node to node in
    ``substeps``. Breakpoints are ``distinct_stations``. Robots that differ in their numbers share one;
    it is never to be written.
    """
    edges = np.array(sorted({0.0, 1.0, *breakpoints}))
    reference, _ = legendre.leggauss(nodes_per_panel)
    nodes = (edges[:-1, None] + 0.5 * np.outer(np.diff(edges), reference + 1.0)).ravel()
    stops = np.array(sorted({*edges[1:], *nodes}))
    starts = np.concatenate([[0.0], stops[:-1]])
    parts = np.arange(1.0, substeps) / substeps
    between = starts[:, None] + (stops - starts)[:, None] * parts
    stops = np.column_stack([between, stops]).ravel()
    steps, step_points = steps_to(stops)
    integrals = integration_to(np.append(nodes, 1.0), edges, nodes_per_panel)
    node_at = {sigma: index for index, sigma in enumerate(nodes)}
    return RodGrid(
        nodes=nodes,
        weights=integrals[-1],
        integration=integrals[:-1],
        panel_nodes=nodes_per_panel,
        edges=edges,
        stops=stops,
        steps=steps,
        step_points=step_points,
        step_node=np.array([node_at.get(stop, -1) for stop in stops], dtype=np.int64),
    )


def steps_to(stops: Floats) -> tuple[Floats, Floats]:
    """Lengths of rotation steps that end at ``stops`` (G,), and the points of every step, (G, 16)."""
    starts = np.concatenate([[0.0], stops[:-1]])
    steps = stops - starts
    return steps, starts[:, None] + steps[:, None] * (0.5 + _POINTS)


def integration_to(sigma: Floats, edges: Floats, nodes_per_panel: int) -> Floats:
    """Weights of the nodes of panels in the integrals from 0 to some places, (len(sigma), K)."""
    reference, weights = legendre.leggauss(nodes_per_panel)
    # Integrals from -1 of the Lagrange polynomials of the nodes.
    coefficients = np.linalg.inv(legendre.legvander(reference, nodes_per_panel - 1))
    antiderivatives = legendre.legint(np.eye(nodes_per_panel), lbnd=-1.0, axis=0)
    found = np.zeros((len(sigma), len(edges) - 1, nodes_per_panel))
    for panel, (start, end) in enumerate(pairwise(edges)):
        half, inside = 0.5 * (end - start), (start < sigma) & (sigma < end)
        local = (sigma[inside] - start) / half - 1.0
        found[inside, panel] = half * legendre.legval(local, antiderivatives).T @ coefficients
        found[sigma >= end, panel] = half * weights
    return found.reshape(len(sigma), -1)

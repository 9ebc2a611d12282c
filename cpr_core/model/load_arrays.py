# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Loads as the kernels see them, for one robot."""

from __future__ import annotations

import numpy as np

from ..description.loads import Loads
from ..description.robot_description import RobotDescription
from ..errors import InvalidRequest
from ..kernels.kernel_arrays import PLATFORM_LOADS, LoadArrays
from ..kernels.twist_layout import ANGULAR, LINEAR
from ..rods.quadrature import SAME_STATION
from .discretised_robot import DiscretisedRobot

__all__ = ["load_arrays"]


def load_arrays(robot: DiscretisedRobot, loads: Loads) -> LoadArrays:
    """Loads as arrays; forces on rods may begin, end and bend at the robot's ``breakpoints``.

    Raises:
        InvalidRequest: No loads, loads that leave the plane of a planar robot, or forces on rods or at
            stations that there are not.
    """
    if not isinstance(loads, Loads):
        raise InvalidRequest(
            "loads",
            f"expected Loads, as robot.default_loads.with_(...) makes them, got {loads!r:.200}",
        )
    description, grid = robot.description, robot.grid
    if robot.planar:
        _check_planar(description, loads)
    rods, nodes = description.rods, len(grid.nodes)
    density = np.empty((len(rods), nodes, 3))
    point = np.zeros((len(rods), nodes + 1, 3))
    masses = {id(element.rod): element.rod for element in rods}
    mass_at = {key: rod.mass_at(grid.nodes)[:, None] for key, rod in masses.items()}
    for number, element in enumerate(rods):
        density[number] = mass_at[id(element.rod)] * loads.gravity + loads.rod_force
    for distributed in loads.distributed:
        _check_stations("distributed", robot.breakpoints, distributed.at[1:-1].tolist())
        rod = _rod_of("distributed", robot.rod_names, distributed.leg)
        for axis in range(3):
            along = np.interp(grid.nodes, distributed.at, distributed.force[:, axis])
            density[rod, :, axis] += along
    for force in loads.points:
        _check_stations("points", robot.breakpoints, [force.at])
        before = np.append(grid.nodes < force.at, True)
        point[_rod_of("points", robot.rod_names, force.leg), before] += force.force
    # Integrals from a node to the tip; the last entry is the one from the base.
    beyond = np.vstack([grid.weights - grid.integration, grid.weights])
    platform = np.zeros(1, PLATFORM_LOADS)
    platform["weight"] = description.platform_mass * loads.gravity
    platform["center_of_mass"] = description.center_of_mass
    platform["moment_world"] = loads.wrench_world[ANGULAR]
    platform["force_world"] = loads.wrench_world[LINEAR]
    platform["moment_body"] = loads.wrench_body[ANGULAR]
    platform["force_body"] = loads.wrench_body[LINEAR]
    return LoadArrays(
        gravity=np.array(loads.gravity, float),
        distributed=np.ascontiguousarray(np.swapaxes(beyond @ density, 1, 2)),
        point=np.ascontiguousarray(np.swapaxes(point, 1, 2)),
        on_rods=np.array([float(density.any() or point.any())]),
        platform=platform,
    )


def _rod_of(load: str, rod_names: tuple[str, ...], name: str) -> int:
    """Number of a rod among all."""
    if not isinstance(name, str) or name not in rod_names:
        raise InvalidRequest(load, f"expected a leg out of {', '.join(rod_names)}, got {name!r}")
    return rod_names.index(name)


def _check_stations(load: str, stations: tuple[float, ...], at: list[float]) -> None:
    for station in at:
        if not any(abs(station - known) < SAME_STATION for known in (0.0, *stations, 1.0)):
            raise InvalidRequest(
                load,
                f"expected a station of the robot "
                f"({', '.join(map(str, stations)) or 'it has none'}), got {station}; "
                "name it under `stations` in the description",
            )


def _check_planar(description: RobotDescription, loads: Loads) -> None:
    for name in ("gravity", "rod_force"):
        vector = getattr(loads, name)
        if vector[2] != 0.0:
            raise InvalidRequest(name, f"expected z = 0 for a planar robot, got {vector[2]:g}")
    for name in ("wrench_world", "wrench_body"):
        mx, my, mz, _, _, fz = getattr(loads, name)
        if mx != 0.0 or my != 0.0 or fz != 0.0:
            raise InvalidRequest(name, "expected mx = my = fz = 0 for a planar robot")
        if mz != 0.0 and description.point_platform:
            raise InvalidRequest(name, "expected mz = 0: a point platform takes no moment")
    for name, forces in (("distributed", loads.distributed), ("points", loads.points)):
        if any(np.any(np.atleast_2d(force.force)[:, 2]) for force in forces):
            raise InvalidRequest(name, "expected z = 0 for a planar robot")

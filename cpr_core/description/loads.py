# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What acts on the robot from outside."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidRequest
from ..validation import cached_property, checked_number, checked_vector, read_only

__all__ = ["WRENCH_NAMES", "DistributedForce", "Loads", "PointForce"]

Floats = NDArray[np.float64]

#: Of the numbers of a wrench, in their order.
WRENCH_NAMES = ("mx", "my", "mz", "fx", "fy", "fz")


#: Vectors of loads: how many numbers, and what they mean.
_VECTORS = {
    "gravity": (3, "x y z in the world, m/s^2"),
    "rod_force": (3, "x y z in the world, N/m"),
    "wrench_world": (6, f"{' '.join(WRENCH_NAMES)}, N m and N"),
    "wrench_body": (6, f"{' '.join(WRENCH_NAMES)}, N m and N"),
}
_FLOAT = np.dtype(np.float64)


def _comparable(part: Any) -> Hashable:
    """What is equal of parts of loads that are: of numbers, names, and forces on rods."""
    if isinstance(part, np.ndarray):
        return (part + 0.0).tobytes()  # -0 is 0
    if isinstance(part, tuple):
        return tuple(map(_comparable, part))
    if isinstance(part, DistributedForce | PointForce):
        return type(part), *map(_comparable, vars(part).values())
    return part


def _kept(name: str, value: ArrayLike) -> Floats:
    """A vector that nobody else can write to: the same object where it is one already.

    Raises:
        InvalidRequest: No vector, or one of the wrong length.
        NonFiniteInput: A NaN or an infinity.
    """
    size, meaning = _VECTORS[name]
    if (
        type(value) is np.ndarray
        and value.base is None
        and not value.flags.writeable
        and value.dtype is _FLOAT
        and value.shape == (size,)
        and all(map(math.isfinite, value.tolist()))
    ):
        return value
    return checked_vector(name, value, size, meaning)


@dataclass(frozen=True, eq=False)
class DistributedForce:
    """Force per length on one rod, fixed in space, linear between stations.

    Attributes:
        leg: Name of the leg; of a leg with several rods that of the rod, such as ``leg2.rod1``.
        at: Stations in s/l, from 0 to 1, increasing, (P,). Interior ones must be stations of the robot.
        force: Force per length at the stations, in the world, (P, 3) [N/m].
    """

    leg: str
    at: Floats
    force: Floats

    def __post_init__(self) -> None:
        """Check the stations and that every one has a force.

        Raises:
            InvalidRequest: Stations that do not increase from 0 to 1, or other forces than one for each.
            NonFiniteInput: A NaN or an infinity.
        """
        stations = checked_vector(
            "distributed.at", self.at, np.size(self.at), "s/l from 0 to 1, increasing"
        )
        whole = len(stations) > 1 and stations[0] == 0.0 and stations[-1] == 1.0
        if not whole or not np.all(np.diff(stations) > 0.0):
            raise InvalidRequest(
                "distributed.at",
                f"expected stations s/l that increase from 0 to 1, got {stations.tolist()}",
            )
        rows = np.asarray(self.force, dtype=object)
        if rows.ndim == 0 or len(rows) != len(stations):
            raise InvalidRequest(
                "distributed.force",
                f"expected {len(stations)} vectors, one for every station, "
                f"got {len(rows) if rows.ndim else repr(self.force)[:200]}",
            )
        force = [
            checked_vector(f"distributed.force[{number}]", row, 3, "x y z in the world, N/m")
            for number, row in enumerate(self.force)
        ]
        object.__setattr__(self, "at", stations)
        object.__setattr__(self, "force", read_only(np.array(force)))


@dataclass(frozen=True, eq=False)
class PointForce:
    """Force on a point of one rod, fixed in space.

    Attributes:
        leg: Name of the leg; of a leg with several rods that of the rod, such as ``leg2.rod1``.
        at: Where, s/l in (0, 1); must be a station of the robot.
        force: In the world, (3,) [N].
    """

    leg: str
    at: float
    force: Floats

    def __post_init__(self) -> None:
        """Check where it is and the force.

        Raises:
            InvalidRequest: A place that is not on the rod, or not three numbers.
            NonFiniteInput: A NaN or an infinity.
        """
        place = checked_vector("points.at", np.atleast_1d(self.at), 1, "s/l between 0 and 1")
        if not 0.0 < place[0] < 1.0:
            raise InvalidRequest("points.at", f"expected s/l between 0 and 1, got {self.at}")
        force = checked_vector("points.force", self.force, 3, "x y z in the world, N")
        object.__setattr__(self, "at", float(place[0]))
        object.__setattr__(self, "force", force)


@dataclass(frozen=True, eq=False, repr=False)
class Loads:
    """External loads. Wrenches stack moment [N m] over force [N] and act at the platform origin P.

    A request takes all loads there are: ``robot.default_loads.with_(...)`` keeps those of the
    description, gravity among them.

    Attributes:
        gravity: Acceleration in the world, on rods and platform, shape (3,) [m/s^2].
        rod_force: Uniform force per length on every rod, fixed in space, shape (3,) [N/m].
        wrench_world: Platform wrench fixed in space, shape (6,). Its moment is not conservative, but for
            planar robots.
        wrench_body: Platform wrench that turns with the platform, shape (6,); not conservative.
        distributed: Forces per length on single rods.
        points: Forces on points of rods.

    Vectors may be given in any form, forces as any sequence; kept are copies that cannot be written to.
    """

    gravity: Floats
    rod_force: Floats
    wrench_world: Floats
    wrench_body: Floats
    distributed: tuple[DistributedForce, ...] = ()
    points: tuple[PointForce, ...] = ()

    def __post_init__(self) -> None:
        """Check all parts, and copy what others may change: what is found for loads is kept with them.

        Raises:
            InvalidRequest: A vector of the wrong length, or no forces.
            NonFiniteInput: A NaN or an infinity.
        """
        for name in _VECTORS:
            given = getattr(self, name)
            kept = _kept(name, given)
            if kept is not given:
                object.__setattr__(self, name, kept)
        for name, kind in (("distributed", DistributedForce), ("points", PointForce)):
            forces = getattr(self, name)
            if not isinstance(forces, Sequence) or not all(
                isinstance(force, kind) for force in forces
            ):
                raise InvalidRequest(
                    name, f"expected a sequence of {kind.__name__}, got {forces!r:.200}"
                )
            if type(forces) is not tuple:
                object.__setattr__(self, name, tuple(forces))

    def __repr__(self) -> str:
        parts = [
            f"{name}={getattr(self, name).tolist()}"
            for name in _VECTORS
            if getattr(self, name).any()
        ]
        for name in ("distributed", "points"):
            legs = [force.leg for force in getattr(self, name)]
            parts += [f"{name} on {' '.join(legs)}"] if legs else []
        return f"<Loads: {', '.join(parts) or 'none'}>"

    @classmethod
    def none(cls) -> Loads:
        """No load at all, gravity neither: ``robot.default_loads`` has that of the description."""
        return cls(np.zeros(3), np.zeros(3), np.zeros(6), np.zeros(6))

    def with_(
        self,
        *,
        gravity: ArrayLike | None = None,
        rod_force: ArrayLike | None = None,
        wrench_world: ArrayLike | None = None,
        wrench_body: ArrayLike | None = None,
        distributed: Sequence[DistributedForce] | None = None,
        points: Sequence[PointForce] | None = None,
    ) -> Loads:
        """The same loads with some replaced, each as a whole; those not named stay as they are.

        Raises:
            InvalidRequest: A vector of the wrong length, or no forces.
            NonFiniteInput: A NaN or an infinity.
        """
        given: dict[str, Any] = {
            "gravity": gravity,
            "rod_force": rod_force,
            "wrench_world": wrench_world,
            "wrench_body": wrench_body,
            "distributed": distributed,
            "points": points,
        }
        return replace(self, **{name: value for name, value in given.items() if value is not None})

    def scaled(self, factor: float) -> Loads:
        """All loads times a factor.

        Raises:
            InvalidRequest: No number.
            NonFiniteInput: A NaN or an infinity.
        """
        return Loads(**self._times(checked_number("factor", factor)))

    def _times(self, factor: float) -> dict[str, Any]:
        """All parts times a factor, by attribute."""
        parts: dict[str, Any] = {name: factor * getattr(self, name) for name in _VECTORS}
        for name in ("distributed", "points"):
            parts[name] = tuple(replace(f, force=factor * f.force) for f in getattr(self, name))
        return parts

    def toward(self, target: Loads, fraction: float) -> Loads:
        """Loads part of the way to others; forces on rods are those of both, weighed.

        Raises:
            InvalidRequest: No loads, or no number.
            NonFiniteInput: A NaN or an infinity.
        """
        if not isinstance(target, Loads):
            raise InvalidRequest("target", f"expected Loads, got {target!r:.200}")
        fraction = checked_number("fraction", fraction)
        if target is self or fraction == 0.0:
            return self
        if fraction == 1.0:
            return target
        mine, theirs = self._times(1.0 - fraction), target._times(fraction)
        return Loads(**{name: mine[name] + theirs[name] for name in mine})

    def differences(self, other: Loads) -> tuple[str, ...]:
        """Names of the attributes in which others differ; empty where they are the same."""
        if other is self:
            return ()
        return tuple(name for name, part in self.parts.items() if part != other.parts[name])

    def conservative(self, planar: bool, point: bool = False) -> bool:
        """Whether all loads have a potential, so that energy decides stability (Section V-D).

        Moments in space and following forces have none; a moment in the plane has one, which
        ``Equilibrium.energy`` leaves out.

        Args:
            planar: Whether the robot stays in the plane.
            point: Whether its platform is a point: that does not turn, and nothing follows it.
        """
        if planar:
            return point or self._conservative_in_plane
        return self._conservative_in_space

    @cached_property
    def parts(self) -> Mapping[str, Hashable]:
        """What is equal where loads are the same, by attribute."""
        return {field.name: _comparable(getattr(self, field.name)) for field in fields(self)}

    @cached_property
    def _conservative_in_plane(self) -> bool:
        return not np.any(self.wrench_body[3:])

    @cached_property
    def _conservative_in_space(self) -> bool:
        return not np.any(self.wrench_world[:3]) and not np.any(self.wrench_body)

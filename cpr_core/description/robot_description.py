# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a robot is made of: immutable values, whatever file they come from."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidRequest
from ..rods.rod import MOST_MODES, StrainModes
from ..validation import cached_property, checked_count
from .chain import ChainRod
from .leg_description import DescribedMotor, LegDescription, described_motors
from .loads import Loads
from .tracker import Tracker
from .written_fields import WrittenFields

__all__ = ["HomeGuess", "ModeCounts", "RobotDescription"]

Floats = NDArray[np.float64]
#: Numbers of strain modes of a rod: torsion, bending about d2 and d3.
ModeCounts = tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class HomeGuess:
    """What is known of the home equilibrium; the rest is found by assembling the robot.

    Attributes:
        motors: Motor positions, (n,); these are exact.
        platform_position: Roughly, (3,) [m]; None: not known.
        platform_rotation: Roughly, (3, 3); None: not known.
        strain: For every leg and every strain component Legendre coefficients of the curvature [1/m]
            without loads: close enough for Newton's method. None: not known.
        bow: For every leg the side to which its middle stands out, a vector in the world, (3,); None
            where it is not known.
        joints: Passive joints roughly, by name [rad or m]; those left out are where their springs rest.
    """

    motors: Floats
    platform_position: Floats | None
    platform_rotation: Floats | None
    strain: tuple[tuple[Floats, Floats, Floats], ...] | None
    bow: tuple[Floats | None, ...] = ()
    joints: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, repr=False)
class RobotDescription:
    """A whole robot, as its file says.

    Attributes:
        name: Name of the robot.
        source: Where the description came from.
        planar: Whether the robot lives in the plane z = 0.
        point_platform: Whether the platform has no orientation (planar only).
        platform_mass: [kg].
        center_of_mass: Of the platform in its frame, (3,) [m].
        legs: The legs.
        controlled: Platform coordinates of the inverse problem, in order; none if there are more
            motors than platform coordinates.
        home: Rough home equilibrium.
        loads: Loads that always act, gravity included.
        stations: s/l where point forces may act, on every leg.
        platform_inertia: About the centre of mass in the platform frame, (3, 3) [kg m^2]; statics does
            not ask for it.
        tolerance: Largest error of the platform position that is allowed [m], for which `load_robot`
            chooses the modes; infinite where the description has numbers of modes instead.
        tracker: Who measures the platform, where and by what marker; None where nothing is said of it.
        written: The fields it was made of; None where it was not made of any.
    """

    name: str
    source: str
    planar: bool
    point_platform: bool
    platform_mass: float
    center_of_mass: Floats
    legs: tuple[LegDescription, ...]
    controlled: tuple[str, ...]
    home: HomeGuess
    loads: Loads = field(default_factory=Loads.none)
    stations: tuple[float, ...] = ()
    platform_inertia: Floats = field(default_factory=lambda: np.zeros((3, 3)))
    tolerance: float = math.inf
    tracker: Tracker | None = None
    written: WrittenFields | None = None

    def __repr__(self) -> str:
        return (
            f"<RobotDescription {self.name} from {self.source}: "
            f"{'planar' if self.planar else 'spatial'}, {len(self.legs)} legs, "
            f"controlled {' '.join(self.controlled) or 'nothing'}>"
        )

    @property
    def text(self) -> str:
        """The description as a file; empty where it was not read from one."""
        return "" if self.written is None else self.written.text

    @property
    def platform_freedom(self) -> int:
        """Number of platform coordinates."""
        if self.planar:
            return 2 if self.point_platform else 3
        return 6

    @cached_property
    def rods(self) -> tuple[ChainRod, ...]:
        """The rods of all legs."""
        return tuple(element for leg in self.legs for element in leg.rods)

    @cached_property
    def rod_names(self) -> tuple[str, ...]:
        """Names of the rods of all legs: those of their legs, numbered where a leg has several."""
        return tuple(name for leg in self.legs for name in leg.rod_names)

    @cached_property
    def longest_rod(self) -> float:
        """Length of the longest rod [m]."""
        return max(element.rod.length for element in self.rods)

    @property
    def mean_length(self) -> float:
        """Mean rod length of a leg as described, of several rods together: the natural length [m]."""
        return float(np.mean([leg.rod_length for leg in self.legs if leg.rods]))

    @property
    def mean_rigidity(self) -> float:
        """Mean E J of a leg, of several rods that of one as soft as they are together [N m^2].

        Of a strip it is that of the way in which it bends far, in the plane that about d3.
        """
        return float(np.mean([leg.rod_rigidity(self.planar) for leg in self.legs if leg.rods]))

    @property
    def gravity(self) -> Floats:
        """Gravity in the world, (3,) [m/s^2]."""
        return self.loads.gravity

    @property
    def motor_names(self) -> tuple[str, ...]:
        """Names of the motors in order."""
        return tuple(motor.name for motor in self.motors)

    @cached_property
    def motors(self) -> tuple[DescribedMotor, ...]:
        """The motors in order; one may move joints of several legs."""
        return described_motors(self.legs)

    def without_limits(self) -> RobotDescription:
        """The same robot with motors that can do everything and rods that bear everything.

        What was ``written`` stays: numbers that are changed there bring the limits back.
        """
        return replace(self, legs=tuple(leg.without_limits() for leg in self.legs))

    def with_modes(self, modes: int) -> RobotDescription:
        """The same robot with another number of modes in every direction that has any.

        A tolerance says of no direction that it has none: then in all of them, torsion too.

        Args:
            modes: How many, from 1 to 40.

        Raises:
            InvalidRequest: Another number, or the basis has its own.
        """
        modes = checked_count("modes", modes, 1, MOST_MODES)
        if any(getattr(element.modes.basis, "modes", None) is not None for element in self.rods):
            raise InvalidRequest(
                "modes", "B-splines have as many modes as degree and knots say: change those"
            )
        if math.isfinite(self.tolerance):
            counts = (0, 0, modes) if self.planar else (modes, modes, modes)
            return self.with_mode_counts([counts] * len(self.rods))
        return self._with_strain_modes(lambda present: present.with_counts(modes))

    def with_mode_counts(self, counts: Sequence[ModeCounts]) -> RobotDescription:
        """The same robot with other numbers of modes.

        Args:
            counts: About the tangent, d2 and d3, for every rod in the order of ``rods``.
        """
        left = iter(counts)
        return self._with_strain_modes(lambda present: replace(present, counts=next(left)))

    def with_richer_modes(self, more: int) -> RobotDescription:
        """The same robot with strain modes of which those of this one are combinations.

        Args:
            more: So many more in every direction, in space also in those that have none; B-splines get a
                knot in every interval.
        """
        more = checked_count("more", more, 1)
        missing = 0 if self.planar else more
        return self._with_strain_modes(lambda present: present.richer(more, missing))

    def with_modes_of(self, described: RobotDescription) -> RobotDescription:
        """The same robot with the strain modes of another one that has the same chains."""
        pairs = zip(self.legs, described.legs, strict=True)
        legs = (leg if leg is other else leg.with_modes_of(other) for leg, other in pairs)
        return replace(self, legs=tuple(legs))

    def _with_strain_modes(self, changed: Callable[[StrainModes], StrainModes]) -> RobotDescription:
        return replace(self, legs=tuple(leg.with_modes(changed) for leg in self.legs))

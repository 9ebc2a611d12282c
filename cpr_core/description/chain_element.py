# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What all elements of a chain can say of themselves; all else the model knows by their kinds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description_part import Described
from ..rods.rod import StrainModes
from .motors import NO_LIMITS, MotorLimits

__all__ = ["ChainElement"]

Floats = NDArray[np.float64]


class ChainElement(Described):
    """A joint, a rigid link or a rod; what follows is that of one that does not move.

    Attributes:
        kind: What the mechanics take it for.
        unit: Of its coordinate; empty where it has none.
        motor: Name of the motor that moves it; None: none does.
        ratio: How far it goes when its motor goes one.
        zero: Where it is with its coordinate at zero.
        stiffness: Of a spring on its coordinate [N m/rad or N/m].
        rest: Coordinate at which the spring is at rest.
        limits: What the motor can do.
    """

    kind: ClassVar[Literal["link", "turn", "shift", "rod"]]
    unit: ClassVar[Literal["rad", "m", ""]] = ""
    motor: str | None = None
    ratio: float = 1.0
    zero: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    limits: MotorLimits = NO_LIMITS

    @property
    def passive(self) -> bool:
        """Whether it has a coordinate that no motor moves."""
        return self.kind in ("turn", "shift") and self.motor is None

    @property
    def motor_unit(self) -> Literal["rad", "m", ""]:
        """Unit of the position of its motor."""
        return self.unit

    def natural_unit(self, length: float) -> float:
        """Natural unit of its coordinate in a robot with rods of a length [m].

        Of a motor with a gear it is what moves the joint by a radian or a rod length: how fast the shaft
        in front of the gear turns says nothing of the robot.
        """
        return (1.0 if self.unit == "rad" else length) / abs(self.ratio)

    def constants(self) -> Mapping[str, ArrayLike]:
        """Its numbers in the mechanics, by the names of ``kernels.kernel_arrays.element_dtype``."""
        return {}

    def behind(
        self, rotation: Floats, position: Floats, coordinate: float
    ) -> tuple[Floats, Floats]:
        """Frame (3, 3) and point (3,) that a rigid element leads to.

        Args:
            rotation: Frame before it in the world, (3, 3).
            position: Point before it, (3,) [m].
            coordinate: Of a joint [rad or m].
        """
        raise NotImplementedError

    def without_limits(self) -> Self:
        """The same with a motor that can do everything, and unbreakable."""
        return self

    def with_modes(self, changed: Callable[[StrainModes], StrainModes]) -> Self:
        """The same with other strain modes where it has any."""
        return self

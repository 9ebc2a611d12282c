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
from .motors import UNDRIVEN, Drive, MotorLimits

__all__ = ["ChainElement"]

Floats = NDArray[np.float64]


class ChainElement(Described):
    """A joint, a rigid link or a rod; what follows is that of one that does not move.

    Attributes:
        kind: What the mechanics take it for.
        unit: Of its coordinate; empty where it has none.
        shown_kind: What it is called where it is shown as a joint; empty where it is none.
        adds_point: Whether it leads to another point than the one before it.
        drive: What moves it.
        stiffness: Of a spring on its coordinate [N m/rad or N/m].
        rest: Coordinate at which the spring is at rest.
    """

    kind: ClassVar[Literal["link", "turn", "shift", "rod"]]
    unit: ClassVar[Literal["rad", "m", ""]] = ""
    shown_kind: ClassVar[Literal["revolute", "prismatic", "feed", ""]] = ""
    adds_point: ClassVar[bool] = True
    drive: Drive = UNDRIVEN
    stiffness: float = 0.0
    rest: float = 0.0

    @property
    def motor(self) -> str | None:
        """Name of the motor that moves it; None: none does."""
        return self.drive.motor

    @property
    def ratio(self) -> float:
        """How far it goes when its motor goes one."""
        return self.drive.ratio

    @property
    def zero(self) -> float:
        """Where it is with its coordinate at zero."""
        return self.drive.zero

    @property
    def limits(self) -> MotorLimits:
        """What the motor can do."""
        return self.drive.limits

    @property
    def passive(self) -> bool:
        """Whether it has a coordinate that no motor moves."""
        return False

    @property
    def motor_unit(self) -> Literal["rad", "m", ""]:
        """Unit of the position of its motor."""
        return "rad" if self.drive.screw else self.unit

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

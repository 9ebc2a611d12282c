"""First-order behaviour of an equilibrium, computed once: smallest eigenvalues, platform matrices."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from .equilibrium import Equilibrium
from .errors import InvalidRequest
from .model import tangent_at
from .reduction_kernel import first_order_into

__all__ = ["FirstOrder", "Response", "check_equilibrium", "first_order"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Response:
    """How platform and efforts answer to motors and wrench; body twists and wrenches.

    Attributes:
        platform_by_motors: ``dSigma_p/dq_a``, (platform, n).
        platform_by_wrench: ``dSigma_p/dw_p``, motors held, (platform, platform).
        efforts_by_motors: ``dtau_a/dq_a``, (n, n).
        efforts_by_wrench: ``dtau_a/dw_p``, motors held, (n, platform).
    """

    platform_by_motors: Floats
    platform_by_wrench: Floats
    efforts_by_motors: Floats
    efforts_by_wrench: Floats


@dataclass(frozen=True, eq=False)
class FirstOrder:
    """Found by condensing every leg onto platform and motors.

    Attributes:
        smallest_locked: Smallest eigenvalue of H_r with the motors held [J]; NaN: not found this way.
        smallest_free: The same with the motors free [J].
        margin: With the motors held, relative to the elastic stiffness; NaN: not found this way.
        response: None: not found this way.
    """

    smallest_locked: float
    smallest_free: float
    margin: float
    response: Response | None


def check_equilibrium(value: object) -> None:
    """Whether this is something a question can be about.

    Raises:
        InvalidRequest: No equilibrium.
    """
    if not isinstance(value, Equilibrium):
        raise InvalidRequest("equilibrium", f"expected an Equilibrium, got {value!r:.200}")


_KEPT: WeakKeyDictionary[Equilibrium, FirstOrder] = WeakKeyDictionary()


def first_order(equilibrium: Equilibrium) -> FirstOrder:
    """First-order behaviour of an equilibrium, computed when first asked for and kept as long as it.

    Legs that cannot hold their tips by their own motions (straight ones) and motions without stiffness
    are beyond this method: NaN and None then send to the dense one.
    """
    kept = _KEPT.get(equilibrium)
    if kept is None:
        kept = _KEPT[equilibrium] = _computed(equilibrium)
    return kept


def _computed(equilibrium: Equilibrium) -> FirstOrder:
    robot = equilibrium.robot
    motors, platform = robot.motor_count, len(robot.platform_axes)
    eigenvalues = np.empty(3)
    response = Response(
        platform_by_motors=np.empty((platform, motors)),
        platform_by_wrench=np.empty((platform, platform)),
        efforts_by_motors=np.empty((motors, motors)),
        efforts_by_wrench=np.empty((motors, platform)),
    )
    # Copies: read-only arrays are another type to numba, for which it would compile all again.
    found = first_order_into(
        robot.arrays, tangent_at(equilibrium), equilibrium.state.copy(),
        equilibrium.platform_rotation.copy(), robot.unit_motions, robot.motion_spans, eigenvalues,
        response.platform_by_motors, response.platform_by_wrench,
        response.efforts_by_motors, response.efforts_by_wrench,
    )  # fmt: skip
    for matrix in vars(response).values():
        matrix.flags.writeable = False
    locked, free, margin = eigenvalues.tolist()
    return FirstOrder(locked, free, margin, response if found else None)

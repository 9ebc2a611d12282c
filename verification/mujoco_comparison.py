# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""MuJoCo on the cases whose rods it has."""

from __future__ import annotations

from importlib.metadata import version

from .cases import Case
from .comparison import Comparison, compared
from .mujoco_forward import forward_mujoco
from .placed_robot import placed

__all__ = ["compare_mujoco"]


def compare_mujoco(case: Case) -> Comparison:
    """A forward solve of a case with MuJoCo's forces, from bent legs.

    Raises:
        NotPossible: MuJoCo has no such robot.
        NotBalanced: No way is found.
    """
    found = forward_mujoco(placed(case.robot().description, case.motors))
    # Without twist the error is even in the length of a piece.
    next_power = 2 * found.powers[-1] - found.powers[-2]
    pieces = ", ".join(str(count) for count in found.pieces)
    return compared(
        case,
        f"MuJoCo {version('mujoco')}",
        f"elasticity.cable, {pieces} pieces a rod, extrapolated; statics ours",
        found,
        f"pieces (l/n)^{next_power}, central differences",
    )

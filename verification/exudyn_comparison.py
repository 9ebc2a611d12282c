# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Exudyn on all cases."""

from __future__ import annotations

from importlib.metadata import version

from .cases import Case
from .comparison import Comparison
from .exudyn_forward import forward
from .placed_robot import placed

__all__ = ["compare_exudyn"]

WHY = {
    "ANCFCable2D": "Newton's residual (4e-7 N), higher powers of the stretch",
    "BeamGeometricallyExact": "elements (h^6) and higher powers of stretch and shear, not told apart",
}


def compare_exudyn(case: Case) -> Comparison:
    """Exudyn's own forward solve of a case, from straight legs.

    Raises:
        NotPossible: It has no such robot.
        NotSettled: Its static solver finds no way.
    """
    found = forward(placed(case.robot().description, case.motors), halvings=case.halvings)
    distance = case.distance(found.unstretched.position)
    elements = f"{', '.join(map(str, found.elements))} elements a rod"
    return Comparison(
        case=case,
        program=f"Exudyn {version('exudyn')}",
        setting=f"{found.kind}, {elements} and 1, 2, 4 times the stiffness, both extrapolated",
        start=f"straight legs, {found.forward_seconds:.2g} s to the first equilibrium",
        distance_as_is=case.distance(found.real.position),
        distance=distance,
        efforts=case.effort_difference(found.unstretched.efforts),
        seconds=found.seconds,
        ours=case.as_accurate_as(distance),
        why=WHY[found.kind],
    )

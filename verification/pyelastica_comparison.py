# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""PyElastica on the case it was built for."""

from __future__ import annotations

from importlib.metadata import version

from .cases import Case
from .comparison import Comparison, compared
from .placed_robot import placed
from .pyelastica_forward import forward_pyelastica

__all__ = ["compare_pyelastica"]

WHY = "elements, stretch and shear, which go with each other (h^6)"


def compare_pyelastica(case: Case) -> Comparison:
    """A forward solve of a case by PyElastica, damped from bent legs to rest.

    Raises:
        NotPossible: It was not built for such a robot.
        NotRelaxed: It does not come to rest.
    """
    found = forward_pyelastica(placed(case.robot().description, case.motors))
    elements = ", ".join(str(count) for count in found.elements)
    return compared(
        case,
        f"PyElastica {version('pyelastica')}",
        f"CosseratRod, {elements} elements a rod, as thick as they are long, extrapolated",
        found,
        WHY,
    )

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What can happen on the way from one equilibrium to another."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ..model.equilibrium import Equilibrium

__all__ = ["EventKind", "PathEvent"]

#: - ``fold``: the branch turns back: no equilibrium of it exists farther on. A singularity of the
#:   problem that is solved (forward: the loss of stability at a snap; inverse: an inverse singularity).
#: - ``bifurcation``: another branch crosses; the branch goes on.
#: - ``stability``: the stability index changes although the problem that is solved stays regular.
#: - ``singularity``: an inverse singularity is passed by motors or efforts.
#: - ``motor_limit``, ``effort_limit``, ``strain_limit``: a motor or a rod can do no more.
#: - ``time_limit``: the time allowed was over.
#: - ``lost``: no equilibrium was found near the last one, and the reason is not known.
EventKind = Literal[
    "fold",
    "bifurcation",
    "stability",
    "singularity",
    "motor_limit",
    "effort_limit",
    "strain_limit",
    "time_limit",
    "lost",
]


@dataclass(frozen=True, eq=False)
class PathEvent:
    """An event on a path.

    Attributes:
        kind: What happened.
        fraction: Where, as a fraction of the way, to 1e-9.
        equilibrium: The last equilibrium before it, less than 1e-8 of the way away; where several
            branches cross, the last one that is well told apart from the others.
        index_before: Stability index before it: of the motors as the problem has them, locked where
            motors or the platform are imposed, free where efforts are.
        index_after: Stability index after it; the same as before where the path ends there.
        message: What happened, for a person.
    """

    kind: EventKind
    fraction: float
    equilibrium: Equilibrium = field(repr=False)
    index_before: int
    index_after: int
    message: str

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Off a saddle to one side: to the same one on every computer, though the energy falls to both."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["softest_side"]

Floats = NDArray[np.float64]

#: Curvatures that differ by less, relative to the softest, are the same but for rounding.
_SAME = 1e-6
#: Weights of this rhythm are all positive and differ from axis to axis: no symmetry cancels them.
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


def softest_side(curvatures: Floats, axes: Floats) -> Floats:
    """A direction of least curvature, (n,), as long as the first eigenvector.

    Eigenvectors have no sign, and where a robot is symmetric in space several have the same curvature:
    which come out of a factorisation is a matter of rounding, and differs between computers. Of all the
    directions they span this is the one that a fixed one tells.

    Args:
        curvatures: Ascending, (m,).
        axes: Their eigenvectors, columns, orthonormal in some metric, (n, m).
    """
    softest = axes[:, curvatures - curvatures[0] <= _SAME * abs(curvatures[0])]
    fixed = 0.5 + np.modf(_GOLDEN * np.arange(len(axes)))[0]
    side = softest @ (softest.T @ fixed)
    return np.asarray(side * (np.linalg.norm(axes[:, 0]) / np.linalg.norm(side)))

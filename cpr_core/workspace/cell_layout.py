# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where numbers of a cell are: its signs, and what is measured of it.

Signs begin as those in the record of an equilibrium (`kernels.record_layout`).
"""

from __future__ import annotations

from ..kernels.record_layout import INVERSE_SIGN

__all__ = [
    "BRANCH_SIGN",
    "FORWARD_MARGIN",
    "INVERSE_MARGIN",
    "LARGEST_EIGENVALUE",
    "MEASURE_COUNT",
    "NEAREST_EIGENVALUE",
    "SIGN_COUNT",
]

#: Behind the signs of an equilibrium: the one that tells branches apart.
BRANCH_SIGN = INVERSE_SIGN + 1
SIGN_COUNT = BRANCH_SIGN + 1
#: Measures: smallest and largest absolute eigenvalue of H_r, motors held; smallest singular values
#: of the forward problem and, next to it, of the inverse one.
NEAREST_EIGENVALUE, LARGEST_EIGENVALUE, FORWARD_MARGIN = 0, 1, 2
INVERSE_MARGIN = FORWARD_MARGIN + 1
MEASURE_COUNT = INVERSE_MARGIN + 1

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The three problems, by what they impose."""

from __future__ import annotations

from enum import IntEnum

__all__ = ["PROBLEMS", "Problem"]


class Problem(IntEnum):
    """What a problem imposes, as the kernels number it; names in small letters elsewhere."""

    MOTORS = 0
    EFFORTS = 1
    POSE = 2


#: The numbers by the keys of ``Robot.problems``.
PROBLEMS = {problem.name.lower(): problem.value for problem in Problem}

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The three problems, by what they impose."""

from __future__ import annotations

from enum import IntEnum
from typing import Literal

__all__ = ["PROBLEMS", "Problem", "ProblemName"]

#: What a problem imposes, in words: keys of ``Robot.problems``.
ProblemName = Literal["motors", "efforts", "pose"]


class Problem(IntEnum):
    """What a problem imposes, as the kernels number it."""

    MOTORS = 0
    EFFORTS = 1
    POSE = 2


#: The numbers by their words.
PROBLEMS = {problem.name.lower(): problem.value for problem in Problem}

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far a request is: in radians of a motor, and what counts as much as one."""

from __future__ import annotations

__all__ = ["EFFORT_UNIT", "LONGEST_STEP"]

#: Efforts and loads that count as a motor turned by a radian: moments in E J / l, forces in E J / l^2.
EFFORT_UNIT = 4.0
#: Longest step that is watched, in radians and rod lengths. A motor several turns away looks near to
#: Newton's method, yet the rod has to be wound there.
LONGEST_STEP = 0.5

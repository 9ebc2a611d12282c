# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Options that numba's compiler takes; it refuses every other one."""

from __future__ import annotations

from numba.core.cpu import CPUTargetOptions

__all__ = ["KNOWN_OPTIONS"]

#: Their names, documented or not.
KNOWN_OPTIONS = frozenset(dir(CPUTargetOptions))

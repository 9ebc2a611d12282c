# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the parts of twists [omega; v] and of wrenches [moment; force] are."""

from __future__ import annotations

__all__ = ["ANGULAR", "FIRST_LINEAR", "LINEAR"]

#: Number of the first component that is linear: those before are angular.
FIRST_LINEAR = 3

#: Rotation or moment, and translation or force.
ANGULAR, LINEAR = slice(0, FIRST_LINEAR), slice(FIRST_LINEAR, 6)

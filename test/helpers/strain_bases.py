# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shipped robots by another strain basis."""

from cpr_core import Robot, load_robot
from helpers.yaml_content import shipped_content


def with_basis(name: str, basis: str, modes: int) -> Robot:
    """A shipped robot whose rods have so many modes of a polynomial basis in every direction."""
    content = shipped_content(name)
    content["strain"]["basis"] = basis
    return load_robot(content, modes=modes)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shipped robots by another strain basis."""

from cpr_core import Robot, load_robot
from cpr_core.description.description_file import shipped_robots
from helpers.yaml_content import yaml_content


def with_basis(name: str, basis: str, modes: int) -> Robot:
    """A shipped robot whose rods have so many modes of a polynomial basis in every direction."""
    content = yaml_content(shipped_robots()[name].read_text().replace("e9 ", ".0e+9 "))
    content["strain"]["basis"] = basis
    return load_robot(content, modes=modes)

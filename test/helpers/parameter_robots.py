# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots whose numbers are named in several ways: once for all legs, by leg, by axis of a joint."""

from cpr_core import load_robot
from cpr_core.description.description_file import shipped_robots
from helpers.yaml_content import shipped_content

SIX_RFS = shipped_robots()["six_rfs"].read_text(encoding="utf-8")
#: A rod that takes all from the robot's, and one that has a length of its own.
SHARED = """
name: shared
space: planar
rod: {length: 0.5, section: {shape: circular, radius: 0.001}, young_modulus: 210e9, shear_modulus: 82e9}
strain: {bending_3: 4}
platform: {shape: point}
legs:
- base: {position: [-0.2, 0, 0], tangent: [0, 1, 0]}
  chain:
  - {joint: revolute, axis: [0, 0, 1], motor: m1}
  - {link: [0.02, 0, 0]}
  - {rod: {}}
  tip: {type: spherical, position: [0, 0, 0]}
- base: {position: [0.2, 0, 0], tangent: [0, 1, 0]}
  chain:
  - {joint: revolute, axis: [0, 0, 1], motor: m2}
  - {link: [0.02, 0, 0]}
  - {rod: {length: 0.6}}
  tip: {type: spherical, position: [0, 0, 0]}
controlled: [x, y]
home: {motors: [0.3, -0.3], bow: outward}
"""


def half_moved():
    """A robot with a universal joint of which a motor turns the first axis; defaults and one value."""
    content = shipped_content("six_rus")
    content["legs"][0]["chain"][2] |= {"motor": ["m", None], "stiffness": 0.2}
    content |= {"controlled": [], "home": {"motors": [0] * 7, "bow": "outward"}}
    return load_robot(content)

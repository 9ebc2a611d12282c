# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot with a leg of no rod: motors held, its platform cannot move along that leg."""

import math

from cpr_core import load_robot

_DESCRIPTION = """
name: rigid_leg
space: planar
rod:
  length: 0.5
  section: {shape: circular, radius: 0.001}
  young_modulus: 210.0e+9
  shear_modulus: 80.0e+9
strain: {bending_3: 6}
platform: {shape: body, mass: 0.05}
legs:
- base: {position: [-0.3, 0, 0], tangent: [0, 1, 0]}
  chain: [{joint: revolute, axis: [0, 0, 1], motor: m1}, {rod: {}}]
  tip: {type: revolute, position: [-0.05, 0, 0]}
- base: {position: [0.3, 0, 0], tangent: [0, 1, 0]}
  chain: [{joint: revolute, axis: [0, 0, 1], motor: m2}, {rod: {}}]
  tip: {type: revolute, position: [0.05, 0, 0]}
- base: {position: [0, -0.1, 0], tangent: [0, 1, 0]}
  chain:
  - {joint: revolute, axis: [0, 0, 1]}
  - {joint: prismatic, axis: [1, 0, 0], motor: m3, offset: 0.5}
  tip: {type: revolute, position: [0, 0, 0]}
controlled: [x, y, angle]
home: {motors: [0.1, -0.1, 0.0], bow: [outward, outward, [1, 0, 0]]}
"""


def rigid_leg():
    """Two legs with rods, and one that is a motor between two hinges."""
    return load_robot(_DESCRIPTION)


def leaning_rigid_leg(x, y, angle):
    """The same with a rough pose of its platform [m, rad]: it leans to one side or the other."""
    turn = f"[{math.cos(0.5 * angle)}, 0.0, 0.0, {math.sin(0.5 * angle)}]"
    pose = f"platform: {{position: [{x}, {y}, 0.0], quaternion_wxyz: {turn}}}, "
    return load_robot(_DESCRIPTION.replace("home: {", "home: {" + pose))

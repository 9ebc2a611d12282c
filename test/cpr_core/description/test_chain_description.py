# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Chains as descriptions say them: what is read of links, rods, joints and shared motors."""

import numpy as np
import pytest
import yaml
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, load_robot
from cpr_core.description.chain import ChainRod, Link, Turn

PLANAR = """
base: {position: [0.0, 0.55, 0.0], tangent: [0.0, -1.0, 0.0]}
chain:
- {joint: revolute, axis: [0, 0, 1], motor: motor1, limits: {position: [-1.5, 1.5], effort: 3.0}}
- {link: [0.03, 0, 0]}                    # rigid: where it leads, in the frame (d1 d2 d3) before it
- {rod: {length: 0.6, section: {shape: circular, radius: 0.001},
         young_modulus: 210e9, shear_modulus: 82e9},
   strain: {bending_3: 8}}                # fields left out are those of the robot's `rod`, `strain`
- {link: [0.02, 0, 0], mass: 0.005}
tip: {type: revolute, position: [0.0, 0.1, 0.0]}
"""
SPATIAL = """
base: {position: [0.04, 0.12, 0], tangent: [0, 1, 0], normal: [-1, 0, 0]}
chain:
- {joint: revolute, axis: [0, -1, 0], motor: m1}
- {link: [0.1, 0, 0], mass: 0.02, center_of_mass: [0.05, 0, 0]}     # the crank
- {joint: revolute, axis: [0, 1, 0], stiffness: 0.1, rest: 0.2}     # passive, sprung [N m/rad, rad]
- {joint: revolute, axis: [0, 0, 1]}                                # passive, free
- {rod: {length: 0.4, rest_curvature: {bending_2: [2.0]}}}
tip: {type: spherical, position: [0.03, -0.09, 0]}
"""


def with_leg(name, leg):
    """A robot with another first leg."""
    changed = shipped_content(name)
    changed["legs"][0] = leg
    return changed


def test_a_planar_leg_with_hub_and_end_piece():
    leg = load_robot(with_leg("three_rfr_hubs", yaml.safe_load(PLANAR))).description.legs[0]
    motor, hub, rod, end = leg.chain
    assert (motor.axis, motor.motor, motor.limits.upper, motor.limits.effort) == (
        (0.0, 0.0, 1.0),
        "motor1",
        1.5,
        3.0,
    )
    assert (hub.offset, hub.mass, end.mass, end.center_of_mass) == (
        (0.03, 0.0, 0.0),
        0.0,
        0.005,
        (0.01, 0.0, 0.0),
    )
    assert rod.modes.counts == (0, 0, 8)
    assert rod.rod.section.radius == 0.001


def test_a_leg_of_crank_and_sprung_joint():
    robot = load_robot(with_leg("six_rus", yaml.safe_load(SPATIAL)))
    leg, others = robot.description.legs[0], robot.description.legs[1]
    kinds = [type(element) for element in leg.chain]
    assert kinds == [Turn, Link, Turn, Turn, ChainRod]
    sprung, free, rod = leg.chain[2:]
    assert (sprung.stiffness, sprung.rest, sprung.motor) == (0.1, 0.2, None)
    assert (free.stiffness, free.motor) == (0.0, None)
    # What a rod does not say is the robot's: all but the length and the curvature at rest.
    shared = others.rods[0].rod
    assert (rod.rod.length, rod.rod.section) == (0.4, shared.section)
    assert rod.rod.young_modulus == shared.young_modulus
    assert [list(series) for series in rod.rod.rest_curvature] == [[], [2.0], []]
    assert robot.motor_names == ("m1", *(f"motor{k}" for k in range(2, 7)))


def test_a_frame_is_turned_by_a_link():
    leg = with_leg("six_rus", yaml.safe_load(SPATIAL))
    leg["legs"][0]["chain"][1] |= {"tangent": [0, 0, 2], "normal": [0, 1, 0]}
    link = load_robot(leg).description.legs[0].chain[1]
    np.testing.assert_allclose(link.rotation, [[0, 0, -1], [0, 1, 0], [1, 0, 0]], atol=1e-15)


def test_strain_of_a_rod_keeps_what_it_does_not_say():
    changed = shipped_content("six_rus")
    changed["legs"][0]["chain"][-1] = {"rod": {}, "strain": {"bending_2": 2}}
    assert load_robot(changed).description.legs[0].rods[0].modes.counts == (3, 2, 5)


def test_limits_and_units_of_motors_that_turn_shift_and_feed():
    changed = shipped_content("six_rus")
    changed["legs"][0]["chain"][0] = {
        "joint": "prismatic",
        "axis": [0, 0, 1],
        "motor": "rail",
        "limits": {"position": [0.0, 0.2]},
    }
    del changed["legs"][1]["chain"][0]["motor"]
    changed["legs"][1]["chain"][-1] = {
        "rod": {"rest_curvature": {}},
        "motor": "feed",
        "limits": {"speed": 0.1},
    }
    changed["home"]["motors"] = [0.0, 0.5, 0.0, 0.0, 0.0, 0.0]
    motors = load_robot(changed).description.motors
    assert [(motor.name, motor.unit, motor.effort_unit) for motor in motors[:3]] == [
        ("rail", "m", "N"),
        ("feed", "m", "N"),
        ("motor3", "rad", "N m"),
    ]
    assert (motors[0].limits.upper, motors[1].limits.speed) == (0.2, 0.1)


def test_a_motor_in_several_joints_is_one():
    changed = shipped_content("six_rus")
    for leg in changed["legs"][3:]:
        leg["chain"][0] |= {"motor": "common", "ratio": -2.0, "offset": 0.1}
    changed |= {"controlled": ["x", "y", "z", "yaw"], "home": {"motors": [0] * 4, "bow": "outward"}}
    robot = load_robot(changed)
    assert robot.motor_names == ("motor1", "motor2", "motor3", "common")
    joints = [leg.chain[0] for leg in robot.description.legs[3:]]
    assert [(joint.ratio, joint.zero) for joint in joints] == [(-2.0, 0.1)] * 3


def test_limits_of_a_shared_motor_are_compared_whichever_joint_has_them_first():
    changed = shipped_content("six_rus")
    for leg in changed["legs"][3:]:
        leg["chain"][0] |= {"motor": "common"}
    changed |= {"controlled": ["x", "y", "z", "yaw"], "home": {"motors": [0] * 4, "bow": "outward"}}
    _, second, third = (leg["chain"][0] for leg in changed["legs"][3:])
    second["limits"] = {"position": [-1.0, 1.0]}
    third["limits"] = {"position": [-1.0, 1.0]}
    assert load_robot(changed).description.motors[3].limits.upper == 1.0
    third["limits"] = {"position": [-0.2, 0.2]}
    with pytest.raises(DescriptionError, match="'common' has other limits") as caught:
        load_robot(changed)
    assert caught.value.field == "legs[5].chain"


def test_a_motor_of_the_short_form_is_no_motor_of_a_chain():
    changed = shipped_content("six_rus")
    short = {
        "base": changed["legs"][0]["base"],
        "motor": {"type": "revolute", "axis": [0, 0, 1], "name": "motor2"},
        "tip": changed["legs"][0]["tip"],
    }
    with pytest.raises(DescriptionError, match=r"motor2.*several joints share"):
        load_robot(with_leg("six_rus", short))

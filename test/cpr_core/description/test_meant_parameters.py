# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Paths that begin with names of legs, motors or joints: what is meant is told, and never another."""

import pytest
import yaml
from helpers.parameter_robots import SHARED, SIX_RFS, half_moved

from cpr_core import UnknownParameter, load_robot

#: Robots, paths that begin with names, and what is meant by them or known of them.
NAMED_PATHS = [
    ("six_rfs", "motor1.offset", "did you mean legs[0].motor.offset?"),
    ("six_rfs", "leg1.motor.offset", "did you mean legs[0].motor.offset?"),
    ("six_rfs", "motor3.motor.offset", "did you mean legs[2].motor.offset?"),
    ("six_rfs", "leg3.tip.postion[1]", "did you mean legs[2].tip.position[1]?"),
    ("six_rfs", "leg2.rod.young_modulus", "did you mean rod.young_modulus?"),
    ("six_rfs", "motor.offset", "did you mean legs[*].motor.offset?"),
    ("six_rfs", "motor2", "motor2 is legs[1].motor"),
    ("six_rfs", "motor2.mass", "motor2 is legs[1].motor"),
    ("six_rfs", "leg2.motor3.offset", "leg2 is legs[1], motor3 is legs[2].motor"),
    ("six_rfs", "legs[1].motor1.offset", "motor1 is legs[0].motor"),
    ("six_rfs", "leg7.motor.offset", "legs[0] to legs[5] are leg1 to leg6"),
    ("six_rfs", "motor7.offset", "legs[0] to legs[5] are leg1 to leg6"),
    ("six_rfs", "legs[6].motor.offset", "legs[0] to legs[5] are leg1 to leg6"),
    ("three_rfr_hubs", "motor1.offset", "did you mean legs[0].chain[0].offset?"),
    ("three_rfr_hubs", "leg2.chain[0].offset", "did you mean legs[1].chain[0].offset?"),
    ("three_rfr_hubs", "leg1.motor.offset", "did you mean legs[0].chain[0].offset?"),
    ("three_rfr_hubs", "leg3.joint1.ofset", "did you mean legs[2].chain[0].offset?"),
    ("delta", "motor2.offset", "did you mean legs[2,3].chain[0].offset?"),
    ("delta", "motor2.ofset", "motor2 is legs[2].chain[0] and legs[3].chain[0]"),
    ("six_rus", "leg2.joint2.stiffness", "did you mean legs[1].chain[2].stiffness?"),
]


@pytest.mark.parametrize(("name", "path", "told"), NAMED_PATHS)
def test_names_in_paths_are_never_taken_for_another_leg_or_motor(name, path, told):
    with pytest.raises(UnknownParameter) as caught:
        load_robot(name).parameter_values(path)
    assert str(caught.value).endswith(f"the description has no number {path}; {told}")


@pytest.mark.parametrize("field", ["E", "G", "rho", "r", "foo", "poisson"])
def test_a_field_like_none_is_not_taken_for_one_of_the_same_part(field):
    """``rod.E`` was said to mean ``rod.length``."""
    with pytest.raises(UnknownParameter) as caught:
        load_robot("six_rfs").with_parameters({f"rod.{field}": 2e11})
    assert caught.value.nearest == ""
    assert "rod.young_modulus, rod.shear_modulus" in caught.value.known
    with pytest.raises(UnknownParameter) as caught:
        load_robot("six_rfs").parameter_values("rod.youngs_modulus")
    assert caught.value.nearest == "rod.young_modulus"


def test_paths_with_names_that_count_otherwise_are_those_of_their_parts():
    content = yaml.safe_load(SHARED)
    content["legs"][0] |= {"name": "leg2"}
    content["legs"][1] |= {"name": "leg1"}
    content["legs"][1]["chain"][0] |= {"name": "crank"}
    robot = load_robot(content)
    for path, meant in (
        ("leg2.chain[0].offset", "legs[0].chain[0].offset"),
        ("leg1.base.position[0]", "legs[1].base.position[0]"),
        ("crank.offset", "legs[1].chain[0].offset"),
        ("m2.offset", "legs[1].chain[0].offset"),
        ("motor2.offset", "legs[1].chain[0].offset"),
        ("leg1.rod1.rod.length", "legs[1].chain[2].rod.length"),
        ("leg1.rod.length", "legs[1].chain[2].rod.length"),
    ):
        with pytest.raises(UnknownParameter) as caught:
            robot.parameter_values(path)
        assert caught.value.nearest == meant


def test_the_only_rod_of_its_own_is_not_meant_by_other_legs():
    content = yaml.safe_load(SIX_RFS)
    content["legs"][1]["rod"] = content["rod"] | {"length": 1.01}
    robot = load_robot(content)
    assert robot.parameter_values("legs[1].rod.length") == [1.01]
    for path in ("legs[0].rod.length", "leg1.rod.length", "leg1.length", "length"):
        with pytest.raises(UnknownParameter) as caught:
            robot.parameter_values(path)
        assert caught.value.nearest == "rod.length"


def test_motors_and_axes_of_universal_joints_mean_their_own_entries():
    robot = half_moved()
    for path, meant in (
        ("m.offset", "legs[0].chain[2].offset[0]"),
        ("leg1.joint2[1].stiffness", "legs[0].chain[2].stiffness[1]"),
        ("leg1.joint2[1].stifness", "legs[0].chain[2].stiffness[1]"),
        ("leg1.joint2.stiffness", "legs[0].chain[2].stiffness"),
    ):
        with pytest.raises(UnknownParameter) as caught:
            robot.parameter_values(path)
        assert caught.value.nearest == meant

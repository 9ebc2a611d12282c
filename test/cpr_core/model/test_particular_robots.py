# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What single robots have: legs that extend, angles out of three, limits, motors to spare, no home."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.strain_bases import with_basis
from helpers.yaml_content import shipped_content

from cpr_core import (
    CprError,
    DescriptionError,
    InvalidRequest,
    MotorLimitExceeded,
    Robot,
    find_equilibria,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    trace,
)
from cpr_core.description.loads import PointForce
from cpr_core.lie import roll_pitch_yaw


def test_lengths_of_extensible_legs_are_recovered():
    robot = load_robot("gough_stewart")
    np.testing.assert_allclose(robot.default_loads.gravity, [0, 0, -9.81])
    assert robot.description.platform_mass == 0.1
    lengths = [0.46, 0.44, 0.45, 0.47, 0.45, 0.46]
    forward = solve_forward(robot, lengths)
    back = solve_inverse(robot, forward.pose)
    np.testing.assert_allclose(back.motors, lengths, atol=1e-9)


def test_tilt_is_controlled_exactly_and_the_rest_follows():
    robot = load_robot("three_rfs")
    tilted = solve_inverse(robot, [0.72, 0.1, -0.05])
    roll, pitch, yaw = roll_pitch_yaw(tilted.platform_rotation)
    assert (roll, pitch) == (pytest.approx(0.1, abs=1e-12), pytest.approx(-0.05, abs=1e-12))
    assert tilted.platform_position[2] == pytest.approx(0.72, abs=1e-12)
    assert abs(yaw) > 1e-4
    again = solve_forward(robot, tilted.motors)
    np.testing.assert_allclose(again.platform_rotation, tilted.platform_rotation, atol=1e-8)
    with pytest.raises(InvalidRequest, match="pitch"):
        solve_inverse(robot, [0.72, 0.0, 2.0])


@pytest.mark.parametrize(
    "controlled", [["z", "pitch", "yaw"], ["x", "roll", "yaw"], ["x", "y", "yaw"]]
)
def test_any_angles_can_be_chosen(controlled):
    content = shipped_content("three_rfs")
    content["controlled"] = controlled
    robot = load_robot(content)
    # Off the symmetric home, where yaw answers to no motor to first order.
    start = solve_forward(robot, solve_home(robot).motors + [0.25, -0.15, 0.05])
    target = solve_forward(robot, start.motors + [0.02, -0.01, 0.015], start=start)
    back = solve_inverse(robot, target.pose, start=start)
    np.testing.assert_allclose(back.pose, target.pose, atol=1e-11)
    np.testing.assert_allclose(back.motors, target.motors, atol=1e-7)


def test_motors_beyond_their_limits_are_refused():
    robot = load_robot("three_rfs")
    with pytest.raises(MotorLimitExceeded, match=r"motor1: position 4\.1 rad") as caught:
        solve_forward(robot, [4.1, 5.4, 5.4])
    assert (caught.value.motor, caught.value.quantity) == ("motor1", "position")
    assert caught.value.limits == (4.2, 6.2)
    weak = Robot(
        replace(
            robot.description,
            legs=tuple(
                replace(
                    leg, drive=replace(leg.drive, limits=replace(leg.drive.limits, effort=0.48))
                )
                for leg in robot.description.legs
            ),
        )
    )
    with pytest.raises(MotorLimitExceeded, match="effort"):
        solve_forward(weak, [5.6, 5.6, 5.6])


def test_rod_lengths_stay_positive():
    content = shipped_content("gough_stewart")
    for leg in content["legs"]:
        del leg["motor"]["limits"]
    robot = load_robot(content)
    for length in (-0.3, 0.0):
        wanted = [0.45, 0.45, length, 0.45, 0.45, 0.45]
        refused = f"motors: motor3: expected a rod length above 0 m, got {length:g} m"
        for ask in (
            lambda motors: solve_forward(robot, motors),
            lambda motors: trace(robot, motors=motors),
            lambda motors: find_equilibria(robot, motors, starts=1),
        ):
            with pytest.raises(InvalidRequest, match=refused):
                ask(wanted)
    assert len(load_robot("rfrfr").fed_rods.rods) == 0
    content["home"]["motors"] = [0.0] * 6
    with pytest.raises(DescriptionError, match=r"home\.motors: expected positive rod lengths"):
        load_robot(content)


def test_a_robot_that_cannot_move_is_stable():
    """One mode a leg: with the motors held the constraints leave nothing to move."""
    rigid = solve_home(load_robot("rfrfr", modes=1))
    assert len(rigid.spectrum_locked.eigenvalues) == 0
    assert rigid.index_locked == 0
    assert rigid.spectrum_locked.margin == rigid.spectrum_locked.smallest == np.inf


def test_rounding_is_no_instability():
    """Two prismatic motors along one line shift the whole robot: a neutral motion."""
    content = shipped_content("rfrfr")
    for leg, slope in zip(content["legs"], (2.59, 0.55), strict=True):
        leg["motor"] = {"type": "prismatic", "axis": [1, 0, 0]}
        leg["base"]["tangent"] = [float(np.cos(slope)), float(np.sin(slope)), 0]
    content["home"]["motors"] = [0.0, 0.0]
    robot = load_robot(content)
    for shift in (0.0, 0.01, 0.02, 0.03):
        assert solve_forward(robot, [shift, shift]).index_free == 0


def test_homes_that_do_not_fit_say_where():
    content = shipped_content("six_rfs")
    for number, leg in enumerate(content["legs"]):
        leg["tip"]["position"] = [20.0 * (-1) ** number, 0, 0]
    robot = load_robot(content)
    with pytest.raises(CprError, match=r"home: .* leg\d misses its tip joint by \d+(\.\d)? m"):
        solve_forward(robot, content["home"]["motors"])
    content = shipped_content("three_rfs")
    content["legs"][0]["motor"]["limits"] = {"position": [0, 1]}
    with pytest.raises(DescriptionError, match=r"home: motor1: position 5\.4 rad is outside"):
        solve_forward(load_robot(content), [5.4] * 3)


@pytest.mark.parametrize("off", [0.3 - 0.1 - 0.2, 1e-15, -1e-12, 9e-10])
@pytest.mark.parametrize("place", ["stations", "profile", "points", "end"])
def test_stations_that_rounding_tells_apart_are_one(place, off):
    """The panel between them had nodes that coincide: their frames were those of freed memory."""
    content = shipped_content("planar_body") | {"gravity": [0.0, -9.81, 0.0]}
    other = 0.3 + off
    force = np.array([0.0, 0.5, 0.0])
    if place == "profile":
        content["rod"]["profile"] = {"at": [0.0, 0.3, 1.0], "stiffness": [1.0, 0.5, 0.5]}
    expected = load_robot(content | {"stations": [0.3]})
    if place == "stations":
        content["stations"] = sorted({0.3, other})
    elif place == "end":
        near = max(1e-15, abs(off))
        content["stations"] = [near, 0.3, 1.0 - near]
    else:
        content["stations"] = [other]
    found = load_robot(content)
    assert len(found.grid.nodes) == len(expected.grid.nodes)
    loads = [
        robot.default_loads.with_(points=[PointForce("leg1", at, force)])
        for robot, at in ((expected, 0.3), (found, other if place == "points" else 0.3))
    ]
    at_rest = [
        solve_forward(robot, solve_home(robot).motors, loads=load)
        for robot, load in zip((expected, found), loads, strict=True)
    ]
    np.testing.assert_allclose(at_rest[1].pose, at_rest[0].pose, atol=1e-9)
    assert at_rest[1].spectrum_locked.margin == pytest.approx(
        at_rest[0].spectrum_locked.margin, abs=1e-6
    )


def test_more_motors_than_coordinates_may_control_them_or_none():
    content = shipped_content("rfrfr")
    content["legs"].append(
        content["legs"][0] | {"base": {"position": [-0.1, 0, 0], "tangent": [1, 0, 0]}}
    )
    content["home"]["motors"].append(2.5)
    assert load_robot(content).redundancy == 1
    content["controlled"] = []
    robot = load_robot(content)
    assert robot.redundancy == 0
    solve_forward(robot, solve_home(robot).motors + 0.05)
    with pytest.raises(InvalidRequest, match="no inverse problem: it controls no platform coord"):
        solve_inverse(robot, [])


def test_modes_that_are_not_independent_are_refused_with_the_reason():
    """Of so many monomials the last are sums of the others, but for rounding."""
    with pytest.raises(DescriptionError, match=r"strain: expected modes that are independent"):
        solve_home(with_basis("rfrfr", "monomials", 20))

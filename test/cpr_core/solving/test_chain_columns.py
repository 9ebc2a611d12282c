# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Columns of rods, links and springs against closed forms: moments at the tip, loads on one rod."""

import numpy as np
import pytest
import yaml
from helpers.same_equilibria import assert_same
from helpers.yaml_content import shipped_content
from scipy.integrate import simpson

from cpr_core import (
    DescriptionError,
    DistributedForce,
    InvalidRequest,
    Loads,
    PointForce,
    bending_strains,
    leg_shapes,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.lie import quaternion_from_rotation, rotation_exp

COLUMN = """
name: column
space: planar
rod: {length: 0.4, section: {shape: circular, radius: 0.001}, young_modulus: 210e9, shear_modulus: 82e9}
strain: {bending_3: 4}
controlled: [angle]
legs:
- base: {position: [0.1, 0.2, 0.0], tangent: [0.6, 0.8, 0.0]}
  chain: []
  tip: {type: fixed, position: [0, 0, 0], tangent: [1, 0, 0]}
home: {motors: [0.3], platform: {position: [0.27, 0.67, 0.0]}}
"""
MOTOR = {"joint": "revolute", "axis": [0, 0, 1], "motor": "motor"}
MOMENT = 0.05


def bent(elements):
    """Tip of a column with a moment: where rigid pieces, arcs and sprung joints lead."""
    position, turn = np.array([0.1, 0.2]), np.arctan2(0.8, 0.6)
    for element in elements:
        forward = np.array([np.cos(turn), np.sin(turn)])
        if "link" in element:
            position = position + element["link"][0] * forward
            continue
        if "joint" in element:
            turn += 0.3 if "motor" in element else MOMENT / element["stiffness"] + element["rest"]
            continue
        radius, length = element["rod"]["section"]["radius"], element["rod"]["length"]
        curvature = MOMENT / (210e9 * np.pi / 4.0 * radius**4)
        end = turn + curvature * length
        position = position + np.array([np.sin(end) - np.sin(turn), np.cos(turn) - np.cos(end)]) / (
            curvature
        )
        turn = end
    return position, turn


def rod(length, radius):
    return {"rod": {"length": length, "section": {"shape": "circular", "radius": radius}}}


@pytest.mark.parametrize(
    "elements",
    [
        [MOTOR, rod(0.3, 0.001), rod(0.2, 0.0013)],
        [MOTOR, rod(0.3, 0.001), {"link": [0.1, 0, 0]}, rod(0.2, 0.0013)],
        [
            MOTOR,
            {"joint": "revolute", "axis": [0, 0, 1], "stiffness": 0.2, "rest": -0.1},
            rod(0.3, 0.001),
        ],
        [MOTOR, {"link": [0.05, 0, 0]}, rod(0.3, 0.001), {"link": [0.02, 0, 0]}],
    ],
    ids=["two radii", "rigid middle", "rotational spring", "hub and end piece"],
)
def test_columns_with_a_moment_at_the_tip(elements):
    column = yaml.safe_load(COLUMN.replace("chain: []", "chain: null"))
    column["legs"][0]["chain"] = elements
    robot = load_robot(column)
    loads = Loads.none().with_(wrench_world=[0, 0, MOMENT, 0, 0, 0])
    found = solve_forward(robot, solve_home(robot).motors, loads=loads)
    position, turn = bent(elements)
    np.testing.assert_allclose(found.platform_position[:2], position, rtol=0, atol=1e-11)
    angle = np.arctan2(found.platform_rotation[1, 0], found.platform_rotation[0, 0])
    assert angle == pytest.approx(turn, abs=1e-11)
    assert found.efforts[0] == pytest.approx(-MOMENT, abs=1e-12)
    np.testing.assert_allclose(leg_shapes(found)[0].position[-1, :2], position, atol=1e-11)


def two_rods(**more):
    """A column of two rods with a hub and a rigid piece between."""
    column = yaml.safe_load(COLUMN.replace("chain: []", "chain: null")) | more
    column["home"]["platform"]["position"] = [0.3, 0.8, 0.0]
    pieces = [rod(0.3, 0.001), {"link": [0.1, 0, 0]}, rod(0.2, 0.0013)]
    column["legs"][0]["chain"] = [MOTOR, {"link": [0.05, 0, 0]}, *pieces]
    return column


@pytest.mark.parametrize("name", ["leg1.rod1", "leg1.rod2"])
def test_loads_on_one_of_two_rods_turn_the_motor_about_the_base(name):
    """Moments about the base, in the description and at run time alike."""
    push, at = [0.2, -0.4, 0.0], np.array([[0.1, 0.3, 0.0], [-0.2, 0.5, 0.0]])
    loads = {
        "points": [{"leg": name, "at": 0.5, "force": push}],
        "distributed": [{"leg": name, "at": [0, 1], "force": at.tolist()}],
    }
    robot = load_robot(two_rods(stations=[0.5]))
    given = Loads.none().with_(
        points=[PointForce(name, 0.5, push)], distributed=[DistributedForce(name, [0, 1], at)]
    )
    found = solve_forward(robot, solve_home(robot).motors, loads=given)
    shape, number = leg_shapes(found, 801)[0], int(name[-1]) - 1
    place, length = shape.position[shape.rod == number] - [0.1, 0.2, 0.0], (0.3, 0.2)[number]
    sigma = np.linspace(0.0, 1.0, 801)
    density = (1.0 - sigma)[:, None] * at[0] + sigma[:, None] * at[1]
    moment = np.cross(place[400], push)[2]
    moment += length * simpson(np.cross(place, density)[:, 2], x=sigma)
    assert found.efforts[0] == pytest.approx(-moment, abs=1e-9)
    described = solve_home(load_robot(two_rods(stations=[0.5], loads=loads)))
    assert_same(described, found, atol=1e-9)


def test_loads_on_a_leg_of_several_rods_name_one():
    robot = load_robot(two_rods(stations=[0.5]))
    load = PointForce("leg1", 0.5, [0.0, 1.0, 0.0])
    with pytest.raises(InvalidRequest, match=r"out of leg1\.rod1, leg1\.rod2, got 'leg1'"):
        solve_forward(robot, [0.3], loads=Loads.none().with_(points=[load]))
    loads = {"points": [{"leg": "leg1", "at": 0.5, "force": [0, 1, 0]}]}
    with pytest.raises(DescriptionError, match=r"points\[0\]\.leg: expected one of leg1\.rod1, l"):
        load_robot(two_rods(loads=loads))


@pytest.mark.parametrize("end_radius", [0.0007, 0.0015])
def test_a_cone_with_a_moment_at_its_tip(end_radius):
    """E J is of fourth order in the radius, that is linear: int M / (E J) in closed form."""
    column = yaml.safe_load(COLUMN.replace("chain: []", "chain: null"))
    taper = {"section": {"shape": "circular", "radius": [0.001, end_radius]}}
    column["legs"][0]["chain"] = [MOTOR, {"rod": taper, "strain": {"bending_3": 14}}]
    robot = load_robot(column)
    loads = Loads.none().with_(wrench_world=[0, 0, MOMENT, 0, 0, 0])
    found = solve_forward(robot, solve_home(robot).motors, loads=loads)
    ratio, thick = end_radius / 0.001, 210e9 * np.pi / 4.0 * 0.001**4
    bend = MOMENT * 0.4 / thick * (1.0 - ratio**-3) / (3.0 * (ratio - 1.0))
    angle = np.arctan2(found.platform_rotation[1, 0], found.platform_rotation[0, 0])
    assert angle == pytest.approx(np.arctan2(0.8, 0.6) + 0.3 + bend, abs=1e-9)
    # The strain of the outermost fibre is that of the thin end.
    thin, at = min(0.001, end_radius), 0.0 if ratio > 1.0 else 1.0
    strain = thin * MOMENT / (210e9 * np.pi / 4.0 * thin**4)
    assert bending_strains(found)[0] == pytest.approx(strain, rel=1e-5), at


@pytest.mark.parametrize("offset", [[0.03, 0, 0], [0.0, 0.04, 0.02]])
def test_a_link_moves_the_tip_as_rigid_kinematics_says(offset):
    """A rod without stress, turned by its motor: the platform follows the link, whatever its length."""
    changed = shipped_content("six_rus")
    leg = changed["legs"][0]
    axis = np.array([0.0, -1.0, 0.0])
    leg["chain"] = [
        {"joint": "revolute", "axis": axis.tolist(), "motor": "motor1"},
        {"link": offset, "tangent": [0, 0, 1], "normal": [0, 1, 0]},
        {"rod": {"length": 0.4, "rest_curvature": {}}},
        {"link": offset},
    ]
    leg["tip"] = {"type": "fixed", "position": [0, 0, 0], "tangent": [1, 0, 0], "normal": [0, 1, 0]}
    changed |= {
        "legs": [leg],
        "gravity": [0, 0, 0],
        "controlled": ["z"],
        "platform": {"mass": 0.0},
    }
    turn = np.column_stack([[0, 0, 1], leg["base"]["normal"], -np.array(leg["base"]["tangent"])])
    home = {"quaternion_wxyz": quaternion_from_rotation(turn).tolist(), "position": [0.0, 0.1, 0.4]}
    changed["home"] = {"motors": [0.0], "strain": [{}], "platform": home}
    robot = load_robot(changed)
    found = solve_forward(robot, [0.7], start=solve_home(robot))
    described = robot.description.legs[0]
    frame = described.base_rotation @ rotation_exp(0.7 * axis)
    tip = described.base_position + frame @ offset
    frame = frame @ np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]])
    tip = tip + frame @ [0.4, 0, 0] + frame @ offset
    np.testing.assert_allclose(found.platform_position, tip, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.platform_rotation, frame, rtol=0, atol=1e-12)
    assert found.efforts[0] == pytest.approx(0.0, abs=1e-12)

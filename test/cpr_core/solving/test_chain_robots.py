# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots whose legs are chains: against the short form, closed forms, rigid kinematics and work."""

from copy import deepcopy

import numpy as np
import pytest
import yaml
from helpers.chain_robots import as_chains
from helpers.shipped_steps import CHAINS, SHORT_FORM, STEPS
from helpers.yaml_content import shipped_content
from numpy.polynomial.legendre import leggauss

from cpr_core import (
    DescriptionError,
    DistributedForce,
    InvalidRequest,
    Loads,
    NoForwardSolution,
    PointForce,
    StrainLimitExceeded,
    bending_strains,
    kinemato_statics,
    leg_shapes,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
)
from cpr_core.lie import quaternion_from_rotation, rotation_exp
from cpr_core.model.assessment import Assessment
from cpr_core.workspace import map_workspace, pose_grid
from cpr_core.workspace.store import read_map, write_map


def assert_same(found, expected, atol=1e-12):
    np.testing.assert_allclose(found.platform_position, expected.platform_position, atol=atol)
    np.testing.assert_allclose(found.platform_rotation, expected.platform_rotation, atol=atol)
    np.testing.assert_allclose(found.efforts, expected.efforts, atol=atol)
    assert found.index_locked == expected.index_locked
    assert found.index_free == expected.index_free


# The short form is the same chain.


@pytest.mark.parametrize("pieces", ["none", "of length zero"])
@pytest.mark.parametrize("name", SHORT_FORM)
def test_the_short_form_is_a_chain_with_links_of_no_length_or_none(name, pieces):
    robot = load_robot(name)
    spelt = load_robot(as_chains(name, links=pieces == "of length zero"))
    home, same = solve_home(robot), solve_home(spelt)
    assert spelt.motor_names == robot.motor_names
    assert_same(same, home)
    moved = home.motors + 0.02 * np.cos(np.arange(robot.motor_count))
    assert_same(solve_forward(spelt, moved), solve_forward(robot, moved))
    np.testing.assert_allclose(
        kinemato_statics(same).jacobian, kinemato_statics(home).jacobian, atol=1e-9
    )
    assert same.spectrum_locked.margin == pytest.approx(home.spectrum_locked.margin, abs=1e-9)


#: Robots in the short form by what their motors do: a name, and what its motors are in place of its own.
OFFSETS = {
    "turn": ("six_rfs", None),
    "turn in the plane": ("planar_body", None),
    "shift": ("gough_stewart", {"type": "prismatic", "axis": [0.3, -0.2, 1.0]}),
    "shift in the plane": ("planar_body", {"type": "prismatic", "axis": [0.6, -0.8, 0.0]}),
}


@pytest.mark.parametrize("kind", OFFSETS)
def test_the_zero_of_a_motor_is_that_of_its_joint(kind):
    """As in a chain with the same offset, and as without offset where the joints are."""
    name, motor = OFFSETS[kind]
    plain = shipped_content(name)
    if motor is not None:
        plain["home"]["motors"] = [0.0] * len(plain["legs"])
        for leg in plain["legs"]:
            leg["motor"] = dict(motor)
    offsets = 0.02 * np.cos(1.0 + np.arange(len(plain["legs"])))
    zeroed = deepcopy(plain)
    for leg, offset in zip(zeroed["legs"], offsets.tolist(), strict=True):
        leg["motor"]["offset"] = offset
    zeroed["home"]["motors"] = (np.array(plain["home"]["motors"]) - offsets).tolist()
    robot, spelt = load_robot(zeroed), load_robot(as_chains(zeroed, links=False))
    assert all(leg.chain[0].zero for leg in spelt.description.legs)
    home = solve_home(robot)
    assert_same(solve_home(spelt), home)
    assert_same(home, solve_home(load_robot(plain)), atol=1e-9)
    np.testing.assert_allclose(home.motors, zeroed["home"]["motors"], atol=1e-15)


@pytest.mark.parametrize("field", ["offset", "ratio", "limits"])
def test_a_base_without_a_motor_has_nothing_of_one(field):
    content = shipped_content("gough_stewart")
    content["legs"][0]["motor"] = {"type": "welded", field: {} if field == "limits" else 0.1}
    with pytest.raises(DescriptionError, match=rf"legs\[0\]\.motor: unknown field '{field}'"):
        load_robot(content)


AXES = [[0.0, 1.0, 0.0], [0.1, 0.0, 1.0]]
#: A universal joint, and the same as two revolute ones.
UNIVERSAL = {
    "passive": ({}, {}, {}),
    "sprung": (
        {"stiffness": [0.2, 0.1], "rest": [0.3, -0.2]},
        {"stiffness": 0.2, "rest": 0.3},
        {"stiffness": 0.1, "rest": -0.2},
    ),
    "first driven": (
        {"motor": ["extra1", None], "ratio": [-0.5, None], "stiffness": [None, 0.2]},
        {"motor": "extra1", "ratio": -0.5},
        {"stiffness": 0.2},
    ),
    "both driven": (
        {"motor": ["extra1", "extra2"], "offset": [0.1, -0.05], "ratio": 2.0},
        {"motor": "extra1", "offset": 0.1, "ratio": 2.0},
        {"motor": "extra2", "offset": -0.05, "ratio": 2.0},
    ),
}


@pytest.mark.parametrize("kind", UNIVERSAL)
def test_a_universal_joint_is_two_revolute_ones(kind):
    universal, *turns = UNIVERSAL[kind]
    with_universal, with_revolutes = shipped_content("six_rus"), shipped_content("six_rus")
    with_universal["legs"][1]["chain"][2] = {"joint": "universal", "axes": AXES} | universal
    with_revolutes["legs"][1]["chain"][2:3] = [
        {"joint": "revolute", "axis": axis} | turn for axis, turn in zip(AXES, turns, strict=True)
    ]
    extra = sum("motor" in turn for turn in turns)
    for changed in (with_universal, with_revolutes):
        changed["controlled"] = [] if extra else ["x", "y", "z", "orientation"]
        changed["home"]["motors"] = [0.0] * 2 + [0.05, 0.02][:extra] + [0.0] * 4
    first, second = load_robot(with_universal), load_robot(with_revolutes)
    assert first.motor_names == second.motor_names and first.motor_count == 6 + extra
    home, same = solve_home(first), solve_home(second)
    assert_same(home, same)
    moved = home.motors + 0.1 * np.cos(np.arange(first.motor_count))
    assert_same(solve_forward(first, moved), solve_forward(second, moved))


# Closed forms: a moment at the tip bends every rod to an arc.

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
    shape, number = leg_shapes(found, 33)[0], int(name[-1]) - 1
    place, length = shape.position[shape.rod == number] - [0.1, 0.2, 0.0], (0.3, 0.2)[number]
    nodes, weights = leggauss(31)
    sigma = 0.5 * (nodes + 1.0)
    density = (1.0 - sigma)[:, None] * at[0] + sigma[:, None] * at[1]
    moment = np.cross(place[16], push)[2]
    moment += 0.5 * length * weights @ np.cross(place[1:-1], density)[:, 2]
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


# Whole robots.


@pytest.fixture(params=CHAINS, scope="module")
def robot(request):
    return load_robot(request.param)


def test_home_is_found_stable_and_poses_lead_back_to_motors(robot):
    home = solve_home(robot)
    assert home.stable and home.residual < 1e-10
    moved = solve_forward(robot, home.motors + STEPS[robot.description.name])
    back = solve_inverse(robot, moved.pose, start=home)
    np.testing.assert_allclose(back.pose, moved.pose, atol=1e-9)
    if robot.redundancy == 0:  # else others are nearer to home
        np.testing.assert_allclose(back.motors, moved.motors, atol=1e-9)


def test_jacobian_against_differences(robot):
    home, step = solve_home(robot), 1e-4
    jacobian = kinemato_statics(home).jacobian
    for motor in range(robot.motor_count):
        way = step * np.eye(robot.motor_count)[motor]
        ahead, behind = (
            solve_forward(robot, home.motors + sign * way, start=home) for sign in (1, -1)
        )
        moved = (ahead.platform_position - behind.platform_position) / (2 * step)
        linear = home.platform_rotation.T @ moved
        rows = [row for row, axis in enumerate(robot.platform_axes) if axis >= 3]
        axes = robot.platform_axes[rows] - 3
        np.testing.assert_allclose(jacobian[rows, motor], linear[axes], atol=1e-7)


def test_energy_is_the_work_of_the_motors(robot):
    """Gravity, springs and all: along a way of the motors, by Gauss' quadrature."""
    home = solve_home(robot)
    way = 3.0 * np.array(STEPS[robot.description.name])
    nodes, weights = leggauss(12)
    work, last = 0.0, home
    for node, weight in zip(0.5 * (nodes + 1.0), 0.5 * weights, strict=True):
        last = solve_forward(robot, home.motors + node * way, start=last)
        work += weight * float(last.efforts @ way)
    end = solve_forward(robot, home.motors + way, start=last)
    assert work == pytest.approx(end.energy - home.energy, rel=1e-6)


def test_the_order_of_the_legs_does_not_matter(robot):
    name = robot.description.name
    changed = shipped_content(name)
    changed["legs"].reverse()
    changed["home"]["motors"].reverse()
    other, home = load_robot(changed), solve_home(robot)
    same = solve_home(other)
    assert other.motor_names == robot.motor_names[::-1]
    np.testing.assert_allclose(same.platform_position, home.platform_position, atol=1e-9)
    np.testing.assert_allclose(same.efforts[::-1], home.efforts, atol=1e-9)


def test_a_robot_elsewhere_and_turned_is_the_same(robot):
    """Without gravity, which has a direction of its own."""
    changed = shipped_content(robot.description.name)
    changed["gravity"] = [0, 0, 0]
    original = solve_home(load_robot(changed))
    turn = rotation_exp([0, 0, 0.8] if robot.planar else [0.3, -0.5, 0.8])
    shift = np.array([0.4, -0.2, 0.0 if robot.planar else 0.7])
    for leg in changed["legs"]:
        base = leg["base"]
        base["position"] = (shift + turn @ base["position"]).tolist()
        for direction in ("tangent", "normal"):
            if direction in base:
                base[direction] = (turn @ base[direction]).tolist()
    changed["home"] |= {
        "platform": {
            "position": (shift + turn @ original.platform_position).tolist(),
            "quaternion_wxyz": quaternion_from_rotation(turn @ original.platform_rotation).tolist(),
        }
    }
    moved = solve_home(load_robot(changed))
    np.testing.assert_allclose(
        moved.platform_position, shift + turn @ original.platform_position, atol=1e-9
    )
    np.testing.assert_allclose(moved.efforts, original.efforts, atol=1e-9)
    assert moved.spectrum_locked.margin == pytest.approx(original.spectrum_locked.margin, rel=1e-7)


def test_a_shared_motor_is_the_motors_moved_together():
    """Index and efforts by the chain rule: q of the six = A q of the shared ones."""
    alone = load_robot("six_rus")
    changed, ratios = shipped_content("six_rus"), (1.0, -0.5, 1.0, 0.8, 1.0, 1.2)
    for number, (leg, ratio) in enumerate(zip(changed["legs"], ratios, strict=True)):
        leg["chain"][0] |= {"motor": f"pair{number // 2 + 1}", "ratio": ratio}
    changed |= {
        "controlled": ["z", "roll", "pitch"],
        "home": changed["home"] | {"motors": [0, 0, 0]},
    }
    paired = load_robot(changed)
    assert paired.motor_names == ("pair1", "pair2", "pair3")
    moved_by = np.zeros((6, 3))
    for number, ratio in enumerate(ratios):
        moved_by[number, number // 2] = ratio
    start = np.array([0.2, -0.1, 0.15])
    shared = solve_forward(paired, start)
    separate = solve_forward(alone, moved_by @ start)
    np.testing.assert_allclose(shared.platform_position, separate.platform_position, atol=1e-9)
    np.testing.assert_allclose(shared.platform_rotation, separate.platform_rotation, atol=1e-9)
    np.testing.assert_allclose(shared.efforts, moved_by.T @ separate.efforts, atol=1e-9)
    assert shared.index_locked == separate.index_locked
    jacobian = kinemato_statics(separate).jacobian @ moved_by
    np.testing.assert_allclose(kinemato_statics(shared).jacobian, jacobian, atol=1e-9)
    # H_r with the motors free, reduced by the chain rule: as many negative eigenvalues.
    states = np.zeros((alone.state_size, paired.state_size))
    states[: alone.arrays.motor_index, : paired.arrays.motor_index] = np.eye(
        alone.arrays.motor_index
    )
    states[alone.arrays.motor_index :, paired.arrays.motor_index :] = moved_by
    whole = states.T @ separate.tangent @ states
    unit = paired.arrays.unit
    np.testing.assert_allclose(
        shared.tangent * unit[:, None] * unit, whole * unit[:, None] * unit, atol=1e-9
    )
    signs = np.linalg.eigvalsh(0.5 * (whole + whole.T) * unit[:, None] * unit)
    held = len(paired.multiplier_indices)
    assert shared.index_free == int(np.sum(signs < 0.0)) - held
    assert shared.spectrum_free.index == shared.index_free


def test_the_six_rus_has_the_motor_angles_its_authors_give():
    """For a pose in the README of their code, solved to 1e-5, where nothing but rods weighs."""
    changed, published = shipped_content("six_rus"), [0.48785652, 0.42037453, 0.28121425]
    changed["platform"]["mass"] = 0.0
    for leg in changed["legs"]:
        del leg["chain"][1]["mass"]
    half = 0.5 * np.deg2rad(10.0)
    pose = [0.0, 0.0, 0.5, np.cos(half), np.sin(half), 0.0, 0.0]
    first, second, third = published
    expected = [first, first, second, third, third, second]
    np.testing.assert_allclose(solve_inverse(load_robot(changed), pose).motors, expected, atol=1e-4)


def test_a_limit_of_one_rod_of_two_is_named(tmp_path):
    """In errors and in maps, and what is stored of a map has a column for every rod."""
    changed = shipped_content("three_rfr_hubs")
    brittle = {"rod": {"length": 0.3, "yield_strain": 0.0036}}
    changed["legs"][1]["chain"][2:3] = [{"rod": {"length": 0.3}}, brittle]
    robot = load_robot(changed)
    assert robot.rod_names == ("leg1", "leg2.rod1", "leg2.rod2", "leg3")
    home = solve_home(robot)
    strains = bending_strains(home)
    assert strains.shape == (4,) and strains[2] < 0.0036
    with pytest.raises(StrainLimitExceeded) as caught:
        solve_forward(robot, home.motors + [0.0, 1.0, 0.0], start=home)
    assert caught.value.leg == "leg2.rod2"
    x, y = home.platform_position[:2].tolist()
    angle = float(np.arctan2(home.platform_rotation[1, 0], home.platform_rotation[0, 0]))
    grid = pose_grid(
        robot, {"x": [x, x + 0.01], "y": [y, y + 0.01]}, resolution=0.01, held={"angle": angle}
    )
    found = map_workspace(robot, grid, workers=0)
    assert found.limit_names[-1] == "strain_limit leg2.rod2"
    assert found.strains.shape == (4, 4)
    write_map(found, tmp_path / "map.nc")
    kept = read_map(tmp_path / "map.nc", robot)
    np.testing.assert_array_equal(kept.strains, found.strains)


def test_a_joint_that_nothing_holds_is_named():
    """A straight rod between two ball joints spins about itself."""
    changed = shipped_content("six_rus")
    for leg in changed["legs"]:
        leg["chain"][3:] = [{"rod": {"rest_curvature": {}}}]
    load_robot(changed)
    changed["legs"][2]["chain"].insert(3, {"joint": "revolute", "axis": [1, 0, 0]})
    with pytest.raises(NoForwardSolution, match=r"nothing holds joint leg3\.joint\d"):
        solve_home(load_robot(changed))
    changed["legs"][2]["chain"][3]["stiffness"] = 0.01
    assert solve_home(load_robot(changed)).stable


def test_what_cannot_be_closed_names_the_leg_and_the_gap():
    changed = shipped_content("six_rus")
    changed["legs"][2]["base"]["position"][0] += 3.0
    with pytest.raises(NoForwardSolution, match=r"leg3 misses its tip joint by 1\.\d+ m"):
        solve_home(load_robot(changed))


def in_pieces(name, pieces):
    """A planar shipped robot, every rod of it in pieces of equal length."""
    described = shipped_content(name)
    rod = {"rod": {"length": described["rod"]["length"] / pieces}}
    for number, leg in enumerate(described["legs"]):
        joint = {"joint": "revolute", "axis": [0, 0, 1], "motor": f"motor{number + 1}"}
        del leg["motor"]
        leg["chain"] = [joint, *([rod] * pieces)]
    return load_robot(described)


def test_natural_units_do_not_depend_on_how_a_rod_is_cut():
    """Rods in halves had half the length and twice the energy: warnings were twice as far away."""
    whole = in_pieces("rfrfr", 1)
    found = Assessment(solve_home(whole))
    for pieces in (2, 3):
        cut = in_pieces("rfrfr", pieces)
        assert cut.mean_length == pytest.approx(whole.mean_length, rel=1e-14)
        assert cut.arrays.energy_unit == pytest.approx(whole.arrays.energy_unit, rel=1e-14)
        np.testing.assert_allclose(cut.motor_units, whole.motor_units, rtol=1e-14)
        again = Assessment(solve_home(cut))
        assert again.margin == pytest.approx(found.margin, rel=5e-3)
        for name in ("forward_singularity", "inverse_singularity"):
            assert again.value(name) == pytest.approx(found.value(name), rel=0.1), (name, pieces)


def test_a_stiff_fitting_decides_no_natural_unit():
    """A thick stub of 3 cm made the unit of energy 600 times as large: the node would have halted."""
    described = shipped_content("rfrfr")
    plain = load_robot(deepcopy(described))
    fitting = {"length": 0.03, "density": 0, "section": {"shape": "circular", "radius": 0.005}}
    for number, leg in enumerate(described["legs"]):
        joint = {"joint": "revolute", "axis": [0, 0, 1], "motor": f"motor{number + 1}"}
        del leg["motor"]
        leg["chain"] = [joint, {"rod": fitting, "strain": {"bending_3": 1}}, {"rod": {}}]
    fitted = load_robot(described)
    assert fitted.mean_length == pytest.approx(1.03 * plain.mean_length)
    assert fitted.arrays.energy_unit == pytest.approx(plain.arrays.energy_unit, rel=1e-3)
    both = [Assessment(solve_home(robot)) for robot in (plain, fitted)]
    for name in ("forward_singularity", "inverse_singularity"):
        first, second = (found.value(name) for found in both)
        assert second == pytest.approx(first, rel=0.2), name

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots whose legs are chains: symmetries, work, shared motors, and angles that others published."""

import numpy as np
import pytest
from helpers.shipped_steps import CHAINS, STEPS
from helpers.yaml_content import shipped_content

from cpr_core import (
    NoForwardSolution,
    StrainLimitExceeded,
    bending_strains,
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
)
from cpr_core.lie import quaternion_from_rotation, rotation_exp
from cpr_core.workspace import map_workspace, pose_grid
from cpr_core.workspace.store import read_map, write_map


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
    states[: alone.kernel_arrays.motor_index, : paired.kernel_arrays.motor_index] = np.eye(
        alone.kernel_arrays.motor_index
    )
    states[alone.kernel_arrays.motor_index :, paired.kernel_arrays.motor_index :] = moved_by
    whole = states.T @ separate.tangent @ states
    unit = paired.kernel_arrays.unit
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
    assert caught.value.rod == "leg2.rod2"
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

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""An equilibrium as text and as JSON, with all that the next command needs."""

import numpy as np
import pytest
import yaml
from helpers.paper_motors import HOME
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose

from cpr_core import bending_strains, load_robot, solve_forward, solve_home
from cpr_core.description.controlled_coordinates import numbers_of


@pytest.mark.parametrize("name", HOME)
def test_json_says_what_was_found_and_how_well(solved, name):
    result = solved("forward", name, "--motors", *HOME[name])
    legs = len(HOME[name])
    assert result["robot"] == name
    assert result["converged"] is True
    assert 0.0 <= result["residual"] < 1e-10
    assert isinstance(result["iterations"], int)
    assert result["motor_names"] == [f"motor{k + 1}" for k in range(legs)]
    assert len(result["motors"]) == len(result["efforts"]) == legs
    assert set(result["platform"]) == {"position", "quaternion_wxyz"}
    assert len(result["platform"]["position"]) == 3
    assert np.linalg.norm(result["platform"]["quaternion_wxyz"]) == pytest.approx(1.0, abs=1e-14)
    assert len(result["leg_coordinates"]) == legs * {"rfrfr": 5, "six_rfs": 10}[name]
    assert len(result["multipliers"]) == legs * {"rfrfr": 2, "six_rfs": 3}[name]
    assert result["energy"] > 0.0
    for reading in ("locked", "free"):
        negative = result[f"smallest_eigenvalue_{reading}"] < 0.0
        assert (result[f"index_{reading}"] > 0) == negative
    assert (result["margin_locked"] > 0.0) == (result["index_locked"] == 0)
    assert result["energy_criterion_applies"] is True


@pytest.mark.parametrize("name", HOME)
def test_text_says_the_same_as_json(cpr, solved, name):
    arguments = ("forward", name, "--motors", *HOME[name])
    result = solved(*arguments)
    status, out, err = cpr(*arguments)
    assert (status, err) == (0, "")
    lines = {line.split()[0]: line.split()[1:] for line in out.splitlines()}
    for motor, position, effort in zip(
        result["motor_names"], result["motors"], result["efforts"], strict=True
    ):
        assert lines[motor] == [f"{position:.10f}", "rad", f"{effort:.10f}", "N", "m"]
    position = [f"{value:.10f}" for value in result["platform"]["position"]]
    assert lines["platform"] == [*position, "m"]
    assert lines["stable"][:4] == ["with", "motors", "held", "(index"]
    if name == "six_rfs":
        quaternion = [f"{value:.10f}" for value in result["platform"]["quaternion_wxyz"]]
        assert lines["quaternion"][:4] == quaternion
    else:
        assert "quaternion" not in lines  # a point has none
    pose = [f"{value:.10f}" for value in result["pose"]]
    assert lines["controlled"] == [*pose, *f"({' '.join(result['pose_names'])})".split()]


def strain_lines(out):
    return [line.split() for line in out.splitlines() if line.startswith("  bending ")]


@pytest.mark.parametrize("name", ["rfrfr", "gough_stewart", "six_rus"])
def test_the_largest_bending_strain_is_printed(cpr, solved, name):
    robot = load_robot(name)
    motors = solve_home(robot).motors
    strains = bending_strains(solve_forward(robot, motors))
    arguments = ("forward", name, "--motors", *motors)
    assert_allclose(solved(*arguments)["bending_strains"], strains, rtol=1e-9)
    rod = robot.rod_names[strains.argmax()]
    assert strain_lines(cpr(*arguments)[1]) == [
        f"bending {strains.max():.10f} strain of {rod}, the largest".split()
    ]


def test_the_bending_strain_nearest_to_its_limit_is_printed_where_there_are_limits(cpr, tmp_path):
    """The second leg is bent more, the first is nearer to what it bears; the third bears anything."""
    content = shipped_content("three_rfs")
    for leg, borne in zip(content["legs"], (0.006, 0.02), strict=False):
        leg["rod"] = content["rod"] | {"yield_strain": borne}
    file = tmp_path / "limits.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    home = solve_home(load_robot(file))
    moved = home.motors + [0.0, 0.1, 0.0]
    strains = bending_strains(solve_forward(home.robot, moved))
    assert strains[0] < strains[1]
    assert strains[0] / 0.006 > strains[1] / 0.02
    assert strain_lines(cpr("forward", file, "--motors", *moved)[1]) == [
        f"bending {strains[0]:.10f} strain of leg1, nearest to its yield strain 0.006".split()
    ]


def test_bending_strains_that_nobody_knows_are_null_and_not_printed(cpr, solved, tmp_path):
    content = shipped_content("rfrfr")
    stiffness = dict.fromkeys(("torsion", "bending_2", "bending_3"), 0.165)
    content["rod"] = {"length": 1.0, "section": {"shape": "given"} | stiffness}
    file = tmp_path / "given.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    arguments = ("forward", file, "--motors", *HOME["rfrfr"])
    assert solved(*arguments)["bending_strains"] == [None, None]
    assert strain_lines(cpr(*arguments)[1]) == []


@pytest.mark.parametrize("name", ["rfrfr", "three_rfr_hubs", "six_rfs", "delta"])
def test_what_forward_prints_is_a_pose_for_inverse(cpr, solved, name):
    described = load_robot(name).description
    arguments = ("forward", name, "--motors", *described.home.motors)
    result = solved(*arguments)
    assert result["pose_names"] == list(numbers_of(described.controlled))
    assert solved("inverse", name, "--pose", *result["pose"])["pose"] == pytest.approx(
        result["pose"], abs=1e-9
    )
    status, out, _ = cpr(*arguments)
    (line,) = [line for line in out.splitlines() if line.startswith("  controlled ")]
    printed = line.split("(")[0].split()[1:]
    found = solved("inverse", name, "--pose", *printed)
    assert status == 0
    assert_allclose(found["motors"], result["motors"], rtol=0.0, atol=1e-7)


def test_angles_alone_are_printed_for_inverse_too(cpr, solved, tmp_path):
    content = shipped_content("six_rfs")
    content |= {"controlled": ["z", "roll", "pitch", "yaw", "x", "y"]}
    file = tmp_path / "angles.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    result = solved("forward", file, "--motors", *HOME["six_rfs"])
    assert result["pose_names"] == ["z", "roll", "pitch", "yaw", "x", "y"]
    found = solved("inverse", file, "--pose", *result["pose"])
    assert_allclose(found["motors"], HOME["six_rfs"], rtol=0.0, atol=1e-9)


def test_robots_that_control_nothing_print_no_pose(cpr, solved, tmp_path):
    content = shipped_content("rfrfr")
    content["legs"].append(
        content["legs"][0] | {"base": {"position": [0, 0, 0], "tangent": [1, 0, 0]}}
    )
    content |= {"controlled": []}
    content["home"] = {"motors": [2.59, 0.55, 1.3], "bow": "left"}
    file = tmp_path / "nothing.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    arguments = ("forward", file, "--motors", 2.59, 0.55, 1.3)
    result = solved(*arguments)
    assert result["pose"] == result["pose_names"] == []
    assert "\n  controlled   nothing\n" in cpr(*arguments)[1] + "\n"

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Every command on robots whose legs are chains."""

import json
import math

import pytest
from helpers.chain_robots import ROBOTS

from cpr_core import load_robot, solve_home
from cpr_core.command_line import main

GRID = {
    "six_rus": ["z=0.345:0.35", "x=0:0.005", "y=0", "phi=0", "theta=0", "psi=0"],
    "rfr_with_hubs": ["x=-0.01:0.01", "y=-0.01:0.01", "angle=0"],
}
STEP = {"six_rus": 0.005, "rfr_with_hubs": 0.02}


@pytest.fixture(params=sorted(ROBOTS))
def robot(request):
    return request.param, ROBOTS[request.param]


def answered(capsys, *arguments):
    status = main([*map(str, arguments), "--json"])
    output = capsys.readouterr()
    assert status == 0, output.err
    return json.loads(output.out)


def test_forward_inverse_and_stability(capsys, robot):
    _, file = robot
    home = solve_home(load_robot(file))
    motors = (home.motors + 0.05).tolist()
    found = answered(capsys, "forward", file, "--motors", *motors)["platform"]
    pose = found["position"] + found["quaternion_wxyz"]
    if home.robot.planar:
        pose = [*found["position"][:2], 2.0 * math.atan2(*found["quaternion_wxyz"][::-3])]
    back = answered(capsys, "inverse", file, "--pose", *pose)
    assert back["motors"] == pytest.approx(motors, abs=1e-8)
    told = answered(capsys, "stability", file, "--motors", *motors)
    assert (told["index"], told["margin"] > 0.1) == (0, True)
    assert len(answered(capsys, "kinemato", file, "--motors", *motors)["jacobian"]) == len(motors)


def test_trace_with_a_picture(capsys, robot, tmp_path):
    name, file = robot
    count = {"six_rus": 6, "rfr_with_hubs": 3}[name]
    picture = tmp_path / "trace.png"
    way = ["--given", "motors", "--from", *[0.0] * count, "--to", *[0.1] * count]
    trace = answered(capsys, "trace", file, *way, "--plot", picture)
    assert trace["reached"] and trace["events"] == []
    assert trace["motors"][-1] == pytest.approx([0.1] * count)
    assert picture.stat().st_size > 10_000


def test_workspace(capsys, robot, tmp_path):
    name, file = robot
    picture = tmp_path / "map.png"
    grid = ["--slice", *GRID[name], "--resolution", STEP[name]]
    found = answered(capsys, "workspace", file, *grid, "--plot", picture)
    assert found["reached"] == 4
    assert picture.stat().st_size > 10_000

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Every command on every shipped robot whose legs are chains."""

import json

import pytest
from helpers.shipped_steps import CHAINS, REDUNDANT, STEPS

from cpr_core import load_robot, solve_forward, solve_home
from cpr_core.command_line import main

LEVEL = ["phi=0", "theta=0", "psi=0"]
#: Two steps along two axes, of this size.
GRIDS = {
    "delta": (0.01, ["x=0:0.01", "y=0:0.01", "z=-0.334"]),
    "four_rfr": (0.01, ["motor1=0.4:0.41", "motor2=0.4:0.41", "--given", "motors"]),
    "six_rus": (0.005, ["z=0.4:0.405", "x=0:0.005", "y=0", *LEVEL]),
    "three_prs": (0.01, ["z=0.39:0.4", "roll=0:0.01", "pitch=0"]),
    "three_rfr_hubs": (0.02, ["x=-0.01:0.01", "y=-0.01:0.01", "angle=0"]),
    "two_rods": (0.02, ["x=-0.01:0.01", "y=0.58:0.6"]),
}
#: Those with an inverse problem.
CONTROLLED = [name for name in CHAINS if load_robot(name).description.controlled]


@pytest.fixture(params=CHAINS)
def name(request):
    return request.param


@pytest.fixture
def equilibrium(name):
    robot = load_robot(name)
    return solve_forward(robot, solve_home(robot).motors + STEPS[name])


def answered(capsys, *arguments):
    status = main([*map(str, arguments), "--json"])
    output = capsys.readouterr()
    assert status == 0, output.err
    return json.loads(output.out)


def test_forward_stability_and_kinemato(capsys, name, equilibrium):
    motors = equilibrium.motors.tolist()
    found = answered(capsys, "forward", name, "--motors", *motors)["platform"]
    assert found["position"] == pytest.approx(equilibrium.platform_position, abs=1e-9)
    told = answered(capsys, "stability", name, "--motors", *motors)
    assert (told["index"], told["margin"] > 0.1) == (0, True)
    jacobian = answered(capsys, "kinemato", name, "--motors", *motors)["jacobian"]
    assert len(jacobian[0]) == len(motors)


@pytest.mark.parametrize("name", CONTROLLED)
def test_inverse(capsys, name, equilibrium):
    found = answered(capsys, "inverse", name, "--pose", *equilibrium.pose.tolist())
    assert found["platform"]["position"] == pytest.approx(equilibrium.platform_position, abs=1e-9)
    if name not in REDUNDANT:  # with redundant motors others are nearer to home
        assert found["motors"] == pytest.approx(equilibrium.motors, abs=1e-8)


def test_trace_with_a_picture(capsys, name, equilibrium, tmp_path):
    home, picture = solve_home(equilibrium.robot).motors.tolist(), tmp_path / "trace.png"
    way = ["--given", "motors", "--from", *home, "--to", *equilibrium.motors.tolist()]
    trace = answered(capsys, "trace", name, *way, "--plot", picture)
    assert trace["reached"] and trace["events"] == []
    assert trace["motors"][-1] == pytest.approx(equilibrium.motors)
    assert picture.stat().st_size > 10_000


def test_workspace(capsys, name, tmp_path):
    picture, (step, grid) = tmp_path / "map.png", GRIDS[name]
    found = answered(
        capsys, "workspace", name, "--slice", *grid, "--resolution", step, "--plot", picture
    )
    assert found["reached"] == 4
    assert picture.stat().st_size > 10_000

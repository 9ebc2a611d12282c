# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Modes with which legs buckle where continuous ones do: against columns, and on robots."""

import numpy as np
import pytest
from helpers.columns import AT_TIP, BENDING, LENGTH, Guided, column
from helpers.rigid_leg import rigid_leg
from helpers.yaml_content import shipped_content

from cpr_core import load_robot, solve_forward, solve_home
from cpr_core.description import joints, motors
from cpr_core.description.chain import Turn
from cpr_core.description.description_file import shipped_robots
from cpr_core.solving.buckling_modes import buckling_modes
from cpr_core.solving.chosen_modes import choose_modes, with_many_modes
from cpr_core.solving.critical_load import critical_load

HINGE = Turn((0.0, 0.0, 1.0))


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize(
    ("factor", "joint", "before", "expected"),
    [
        (1.0, joints.RevoluteJoint(AT_TIP), [HINGE], 3),
        (0.6991556596428412, joints.RevoluteJoint(AT_TIP), [], 4),
        (0.5, joints.Fixed(AT_TIP), [], 5),
    ],
)
def test_columns_buckle_where_euler_says_with_as_many_and_not_with_one_less(
    factor, joint, before, expected, planar
):
    def made(modes):
        return column(
            motors.Welded(), joint, planar=planar, modes=modes, before=before, robot=Guided
        )

    assert buckling_modes(solve_home(made(12))) == [expected]
    euler = np.pi**2 * BENDING / (factor * LENGTH) ** 2
    found = [
        critical_load(solve_home(made(modes)), [-1.0, 0.0, 0.0], limit=9.0 * euler)
        for modes in (expected - 1, expected)
    ]
    assert found[0] is None or found[0].value > 1.01 * euler
    assert euler < found[1].value < 1.01 * euler


@pytest.mark.parametrize("radius", [[0.0015, 0.00045], 0.0015])
@pytest.mark.parametrize(
    "profile", [None, {"at": [0, 0.45, 0.5, 0.55, 1], "stiffness": [1, 1, 0.1, 1, 1]}]
)
def test_uneven_rods_keep_what_it_takes(radius, profile):
    """Five modes were thought to be enough, and left forces up to 16 % too high."""
    content = truss({"tolerance": 1e-5}, fed=False)
    content["rod"]["section"]["radius"] = radius
    if profile is not None:
        content["rod"]["profile"] = profile
    chosen, many = load_robot(content), load_robot(content, modes=22)
    if not isinstance(radius, list) and profile is None:
        assert max(max(rod.modes.counts) for rod in chosen.description.rods) <= 5
    found = [critical_load(solve_home(robot), [0, 0, -1.0]).value for robot in (chosen, many)]
    assert found[0] == pytest.approx(found[1], rel=0.015)


@pytest.mark.parametrize("fed", [True, False])
def test_rods_of_a_truss_have_no_torsion_by_rounding(fed):
    """They hold the platform rigidly: it has no compliance that could be lost."""
    chosen = load_robot(truss({"tolerance": 1e-5}, fed=fed))
    assert [rod.modes.counts for rod in chosen.description.rods] == [(0, 3, 3)] * 6


def test_uneven_rods_have_modes_in_every_basis():
    """With 24 monomials there may be no home."""
    for basis in ("monomials", "chebyshev"):
        content = shipped_content("rfrfr")
        content["strain"] = {"basis": basis}
        radius = content["rod"]["section"]["radius"]
        content["rod"]["section"]["radius"] = [radius, 0.6 * radius]
        chosen = choose_modes(load_robot(content), 1e-3)
        assert all(3 <= max(rod.modes.counts) <= 24 for rod in chosen.description.rods)


def truss(strain, fed=True):
    """Six straight legs that nothing bends: guides that swivel feed or push rods with ball joints."""
    legs, lengths = [], []
    for number in range(6):
        side, way = (-1) ** (number + 1), np.radians(120.0 * (number // 2))
        base = 0.15 * np.array([*_on_ring(way + side * np.radians(20.0)), 0.0])
        tip = 0.08 * np.array([*_on_ring(way + side * np.radians(45.0)), 0.0])
        leg = tip + [0.0, 0.0, 0.35] - base
        lengths.append(float(np.linalg.norm(leg)))
        legs.append(
            {
                "base": {
                    "position": base.tolist(),
                    "tangent": leg.tolist(),
                    "normal": np.cross(leg, [0.0, 0.0, 1.0]).tolist(),
                },
                "chain": [
                    {"joint": "universal", "axes": [[0, 1, 0], [0, 0, 1]]},
                    *_pushed(f"feed{number}", fed),
                ],
                "tip": {"type": "spherical", "position": tip.tolist()},
            }
        )
    return {
        "name": "truss",
        "space": "spatial",
        "gravity": [0, 0, -9.81],
        "platform": {"mass": 0.2},
        "rod": {
            "length": lengths[0],
            "section": {"shape": "circular", "radius": 0.0015},
            "young_modulus": 75e9,
            "shear_modulus": 28e9,
        },
        "strain": strain,
        "legs": legs,
        "controlled": ["x", "y", "z", "orientation"],
        "home": {
            "motors": lengths if fed else [0.0] * 6,
            "platform": {"position": [0.0, 0.0, 0.35]},
        },
    }


def _pushed(motor, fed):
    if fed:
        return [{"rod": {}, "motor": motor}]
    return [{"joint": "prismatic", "axis": [1, 0, 0], "motor": motor}, {"rod": {}}]


def _on_ring(angle):
    return np.cos(angle), np.sin(angle)


def test_a_tolerance_keeps_what_guards_a_robot_whose_legs_nothing_bends():
    """One mode was chosen, and it buckled at 12 / pi^2 times the force, without a word."""
    many, chosen = (
        load_robot(truss({"bending_2": 10, "bending_3": 10})),
        load_robot(truss({"tolerance": 1e-5})),
    )
    forces = [critical_load(solve_home(robot), [0, 0, -1.0]).value for robot in (many, chosen)]
    assert forces[1] == pytest.approx(forces[0], rel=0.01)
    pushed = -0.97 * forces[0] * np.array([0, 0, 0, 0, 0, 1.0])
    margins = [
        solve_forward(
            robot, solve_home(robot).motors, loads=robot.default_loads.with_(wrench_world=pushed)
        ).margin
        for robot in (many, chosen)
    ]
    assert margins[1] == pytest.approx(margins[0], abs=0.01)


@pytest.mark.parametrize("name", shipped_robots())
def test_no_tolerance_leaves_fewer_than_legs_buckle_with(name):
    robot = load_robot(name)
    wanted = buckling_modes(with_many_modes(robot, 1e-2)[0])
    chosen = choose_modes(robot, 1e-2).description.rods
    first = 2 if robot.planar else 1
    assert min(wanted) >= 3
    for rod, fewest in zip(chosen, wanted, strict=True):
        assert min(rod.modes.counts[first:]) >= fewest


def test_legs_without_rods_buckle_nowhere():
    robot = rigid_leg()
    rods = len(robot.description.rods)
    assert len(robot.numbers.legs) > rods == len(buckling_modes(solve_home(robot)))
    assert len(choose_modes(robot, 1e-4).description.rods) == rods


def test_legs_that_are_bent_far_get_what_clamped_ones_take_at_most():
    assert buckling_modes(solve_home(load_robot("rfrfr", modes=9))) == [5, 5]

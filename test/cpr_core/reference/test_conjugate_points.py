# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Stability by conjugate points of continuous rods, against the index of the strain-mode model."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from helpers.reference_paths import numbers, read, straight_path
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from cpr_core import (
    InvalidRequest,
    Loads,
    Robot,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
)
from cpr_core.reference.conjugate_points import conjugate_points, robot_fields, rod_fields
from cpr_core.reference.continuous_rods import solve_continuous
from cpr_core.reference.rod_integration import integrate, transition

GRAVITY = {
    ("rfrfr", False): (0.0, 0.0, 0.0),
    ("rfrfr", True): (0.0, -9.81, 0.0),
    ("six_rfs", False): (0.0, 0.0, 0.0),
    ("six_rfs", True): (0.0, 0.0, -9.81),
}
SLICE_ROTATION = Rotation.from_euler("ZYZ", [np.pi / 8, np.pi / 3, 0.0])
X, Y, Z, TURN_X, TURN_Y, TURN_Z, COUPLE_X, COUPLE_Y, COUPLE_Z, PUSH_X, PUSH_Y, PUSH_Z = range(12)


@cache
def robot_with_twelve_modes(name):
    return load_robot(name, modes=12)


def slice_pose(y):
    x, *yz, w = SLICE_ROTATION.as_quat()
    return np.array([-0.4, y, 0.635, w, x, *yz])


def pose_between(start, goal, fraction):
    """From the home pose to the slice: position on a line, rotation about one axis."""
    first = Rotation.from_matrix(start.platform_rotation.copy())  # older scipy writes there
    turn = (SLICE_ROTATION * first.inv()).as_rotvec()
    x, *yz, w = (Rotation.from_rotvec(fraction * turn) * first).as_quat()
    position = start.platform_position + fraction * (goal[:3] - start.platform_position)
    return np.array([*position, w, x, *yz])


@cache
def start_of_path(name, heavy):
    robot = robot_with_twelve_modes(name)
    loads = Loads.none().with_(gravity=GRAVITY[name, heavy])
    if name == "rfrfr":
        return solve_inverse(robot, [0.0, 0.8], start=solve_inverse(robot, [0.0, 0.8]), loads=loads)
    equilibrium, goal = solve_home(robot), slice_pose(0.0)
    for fraction in np.linspace(0.0, 1.0, 11)[1:]:
        equilibrium = solve_inverse(
            robot, pose_between(solve_home(robot), goal, fraction), start=equilibrium
        )
    return solve_inverse(robot, goal, start=equilibrium, loads=loads)


def path(name, heavy, values):
    """Equilibria along the two lines of the paper's stability studies."""
    equilibrium = start_of_path(name, heavy)
    for value in values:
        pose = [0.0, value] if name == "rfrfr" else slice_pose(value)
        equilibrium = solve_inverse(equilibrium.robot, pose, start=equilibrium)
        yield equilibrium


def test_rod_agrees_with_a_general_solver():
    rigidities, distributed = np.array([0.3, 0.2, 0.2]), np.array([0.1, -0.4, 0.3])
    frame = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    moment, force = np.array([0.1, 0.4, -0.3]), np.array([0.5, -0.7, 0.9])

    def slope(s, y):
        rotation, m, n = y[3:12].reshape(3, 3), y[12:15], y[15:]
        curvature = rotation @ (rotation.T @ m / rigidities)
        return np.concatenate(
            [
                rotation[:, 0],
                np.cross(curvature, rotation.T).T.ravel(),
                -np.cross(rotation[:, 0], n),
                -distributed,
            ]
        )

    start = np.concatenate([np.zeros(3), frame.ravel(), moment, force])
    expected = solve_ivp(slope, (0.0, 1.3), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    rod = integrate((np.zeros(3), frame, moment, force), 1.3, rigidities, distributed)
    assert_allclose(rod.states[-1][:18], expected, atol=1e-11)
    assert_allclose(rod.at(0.5)[:18], rod.states[32][:18], atol=0.0)
    back = integrate(
        (expected[:3], expected[3:12], expected[12:15], expected[15:]),
        -1.3,
        rigidities,
        distributed,
    )
    assert_allclose(back.states[-1][:18], start, atol=1e-11)


@pytest.mark.parametrize("kind", ["turn", "couple", "push"])
def test_variations_of_a_rod_agree_with_differences(kind):
    rigidities, distributed = np.array([0.3, 0.2, 0.2]), np.array([0.1, -0.4, 0.3])
    frame = Rotation.from_rotvec([0.3, -0.8, 0.5])
    moment, force = np.array([0.1, 0.4, -0.3]), np.array([0.5, -0.7, 0.9])

    def rod(change):
        turn, couple, push = (
            change if kind == k else np.zeros(3) for k in ("turn", "couple", "push")
        )
        turned = (Rotation.from_rotvec(turn) * frame).as_matrix()
        start = (np.zeros(3), turned, moment + couple, force + push)
        return integrate(start, 1.3, rigidities, distributed)

    column, h = {"turn": 0, "couple": 3, "push": 6}[kind], 1e-5
    middle = rod(np.zeros(3)).states[-1]
    variations = transition(middle)[:9, 3:]
    for axis in range(3):
        above, below = rod(h * np.eye(3)[axis]).states[-1], rod(-h * np.eye(3)[axis]).states[-1]
        slope = (above - below)[:18] / (2 * h)
        spin = slope[3:12].reshape(3, 3) @ middle[3:12].reshape(3, 3).T
        turn = [spin[2, 1], spin[0, 2], spin[1, 0]]
        expected = np.concatenate([slope[:3], turn, slope[12:15]])
        assert_allclose(variations[:, column + axis], expected, atol=1e-8)


def test_continuous_rods_on_the_rfrfr_path():
    rows = read("rfrfr_forward_path.csv")
    equilibrium = solve_home(load_robot("rfrfr"))
    for row in rows:
        equilibrium = solve_forward(equilibrium.robot, numbers(row, "q1", "q2"), start=equilibrium)
        rods = solve_continuous(equilibrium)
        assert rods.residual < 1e-11
        assert rods.integration_error < 1e-11
        assert_allclose(rods.platform_position[:2], numbers(row, "x", "y"), atol=1e-11)
        assert_allclose(rods.efforts, numbers(row, "tau1", "tau2"), atol=1e-11)
        assert_allclose(rods.base_wrenches[0, 3:5], numbers(row, "F1x", "F1y"), atol=1e-11)
        assert len(conjugate_points(rods)) == row["nneg_lock"]
    assert len(rows) == 51


def test_continuous_rods_on_the_six_rfs_path():
    rows = read("6rfs_forward_path.csv")
    motors = [f"q{k}" for k in range(1, 7)]
    expected = {int(row["t"]): row for row in rows}
    equilibrium, compared = solve_home(load_robot("six_rfs")), 0
    for t, target in enumerate(straight_path(rows, motors)):
        equilibrium = solve_forward(equilibrium.robot, target, start=equilibrium)
        if t not in expected:
            continue
        row, rods = expected[t], solve_continuous(equilibrium)
        assert rods.residual < 1e-11
        assert rods.integration_error < 1e-11
        assert_allclose(rods.platform_position, numbers(row, "px", "py", "pz"), atol=1e-11)
        quaternion = numbers(row, "qw", "qx", "qy", "qz")
        assert_allclose(rods.platform_quaternion, quaternion, atol=1e-11)
        efforts = numbers(row, *(f"tau{k}" for k in range(1, 7)))
        assert_allclose(rods.efforts, efforts, atol=1e-11)
        assert len(conjugate_points(rods)) == row["nneg_lock"]
        compared += 1
    assert compared == len(rows) == 6


@pytest.mark.parametrize(
    ("mass", "loads"),
    [
        (0.0, {"gravity": [0.3, -0.2, -9.81], "rod_force": [0.05, 0.1, -0.08]}),
        (0.02, {"gravity": [0.0, 0.0, -9.81], "wrench_world": [0, 0, 0, 0.1, -0.15, 0.2]}),
        (0.0, {"wrench_world": [0.01, 0.02, -0.01, 0, 0, 0]}),
        (0.0, {"wrench_body": [0.01, -0.01, 0.02, 0.1, 0.05, -0.1]}),
    ],
)
def test_continuous_rods_under_loads_agree_with_twelve_modes(mass, loads):
    description = replace(
        robot_with_twelve_modes("six_rfs").description,
        platform_mass=mass,
        center_of_mass=np.array([0.02, -0.01, 0.03]),
    )
    robot, loads = Robot(description), Loads.none().with_(**loads)
    modes = solve_forward(robot, solve_home(robot).motors, loads=loads)
    rods = solve_continuous(modes)
    assert rods.integration_error < 1e-11
    assert_allclose(rods.platform_position, modes.platform_position, atol=1e-8)
    assert_allclose(rods.platform_rotation, modes.platform_rotation, atol=1e-8)
    assert_allclose(rods.efforts, modes.efforts, atol=1e-8)
    if loads.conservative(planar=False):
        assert len(conjugate_points(rods)) == modes.index_locked
    held = solve_continuous(modes, "pose")
    assert_allclose(held.platform_position, modes.platform_position, atol=0.0)
    assert_allclose(held.motors, modes.motors, atol=1e-7)


@pytest.mark.parametrize("heavy", [False, True])
@pytest.mark.parametrize(
    ("name", "ends"),
    [
        ("rfrfr", (0.8, -0.2)),
        pytest.param("six_rfs", (0.0, 0.2), marks=pytest.mark.slow),
    ],
)
def test_as_many_conjugate_points_as_negative_eigenvalues(name, ends, heavy):
    seen = set()
    for equilibrium in path(name, heavy, np.linspace(*ends, 50)):
        rods = solve_continuous(equilibrium, "pose")
        # Truncation, worst where the legs bend most: 6e-5, 2e-5, 5e-6 with 12, 14, 16 modes.
        assert_allclose(rods.motors, equilibrium.motors, atol=1e-4)
        fields = robot_fields(rods)
        points = conjugate_points(fields)
        assert len(points) == equilibrium.index_locked
        seen.add(len(points))
        for point in set(points):
            dependent = np.sum(fields.singular_values(point) < 1e-9)
            assert dependent == points.count(point)
    assert seen == ({0, 1, 2} if name == "rfrfr" else {0, 1})


@pytest.mark.parametrize(
    ("name", "expected", "bracket"),
    [
        ("rfrfr", 0.03571, (0.06, 0.01)),
        ("rfrfr", -0.05740, (-0.03, -0.08)),
        ("six_rfs", 0.16700, (0.15, 0.18)),
    ],
)
def test_a_conjugate_point_reaches_the_base_where_stability_is_lost(name, expected, bracket):
    (start,) = path(name, False, bracket[:1])

    def equilibrium(value):
        pose = [0.0, value] if name == "rfrfr" else slice_pose(value)
        return solve_inverse(start.robot, pose, start=start)

    def determinant(value):
        return robot_fields(solve_continuous(equilibrium(value), "pose")).determinant(0.0)

    crossing = brentq(determinant, *bracket, xtol=1e-9)
    assert crossing == pytest.approx(expected, abs=1e-5)
    side = 1e-4 * np.sign(bracket[1] - bracket[0])
    before, after = equilibrium(crossing - side), equilibrium(crossing + side)
    assert after.index_locked == before.index_locked + 1
    stable, lost = (
        conjugate_points(solve_continuous(solution, "pose")) for solution in (before, after)
    )
    assert len(lost) == len(stable) + 1
    assert lost[0] < 1e-2  # the new one has just come in at the base


@pytest.mark.parametrize("heavy", [False, True])
def test_variations_are_conjugate_and_rods_close(heavy):
    for name in ("rfrfr", "six_rfs"):
        equilibrium = start_of_path(name, heavy)
        fields = robot_fields(solve_continuous(equilibrium))
        for u in (0.0, 0.31, 0.8):
            b, z = fields.at(u)
            work = b.T @ z
            assert_allclose(work, work.T, atol=1e-11 * np.abs(work).max())
        for rod, leg in zip(fields.rods, equilibrium.robot.description.legs, strict=True):
            assert_allclose(rod.states[-1][:3], leg.base_position, atol=1e-11)


#: Tip conditions with the effective-length factor K, and k (l - u l) at the conjugate points.
COLUMNS = {
    "free": (
        2.0,
        [X, Y, Z, TURN_X, TURN_Y, TURN_Z],
        [0.5 * np.pi, 1.5 * np.pi, 2.5 * np.pi],
    ),
    "pinned": (
        0.699,
        [X, PUSH_Y, PUSH_Z, TURN_X, TURN_Y, TURN_Z],
        [brentq(lambda x: np.sin(x) - x * np.cos(x), *b, xtol=1e-14) for b in ((4, 5), (7, 8))],
    ),
    "clamped": (
        0.5,
        [X, PUSH_Y, PUSH_Z, COUPLE_X, COUPLE_Y, COUPLE_Z],
        [2 * np.pi, 8.986818915818128],
    ),
    "guided": (1.0, [X, Y, Z, COUPLE_X, COUPLE_Y, COUPLE_Z], [np.pi, 2 * np.pi]),
}


def column(load, free, planar=False):
    """A straight column of length 0.7 m along x, E J = 0.4 N m^2, under a dead axial load."""
    tip = ([0.7, 0.0, 0.0], np.eye(3), np.zeros(3), [-load, 0.0, 0.0])
    return rod_fields(tip, 0.7, np.array([0.3, 0.4, 0.4]), free, planar=planar)


@pytest.mark.parametrize("tip", COLUMNS)
def test_euler_columns_buckle_at_their_classical_loads(tip):
    factor, free, roots = COLUMNS[tip]
    euler = 0.4 * np.pi**2 / 0.7**2
    in_plane = [component for component in free if component in (X, Y, TURN_Z, COUPLE_Z, PUSH_Y)]

    def at_base(load):
        return column(load, in_plane, planar=True).determinant(0.0)

    critical = brentq(at_base, 0.8 * euler / factor**2, 1.2 * euler / factor**2, xtol=1e-13)
    assert np.sqrt(euler / critical) == pytest.approx(factor, abs=5e-4)
    assert critical == pytest.approx(0.4 * (roots[0] / 0.7) ** 2, rel=1e-11)
    # Just beyond the last root all the conjugate points are there; a round column bends either way.
    wave_number = 1.02 * roots[-1] / 0.7
    expected = sorted(1.0 - np.array(roots) / (0.7 * wave_number))
    load = 0.4 * wave_number**2
    assert_allclose(conjugate_points(column(load, in_plane, planar=True)), expected, atol=1e-10)
    assert_allclose(conjugate_points(column(load, free)), np.repeat(expected, 2), atol=1e-8)
    assert not conjugate_points(column(0.99 * critical, free))
    assert not conjugate_points(column(-5.0 * critical, free))


def test_determinants_at_several_sections_are_those_at_each():
    fields = column(80.0, COLUMNS["clamped"][1])
    sections = np.linspace(0.0, 0.9, 7)
    each = [fields.determinant(section) for section in sections]
    assert_allclose(fields.determinants(sections), each, rtol=1e-12)


def test_column_hinged_at_both_ends():
    """A hinge instead of the clamp at the section: the determinant of (dp, dm)."""

    def hinged(load):
        places, wrenches = column(load, [X, PUSH_Y, TURN_Z], planar=True).at(0.0)
        return np.linalg.det(np.vstack([places[:2], wrenches[2:]]))

    euler = 0.4 * np.pi**2 / 0.7**2
    assert brentq(hinged, 0.8 * euler, 1.2 * euler, xtol=1e-13) == pytest.approx(euler, rel=1e-11)


def test_what_the_method_does_not_cover_is_refused():
    for name, match in (("gough_stewart", "revolute motor"), ("planar_body", "takes no moment")):
        with pytest.raises(InvalidRequest, match=match):
            robot_fields(solve_continuous(solve_home(load_robot(name))))
    robot = robot_with_twelve_modes("six_rfs")
    twisted = Loads.none().with_(wrench_world=[0.01, 0.0, 0.0, 0.0, 0.0, 0.0])
    rods = solve_continuous(solve_forward(robot, solve_home(robot).motors, loads=twisted))
    with pytest.raises(InvalidRequest, match="potential"):
        conjugate_points(rods)

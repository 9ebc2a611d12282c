# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The class of robots: what must hold for every shipped one, and the parts none of them has."""

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from helpers.shipped_steps import REDUNDANT, STEPS
from helpers.strain_bases import with_basis
from helpers.yaml_content import shipped_content
from scipy.integrate import quad

from cpr_core import (
    CprError,
    DescriptionError,
    InvalidRequest,
    Loads,
    MotorLimitExceeded,
    Robot,
    bending_strains,
    find_equilibria,
    leg_shapes,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
    trace,
)
from cpr_core.description.description_file import shipped_robots
from cpr_core.description.loads import DistributedForce, PointForce
from cpr_core.description.motors import Extensible, Prismatic, RevoluteMotor, Welded
from cpr_core.description.robot_description import HomeGuess
from cpr_core.lie import roll_pitch_yaw, rotation_exp
from cpr_core.model.robot import kept_with_robot

HEAVY = {True: [0.5, -2.0, 0.0], False: [0.5, -1.0, -9.81]}


@pytest.fixture(scope="module", params=sorted(shipped_robots()))
def robot(request):
    return load_robot(request.param)


@pytest.fixture(scope="module", params=sorted(set(shipped_robots()) - set(REDUNDANT)))
def square(request):
    return load_robot(request.param)


def moved(robot, start=None, loads=None):
    motors = solve_home(robot).motors + np.array(STEPS[robot.description.name])
    return solve_forward(robot, motors, start=start, loads=loads)


def heavy(robot):
    return robot.default_loads.with_(gravity=HEAVY[robot.planar])


def test_every_shipped_robot_has_a_step():
    assert set(STEPS) == set(shipped_robots())


def test_home_is_stable(robot):
    assert solve_home(robot).converged
    assert solve_home(robot).index_locked == 0
    np.testing.assert_array_equal(solve_home(robot).motors, robot.description.home.motors)


def test_the_inverse_problem_gives_back_the_motors(square):
    forward = moved(square, loads=heavy(square))
    back = solve_inverse(square, forward.pose, loads=heavy(square))
    np.testing.assert_allclose(back.motors, forward.motors, atol=1e-9)
    np.testing.assert_allclose(back.efforts, forward.efforts, atol=1e-6)


def test_the_efforts_lead_back_to_the_motors(robot):
    start = moved(robot, loads=heavy(robot))
    onward = solve_forward(
        robot, start.motors + 0.2 * np.array(STEPS[robot.description.name]), start=start
    )
    back = solve_forward_by_effort(robot, start.efforts, start=onward)
    np.testing.assert_allclose(back.motors, start.motors, atol=1e-8)


def test_the_hessian_is_symmetric_under_conservative_loads(robot):
    loaded = moved(robot, loads=heavy(robot))
    unit = robot.arrays.unit
    tangent = loaded.tangent * unit[:, None] * unit
    np.testing.assert_allclose(tangent, tangent.T, atol=1e-10 * np.abs(tangent).max())


def test_energy_gained_is_the_work_of_the_motors(robot):
    first = solve_forward(robot, solve_home(robot).motors, loads=heavy(robot))
    last = moved(robot, start=first)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    step, equilibrium, work = last.motors - first.motors, first, 0.0
    for node, weight in zip(0.5 * (nodes + 1.0), 0.5 * weights, strict=True):
        equilibrium = solve_forward(robot, first.motors + node * step, start=equilibrium)
        work += weight * equilibrium.efforts @ step
    assert last.energy - first.energy == pytest.approx(work, rel=1e-6)


def turned_description(description, turn, shift):
    """The whole robot somewhere else."""

    def motor(motor):
        if isinstance(motor, RevoluteMotor | Prismatic):
            return type(motor)(tuple(turn @ motor.axis))
        assert isinstance(motor, Extensible | Welded)
        return motor

    home = description.home
    return replace(
        description,
        legs=tuple(
            replace(
                leg,
                base_position=turn @ leg.base_position + shift,
                base_rotation=turn @ leg.base_rotation,
                motor=motor(leg.motor),
            )
            for leg in description.legs
        ),
        home=HomeGuess(
            motors=home.motors,
            platform_position=None
            if home.platform_position is None
            else turn @ home.platform_position + shift,
            platform_rotation=turn @ home.platform_rotation,
            strain=home.strain,
            bow=tuple(None if side is None else turn @ side for side in home.bow),
        ),
        loads=description.loads.with_(gravity=turn @ description.gravity),
    )


def test_a_robot_turned_and_shifted_with_its_loads_does_the_same(robot):
    turn = rotation_exp([0.0, 0.0, 0.7] if robot.planar else [0.4, -0.8, 0.5])
    shift = np.array([1.0, -2.0, 0.0 if robot.planar else 0.5])
    wrench = np.array([0.0, 0.0, 0.0, 0.05, -0.08, 0.0 if robot.planar else 0.1])
    other = Robot(turned_description(robot.description, turn, shift))
    original = moved(robot, loads=heavy(robot).with_(wrench_world=wrench))
    turned = moved(
        other,
        loads=other.default_loads.with_(
            gravity=turn @ HEAVY[robot.planar],
            wrench_world=np.concatenate([turn @ wrench[:3], turn @ wrench[3:]]),
        ),
    )
    np.testing.assert_allclose(
        turned.platform_position, turn @ original.platform_position + shift, atol=1e-9
    )
    if not robot.description.point_platform:
        np.testing.assert_allclose(
            turned.platform_rotation, turn @ original.platform_rotation, atol=1e-9
        )
    np.testing.assert_allclose(turned.efforts, original.efforts, atol=1e-8)
    np.testing.assert_allclose(turned.leg_coordinates, original.leg_coordinates, atol=1e-8)
    np.testing.assert_allclose(
        turned.spectrum_locked.eigenvalues,
        original.spectrum_locked.eigenvalues,
        rtol=1e-7,
        atol=1e-9,
    )


@pytest.mark.parametrize("name", sorted(STEPS))
@pytest.mark.parametrize("basis", ["chebyshev", "monomials", "bsplines"])
def test_the_basis_does_not_matter_for_the_same_polynomials(name, basis):
    content = shipped_content(name)
    content["strain"] |= {"basis": basis}
    if basis == "bsplines":  # without knots: Bernstein polynomials
        content["strain"] |= {"degree": 4, "knots": []}
        if content["strain"].get("torsion"):
            content["strain"]["torsion"] = 5
    reference = load_robot(name)
    if content["strain"].get("torsion") == 5:
        legendre = shipped_content(name)
        legendre["strain"]["torsion"] = 5
        reference = load_robot(legendre)
    found, expected = moved(load_robot(content)), moved(reference)
    np.testing.assert_allclose(found.platform_position, expected.platform_position, atol=1e-8)
    np.testing.assert_allclose(found.efforts, expected.efforts, atol=1e-7)
    np.testing.assert_allclose(
        found.spectrum_locked.eigenvalues, expected.spectrum_locked.eigenvalues, rtol=1e-5
    )


def test_splines_with_knots_approach_the_same_solution():
    content = shipped_content("six_rfs")
    content["strain"] = {"basis": "bsplines", "degree": 4, "knots": [0.2, 0.4, 0.6, 0.8]}
    content["strain"]["torsion"] = 0
    found, expected = moved(load_robot(content)), moved(load_robot("six_rfs", modes=12))
    np.testing.assert_allclose(found.platform_position, expected.platform_position, atol=2e-5)


@pytest.mark.parametrize("name", sorted(STEPS))
def test_the_error_falls_spectrally_with_the_modes(name):
    exact = moved(load_robot(name, modes=14))
    errors = [
        np.linalg.norm(moved(load_robot(name, modes=m)).platform_position - exact.platform_position)
        for m in (3, 5, 7, 9, 11)
    ]
    # A factor of five a mode on the whole, down to rounding.
    assert errors[-1] < max(errors[0] * 5.0**-8, 1e-10)


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
    assert len(load_robot("rfrfr").fed_rods) == 0
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


def cantilever(**rod):
    """One clamped rod of length 0.5 m with a free platform at its tip, in the plane."""
    leg = {
        "base": {"position": [0, 0, 0], "tangent": [1, 0, 0]},
        "motor": {"type": "welded"},
        "tip": {"type": "fixed", "position": [0, 0, 0], "tangent": [1, 0, 0]},
        "rod": {
            "length": 0.5,
            "section": {"shape": "given", "torsion": 0.1, "bending_2": 0.2, "bending_3": 0.2},
            **rod,
        },
    }
    return {
        "name": "cantilever",
        "space": "planar",
        "rod": leg["rod"],
        "legs": [leg],
        "strain": {"bending_3": 10},
        "stations": [0.4],
        "controlled": [],
        "home": {
            "motors": [],
            "platform": {"position": [0.5, 0, 0]},
            "strain": [{}],
        },
    }


LENGTH, BENDING = 0.5, 0.2


def deflection(content, loads=None):
    robot = load_robot(content)
    return solve_forward(robot, [], loads=loads).platform_position[1]


def test_a_point_force_bends_like_the_textbook_beam():
    force, at = 1e-5, 0.4 * LENGTH
    loads = Loads.none().with_(points=[PointForce("leg1", 0.4, np.array([0.0, force, 0.0]))])
    expected = force * at**2 * (3.0 * LENGTH - at) / (6.0 * BENDING)
    assert deflection(cantilever(), loads) == pytest.approx(expected, rel=1e-4)


def test_a_triangular_load_bends_like_the_textbook_beam():
    force = np.array([[0.0, 1e-4, 0.0], [0.0, 0.0, 0.0]])
    loads = Loads.none().with_(distributed=[DistributedForce("leg1", np.array([0.0, 1.0]), force)])
    expected = 1e-4 * LENGTH**4 / (30.0 * BENDING)
    assert deflection(cantilever(), loads) == pytest.approx(expected, rel=1e-7)


def test_loads_of_the_description_act_from_home_on():
    content = cantilever()
    content["loads"] = {
        "points": [{"leg": "leg1", "at": 0.7, "force": [0, 1e-5, 0]}],
        "distributed": [
            {"leg": "leg1", "at": [0, 0.5, 1], "force": [[0, 0, 0], [0, 1e-4, 0], [0, 0, 0]]}
        ],
        "platform_force": [0, 2e-5, 0],
    }
    at = 0.7 * LENGTH
    expected = 1e-5 * at**2 * (3.0 * LENGTH - at) / (6.0 * BENDING)
    expected += 2e-5 * LENGTH**3 / (3.0 * BENDING)
    hat, _ = quad(
        lambda s: (1.0 - abs(2.0 * s / LENGTH - 1.0)) * s**2 * (3.0 * LENGTH - s),
        0.0,
        LENGTH,
        points=[0.25],
    )
    expected += 1e-4 * hat / (6.0 * BENDING)
    found = solve_home(load_robot(content)).platform_position[1]
    assert found == pytest.approx(expected, rel=1e-4)


def test_a_tapered_rod_bends_as_its_stiffness_says():
    content = cantilever(profile={"at": [0, 0.5, 1], "stiffness": [1.0, 0.6, 0.5]})
    content["strain"] = {"basis": "bsplines", "degree": 5, "knots": [0.5]}
    force = 1e-5

    def compliance(s):
        return (LENGTH - s) ** 2 / (BENDING * np.interp(s / LENGTH, [0, 0.5, 1], [1.0, 0.6, 0.5]))

    expected = force * quad(compliance, 0.0, LENGTH, points=[0.25])[0]
    loads = Loads.none().with_(wrench_world=[0, 0, 0, 0, force, 0])
    assert deflection(content, loads) == pytest.approx(expected, rel=1e-4)


def test_the_mass_of_a_tapered_rod_is_what_its_profile_says():
    section = {"shape": "given", "torsion": 1, "bending_2": 1, "bending_3": 1, "mass": 0.2}
    content = cantilever(section=section, profile={"at": [0, 0.3, 1], "mass": [1.0, 0.5, 0.2]})
    robot = load_robot(content)
    weight = robot.load_arrays(Loads.none().with_(gravity=[0, -10.0, 0])).distributed[0, 1, -1]
    mean = 0.3 * 0.75 + 0.7 * 0.35
    assert weight == pytest.approx(-10.0 * 0.2 * mean, rel=1e-12)


@pytest.mark.parametrize("curvature", [0.5, -4.0])
def test_a_rod_curved_at_rest_is_an_arc_without_stress(curvature):
    robot = load_robot(cantilever(rest_curvature={"bending_3": [curvature]}))
    home = solve_home(robot)
    angle = curvature * LENGTH
    np.testing.assert_allclose(
        home.platform_position[:2],
        [np.sin(angle) / curvature, (1.0 - np.cos(angle)) / curvature],
        atol=1e-10,
    )
    assert home.energy == pytest.approx(0.0, abs=1e-12)
    assert home.spectrum_locked.margin == pytest.approx(1.0, abs=1e-9)


def test_forces_at_other_places_than_stations_are_refused():
    robot = load_robot(cantilever())
    off = PointForce("leg1", 0.33, np.array([0.0, 1.0, 0.0]))
    with pytest.raises(InvalidRequest, match=r"station of the robot \(0\.4\), got 0\.33"):
        solve_forward(robot, [], loads=Loads.none().with_(points=[off]))
    unknown = PointForce("arm", 0.4, np.array([0.0, 1.0, 0.0]))
    with pytest.raises(InvalidRequest, match="expected a leg out of leg1, got 'arm'"):
        solve_forward(robot, [], loads=Loads.none().with_(points=[unknown]))


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


BAD = {
    "spin that nothing holds": (
        "legs[0].motor.spin",
        lambda c: c["legs"][0].update(
            motor={"type": "extensible", "spin": True},
            tip={"type": "spherical", "position": [0, 0, 0]},
        ),
    ),
    "misspelt field": (
        "rod",
        lambda c: c["rod"].update(lenght=c["rod"].pop("length")),
    ),
    "force at the tip": (
        "loads.points[0].at",
        lambda c: c["loads"]["points"][0].update(at=1),
    ),
    "dangling leg": ("loads.points[0].leg", lambda c: c["loads"]["points"][0].update(leg="arm")),
    "tube without wall": (
        "rod.section.inner_radius",
        lambda c: c["rod"].update(
            section={"shape": "annular", "radius": 0.001, "inner_radius": 0.001},
            young_modulus=1e9,
            shear_modulus=1e9,
        ),
    ),
    "no modulus": (
        "rod",
        lambda c: c["rod"].update(section={"shape": "circular", "radius": 0.001}),
    ),
    "field of another section": ("rod.section", lambda c: c["rod"]["section"].update(radius=1.0)),
    "stations that fall": (
        "rod.profile.at",
        lambda c: c["rod"].update(profile={"at": [0, 0.7, 0.5, 1]}),
    ),
    "factors that are missing": (
        "rod.profile.stiffness",
        lambda c: c["rod"].update(profile={"at": [0, 0.5, 1], "stiffness": [1, 2]}),
    ),
    "limits reversed": (
        "legs[0].motor.limits.position",
        lambda c: c["legs"][0]["motor"].update(limits={"position": [1, -1]}),
    ),
    "tapered extensible leg": (
        "legs[0].motor.type",
        lambda c: (
            c["legs"][0].update(motor={"type": "extensible"}),
            c["rod"].update(profile={"at": [0, 1], "stiffness": [1, 2]}),
        ),
    ),
    "length that can vanish": (
        "legs[0].motor.limits.position",
        lambda c: c["legs"][0].update(
            motor={"type": "extensible", "limits": {"position": [0.0, 1.0]}}
        ),
    ),
    "spin of a revolute motor": (
        "legs[0].motor",
        lambda c: c["legs"][0]["motor"].update(spin=True),
    ),
    "wrong number of splines": (
        "strain",
        lambda c: c.update(strain={"basis": "bsplines", "degree": 3, "bending_3": 7}),
    ),
    "knots of polynomials": ("strain.knots", lambda c: c.update(strain={"knots": [0.5]})),
    "planar universal joint": (
        "legs[0].tip.type",
        lambda c: c["legs"][0].update(
            tip={"type": "universal", "position": [0, 0, 0], "axis": [1, 0, 0]}
        ),
    ),
    "planar rod curved out of the plane": (
        "rod.rest_curvature",
        lambda c: c["rod"].update(rest_curvature={"bending_2": [1.0]}),
    ),
    "force out of the plane": (
        "loads.points[0].force",
        lambda c: c["loads"]["points"][0].update(force=[0, 0, 1]),
    ),
    "more vectors than stations": (
        "loads.distributed[0].force",
        lambda c: c["loads"].update(
            distributed=[{"leg": "leg1", "at": [0, 1], "force": [[0, 1, 0]] * 3}]
        ),
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_descriptions_name_the_field(case):
    field, spoil = BAD[case]
    content = cantilever()
    del content["legs"][0]["rod"]
    content["legs"][0]["motor"] = {"type": "revolute", "axis": [0, 0, 1]}
    content["controlled"], content["home"]["motors"] = ["angle"], [0.0]
    content["loads"] = {"points": [{"leg": "leg1", "at": 0.4, "force": [0, 0.001, 0]}]}
    load_robot(content)
    spoil(content)
    with pytest.raises(DescriptionError) as caught:
        load_robot(content)
    assert caught.value.field == field, caught.value
    assert caught.value.problem


@pytest.mark.parametrize("tip", [{"type": "fixed", "tangent": [1, 0, 0]}, {"type": "revolute"}])
def test_spatial_tips_need_their_directions(tip):
    content = shipped_content("three_rfs")
    content["legs"][1]["tip"] = {"position": [0, 0.1, 0], **tip}
    with pytest.raises(DescriptionError, match=r"legs\[1\]\.tip: missing field '(normal|axis)'"):
        load_robot(content)


@pytest.fixture
def yaml_file(tmp_path):
    def write(text):
        path = tmp_path / "robot.yaml"
        path.write_text(text)
        return path

    return write


def test_parts_of_a_file_can_be_shared_by_anchors_and_merge_keys(yaml_file):
    text = shipped_robots()["rfrfr"].read_text()
    tip = "tip: {type: revolute, position: [0, 0, 0]}"
    shared = text.replace(tip, "tip: &tip {type: revolute, position: [0, 0, 0]}", 1)
    shared = shared.replace(tip, "tip: {<<: *tip}", 1)
    assert shared.count("tip") > 2
    robot = load_robot(yaml_file(shared))
    assert robot.description.legs[1].joint == load_robot("rfrfr").description.legs[1].joint


def test_numbers_are_read_as_they_look(yaml_file):
    text = shipped_robots()["rfrfr"].read_text()
    robot = load_robot(yaml_file(text.replace("density: 7800", "density: 07800")))
    assert robot.description.legs[0].rod.density == 7800.0
    with pytest.raises(DescriptionError, match=r"home\.motors\[0\]: expected number, got '1:30'"):
        load_robot(yaml_file(text.replace("[2.59, 0.55]", "[1:30, 0.55]")))


def test_planar_homes_bend_in_the_plane(yaml_file):
    text = shipped_robots()["rfrfr"].read_text()
    with pytest.raises(DescriptionError, match=r"home\.strain\[0\]: a planar robot bends"):
        load_robot(yaml_file(text.replace("bow: outward", "strain: [{bending_2: [-2.0]}, {}]")))


def test_a_folder_is_no_description(tmp_path):
    with pytest.raises(DescriptionError, match="it is a folder"):
        load_robot(tmp_path)


def test_what_is_no_file_is_said_to_be_something_else():
    with pytest.raises(DescriptionError, match="it is something else"):
        load_robot("/dev/null")


@pytest.mark.parametrize("ask", [solve_home, leg_shapes, bending_strains])
@pytest.mark.parametrize("given", ["six_rfs", 3.5])
def test_what_is_no_robot_and_no_equilibrium_is_named(ask, given):
    """A string ended in words about attributes."""
    with pytest.raises(InvalidRequest, match=r"expected an? (Robot|Equilibrium), got"):
        ask(given)
    if ask is not solve_home:
        with pytest.raises(InvalidRequest, match="expected an Equilibrium, got"):
            ask(load_robot("rfrfr"))


@pytest.mark.parametrize("values", [["1", "2"], [True, False], [1.0, None]])
def test_words_and_truth_values_are_no_motor_positions(values):
    with pytest.raises(InvalidRequest, match="motors: expected 2 numbers"):
        solve_forward(load_robot("rfrfr"), values)


def test_threads_that_search_at_once_keep_the_same():
    robot, together = load_robot("rfrfr"), threading.Barrier(4)

    @kept_with_robot
    def find(searched, number):
        assert searched is robot
        together.wait(timeout=60)
        return object()

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: find(robot, 7), range(4)))
    assert len(set(found)) == 1
    assert find(robot, 7) is found[0]
    together.abort()
    with pytest.raises(threading.BrokenBarrierError):
        find(robot, 8)  # another question: searched for again


def test_so_many_answers_are_kept_and_the_oldest_go_first():
    robot, asked = load_robot("rfrfr"), []

    @partial(kept_with_robot, most=2, by=lambda numbers: numbers.tobytes())
    def find(_, numbers):
        asked.append(numbers.tolist())  # None is an answer as any other

    for number in (1, 2, 1, 3, 2, 1, 3):
        find(robot, np.array([number]))
    assert asked == [[1], [2], [3], [1]]


def test_modes_that_are_not_independent_are_refused_with_the_reason():
    """Of so many monomials the last are sums of the others, but for rounding."""
    with pytest.raises(DescriptionError, match=r"strain: expected modes that are independent"):
        solve_home(with_basis("rfrfr", "monomials", 20))

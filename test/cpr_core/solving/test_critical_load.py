# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Critical loads against classical columns and against a search by hand."""

import numpy as np
import pytest
from helpers.columns import AT_TIP, BENDING, LENGTH, Guided, column
from helpers.yaml_content import shipped_content
from scipy.optimize import brentq

from cpr_core import (
    InvalidRequest,
    Loads,
    MotorLimitExceeded,
    NoForwardSolution,
    NoSolution,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.description import joints, motors
from cpr_core.description.chain import Link, Turn
from cpr_core.solving.critical_load import critical_load, critical_load_factor

CLAMPED_FREE = np.pi**2 * BENDING / (2.0 * LENGTH) ** 2


@pytest.mark.parametrize(
    ("factor", "motor", "joint", "robot"),
    [
        (2.0, motors.Welded(), joints.Fixed(AT_TIP), None),
        (0.6991556596428412, motors.Welded(), joints.RevoluteJoint(AT_TIP), Guided),
        (0.5, motors.Welded(), joints.Fixed(AT_TIP), Guided),
    ],
)
def test_columns_carry_their_classical_load(factor, motor, joint, robot):
    made = column(motor, joint, modes=12, **({"robot": robot} if robot else {}))
    found = critical_load(solve_home(made), [-7.0, 0.0, 0.0])
    assert found.value == pytest.approx(np.pi**2 * BENDING / (factor * LENGTH) ** 2, rel=1e-6)
    assert found.kind == "crossing"
    assert found.equilibrium.index_locked == 0


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("size", [1e-9, 1e160, 1.7e308])
def test_it_counts_where_a_direction_points_and_not_how_far(size):
    home = solve_home(load_robot("rfrfr"))
    values = [critical_load(home, way).value for way in ([0.5, -1.0, 0.0], [0.5 * size, -size, 0])]
    assert values[1] == pytest.approx(values[0], rel=1e-7)


def _sprung(stiffness):
    return Turn((0.0, 0.0, 1.0), stiffness=stiffness)


SPRING, HUB, END = 2.0 * BENDING / LENGTH, 0.2 * LENGTH, 0.3 * LENGTH


@pytest.mark.parametrize(
    ("before", "behind", "characteristic"),
    [
        ([_sprung(SPRING)], [], lambda k: k * BENDING * np.tan(k * LENGTH) - SPRING),
        ([], [Link((END, 0.0, 0.0))], lambda k: k * END * np.tan(k * LENGTH) - 1.0),
        (
            [_sprung(SPRING), Link((HUB, 0.0, 0.0))],
            [],
            lambda k: k * BENDING * np.tan(k * LENGTH) - SPRING + HUB * k**2 * BENDING,
        ),
    ],
    ids=["spring", "rigid end", "spring and hub"],
)
def test_columns_with_springs_and_rigid_ends_carry_what_their_equation_says(
    before, behind, characteristic
):
    """Free at the tip; the first root of the characteristic equation is below that of tan."""
    robot = column(motors.Welded(), joints.Fixed(AT_TIP), modes=12, before=before, behind=behind)
    found = critical_load(solve_home(robot), [-1.0, 0.0, 0.0])
    root = brentq(characteristic, 1e-6, (0.5 - 1e-9) * np.pi / LENGTH, xtol=1e-13)
    assert found.value == pytest.approx(BENDING * root**2, rel=1e-6)
    assert found.equilibrium.index_locked == 0


def test_the_factor_is_the_force_over_the_one_that_acts():
    made = column(motors.Welded(), joints.Fixed(AT_TIP), modes=12)
    loads = Loads.none().with_(wrench_world=[0, 0, 0, -0.2 * CLAMPED_FREE, 0, 0])
    found = critical_load_factor(solve_forward(made, [], loads=loads))
    assert found.value == pytest.approx(5.0, rel=1e-6)


def test_pulling_never_buckles():
    made = column(motors.Welded(), joints.Fixed(AT_TIP))
    assert critical_load(solve_home(made), [1.0, 0.0, 0.0], limit=20.0 * CLAMPED_FREE) is None


def test_loads_that_are_too_far_to_be_walked_to_at_once_end_no_branch():
    made = column(motors.Welded(), joints.Fixed(AT_TIP))
    loads = Loads.none().with_(wrench_world=[0, 0, 0, 2.5 * CLAMPED_FREE, 0, 0])
    assert critical_load_factor(solve_forward(made, [], loads=loads)) is None


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "three_rfs"])
def test_the_smallest_eigenvalue_vanishes_there_and_nowhere_before(name):
    robot = load_robot(name)
    down = [0.0, -1.0, 0.0] if robot.planar else [0.0, 0.0, -1.0]
    start = solve_forward(robot, solve_home(robot).motors + 0.02 * np.arange(robot.motor_count))
    found = critical_load(start, down)
    equilibrium = start
    for fraction in np.linspace(0.02, 0.98, 25):
        wrench = np.concatenate([np.zeros(3), fraction * found.value * np.array(down)])
        loads = start.loads.with_(wrench_world=start.loads.wrench_world + wrench)
        equilibrium = solve_forward(robot, start.motors, start=equilibrium, loads=loads)
        assert equilibrium.index_locked == 0
    last = found.equilibrium.spectrum_locked.eigenvalues[0]
    assert 0.0 < last < 1e-2 * start.spectrum_locked.eigenvalues[0]
    wrench = np.concatenate([np.zeros(3), 1.001 * found.value * np.array(down)])
    loads = start.loads.with_(wrench_world=start.loads.wrench_world + wrench)
    assert found.kind == "fold"
    with pytest.raises(NoSolution):
        solve_forward(robot, start.motors, start=found.equilibrium, loads=loads)


def test_a_limit_that_is_met_after_stability_is_lost_hides_nothing():
    """One step of the load went past the loss, and the limit behind it was told."""
    description = load_robot("three_rfs").description.text
    found = []
    for effort in (2.0, 20.0):
        robot = load_robot(description.replace("effort: 2.0", f"effort: {effort}"))
        start = solve_forward(robot, solve_home(robot).motors + [0.17, 0.06, 0.22])
        found.append(critical_load(start, [2.02, -1.06, 0.37], motors_are="free"))
    assert found[0].kind == found[1].kind == "crossing"
    assert found[0].value == pytest.approx(found[1].value, rel=1e-7)
    assert np.abs(found[0].equilibrium.efforts).max() < 2.0


def test_a_limit_on_the_way_is_told_of_the_whole_way():
    """It was told of a step of the load, whose size nobody knows."""
    home = solve_home(load_robot("planar_body"))
    for limit in (400.0, 4000.0):
        with pytest.raises(
            MotorLimitExceeded, match=r"it is passed at a force of [0-9.]+ N$"
        ) as told:
            critical_load(home, [0.0, -1.0, 0.0], limit=limit)
        force = float(str(told.value).split()[-2])
        assert told.value.fraction == pytest.approx(force / limit, rel=1e-5)
        assert told.value.event.fraction == told.value.fraction
        for part, within in ((0.999, True), (1.001, False)):
            loads = home.loads.with_(wrench_world=[0, 0, 0, 0, -part * force, 0])
            if within:
                solve_forward(home.robot, home.motors, loads=loads)
            else:
                with pytest.raises(MotorLimitExceeded):
                    solve_forward(home.robot, home.motors, loads=loads)
    pushed = solve_forward(
        home.robot, home.motors, loads=home.loads.with_(wrench_world=[0] * 4 + [-50, 0])
    )
    with pytest.raises(
        MotorLimitExceeded, match=r"it is passed at a factor of [0-9.]+ on the loads$"
    ) as told:
        critical_load_factor(pushed, limit=9.0)
    factor = float(str(told.value).split()[-4])
    assert told.value.fraction == pytest.approx((factor - 1.0) / 8.0, rel=1e-5)
    assert factor == pytest.approx(force / 50.0, rel=0.05)  # with the weights


@pytest.mark.parametrize("torsion", [0, 1])
def test_where_branches_cross_it_is_a_crossing_though_none_goes_on(torsion):
    """Rounding decided: with another mode, which bends nothing, the same load was not a fold."""
    content = shipped_content("three_rfs")
    content["strain"]["torsion"] = torsion
    found = critical_load(solve_home(load_robot(content)), [0.0, 0.0, -1.0])
    # The eigenvalue falls by 0.06 J/N to zero there, by extrapolation, and is known to 1e-9 J.
    assert found.value == pytest.approx(1.96046605456, rel=2e-8)
    assert found.kind == "crossing"


@pytest.mark.filterwarnings("ignore:.*origin of the world:cpr_core.DescriptionWarning")
@pytest.mark.parametrize("name", ["two_rods", "planar_body"])
def test_a_walk_that_rounding_ends_is_no_fold(name):
    """As far from the origin of the world as maps of countries are; a hundredth of the load was told."""
    content = shipped_content(name)
    far = np.array([5e6, -5e6 / 3.0, 0.0])
    for leg in content["legs"]:
        leg["base"]["position"] = (far + leg["base"]["position"]).tolist()
    if "platform" in content["home"]:
        near = content["home"]["platform"]["position"]
        content["home"]["platform"]["position"] = (far + near).tolist()
    home = solve_home(load_robot(content))
    away = [0.05, -0.03, 0.02][: len(home.motors)]
    start = solve_forward(home.robot, home.motors + away, start=home)
    with pytest.raises(
        NoForwardSolution, match=r"the walk was lost at a force of [0-9.]+ N, where stability does"
    ) as told:
        critical_load(start, [0.3, -1.0, 0.0], limit=100.0)
    lost = told.value
    assert lost.event.kind == "lost" and lost.event.equilibrium is lost.last
    force = float(str(lost).split(" N, ")[0].split()[-1])
    assert lost.fraction == lost.event.fraction == pytest.approx(force / 100.0, rel=1e-5)
    assert lost.last.margin > 0.6


def test_the_load_at_a_fold_that_is_reached_already_is_told():
    """Nothing is left to fall there."""
    found = critical_load(solve_home(load_robot("rfrfr")), [0.0, -1.0, 0.0])
    again = critical_load(found.equilibrium, [0.0, -1.0, 0.0])
    assert (found.kind, again.kind) == ("fold", "fold")
    assert again.value < 1e-6 * found.value


@pytest.mark.parametrize("limit", [-3.0, 0.0])
def test_a_limit_that_is_none_is_refused(limit):
    """It was answered that nothing is critical up to there."""
    home = solve_home(load_robot("rfrfr"))
    with pytest.raises(InvalidRequest, match=r"limit: expected more than 0, got"):
        critical_load(home, [0.0, -1.0, 0.0], limit=limit)
    with pytest.raises(InvalidRequest, match=r"limit: expected more than 1, got"):
        critical_load_factor(home, limit=1.0 + 0.1 * limit)
    with pytest.raises(InvalidRequest, match=r"limit: expected more than 1, got 0\.999999999$"):
        critical_load_factor(home, limit=1.0 - 1e-9)


def test_questions_without_an_answer_are_refused():
    robot = load_robot("six_rfs")
    with pytest.raises(InvalidRequest, match="direction"):
        critical_load(solve_home(robot), [0.0, 0.0, 0.0])
    with pytest.raises(InvalidRequest, match="direction: expected z = 0 of a planar robot"):
        critical_load(solve_home(load_robot("rfrfr")), [0.0, -1.0, 0.1])
    moment = Loads.none().with_(wrench_world=[0, 0, 0.01, 0, 0, 0])
    turned = solve_forward(robot, solve_home(robot).motors, loads=moment)
    with pytest.raises(InvalidRequest, match="potential"):
        critical_load(turned, [0.0, 0.0, -1.0])

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Loads: checks of what is given, what is refused in the plane, what has a potential."""

import copy
from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose

from cpr_core import solve_forward, solve_home
from cpr_core.description.inherited_loads import inherited_loads, overridden_loads
from cpr_core.description.loads import DistributedForce, Loads, PointForce, checked_vector
from cpr_core.errors import CprError, DescriptionError, InvalidRequest, NonFiniteInput
from cpr_core.kernels.kernel_arrays import PLATFORM_LOADS, interpolated_loads
from cpr_core.solving.load_robot import load_robot

FIELDS = {"gravity": 3, "rod_force": 3, "wrench_world": 6, "wrench_body": 6}


@pytest.fixture(scope="module")
def point_robot():
    return load_robot("rfrfr")


@pytest.fixture(scope="module")
def planar_body():
    content = shipped_content("rfrfr")
    content["rod"].update(young_modulus=210.0e9, shear_modulus=82.0e9)
    content["platform"] = {"shape": "body", "mass": 0.5, "center_of_mass": [0.1, 0.2, 0.0]}
    content["legs"][0]["tip"]["position"] = [-0.05, 0.0, 0.0]
    content["legs"][1]["tip"]["position"] = [0.05, 0.0, 0.0]
    return load_robot(content)


@pytest.fixture(scope="module")
def spatial_robot():
    return load_robot("six_rfs")


@pytest.mark.parametrize(
    "value", [[1, 2, 3], (1.0, 2.0, 3.0), np.array([1, 2, 3]), range(1, 4), np.float32([1, 2, 3])]
)
def test_vectors_come_in_any_form_and_go_out_as_floats(value):
    vector = checked_vector("gravity", value, 3)
    assert vector.dtype == np.float64
    assert vector.tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ("value", "found"),
    [
        ([1.0, 2.0], "got 2"),
        ([1.0, 2.0, 3.0, 4.0], "got 4"),
        ([], "got 0"),
        (1.0, "shape ()"),
        ([[1.0, 2.0, 3.0]], "shape (1, 3)"),
        ("north", "'north'"),
        ([1.0, "up", 2.0], "up"),
        ([[1.0], [2.0, 3.0], 4.0], "[[1.0]"),
        ({"x": 1.0}, "{'x': 1.0}"),
        ([1j, 0, 0], "1j"),
        (object(), "object"),
        (None, "shape ()"),
    ],
)
def test_what_is_no_vector_is_refused_with_what_was_expected(value, found):
    with pytest.raises(InvalidRequest) as caught:
        checked_vector("gravity", value, 3, "x y z")
    assert caught.value.argument == "gravity"
    assert caught.value.code == "INVALID_ROBOT_STATE"
    text = str(caught.value)
    assert text.startswith("gravity: expected 3 numbers (x y z)")
    assert found in text


def test_numbers_beyond_floats_are_refused_like_any_other_mistake():
    with pytest.raises(CprError, match="gravity"):
        checked_vector("gravity", [10**400, 0, 0], 3)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, None])
@pytest.mark.parametrize("place", range(3))
def test_vectors_that_are_not_finite_are_refused(value, place):
    vector = [1.0, 2.0, 3.0]
    vector[place] = value
    with pytest.raises(NonFiniteInput, match="all finite") as caught:
        checked_vector("gravity", vector, 3)
    assert caught.value.argument == "gravity"
    assert caught.value.code == "NON_FINITE_INPUT"


def test_checked_vectors_are_read_only_copies():
    given = np.array([1.0, 2.0, 3.0])
    vector = checked_vector("gravity", given, 3)
    given[0] = 9.0
    assert vector[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        vector[0] = 9.0
    assert given.flags.writeable


def test_no_loads_are_zero_and_conservative():
    loads = Loads.none()
    for name, size in FIELDS.items():
        assert getattr(loads, name).shape == (size,)
        assert not np.any(getattr(loads, name))
    assert loads.conservative(planar=True)
    assert loads.conservative(planar=False)


@pytest.mark.parametrize("name", FIELDS)
def test_with_replaces_what_is_given_and_keeps_the_rest(name):
    start = Loads.none().with_(
        gravity=[0, 0, -9.81], rod_force=[1, 2, 3], wrench_world=range(6), wrench_body=range(6, 12)
    )
    value = np.arange(FIELDS[name]) + 100.0
    changed = start.with_(**{name: value})
    for other in FIELDS:
        expected = value if other == name else getattr(start, other)
        assert np.array_equal(getattr(changed, other), expected)
    assert not np.array_equal(getattr(start, name), value)


@pytest.mark.parametrize("name", FIELDS)
def test_with_names_the_load_that_is_wrong(name):
    size = FIELDS[name]
    with pytest.raises(InvalidRequest, match=rf"{name}: expected {size} numbers .*got {size + 1}"):
        Loads.none().with_(**{name: np.zeros(size + 1)})
    with pytest.raises(NonFiniteInput, match=name):
        Loads.none().with_(**{name: np.full(size, np.nan)})


@pytest.mark.parametrize("name", FIELDS)
def test_loads_cannot_be_changed_in_place(name):
    for loads in (Loads.none(), Loads.none().with_(**{name: np.ones(FIELDS[name])})):
        with pytest.raises(ValueError, match="read-only"):
            getattr(loads, name)[0] = 1.0
        with pytest.raises(FrozenInstanceError):
            setattr(loads, name, np.zeros(FIELDS[name]))


def test_no_loads_are_not_shared():
    first, second = Loads.none(), Loads.none()
    assert first.gravity is not second.gravity


def unit(place):
    vector = np.zeros(6)
    vector[place] = 1.0
    return vector


@pytest.mark.parametrize("place", range(6))
def test_in_space_moments_and_following_wrenches_have_no_potential(place):
    assert Loads.none().with_(wrench_world=unit(place)).conservative(False) == (place >= 3)
    assert not Loads.none().with_(wrench_body=unit(place)).conservative(False)


@pytest.mark.parametrize("place", [2, 3, 4])
def test_in_the_plane_only_following_forces_have_no_potential(place):
    assert Loads.none().with_(wrench_world=unit(place)).conservative(True)
    assert Loads.none().with_(wrench_body=unit(place)).conservative(True) == (place == 2)
    assert Loads.none().with_(wrench_body=unit(place)).conservative(True, point=True)


def test_nothing_follows_a_platform_that_does_not_turn():
    """Where the same force in the world was stable, one of the platform had no stability at all."""
    robot = load_robot("rfrfr")
    motors, force = solve_home(robot).motors, [0.0, 0.0, 0.0, 0.1, -0.2, 0.0]
    world, body = (
        solve_forward(robot, motors, loads=robot.default_loads.with_(**{name: force}))
        for name in ("wrench_world", "wrench_body")
    )
    assert body.stable and world.stable
    assert body.spectrum_locked.energy_criterion_applies
    assert body.margin == pytest.approx(world.margin, rel=1e-12)
    solve_forward(robot, motors + 0.01, start=body, stable_only=True)


@pytest.mark.parametrize("planar", [True, False])
def test_gravity_and_rod_forces_are_conservative(planar):
    loads = Loads.none().with_(gravity=[1.0, 2.0, 0.0], rod_force=[3.0, 4.0, 0.0])
    assert loads.conservative(planar)


@pytest.mark.parametrize("name", ["gravity", "rod_force"])
def test_forces_out_of_the_plane_are_refused(point_robot, planar_body, spatial_robot, name):
    loads = Loads.none().with_(**{name: [0.0, 0.0, -9.81]})
    for robot in (point_robot, planar_body):
        with pytest.raises(InvalidRequest, match=rf"{name}: expected z = 0 .*got -9.81") as caught:
            robot.load_arrays(loads)
        assert caught.value.argument == name
    spatial_robot.load_arrays(loads)


@pytest.mark.parametrize("name", ["wrench_world", "wrench_body"])
@pytest.mark.parametrize("place", [0, 1, 5])
def test_wrenches_out_of_the_plane_are_refused(
    point_robot, planar_body, spatial_robot, name, place
):
    loads = Loads.none().with_(**{name: unit(place)})
    for robot in (point_robot, planar_body):
        with pytest.raises(InvalidRequest, match=rf"{name}: expected mx = my = fz = 0") as caught:
            robot.load_arrays(loads)
        assert caught.value.argument == name
    spatial_robot.load_arrays(loads)


@pytest.mark.parametrize("name", ["wrench_world", "wrench_body"])
def test_a_point_takes_no_moment_a_planar_body_does(point_robot, planar_body, name):
    loads = Loads.none().with_(**{name: unit(2)})
    with pytest.raises(InvalidRequest, match=rf"{name}: expected mz = 0") as caught:
        point_robot.load_arrays(loads)
    assert caught.value.argument == name
    moment = name.replace("wrench", "moment")
    assert planar_body.load_arrays(loads).platform[moment][0].tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize("name", ["wrench_world", "wrench_body"])
@pytest.mark.parametrize("place", [3, 4])
def test_forces_in_the_plane_are_taken(point_robot, planar_body, name, place):
    loads = Loads.none().with_(**{name: unit(place)})
    force = name.replace("wrench", "force")
    for robot in (point_robot, planar_body):
        assert np.array_equal(robot.load_arrays(loads).platform[force][0], unit(place)[3:])


def test_weight_is_that_of_what_hangs_beyond_and_of_the_platform(planar_body):
    gravity, force = np.array([1.0, -9.81, 0.0]), np.array([0.3, 0.2, 0.0])
    arrays = planar_body.load_arrays(Loads.none().with_(gravity=gravity, rod_force=force))
    per_length = 7800.0 * np.pi * 0.001**2 * gravity + force
    beyond = np.array([*(1.0 - planar_body.grid.nodes), 1.0])
    for leg in range(2):
        assert_allclose(
            arrays.distributed[leg], np.outer(per_length, beyond), rtol=1e-14, atol=1e-15
        )
    assert_allclose(arrays.platform["weight"][0], 0.5 * gravity, rtol=1e-15)
    assert_allclose(arrays.platform["center_of_mass"][0], [0.1, 0.2, 0.0], rtol=1e-15)


def test_default_loads_are_the_gravity_of_the_description():
    content = shipped_content("six_rfs")
    content["rod"].update(young_modulus=210.0e9, shear_modulus=82.0e9)
    content["gravity"] = [0.0, 0.0, -9.81]
    loads = load_robot(copy.deepcopy(content)).default_loads
    assert loads.gravity.tolist() == [0.0, 0.0, -9.81]
    assert not np.any(loads.rod_force)
    assert not np.any(loads.wrench_world)
    assert not np.any(loads.wrench_body)


@pytest.mark.parametrize("fraction", [0.0, 0.3, 1.0])
def test_loads_between_are_those_of_what_is_given_between(spatial_robot, fraction):
    first = Loads.none().with_(gravity=[0.0, 1.0, -9.0], wrench_world=np.arange(6.0))
    last = Loads.none().with_(rod_force=[0.1, 0.2, 0.3], wrench_body=np.arange(6.0, 12.0))
    mixed = {
        name: (1.0 - fraction) * np.array(getattr(first, name)) + fraction * getattr(last, name)
        for name in ("gravity", "rod_force", "wrench_world", "wrench_body")
    }
    arrays = [spatial_robot.load_arrays(loads) for loads in (first, last)]
    found = interpolated_loads(*arrays, fraction)
    expected = spatial_robot.load_arrays(Loads.none().with_(**mixed))
    for name in PLATFORM_LOADS.names:
        assert_allclose(found.platform[name], expected.platform[name], rtol=0.0, atol=1e-14)
    assert_allclose(found.distributed, expected.distributed, rtol=0.0, atol=1e-14)
    assert_allclose(found.point, expected.point, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("fraction", [0.25, 0.5])
def test_forces_on_rods_are_weighed_between_loads(fraction):
    """Loads on a way hold the forces of both ends."""
    first, last = (
        Loads.none().with_(
            distributed=[DistributedForce(leg, [0.0, 1.0], force * np.ones((2, 3)))],
            points=[PointForce(leg, 0.35, [force, 0.0, -force])],
        )
        for leg, force in (("leg1", 0.2), ("leg2", -0.3))
    )
    between = first.toward(last, fraction)
    total = {"leg1": (1.0 - fraction) * 0.2, "leg2": -fraction * 0.3}
    assert {force.leg: force.force[0] for force in between.points} == pytest.approx(total)
    assert {force.leg: force.force[0, 0] for force in between.distributed} == pytest.approx(total)


def made(**parts):
    """Loads as a caller makes them, without ``with_``."""
    zeros = {name: np.zeros(size) for name, size in FIELDS.items()}
    return Loads(**zeros | parts)


def test_loads_are_made_of_vectors_in_any_form():
    loads = made(gravity=[0, 0, -9.81], wrench_body=range(6))
    assert loads.gravity.tolist() == [0.0, 0.0, -9.81]
    assert loads.wrench_body.dtype == np.float64
    assert "gravity=[0.0, 0.0, -9.81]" in repr(loads)
    assert made(points=[PointForce("leg1", 0.5, [1, 0, 0])]).points[0].leg == "leg1"


@pytest.mark.parametrize("name", FIELDS)
def test_loads_that_make_no_sense_are_refused_when_they_are_made(name):
    with pytest.raises(InvalidRequest, match=f"{name}: expected {FIELDS[name]} numbers .*got 2"):
        made(**{name: np.zeros(2)})
    wrong = np.full(FIELDS[name], np.nan)
    for writeable in (True, False):
        wrong.flags.writeable = writeable
        with pytest.raises(NonFiniteInput, match=name):
            made(**{name: wrong})
    for kind, forces in (("distributed", 5), ("points", ["leg1"]), ("points", None)):
        with pytest.raises(InvalidRequest, match=f"{kind}: expected a sequence"):
            made(**{kind: forces})


def test_a_caller_cannot_change_loads_that_were_given():
    """Arrays for the kernels are kept with loads: a change would be seen by some solves only."""
    given = {name: np.ones(size) for name, size in FIELDS.items()}
    view = np.ones(6)
    shown = view[:]
    shown.flags.writeable = False
    along = np.ones((2, 3))
    distributed = DistributedForce("leg1", [0.0, 1.0], along)
    loads = Loads(**given, distributed=(distributed,)).with_(wrench_body=shown)
    for vector in (*given.values(), view, along):
        vector[:] = 7.0
    for vector in (*(getattr(loads, name) for name in FIELDS), distributed.force):
        assert np.all(vector == 1.0)
        with pytest.raises(ValueError, match="read-only"):
            vector[0] = 7.0


def test_what_stays_of_loads_is_not_copied():
    loads = Loads.none().with_(gravity=[0, 0, -9.81])
    assert loads.with_(wrench_world=np.ones(6)).gravity is loads.gravity


def test_stations_that_do_not_reach_the_ends_are_told_so():
    """They were told not to be increasing from 0 to 1."""
    content = shipped_content("rfrfr")
    force = [[0.0, 0.0, 0.0]] * 3
    content["loads"] = {"distributed": [{"leg": "leg1", "at": [0.1, 0.4, 0.8], "force": force}]}
    with pytest.raises(
        DescriptionError, match=r"the first 0 and the last 1, got \[0.1, 0.4, 0.8\]"
    ):
        load_robot(content)


@pytest.mark.parametrize("at", [[0.0, 0.9], [0.1, 1.0], [0.0, 0.5, 0.5, 1.0], [0.0]])
def test_stations_of_a_force_go_from_one_end_to_the_other(at):
    with pytest.raises(InvalidRequest, match="increase from 0 to 1"):
        DistributedForce("leg1", at, np.ones((len(at), 3)))


def test_forces_bend_at_stations_of_the_robot_only(spatial_robot):
    """Its quadrature has no node anywhere else."""
    bent = DistributedForce("leg1", [0.0, 0.3, 1.0], np.ones((3, 3)))
    with pytest.raises(InvalidRequest, match=r"distributed: expected a station .* got 0\.3"):
        spatial_robot.load_arrays(Loads.none().with_(distributed=[bent]))


#: Another value of every attribute.
OTHERS = {
    "gravity": [0.0, 0.0, -1.62],
    "rod_force": [0.1, 0.0, 0.0],
    "wrench_world": [0.0, 0.0, 0.0, 1e-9, 0.0, 0.0],
    "wrench_body": [0.0, 0.2, 0.0, 0.0, 0.0, 0.0],
    "distributed": [DistributedForce("leg1", [0.0, 1.0], np.ones((2, 3)))],
    "points": [PointForce("leg1", 0.5, [0.0, 1.0, 0.0])],
}


def test_every_attribute_tells_loads_apart():
    assert set(OTHERS) == {field.name for field in fields(Loads)}
    same = made(gravity=[0.0, -0.0, 0.0])
    assert Loads.none().differences(same) == same.differences(Loads.none()) == ()
    for name, value in OTHERS.items():
        changed, again = (Loads.none().with_(**{name: copy.deepcopy(value)}) for _ in range(2))
        assert changed.differences(same) == same.differences(changed) == (name,)
        assert changed.differences(again) == ()
        assert changed.scaled(0.5).differences(changed) == (name,)
        assert changed.toward(same, 0.5).differences(changed.scaled(0.5)) in ((), (name,))
        assert changed.toward(same, 0.5).differences(same) == (name,)
    everything = Loads.none().with_(**OTHERS)
    assert everything.differences(same) == tuple(OTHERS)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("distributed", {"leg": "leg2"}),
        ("distributed", {"at": [0.0, 0.5, 1.0], "force": np.ones((3, 3))}),
        ("distributed", {"force": 2.0 * np.ones((2, 3))}),
        ("points", {"leg": "leg2"}),
        ("points", {"at": 0.25}),
        ("points", {"force": [0.0, 1.0, 1e-12]}),
    ],
)
def test_every_attribute_tells_forces_on_rods_apart(name, change):
    (force,) = OTHERS[name]
    loads = [Loads.none().with_(**{name: [each]}) for each in (force, replace(force, **change))]
    assert loads[0].differences(loads[1]) == (name,)


def test_what_is_inherited_follows_the_description():
    before = Loads.none().with_(gravity=[0.0, 0.0, -9.81], rod_force=[0.0, 0.3, 0.0])
    for name, value in OTHERS.items():
        after, given = before.with_(**{name: value}), before.with_(**{name: value}).scaled(2.0)
        followed = inherited_loads(before.with_(wrench_world=np.ones(6)), before, after)
        assert followed.differences(after) == ("wrench_world",)
        assert overridden_loads(before, before, after) == ()
        assert inherited_loads(given, before, after).differences(given) == ()
        assert overridden_loads(given, before, after) == (name,)

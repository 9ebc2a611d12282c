# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots and loads of stored maps: told apart by all that a map depends on, and by nothing else."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.chain_robots import CHAINS, robot_of
from helpers.parameter_kinds import parameter_kinds
from helpers.yaml_content import shipped_content

from cpr_core import CprError, Loads, PointForce, Robot, load_robot
from cpr_core.description.description_file import shipped_robots
from cpr_core.description.tracker import Tracker
from cpr_core.workspace.stored_values import as_json, is_robot, is_same, robot_as_json

ROBOTS = sorted(shipped_robots())


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request):
    return load_robot(request.param)


def test_a_robot_is_itself_wherever_its_description_came_from(robot):
    again = load_robot(shipped_content(robot.description.name))
    assert is_robot(again, robot_as_json(robot))
    assert is_robot(robot, robot_as_json(again))
    tracked = replace(robot.description, tracker=Tracker(*np.ones((4, 3))))
    assert is_robot(Robot(tracked), robot_as_json(robot))
    assert is_robot(robot, robot_as_json(Robot(tracked)))


def test_no_shipped_robot_is_another_one():
    stored = {name: robot_as_json(load_robot(name)) for name in ROBOTS}
    for name in ROBOTS:
        assert [other for other in ROBOTS if is_robot(load_robot(name), stored[other])] == [name]


def test_every_kind_of_number_in_a_description_tells_robots_apart(robot):
    stored, kinds = robot_as_json(robot), parameter_kinds(robot)
    scaled_away = re.compile(
        r"^tracker|\b(tangent|normal|axis|axes)\b"
    )  # directions have no length
    mechanics = [path for path in kinds if not scaled_away.search(path)]
    assert len(mechanics) > 5
    for path in mechanics:
        value = robot.parameter_values(path)[0]
        try:
            changed = robot.with_parameters({path: value * (1.0 + 1e-9) + 1e-12 * (value == 0.0)})
        except CprError:
            continue  # out of the plane, or of its range
        assert not is_robot(changed, stored), path
    assert not is_robot(load_robot(robot.description.name, modes=7), stored)


def test_maps_of_versions_that_knew_less_or_told_more_are_read():
    """Fields that were not known then have their defaults; of trackers nothing depends."""
    robot = load_robot("six_rus")
    content = json.loads(robot_as_json(robot))
    assert not {"tracker", "written", "source"} & set(content)
    told = content | {"tracker": None, "written": None, "source": "mine.yaml"}
    assert is_robot(robot, json.dumps(told))
    assert not is_robot(robot, json.dumps(content | {"unheard_of": 0}))
    assert not is_robot(robot, json.dumps(content | {"type": "Other"}))
    for name in ("legs", "home", "platform_mass"):
        assert not is_robot(robot, json.dumps({k: v for k, v in content.items() if k != name}))


def _before_drives(stored):
    """Fields of a drive beside those of what it moves."""
    if "drive" not in stored:
        return stored
    drive = stored.pop("drive")
    if "motor" in stored:  # a leg
        own = {"motor_name": drive["motor"], "offset": drive["zero"], "limits": drive["limits"]}
    else:
        own = {name: value for name, value in drive.items() if name != "type"}
    return stored | own


def test_maps_of_versions_without_drives_are_read(robot):
    older = json.dumps(json.loads(robot_as_json(robot), object_hook=_before_drives))
    assert "drive" not in older and "motor_name" in older
    assert is_robot(robot, older)
    assert not is_robot(robot, re.sub(r'"speed": [^,]+', '"speed": 7.25', older))


@pytest.mark.parametrize("kind", CHAINS)
def test_nor_is_anything_of_a_chain_lost(kind):
    """Also not where a joint is that no motor moves."""
    robot = robot_of((kind, *("motor",) * 5))
    older = json.dumps(json.loads(robot_as_json(robot), object_hook=_before_drives))
    assert is_robot(robot, older)
    if '"zero": 0.1' in older:
        assert not is_robot(robot, older.replace('"zero": 0.1', '"zero": 0.0'))


def test_loads_are_those_that_were_stored():
    push = Loads.none().with_(points=[PointForce("leg1", 0.5, [0.0, 1.0, 0.0])])
    assert is_same(push, as_json(push))
    assert is_same(Loads.none(), as_json(Loads.none()))
    assert not is_same(push, as_json(Loads.none()))
    assert not is_same(Loads.none(), as_json(push))
    older = json.loads(as_json(Loads.none()))
    del older["points"]
    assert is_same(Loads.none(), json.dumps(older))
    assert not is_same(push, json.dumps(older))
    assert is_same(push.with_(gravity=-np.zeros(3)), as_json(push))


def test_motors_that_are_held_tell_robots_apart():
    """Files of before have no motors that are held."""
    robot = load_robot("four_rfr")
    first, second = robot.holding((0,)), robot.holding((1,))
    for each in (robot, first, second):
        same = [is_robot(other, robot_as_json(each)) for other in (robot, first, second)]
        assert same == [each is other for other in (robot, first, second)]
    assert "held_motors" not in json.loads(robot_as_json(robot))

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What goals order, what is refused with which code and words, and what is told of a map."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from cpr_msgs.action import MapWorkspace
from cpr_msgs.msg import ErrorCode
from geometry_msgs.msg import WrenchStamped
from helpers.drive import PERIOD, SETTINGS, robot
from helpers.map_client import SMALL, map_axes
from helpers.workspace_cases import small_map

from cpr_core import CprError, solve_forward, solve_home
from cpr_core.model.assessment import Assessment
from cpr_core.workspace import MapSummary, motor_grid, pose_grid, summary_of
from cpr_core.workspace.borders import Border
from cpr_core.workspace.store import write_map
from cpr_ros.error_codes import error_code
from cpr_ros.following.setpoint_following import SetpointFollower
from cpr_ros.maps.map_folder import MapFolder
from cpr_ros.maps.map_messages import map_feedback, map_order, map_result
from cpr_ros.maps.map_order import MapState
from cpr_ros.messages.frames import Frames
from cpr_ros.operation.solver import Solver

Goal = MapWorkspace.Goal


class Orders:
    """A node that is not at home, and a folder for its maps."""

    def __init__(self, folder, name="rfrfr"):
        self.robot, self.folder = robot(name), folder
        follower = SetpointFollower(self.robot, PERIOD, SETTINGS)
        self.solver = Solver(self.robot, Frames("base", "platform"), follower, 20.0)
        self.home = solve_home(self.robot)
        self.solver.current = Assessment(solve_forward(self.robot, self.home.motors + 0.1))

    def order(self, axes=None, file="map.nc", **goal):
        given = map_axes(SMALL if axes is None else axes)
        return map_order(
            self.solver, Goal(axes=given, file=file, **goal), MapFolder(self.folder, False)
        )

    def refusal(self, *arguments, **goal):
        with pytest.raises(CprError) as refused:
            self.order(*arguments, **goal)
        return error_code(refused.value)


@pytest.fixture
def orders(tmp_path):
    return Orders(tmp_path)


def assert_same_grid(found, expected):
    assert (found.given, found.names, found.axis_names) == (
        expected.given,
        expected.names,
        expected.axis_names,
    )
    np.testing.assert_array_equal(found.origin, expected.origin)
    for mine, theirs in zip(found.values, expected.values, strict=True):
        np.testing.assert_array_equal(mine, theirs)


def test_a_goal_orders_what_the_library_makes_of_it(orders, tmp_path):
    order = orders.order(tolerance=1e-3, threshold=0.02, workers=3)
    axes = {name: (first, last) for name, (first, last, _) in SMALL.items()}
    resolution = {name: step for name, (_, _, step) in SMALL.items()}
    assert_same_grid(order.grid, pose_grid(orders.robot, axes, resolution=resolution))
    assert (order.tolerance, order.threshold, order.workers) == (1e-3, 0.02, 3)
    assert (order.file, order.resume, order.objective) == (tmp_path / "map.nc", False, None)
    assert order.start is orders.solver.current.equilibrium
    assert order.loads is order.start.loads
    assert orders.order(tolerance=0.0, threshold=0.0).threshold == 0.0


def test_motors_are_axes_or_held(tmp_path):
    orders = Orders(tmp_path, "planar_body")
    axes = {"motor1": (-0.1, 0.1, 0.05), "motor3": (-0.2, 0.0, 0.1)}
    held = {"held": ["motor2"], "held_values": [0.3]}
    order = orders.order(axes, given=Goal.GIVEN_MOTORS, **held)
    expected = motor_grid(
        orders.robot,
        {name: (first, last) for name, (first, last, _) in axes.items()},
        {"motor2": 0.3},
        resolution={name: step for name, (_, _, step) in axes.items()},
    )
    assert_same_grid(order.grid, expected)
    everywhere = order.grid.coordinates(order.grid.places(np.arange(order.grid.size)))
    np.testing.assert_array_equal(everywhere[:, order.grid.names.index("motor2")], 0.3)


def test_a_map_begins_where_it_is_told_under_the_wrench_of_its_goal(orders):
    message = WrenchStamped()
    message.wrench.force.x, message.wrench.torque.z = 0.1, -0.2
    for start, expected in (
        (Goal.START_CURRENT, orders.solver.current.equilibrium),
        (Goal.START_HOME, orders.home),
    ):
        order = orders.order(start=start, wrench=[message])
        assert order.start is expected
        np.testing.assert_array_equal(order.loads.wrench_world, [0, 0, -0.2, 0.1, 0, 0])


def test_the_objective_is_that_of_a_redundant_robot(tmp_path):
    orders = Orders(tmp_path, "four_rfr")
    axes = {"x": (-0.1, 0.1, 0.1), "y": (-0.1, 0.1, 0.1)}
    assert orders.order(axes).objective is None
    assert orders.order(axes, objective="least_effort").objective == "least_effort"
    told = orders.refusal(axes, objective="least_hope")
    assert told.val == ErrorCode.INVALID_ROBOT_STATE
    assert "objective: expected least_motion, least_effort or greatest_margin" in told.message


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", ["first", "last", "resolution", "tolerance", "threshold", "held"])
def test_every_number_of_a_goal_is_finite_or_named(tmp_path, place, number):
    """An axis without end was said to have too many cells."""
    orders = Orders(tmp_path, "planar_body")
    axis = dict(zip(("first", "last", "resolution"), (-0.1, 0.1, 0.05), strict=True))
    goal, name = {}, "y"
    if place in axis:
        axis[place] = number
    elif place == "held":
        goal, name = {"held": ["angle"], "held_values": [number]}, "angle"
    else:
        goal, name = {place: number}, place
    told = orders.refusal({"x": (-0.1, 0.1, 0.05), "y": tuple(axis.values())}, **goal)
    assert told.val == ErrorCode.NON_FINITE_INPUT, told
    assert name in told.message


@pytest.mark.parametrize(
    ("axes", "goal", "words"),
    [
        (SMALL, {"given": 7}, "given: expected GIVEN_POSE 0 or GIVEN_MOTORS 1, got 7"),
        (SMALL, {"held": ["angle"]}, "held_values: expected 1 numbers, got 0"),
        (SMALL, {"held": ["y"], "held_values": [0.1]}, "axes: y is given twice"),
        (SMALL, {"tolerance": -1e-9}, "tolerance: expected a positive number or 0"),
        (SMALL, {"threshold": -1e-9}, "threshold: expected a positive number or 0"),
        (SMALL, {"start": 7}, "start: expected START_CURRENT 0, START_HOME 1 or START_GIVEN 2"),
        (SMALL, {"start": 2}, "start_equilibrium: expected one, got 0"),
        (SMALL, {"existing_file": 7}, "existing_file: expected REFUSE 0, RESUME 1 or REPLACE 2"),
        (SMALL, {"objective": "least_effort"}, "has no more motors than controlled coordinates"),
        (SMALL, {"objective": "x" * 1001}, "names of at most 1000 letters"),
        ({"x": (0.0, 1.0, 0.1)}, {}, "at least two axes"),
        ({"x": (0.0, 1.0, 0.1), "z": (0.0, 1.0, 0.1)}, {}, "'z'"),
        ({"x": (0.0, 1.0, 0.1), "y" * 1001: (0.0, 1.0, 0.1)}, {}, "names of at most 1000 letters"),
        ({f"x{axis}": (0.0, 1.0, 0.1) for axis in range(7)}, {}, "at most 6 axes"),
        ({"x": (0.0, 1.0, 1e-6), "y": (0.0, 1.0, 9e-7)}, {}, "y: expected at most 1,000,000 cells"),
        ({"x": (0.1, 0.0, 0.1), "y": (0.0, 1.0, 0.1)}, {}, "larger"),
        ({"x": (0.0, 0.1, 0.0), "y": (0.0, 1.0, 0.1)}, {}, "positive"),
    ],
)
def test_what_cannot_be_ordered_is_told_and_leaves_no_file(orders, tmp_path, axes, goal, words):
    told = orders.refusal(axes, **goal)
    assert told.val == ErrorCode.INVALID_ROBOT_STATE
    assert words in told.message
    assert list(tmp_path.iterdir()) == []


def test_only_maps_are_replaced_and_only_by_whoever_means_it(orders, tmp_path):
    write_map(small_map(), tmp_path / "map.nc")
    (tmp_path / "text.nc").write_text("precious")
    before = {file: file.read_bytes() for file in tmp_path.iterdir()}
    for file, existing, words in (
        ("map.nc", Goal.REFUSE, "map.nc exists: set existing_file to RESUME or REPLACE"),
        ("text.nc", Goal.REFUSE, "text.nc exists"),
        ("text.nc", Goal.REPLACE, "is none and is not replaced"),
        ("no/map.nc", Goal.REPLACE, "folder that exists"),
        ("", Goal.REPLACE, "expected the name of a NetCDF file"),
    ):
        told = orders.refusal(file=file, existing_file=existing)
        assert told.val == ErrorCode.INVALID_FILE
        assert words in told.message
    for existing in (Goal.RESUME, Goal.REPLACE):
        order = orders.order(existing_file=existing)
        assert order.file == tmp_path / "map.nc"
        assert order.resume == (existing == Goal.RESUME)
    assert {file: file.read_bytes() for file in tmp_path.iterdir()} == before


@pytest.mark.parametrize("threshold", [0.0, 0.02, 1.0])
def test_a_result_counts_the_cells_of_the_map_that_was_made(threshold):
    found = small_map()
    code = ErrorCode(val=ErrorCode.SUCCESS)
    result = map_result(code, "/maps/map.nc", summary_of(found, threshold))
    assert (result.error_code, result.file, result.complete) == (code, "/maps/map.nc", True)
    assert list(result.shape) == list(found.grid.shape)
    assert result.cells == np.prod(found.grid.shape)
    assert result.reached == np.sum(found.reached)
    assert result.stable == np.sum(found.reached & (found.index_locked == 0))
    assert result.usable == np.sum(found.usable)
    assert result.beyond_limits == np.sum(found.reached & ~found.within_limits)
    assert result.below_threshold == np.sum(found.inverse_condition_number < threshold)
    assert result.disagreements == len(found.disagreements)
    assert result.cell_area == pytest.approx(0.01)
    assert 0 < result.usable <= result.stable < result.reached < result.cells
    for border, true in zip(result.borders, found.borders, strict=True):
        assert (border.kind, border.points) == (true.kind, len(true.points))
        np.testing.assert_array_equal(border.lower, true.points.min(axis=0))
        np.testing.assert_array_equal(border.upper, true.points.max(axis=0))


def test_a_border_without_points_has_no_ends():
    found, none = small_map(), np.zeros((0, 2), np.int64)
    empty = Border("limits", none.astype(float), none, none[:, 0], none[:, 0], none)
    summary = summary_of(found.with_borders((empty,), 1e-5), 0.0)
    (border,) = map_result(ErrorCode(val=ErrorCode.SUCCESS), "", summary).borders
    assert (border.kind, border.points) == ("limits", 0)
    assert len(border.lower) == len(border.upper) == 0


def test_every_number_of_a_summary_has_a_place_of_its_own_in_the_result():
    numbers = {
        field.name: 1 + number
        for number, field in enumerate(fields(MapSummary))
        if field.type in ("int", "float")
    }
    summary = replace(summary_of(small_map(), 0.0), **numbers, complete=False)
    result = map_result(ErrorCode(val=ErrorCode.PREEMPTED), "", summary)
    assert {name: getattr(result, name) for name in numbers} == numbers
    assert not result.complete


def test_without_a_map_there_are_a_reason_and_no_numbers():
    code = ErrorCode(val=ErrorCode.FAILURE, message="ended with SIGKILL")
    assert map_result(code, "", None) == MapWorkspace.Result(error_code=code)
    assert map_result(code, "map.nc", None) == MapWorkspace.Result(error_code=code, file="map.nc")


def test_feedback_is_how_far_the_map_is():
    told = map_feedback(MapState(done=1, reached=2, total=3, rate=4.5))
    assert (told.done, told.reached, told.total, told.rate) == (1, 2, 3, 4.5)

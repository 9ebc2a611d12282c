# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Wrong Python types are refused with what was expected, everywhere."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest

from cpr_core import (
    CprError,
    DistributedForce,
    InvalidRequest,
    Loads,
    Measurement,
    NonFiniteInput,
    PointForce,
    continued,
    critical_load,
    critical_load_factor,
    derivatives,
    error_of,
    find_equilibria,
    kinemato_statics,
    leg_shapes,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    spectrum,
    trace,
    trace_through,
)
from cpr_core.drawing.map_plots import check_field
from cpr_core.validation import (
    cached_property,
    checked_count,
    checked_matrix,
    checked_number,
    checked_time,
    checked_vector,
    checked_word,
    kept_with_value,
)

ROBOT = load_robot("rfrfr")
HOME = solve_home(ROBOT)
MODEL = kinemato_statics(HOME)

QUESTIONS = {
    "robot": load_robot,
    "modes": lambda value: load_robot("rfrfr", modes=value),
    "motors": lambda value: solve_forward(ROBOT, value),
    "loads": lambda value: solve_forward(ROBOT, HOME.motors, loads=value),
    "pose": lambda value: solve_inverse(ROBOT, value),
    "starts": lambda value: find_equilibria(ROBOT, HOME.motors, starts=value),
    "seed": lambda value: find_equilibria(ROBOT, HOME.motors, starts=1, seed=value),
    "time limit": lambda value: solve_forward(ROBOT, HOME.motors, time_limit=value),
    "motors of a path": lambda value: trace(ROBOT, motors=value),
    "points of a path": lambda value: trace(ROBOT, motors=HOME.motors, points=value),
    "points of a leg": lambda value: leg_shapes(HOME, value),
    "equilibrium": spectrum,
    "equilibrium of a model": kinemato_statics,
    "reading": lambda value: spectrum(HOME, value),
    "problem": MODEL.singularity,
    "objective": lambda value: solve_inverse(ROBOT, HOME.pose, objective=value),
    "problem of derivatives": lambda value: derivatives(HOME, ["rod.length"], problem=value),
    "quantities": lambda value: derivatives(HOME, ["rod.length"], value),
    "frame": lambda value: Measurement(motors=HOME.motors, frame=value),
    "field": lambda value: check_field(ROBOT, value),
    "problem of an error": lambda value: error_of(HOME, value),
    "problem of another robot": lambda value: continued(HOME, ROBOT, value),
    "length": lambda value: MODEL.singularity("forward", value),
    "increments": lambda value: MODEL.solve(motors=value, wrench=[0, 0]),
    "direction": lambda value: critical_load(HOME, value),
    "limit": lambda value: critical_load_factor(HOME, limit=value),
    "factor": HOME.loads.scaled,
    "other loads": lambda value: HOME.loads.toward(value, 0.5),
    "fraction": lambda value: HOME.loads.toward(Loads.none(), value),
    "gravity": lambda value: HOME.loads.with_(gravity=value),
    "distributed": lambda value: HOME.loads.with_(distributed=value),
    "points": lambda value: HOME.loads.with_(points=value),
    "stations": lambda value: DistributedForce("leg1", value, np.zeros((2, 3))),
    "forces": lambda value: DistributedForce("leg1", [0, 1], value),
    "place": lambda value: PointForce("leg1", value, [0, 0, 0]),
}


@pytest.mark.parametrize(
    "value",
    ["word", {}, {"a": 1}, object(), [[1, 2]], 1j, b"bytes", True, False, np.ones((3, 1, 1))],
)
@pytest.mark.parametrize("question", QUESTIONS)
def test_no_wrong_type_becomes_another_error(question, value):
    with pytest.raises(CprError, match=r"expected|missing|no such file"):
        QUESTIONS[question](value)


def test_counts_are_whole_and_numbers_finite():
    assert checked_count("n", np.int64(3), 1) == 3
    assert checked_number("x", np.float32(0.5)) == 0.5
    assert checked_count("n", 1, 1, 1) == 1
    assert (checked_time(0.0), checked_time(None)) == (0.0, np.inf)
    for time in (-1e-9, np.nan):
        with pytest.raises(InvalidRequest, match="time_limit: expected a time of at least 0 s"):
            checked_time(time)
    for value in (2.5, 2.0, True, "2", None, np.timedelta64(2, "s")):
        with pytest.raises(InvalidRequest, match="n: expected a whole number"):
            checked_count("n", value, 1)
    with pytest.raises(InvalidRequest, match="n: expected at least 1, got 0"):
        checked_count("n", 0, 1)
    with pytest.raises(NonFiniteInput, match="x: expected a finite number, got inf"):
        checked_number("x", np.inf)
    with pytest.raises(InvalidRequest, match="x: expected a number"):
        checked_number("x", np.timedelta64(2, "s"))


def test_words_are_of_those_known():
    assert checked_word("fruit", "fig", ("fig", "plum")) == "fig"
    for value in ("pear", "", None, 3, ["fig"], np.array(["fig", "plum"])):
        with pytest.raises(InvalidRequest, match="fruit: expected fig, plum or apple, got"):
            checked_word("fruit", value, ("fig", "plum", "apple"))
    with pytest.raises(InvalidRequest, match="fruit: expected fig, got 'plum'"):
        checked_word("fruit", "plum", ("fig",))


@pytest.mark.parametrize(
    "value",
    [
        np.ma.masked_array([2.59, 0.55], mask=[False, True]),
        np.array([2.59 + 1j, 0.55]),
        np.array([1, 2], "timedelta64[s]"),
        np.array(["2020", "2021"], "datetime64[D]"),
    ],
    ids=["masked", "complex", "duration", "date"],
)
def test_what_is_masked_and_times_are_no_numbers(value):
    for question in ("motors", "pose", "stations"):
        with pytest.raises(InvalidRequest, match="expected 2 numbers"):
            QUESTIONS[question](value)
    for rows in (1, None):
        with pytest.raises(InvalidRequest, match=r"expected .*2 numbers"):
            checked_matrix("rows", value[None], rows, 2)
    with pytest.raises(InvalidRequest, match="motors: expected rows of 2 numbers"):
        trace_through(ROBOT, motors=value[None])
    with pytest.raises(InvalidRequest, match="platform: expected 2 numbers or NaN"):
        MODEL.solve(platform=value, wrench=[0, 0])


def test_a_masked_array_of_which_nothing_is_masked_is_one_of_numbers():
    found = solve_forward(ROBOT, np.ma.masked_array(HOME.motors))
    np.testing.assert_array_equal(found.motors, HOME.motors)


def test_matrices_have_their_rows_and_columns():
    rows = np.arange(6.0).reshape(3, 2)
    for count in (None, 3):
        np.testing.assert_array_equal(checked_matrix("m", rows.tolist(), count, 2), rows)
    for value in (rows[0], rows.T, rows[None], [[1, 2], [3]], "word", 1.0):
        for count, text in ((None, "rows of 2 numbers"), (3, "a matrix of 3 x 2 numbers")):
            with pytest.raises(InvalidRequest, match=f"m: expected {text}, got"):
                checked_matrix("m", value, count, 2)
    with pytest.raises(InvalidRequest, match="m: expected a matrix of 3 x 2 numbers, got"):
        checked_matrix("m", rows[:2], 3, 2)
    rows[1, 1] = np.inf
    with pytest.raises(NonFiniteInput, match=r"all finite, row 1 is \[2\.0, inf\]"):
        checked_matrix("m", rows, None, 2)


def test_vectors_are_numbers_in_a_row_that_nobody_can_write_to():
    given = np.arange(3.0)
    vector = checked_vector("v", given, 3)
    np.testing.assert_array_equal(vector, given)
    assert given.flags.writeable and not vector.flags.writeable
    with pytest.raises(InvalidRequest, match=r"v: expected 3 numbers \(x y z\), got 2"):
        checked_vector("v", [1, 2], 3, "x y z")
    with pytest.raises(
        InvalidRequest, match=r"v: expected 3 numbers, got an array of shape \(3, 1\)"
    ):
        checked_vector("v", given[:, None], 3)


def test_numbers_no_float_can_hold_are_none():
    with pytest.raises(InvalidRequest, match="x: expected a number, got 1000"):
        checked_number("x", 10**400)
    with pytest.raises(InvalidRequest, match="time_limit: expected a time of at least 0 s"):
        checked_time(10**400)
    for question in ("modes", "length", "limit", "factor", "time limit"):
        with pytest.raises(CprError, match="expected"):
            QUESTIONS[question](10**400)


@pytest.mark.parametrize(
    ("at", "force", "text"),
    [
        ([0, 0.5, 1], np.zeros((2, 3)), r"distributed\.force: expected 3 vectors.*got 2"),
        ([0, 1], [[0, 0, 0], [0, 0]], r"force\[1\]: expected 3 numbers"),
        ([0, 1], 1.0, r"expected 2 vectors, one for every station, got 1\.0"),
        ([0, 0.5, 0.5, 1], np.zeros((4, 3)), "increase from 0 to 1"),
        ([0.2, 1], np.zeros((2, 3)), "increase from 0 to 1"),
    ],
)
def test_a_distributed_force_has_a_vector_for_every_station(at, force, text):
    with pytest.raises(InvalidRequest, match=text):
        DistributedForce("leg1", at, force)


def test_point_forces_are_on_the_rod():
    with pytest.raises(InvalidRequest, match=r"points\.at: expected s/l between 0 and 1, got 1\.0"):
        PointForce("leg1", 1.0, [0, 0, 0])
    with pytest.raises(NonFiniteInput, match=r"points\.force"):
        PointForce("leg1", 0.5, [0, np.nan, 0])
    half = Loads.none().with_(points=[PointForce("leg1", 0.5, [0, 2, 0])]).scaled(0.5)
    np.testing.assert_array_equal(half.points[0].force, [0, 1, 0])


class Found:
    """What two threads find at once."""

    def __init__(self, barrier):
        self.barrier = barrier

    @cached_property
    def value(self):
        self.barrier.wait(timeout=60.0)
        return object()


def in_two_threads(*instances):
    with ThreadPoolExecutor(2) as threads:
        return list(threads.map(lambda instance: instance.value, instances))


def test_threads_find_what_belongs_to_several_at_once():
    """That of Python 3.11 finds one after the other, and hangs in a process forked meanwhile."""
    barrier = Barrier(2)
    first, second = in_two_threads(Found(barrier), Found(barrier))
    assert first is not second


def test_threads_that_find_the_same_all_have_what_is_kept():
    found = Found(Barrier(2))
    first, second = in_two_threads(found, found)
    assert first is second is found.value


def test_what_is_kept_with_a_value_is_found_once_for_each():
    asked = []

    @kept_with_value
    def found(value):
        asked.append(value)
        return len(asked)

    first, second = Found(None), Found(None)
    assert [found(first), found(second), found(first), found(second)] == [1, 2, 1, 2]
    assert asked == [first, second]

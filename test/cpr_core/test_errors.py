# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Errors arrive as they were raised, wherever that was; different numbers in them look different."""

import math
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from helpers.exceptions import assert_travels, example_of, exceptions_of
from helpers.workspace_cases import small_map

import cpr_core
from cpr_core import (
    DescriptionError,
    InvalidRequest,
    MotorLimitExceeded,
    NoForwardSolution,
    NoInverseSolution,
    NonFiniteInput,
    NotReached,
    StrainLimitExceeded,
    UnknownParameter,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    trace,
)
from cpr_core.errors import distinct, rounded_seconds
from cpr_core.workspace.map_files import MapNotWritten


@cache
def arguments():
    """What exceptions are made from, by the class whose ``__init__`` takes it."""
    robot = load_robot("rfrfr")
    stopped = trace(robot, pose=[3.0, 0.0], points=3).stopped
    assert stopped is not None
    way = 0.25, stopped.equilibrium, stopped
    return {
        DescriptionError: ("robot.yaml", "legs[1].motor", "expected a motor"),
        InvalidRequest: ("motors", "expected 2 numbers, got 1"),
        UnknownParameter: ("rod.lenght", "rod.length"),
        NotReached: ("the branch folds back", *way),
        MotorLimitExceeded: ("motor1", "position", 2.0, (-1.0, 1.0), "rad", *way),
        StrainLimitExceeded: ("leg1", 0.02, 0.01, *way),
        StrainLimitExceeded.__base__: ("a limit is passed", *way),
        MapNotWritten: (Path("map.nc"), small_map(), "no space left"),
    }


@pytest.mark.parametrize("kind", exceptions_of(cpr_core), ids=lambda kind: kind.__name__)
def test_exceptions_are_pickled_and_copied(kind):
    """In a pool of processes one that is not ends the pool, or leaves its caller waiting for ever."""
    assert_travels(example_of(kind, arguments()))


def raised(solve, *given, **options):
    with pytest.raises(cpr_core.CprError) as caught:
        solve(*given, **options)
    return caught.value


def test_so_are_those_that_were_raised():
    robot = load_robot("six_rfs")
    home = solve_home(robot)
    errors = (
        raised(solve_forward, robot, home.motors + 30.0),
        raised(solve_inverse, robot, home.pose + 3.0 * np.eye(7)[0]),
        raised(solve_forward, robot, np.full(6, np.nan)),
        raised(robot.with_parameters, {"rod.lenght": 1.0}),
        raised(load_robot, {"name": "x"}),
    )
    assert isinstance(errors[1], NoInverseSolution)
    for error in errors:
        assert_travels(error)


def test_a_pool_of_processes_raises_what_its_tasks_do():
    robot = load_robot("rfrfr")
    home = solve_home(robot)  # other processes find it to rounding only
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        with pytest.raises(NonFiniteInput, match=r"^motors: ") as refused:
            pool.submit(solve_forward, robot, [np.nan, 1.0]).result(timeout=300)
        assert refused.value.argument == "motors"
        with pytest.raises(NoForwardSolution) as caught:
            pool.submit(solve_forward, robot, [2000.0, 1.0], start=home).result(timeout=300)
    expected = raised(solve_forward, robot, [2000.0, 1.0], start=home)
    assert str(caught.value) == str(expected)
    assert caught.value.fraction == expected.fraction
    np.testing.assert_array_equal(caught.value.last.state, expected.last.state)
    assert caught.value.event.kind == expected.event.kind


@pytest.mark.parametrize(
    ("numbers", "texts"),
    [
        ((0.05, 0.1), ["0.05", "0.1"]),
        ((0.0499999, 0.05), ["0.0499999", "0.05"]),
        ((0.05, math.nextafter(0.05, 1.0)), ["0.05", "0.05000000000000001"]),
        ((2.8, 2.8), ["2.8", "2.8"]),
        ((2.8000001, -math.inf, 2.8), ["2.8000001", "-inf", "2.8"]),
        ((math.nan, 1.0), ["nan", "1"]),
        ((-785.398, -0.0), ["-785.4", "0"]),
    ],
)
def test_different_numbers_look_different(numbers, texts):
    assert distinct(*numbers) == texts


def test_more_digits_may_be_wanted_anyway():
    assert distinct(math.pi, 1.5, fewest=6) == ["3.14159", "1.5"]


@pytest.mark.parametrize(
    ("time", "text"),
    [(-6.9e-18, "0"), (-0.0, "0"), (-1.5, "-1.5"), (2.1e-9, "2e-09"), (0.1, "0.1")],
)
def test_times_are_zero_where_only_rounding_says_otherwise(time, text):
    assert rounded_seconds(time) == text

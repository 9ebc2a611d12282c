# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that are measured where they were sent, or not."""

import math

import numpy as np
import pytest
from helpers.drive import robot
from helpers.geared_robots import geared

from cpr_ros.following.measured_motors import MotorMeasurement, SeenMotors
from cpr_ros.following.motor_arrival import Elsewhere, MotorArrival

SENT = np.array([2.6, 0.5])
TOLERANCE = 0.02


@pytest.fixture
def arrival():
    return MotorArrival(robot("rfrfr"))


def looked(arrival, measured, now=0.0, *, commands=SENT, missing="", tolerance=TOLERANCE):
    place = None if measured is None else MotorMeasurement(np.asarray(measured, float), 0.0)
    return arrival.look(commands, SeenMotors(place, missing), tolerance, now)


def test_motors_within_the_tolerance_are_there(arrival):
    assert looked(arrival, SENT + [0.019, -0.019]) == Elsewhere("", 0.0)
    assert looked(arrival, SENT + [0.0, -0.021]).way == pytest.approx(0.021)


def test_every_motor_that_is_elsewhere_is_named_with_its_command(arrival):
    told = looked(arrival, SENT + [0.0, 0.1])
    assert told.why == (
        "motor2 is measured at 0.6 rad, its command is 0.5: 0.1 (rad or rod lengths) away, "
        "more than arrived_tolerance 0.02"
    )
    told = looked(arrival, SENT + [-0.3, 0.1])
    assert told.why.startswith("motor1 is measured at 2.3 rad, its command is 2.6; motor2 is ")
    assert told.way == pytest.approx(0.3)
    assert arrival.last == told


def test_a_motor_behind_a_gear_turns_farther_and_is_as_near():
    _, behind_gears, ratios = geared("rfrfr")
    arrival = MotorArrival(behind_gears)
    for joints, there in (([0.019, 0.0], True), ([0.021, 0.0], False)):
        found = looked(arrival, (SENT + joints) / ratios, commands=SENT / ratios)
        assert (found.why == "") == there


def test_where_nothing_is_measured_or_asked_for_nothing_is_against_it(arrival):
    assert looked(arrival, None) == Elsewhere()
    assert looked(arrival, SENT + 1.0, tolerance=0.0) == Elsewhere()
    assert looked(arrival, None, missing="too old", tolerance=0.0) == Elsewhere()
    assert looked(arrival, SENT, commands=None) == Elsewhere()


def test_motors_that_are_measured_no_more_are_nobody_knows_where(arrival):
    told = looked(arrival, None, missing="the measured motors are too old")
    assert told.why == "the measured motors are too old"
    assert math.isnan(told.way)


def test_it_counts_how_long_they_are_elsewhere_since_commands_rest(arrival):
    still = SENT - 0.3
    for number in range(30):  # on their way
        looked(arrival, still, 0.1 * number, commands=still + 0.03 * number)
        assert arrival.waited(0.1 * number) == 0.0
    for number in range(10):
        noise = 0.005 * (-1) ** number  # of a correction by measured poses
        looked(arrival, still, 3.0 + 0.1 * number, commands=SENT + noise)
    assert arrival.waited(4.0) == pytest.approx(1.0)
    looked(arrival, SENT, 4.0)
    assert arrival.waited(4.0) == 0.0
    looked(arrival, still, 4.5)
    assert arrival.waited(4.7) == pytest.approx(0.2)


def test_motors_that_come_nearer_are_waited_for_however_slow(arrival):
    """A slow drive was given up on its way, as commands had rested for long enough."""
    for number in range(100):
        looked(arrival, SENT - 0.3 + 0.003 * number, 0.1 * number)
        assert arrival.waited(0.1 * number) < 0.5
    jammed = SENT - 0.1
    looked(arrival, jammed, 20.0, commands=SENT + 0.05)
    looked(arrival, jammed, 21.0, commands=SENT + 0.05)
    assert arrival.waited(21.0) == pytest.approx(1.0)

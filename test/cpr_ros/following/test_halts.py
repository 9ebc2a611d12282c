# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a follower slows down and halts: before instabilities, singularities and limits."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from helpers.drive import PERIOD, SETTINGS, THRESHOLDS, Drive, changed_robot, robot, to

from cpr_core import load_robot
from cpr_core.model.assessment import Threshold
from cpr_ros.following.goals import MotorGoal
from cpr_ros.following.supervision import Action, State, Status


@pytest.mark.parametrize("modes", [5, 12])
def test_straight_through_an_instability_it_slows_halts_before_and_returns(modes):
    """The crossing of the continuous rods with motors locked lies at y = 0.03571."""
    rfrfr = Drive(load_robot("rfrfr", modes))
    to(rfrfr, 0.0, 0.8)
    rfrfr.until_state(State.IDLE)
    to(rfrfr, 0.0, -0.2)
    halted = rfrfr.until_state(State.HALTED)
    assert halted.verdict.status == Status.HALT_FOR_STABILITY
    assert (halted.verdict.action, halted.verdict.speed_scale) == (Action.HALT, 0.0)
    assert 0.0357 < rfrfr.position[1] < 0.06
    assert THRESHOLDS["margin"].stop <= rfrfr.current.margin < 1.02 * THRESHOLDS["margin"].stop
    assert all(outcome.assessment.index == 0 for outcome in rfrfr.outcomes)
    statuses = [outcome.verdict.status for outcome in rfrfr.outcomes]
    assert statuses.index(Status.DECELERATE_FOR_STABILITY) < statuses.index(
        Status.HALT_FOR_STABILITY
    )
    # What is compared is told apart, by the names of the message and the parameters.
    words = re.fullmatch(
        r"the next margin, (\S+), is below margin_stop 0.05; here it is (\S+)",
        halted.verdict.text,
    )
    assert float(words[1]) < 0.05 < float(words[2])
    # It stays there however long it is pushed ...
    at_halt = rfrfr.current
    for _ in range(100):
        assert rfrfr.tick().state == State.HALTED
    assert rfrfr.current is at_halt
    # ... and is not trapped.
    to(rfrfr, 0.0, 0.8)
    rfrfr.until_state(State.IDLE)
    np.testing.assert_allclose(rfrfr.position[:2], [0.0, 0.8], atol=1e-9)
    assert rfrfr.outcomes[-1].verdict.action == Action.NONE


def test_speed_falls_with_the_margin_on_the_way_in_and_not_on_the_way_out(rfrfr):
    def fastest(outcomes):
        """Largest motor step by speed scale before it, where the margin warns."""
        pairs = []
        for before, after in pairwise(outcomes):
            step = np.abs(
                after.assessment.equilibrium.motors - before.assessment.equilibrium.motors
            ).max()
            level = THRESHOLDS["margin"].level(before.assessment.margin)
            if 0.1 < level < 0.9:
                pairs.append((step / PERIOD, level))
        return np.array(pairs)

    to(rfrfr, 0.0, -0.2)
    rfrfr.until_state(State.HALTED)
    inward = fastest(rfrfr.outcomes)
    assert len(inward) > 10
    assert np.all(inward[:, 0] <= inward[:, 1] * (1.0 + 1e-6))
    rfrfr.outcomes.clear()
    to(rfrfr, 0.0, 0.8)
    rfrfr.until_state(State.IDLE)
    outward = fastest(rfrfr.outcomes)
    assert np.median(outward[:, 0]) > 0.8


def test_a_setpoint_stream_into_the_instability_does_not_get_through(rfrfr):
    """New setpoints at every tick must not start the search for the way anew."""
    for _ in range(2500):
        to(rfrfr, 0.0, -0.2)
        rfrfr.tick()
    assert rfrfr.outcomes[-1].state == State.HALTED
    assert all(outcome.assessment.index == 0 for outcome in rfrfr.outcomes)
    assert rfrfr.current.margin >= THRESHOLDS["margin"].stop


def test_motors_straight_through_an_instability_are_halted_as_well(rfrfr):
    rfrfr.follow(MotorGoal(rfrfr.robot, rfrfr.motors + [4.0, -4.0]))
    halted = rfrfr.until_state(State.HALTED)
    assert halted.verdict.status == Status.HALT_FOR_STABILITY
    assert rfrfr.current.margin >= THRESHOLDS["margin"].stop


def test_what_is_below_the_stop_threshold_already_may_get_better_and_not_worse(rfrfr):
    """Thresholds raised at run time leave the robot free to come back."""
    to(rfrfr, 0.0, 0.15)
    rfrfr.until_state(State.IDLE)
    thresholds = THRESHOLDS | {"margin": Threshold(0.9, 0.8)}
    rfrfr.follower.settings = replace(SETTINGS, thresholds=thresholds)
    margin = rfrfr.current.margin
    assert margin < 0.8
    to(rfrfr, 0.0, 0.1)
    rfrfr.until_state(State.HALTED)
    assert rfrfr.current.margin == margin
    to(rfrfr, 0.0, 0.8)
    rfrfr.until_state(State.IDLE)
    assert rfrfr.current.margin > 0.9


def test_it_halts_before_an_inverse_singularity_on_a_platform_way_only():
    """Stretched out, the motors cannot lift the point any more."""
    thresholds = THRESHOLDS | {"inverse_singularity": Threshold(0.03, 0.015)}
    drive = Drive(robot("rfrfr"), thresholds=thresholds)
    to(drive, 0.0, 1.1)
    halted = drive.until_state(State.HALTED)
    assert halted.verdict.status == Status.HALT_FOR_SINGULARITY
    assert 0.015 <= drive.current.inverse_singularity < 0.016
    assert 0.9 < drive.position[1] < 0.98
    statuses = {outcome.verdict.status for outcome in drive.outcomes}
    assert Status.DECELERATE_FOR_APPROACHING_SINGULARITY in statuses
    # Motors know no inverse problem.
    drive.follow(MotorGoal(drive.robot, drive.motors + [-0.1, 0.1]))
    drive.until_state(State.IDLE)
    assert drive.current.inverse_singularity < 0.015
    drive.outcomes.clear()
    to(drive, 0.0, 0.8)
    drive.until_state(State.IDLE)
    statuses = {outcome.verdict.status for outcome in drive.outcomes}
    assert Status.DECELERATE_FOR_LEAVING_SINGULARITY in statuses


@pytest.mark.parametrize("far", [1e6, 1e100, 1e200, 1e300])
def test_a_pose_beyond_all_robots_halts(rfrfr, far):
    """The square of its distance was infinite: it was followed for ever, by steps of nothing."""
    to(rfrfr, far, 0.7)
    outcome = rfrfr.until_state(State.HALTED)
    assert outcome.verdict.action == Action.HALT


def test_it_stops_at_the_range_of_a_motor(rfrfr):
    def limit(content):
        for leg in content["legs"]:
            leg["motor"]["limits"] = {"position": [-0.5, 2.8]}

    drive = Drive(changed_robot("rfrfr", limit))
    drive.follow(MotorGoal(drive.robot, [3.5, 0.55]))
    drive.until_state(State.IDLE)
    assert drive.motors[0] == 2.8
    assert drive.outcomes[-1].verdict.status == Status.JOINT_BOUND
    # The other motor is not held up by it, and the way back is free.
    drive.follow(MotorGoal(drive.robot, [3.5, 0.60]))
    drive.until_state(State.IDLE)
    np.testing.assert_array_equal(drive.motors, [2.8, 0.60])
    drive.follow(MotorGoal(drive.robot, [2.59, 0.60]))
    drive.until_state(State.IDLE)
    assert drive.outcomes[-1].verdict.status == Status.NO_WARNING
    # A platform way that would need more is halted.
    to(drive, 0.0, 0.7)
    halted = drive.until_state(State.HALTED)
    assert halted.verdict.status == Status.JOINT_BOUND
    assert drive.motors[0] <= 2.8


def test_it_halts_before_the_effort_of_a_motor_is_reached():
    def limit(content):
        for leg in content["legs"]:
            leg["motor"]["limits"] = {"effort": 1.0}

    drive = Drive(changed_robot("rfrfr", limit))
    to(drive, 0.0, 0.3)
    halted = drive.until_state(State.HALTED)
    assert halted.verdict.status == Status.JOINT_BOUND
    assert 0.9 < np.abs(drive.current.equilibrium.efforts).max() <= 0.98 + 1e-9


def test_it_halts_before_a_rod_yields():
    def limit(content):
        content["rod"]["yield_strain"] = 0.006

    drive = Drive(changed_robot("rfrfr", limit))
    to(drive, 0.0, 0.3)
    halted = drive.until_state(State.HALTED)
    assert halted.verdict.status == Status.STRAIN_BOUND
    assert drive.current.strain_reserve == pytest.approx(
        THRESHOLDS["strain_reserve"].stop, abs=0.01
    )

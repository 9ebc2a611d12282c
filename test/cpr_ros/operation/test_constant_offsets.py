# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that are off their commands by the same wherever the node begins are not begun with again."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.drive import PERIOD, SETTINGS
from helpers.session_bench import LIVE, apply, commanded, still

from cpr_ros.closed_loop.jogging import PlatformTwist
from cpr_ros.error_codes import RequestError
from cpr_ros.following.goals import MotorGoal
from cpr_ros.following.supervision import Action
from cpr_ros.operation.live_changes import apply_live
from cpr_ros.operation.starting_place import begin_at_measured


class Drive:
    """Motors that go where they are sent, but for an offset, a jam or a hand; asked for a setpoint.

    Attributes:
        off: Of the motors from their commands, (n,).
        jammed: Whether the second one stays where it is.
        held: Where the motors are held; None: nobody holds them.
        begun: How often the node has begun where they are measured.
    """

    def __init__(self, bench):
        self.bench, self.session = bench, bench.session
        self.home = self.session.solver.current.equilibrium.motors
        commanded(self.session, self.home)
        self.motors, self.off, self.begun = self.home, np.zeros(2), 0
        self.jammed, self.held = False, None

    def run(self, seconds, setpoint=lambda now: None):
        """Let time pass; what is asked for while the node takes nothing is lost."""
        for number in range(round(seconds / PERIOD)):
            self._drive()
            goal = setpoint(self.bench.now)
            if (
                goal is not None
                and number % 4 == 0
                and not self.session.moved_by_others.in_question
            ):
                self.session.orders.follow(MotorGoal(self.session.robot, goal), self.bench.now)
            if self.session.take_measured(self.motors, self.bench.now):
                begin_at_measured(self.session, self.motors)
                self.begun += 1
            self.bench.tick()

    def _drive(self):
        sent = self.bench.commands[-1] if self.bench.commands else self.home
        step = np.clip(sent + self.off - self.motors, -4.0 * PERIOD, 4.0 * PERIOD)
        self.motors = self.motors + [step[0], 0.0 if self.jammed else step[1]]
        if self.held is not None:
            self.motors = self.held

    def push(self, way, setpoint=lambda now: None):
        """Somebody moves the second motor, and holds it until the node has begun there."""
        begun, place = self.begun, self.motors
        self.held = place + [0.0, way]
        for _ in range(20):
            if self.begun == begun:
                self.run(0.1, setpoint)
        self.held = None
        self.stay()

    def stay(self):
        """The motors hold where they are, whatever they were sent before."""
        self.bench.commands.append(self.motors)

    def jumps(self):
        """Commands that are farther from the one before than the speed limit allows."""
        max_speed = self.session.follower.settings.max_speed
        steps = np.diff([self.home, *self.bench.commands], axis=0)
        return int((np.abs(steps).max(axis=1) > 1.5 * PERIOD * max_speed).sum())

    def swing(self, now):
        """A stream of setpoints."""
        return self.home + 0.3 * np.sin(0.8 * now)


@pytest.fixture
def drive(bench):
    return Drive(bench)


def halted(drive):
    """Whether nothing moves, and a supervisor is told of an offset of the second motor."""
    sent, told = len(drive.bench.commands), drive.session.verdict(drive.bench.now)
    drive.run(1.5, drive.swing)
    assert len(drive.bench.commands) == sent
    return told.action == Action.HALT and "motor2 was measured" in told.text


@pytest.mark.parametrize("off", [0.3, -0.3, 0.15])
@pytest.mark.parametrize("max_speed", [1.0, 3.0])
def test_motors_that_are_off_by_the_same_are_begun_with_once(drive, off, max_speed):
    """A coupling slipped: every second a setpoint moved the robot on by as much at once."""
    apply_live(
        drive.session,
        replace(LIVE, settings=replace(SETTINGS, max_speed=max_speed)),
        drive.bench.now,
    )
    goals = [drive.home, drive.home + [0.3, -0.3]]
    drive.run(1.0, drive.swing)
    drive.off = np.array([0.0, off])
    drive.run(12.0, lambda now: goals[int(now / 2.0) % 2] if max_speed > 1.0 else drive.swing(now))
    assert (drive.begun, drive.jumps()) == (1, 1)
    assert halted(drive)
    assert (
        f"motor2 was measured {off:+.3g} rad off its command" in drive.session.moved_by_others.away
    )


def offset(drive):
    """A motor that is off by the same again."""
    drive.off = np.array([0.0, 0.3])
    drive.run(5.0, drive.swing)
    assert halted(drive)
    return drive.session


def test_nothing_is_taken_while_motors_are_off_by_the_same(drive):
    session, now = offset(drive), drive.bench.now
    for ask in (
        lambda: session.orders.follow(MotorGoal(session.robot, drive.home), now),
        lambda: session.orders.jog(PlatformTwist(np.eye(6)[3], in_platform=False), now),
        lambda: still(session, drive.home, now),
        lambda: apply(session, 2.6, 0.5),
        session.orders.reset,
    ):
        with pytest.raises(RequestError, match=r"motor2 was measured \+0\.3 rad off its command"):
            ask()
    assert session.outgoing.repeated() is None
    assert session.known_place[1] is None  # a node of later has to measure them
    drive.motors = drive.motors + 0.5  # who moves them by hand has not mended them
    drive.held = drive.motors
    drive.run(2.0)
    assert (drive.begun, drive.session.verdict(drive.bench.now).action) == (1, Action.HALT)


def activated(drive):
    """The node becomes active where the motors are measured, as its operator asks for."""
    drive.session.stand()
    begin_at_measured(drive.session, drive.motors)
    drive.run(1.0)
    assert drive.session.verdict(drive.bench.now).action == Action.NONE


def test_who_activates_the_node_anew_begins_there(drive):
    session = offset(drive)
    activated(drive)
    begun, jumps = drive.begun, drive.jumps()
    drive.run(5.0, drive.swing)  # nobody has mended it
    assert (drive.begun - begun, drive.jumps() - jumps) == (0, 1)
    assert halted(drive)
    drive.off = np.zeros(2)
    drive.stay()
    activated(drive)
    drive.run(5.0, drive.swing)
    np.testing.assert_allclose(drive.motors, drive.bench.commands[-1], atol=0.02)
    assert not session.moved_by_others.away
    drive.push(0.3)  # as far as it was off
    assert drive.begun - begun == 1


def test_motors_that_are_where_they_were_sent_again_go_on(drive):
    session = offset(drive)
    drive.off = np.zeros(2)
    drive.run(1.0)
    assert session.verdict(drive.bench.now).action == Action.NONE
    drive.run(2.0, drive.swing)
    np.testing.assert_allclose(drive.motors, drive.bench.commands[-1], atol=0.02)


def test_a_tolerance_that_is_large_enough_ends_it(drive):
    session, sent = offset(drive), len(drive.bench.commands)
    apply_live(session, replace(LIVE, moved_tolerance=0.5), drive.bench.now)
    drive.run(1.0)
    assert len(drive.bench.commands) == sent
    drive.run(5.0, drive.swing)
    assert len(drive.bench.commands) > sent and not session.moved_by_others.away


@pytest.mark.parametrize("moving", [False, True])
def test_motors_that_are_pushed_as_far_again_and_again_are_begun_with_every_time(drive, moving):
    for _ in range(4):
        around = drive.session.solver.current.equilibrium.motors

        def stream(now, around=around):
            return around + 0.1 * np.sin(5.0 * now) if moving else None

        drive.run(2.0, stream)
        drive.push(-0.3, stream)
    assert drive.begun == 4


def test_motors_that_jam_as_far_behind_again_and_again_are_begun_with_every_time(drive):
    """They are as far behind as commands go ahead; in between they have followed."""
    for number in range(3):
        goal = drive.session.solver.current.equilibrium.motors + [0.0, 0.6]
        for jammed in (False, True):
            drive.jammed = jammed
            drive.run(0.3, lambda now, goal=goal: goal)
        drive.run(2.0)
        assert drive.begun == number + 1
        drive.jammed = False
        drive.stay()

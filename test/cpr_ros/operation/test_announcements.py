# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the log is told, and how often."""

from dataclasses import replace

import pytest
from helpers.drive import PERIOD, robot

from cpr_core import solve_home
from cpr_core.model.assessment import Assessment
from cpr_ros.following.borne_loads import Snapped
from cpr_ros.following.news import News
from cpr_ros.following.outcome import Outcome
from cpr_ros.following.supervision import Action, State, Status, Verdict
from cpr_ros.operation.announcements import Announcements

FREE = Verdict(Status.NO_WARNING, "stable", Action.NONE, 1.0, "margin", 5.0)
HALT = Verdict(Status.HALT_FOR_STABILITY, "too near", Action.HALT, 0.0, "margin", 0.0)


class Log:
    def __init__(self):
        self.announcements, self.now = Announcements(), 0.0
        self.warnings, self.informations = [], []
        self.outcome = Outcome(Assessment(solve_home(robot("rfrfr"))), False, State.IDLE, FREE)

    def ticks(self, count, state, verdict):
        for _ in range(count):
            self.now += PERIOD
            outcome = replace(self.outcome, state=state, verdict=verdict)
            warning, information = self.announcements.after_tick(outcome, self.now)
            self.warnings += [warning] if warning else []
            self.informations += [information] if information else []


@pytest.fixture
def log():
    return Log()


def test_free_motion_is_not_worth_a_word(log):
    for _ in range(3):
        log.ticks(10, State.FOLLOWING, FREE)
        log.ticks(10, State.IDLE, FREE)
    assert (log.warnings, log.informations) == ([], [])


def test_a_halt_and_its_end_are_said_once(log):
    for number in range(1, 4):
        log.ticks(300, State.HALTED, HALT)
        log.ticks(300, State.FOLLOWING, FREE)
        assert log.warnings == ["halt (HALTED, HALT_FOR_STABILITY): too near"] * number
        assert log.informations == ["the halt is over (FOLLOWING): stable"] * number


def test_what_changes_in_the_tick_that_ends_a_halt_is_said_with_it(log):
    """It was said a tick later, if there was one."""
    other, count = Log(), 0
    other.ticks(10, State.HALTED, HALT)
    while not other.informations:
        other.ticks(1, State.FOLLOWING, FREE)
        count += 1
    log.ticks(10, State.HALTED, HALT)
    log.ticks(count - 1, State.FOLLOWING, FREE)
    assert log.informations == []
    log.ticks(1, State.PAUSED, FREE)
    assert log.informations == [
        "the halt is over (PAUSED): stable; paused: holds, and takes no setpoints"
    ]


def test_a_robot_that_may_have_snapped_is_told_of_within_a_halt_too(log):
    log.ticks(10, State.IDLE, HALT)
    snapped = Verdict(Status.BRANCH_JUMP, "snapped", Action.HALT, 0.0, "margin", 0.0)
    log.outcome = replace(log.outcome, refusal=Snapped("branch_jump", "snapped"))
    log.ticks(10, State.IDLE, snapped)
    log.outcome = replace(log.outcome, refusal=None)
    log.ticks(10, State.IDLE, HALT)
    assert log.warnings == [
        "halt (IDLE, HALT_FOR_STABILITY): too near",
        "halt (IDLE, BRANCH_JUMP): snapped",
    ]


def test_a_robot_that_becomes_lost_within_a_halt_is_told_of_once(log):
    nowhere = Verdict(Status.NOT_CONVERGED, "nowhere", Action.HALT, 0.0, "margin", 0.0)
    log.ticks(10, State.TRACKING, HALT)
    for _ in range(2):
        log.ticks(10, State.LOST, nowhere)
        log.ticks(10, State.TRACKING, HALT)
    assert log.warnings == [
        "halt (TRACKING, HALT_FOR_STABILITY): too near",
        *["halt (LOST, NOT_CONVERGED): nowhere"] * 2,
    ]
    assert log.informations == []


def test_motors_that_are_measured_no_more_are_told_once(log):
    gone, back = "the measured motors are older than measured_timeout 0.5 s", ""
    told = [log.announcements.of_motors(why) for why in (back, gone, gone, back, back, gone)]
    missing = (f"{gone}: what is moved now is moved without being seen", "")
    assert told == [
        ("", ""),
        missing,
        ("", ""),
        ("", "the motors are measured again"),
        ("", ""),
        missing,
    ]


def test_motors_that_were_not_measured_for_a_moment_are_not_told_as_missing_now(log):
    """Back after 0.6 s, the log's first word was that what is moved now is moved unseen."""
    back = "the measured motors are older than measured_timeout 0.5 s; it came again"
    told = [log.announcements.of_motors(why, again=True) for why in (back, back, "")]
    warning = f"{back}: what was moved meanwhile was moved without being seen"
    assert told == [(warning, ""), ("", ""), ("", "the motors are measured again")]


def test_others_who_command_are_told_once(log):
    others, nobody = "/commands has 1 more publisher", ""
    told = [
        log.announcements.of_commanders(who) for who in (nobody, others, others, nobody, others)
    ]
    gone = ("", "nobody else commands the motors any more")
    assert told == [("", ""), (others, ""), ("", ""), gone, (others, "")]


def test_ticks_go_on_until_the_end_of_a_halt_is_said(log):
    """A robot at rest was not said to be free before it moved."""
    for state, verdict, rests in ((State.IDLE, HALT, True), (State.IDLE, FREE, False)):
        log.ticks(1, state, verdict)
        assert log.announcements.at_rest == rests
    log.ticks(200, State.IDLE, FREE)
    assert log.announcements.at_rest
    assert log.informations == ["the halt is over (IDLE): stable"]


def test_a_halt_that_trembles_is_one_halt(log):
    for _ in range(100):
        log.ticks(3, State.HALTED, HALT)
        log.ticks(20, State.FOLLOWING, FREE)
    assert len(log.warnings) == 1
    assert log.informations == []
    log.ticks(200, State.IDLE, FREE)
    assert len(log.informations) == 1


@pytest.mark.parametrize(
    ("state", "verdict"),
    [(State.IDLE, HALT), (State.PAUSED, HALT), (State.STALE, FREE), (State.LOST, HALT)],
)
def test_every_way_to_be_held_is_a_halt(log, state, verdict):
    log.ticks(5, state, verdict)
    assert len(log.warnings) == 1
    assert log.warnings[0].startswith(f"halt ({state.name}, ")


def test_pauses_and_returns_are_said_once(log):
    log.ticks(5, State.PAUSED, FREE)
    log.ticks(5, State.IDLE, FREE)
    log.ticks(5, State.RETURNING, FREE)
    log.ticks(5, State.IDLE, FREE)
    assert log.informations == [
        "paused: holds, and takes no setpoints",
        "released: takes setpoints again",
        "on the way home",
        "the way home has ended",
    ]


def test_a_release_that_lets_commands_go_on_is_said_to(log):
    """It was said to take setpoints, and the robot drove off."""
    log.ticks(5, State.PAUSED, FREE)
    log.ticks(5, State.ALIGNING, FREE)
    log.ticks(5, State.IDLE, FREE)
    assert log.informations[1:] == ["released: commands go on to where the node has the robot"]


def test_a_halted_robot_that_is_sent_home_is_said_to_be_on_its_way(log):
    """It was not: only a tick at which it was idle in between made a way home of it."""
    log.ticks(5, State.HALTED, HALT)
    log.ticks(5, State.RETURNING, FREE)
    log.ticks(5, State.IDLE, FREE)
    assert log.informations == ["on the way home", "the way home has ended"]


def test_a_way_home_with_halts_is_one_way_home(log):
    log.ticks(5, State.RETURNING, FREE)
    for _ in range(3):
        log.ticks(5, State.HALTED, HALT)
        log.ticks(5, State.RETURNING, FREE)
    log.ticks(5, State.FOLLOWING, FREE)
    log.ticks(5, State.HALTED, HALT)
    log.ticks(5, State.RETURNING, FREE)
    assert log.informations == ["on the way home"] * 2


def test_a_setpoint_that_nobody_asked_to_forget_is_told_once():
    """The robot stood somewhere on its way, and nothing said why."""
    announcements = Announcements()
    assert announcements.of_setpoint("") == News()
    told = announcements.of_setpoint("the bus is dead")
    assert told == News(warning="the setpoint is forgotten, the robot holds: the bus is dead")
    assert announcements.of_setpoint("the bus is dead") == News()
    assert announcements.of_setpoint("") == News()  # another one has come
    assert announcements.of_setpoint("the bus is dead").warning

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that are late are not said to stand still, and those that stand still are told in time."""

from dataclasses import dataclass

import numpy as np
import pytest
from helpers.drive import robot
from hypothesis import given, settings
from hypothesis import strategies as st

from cpr_ros.following.motor_commands import MotorCommands
from cpr_ros.following.moved_by_others import FOLLOWING, SETTLING, MovedByOthers
from cpr_ros.following.standstill import GONE_ON, RESTING

ROBOT, PERIOD, HOME = robot("rfrfr"), 0.005, np.array([2.6, 0.5])


@dataclass(frozen=True)
class Motors:
    """Motors that do what they were sent to do a while ago, and who measures them.

    Attributes:
        late: Pure delay [s].
        lag: Time constant of the rest [s].
        rate: Of measurements [1/s].
        noise: Of these, largest [rad].
        offset: What a load holds them off their command by [rad].
        fastest: Speed they do not exceed [rad/s].
        sticks: Times at which they stop, and for how long [s].
    """

    late: float = 0.0
    lag: float = 0.0
    rate: float = 100.0
    noise: float = 0.0
    offset: float = 0.0
    fastest: float = np.inf
    sticks: tuple[tuple[float, float], ...] = ()


class Watched:
    """Commands to such motors, and what is said of these, tick by tick."""

    def __init__(self, motors, tolerance, max_speed, max_lead=0.0):
        self.motors, self.max_speed, self.rate = motors, max_speed, motors.rate
        self.others = MovedByOthers(ROBOT, tolerance)
        self.commands = MotorCommands(ROBOT, PERIOD, max_lead)
        self.commands.place(HOME)
        self.random, self.tick, self.next_measured = np.random.default_rng(1), 0, 0.0
        self.sent, self.at, self.measured = [HOME], HOME, HOME + motors.offset
        self.far_since = None

    def go(self, target, speed, seconds=np.inf):
        """Towards a target until it is reached, or for so long [s]; whether something is said."""
        for _ in range(round(min(seconds, 20.0) / PERIOD)):
            if self.commands.aligned_with(target):
                break
            way = target - self.commands.newest
            part = min(1.0, speed * PERIOD / np.abs(way).max())
            aim = target if part == 1.0 else self.commands.newest + part * way
            command = self.commands.step_to(aim, self.max_speed, self.measured)
            self.step(command, self.commands.waits)
            if self.others.away:
                return True
        return False

    def rest(self, seconds):
        """Without commands; whether something is said."""
        for _ in range(round(seconds / PERIOD)):
            self.step(None, False)
            if self.others.away:
                return True
        return False

    def step(self, command, waits):
        """One tick."""
        now = self.tick * PERIOD
        if command is not None:
            self.others.commanded(now, command)
        self.sent.append(self.commands.newest)
        if not any(begin <= now < begin + length for begin, length in self.motors.sticks):
            wanted = self.sent[max(0, self.tick + 1 - round(self.motors.late / PERIOD))]
            part = min(1.0, PERIOD / self.motors.lag) if self.motors.lag else 1.0
            most = self.motors.fastest * PERIOD
            self.at = self.at + np.clip(part * (wanted - self.at), -most, most)
        if now >= self.next_measured:
            self.next_measured += 1.0 / self.rate
            self.measure(now, waits)
        self.tick += 1

    def measure(self, now, waits):
        noise = self.random.uniform(-1.0, 1.0, 2) * self.motors.noise
        self.measured = self.at + self.motors.offset + noise
        sent, options = self.commands.newest, {"max_speed": self.max_speed, "waited_for": waits}
        self.others.take(self.measured, sent, now, **options)
        far = np.abs(self.measured - sent).max() > self.others.tolerance
        self.far_since = (now if self.far_since is None else self.far_since) if far else None


@pytest.mark.parametrize("pause", [0.1, 0.3, 0.36, 0.4, 0.44, 0.48, 0.6])
def test_a_pause_before_new_commands_is_no_time_in_which_they_went_on(pause):
    """Motors 0.13 s late were said to have rested for half a second, commands went on for a tenth."""
    watched = Watched(Motors(late=0.13), 0.02, 0.2, 0.2)
    for number in range(8):
        assert not watched.go(HOME + [0.1 * (number % 2 == 0), 0.0], 0.2)
        assert not watched.rest(pause)


@pytest.mark.parametrize("slow", [0.003, 0.02, 0.1])
def test_slow_commands_before_fast_ones_are_none_either(slow):
    watched = Watched(Motors(late=0.2), 0.1, 1.0)
    for sign in (1.0, -1.0, 1.0):
        assert not watched.go(HOME + [0.3 * sign, 0.0], slow, seconds=1.3)
        assert not watched.go(HOME + [0.6 * sign, 0.0], 1.0, seconds=0.4)


def test_small_commands_back_and_forth_are_none_either():
    """Of a pose that is measured with noise: the motors hardly go with them."""
    watched = Watched(Motors(late=0.1, lag=0.1), 0.1, 1.0)
    for number in range(60):
        assert not watched.go(HOME + [0.025 * (number % 2), 0.0], 1.0)
    assert not watched.go(HOME + [0.6, 0.0], 1.0)


def test_ways_out_that_motors_hardly_follow_do_not_add_up():
    """Too short for motors that follow slowly: together they are farther out for a second."""
    watched = Watched(Motors(late=0.1, lag=0.3), 0.1, 1.0)
    for _ in range(30):
        assert not watched.go(HOME + [0.04, 0.0], 1.0)
        assert not watched.go(HOME, 1.0)
        assert not watched.rest(0.22)
    assert np.abs(watched.at - HOME).max() < RESTING
    assert not watched.go(HOME + [0.6, 0.0], 1.0)


@pytest.mark.parametrize("max_speed", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("part", [0.05, 0.1, 0.15, 0.2, 0.5])
def test_slow_drives_are_not_moved_by_others_while_they_come_nearer(part, max_speed):
    """Commands rest as far ahead as max_lead allows; somebody was said to have moved the motors."""
    watched = Watched(Motors(fastest=part * max_speed), 0.1, max_speed, 0.2)
    target = HOME + [0.3, -0.3]
    assert not watched.go(target, max_speed)
    assert not watched.rest(0.5 / watched.motors.fastest)
    np.testing.assert_allclose(watched.measured, target, atol=1e-9)
    watched.at = target + [0.2, 0.0]
    assert watched.rest(0.6) and "somebody else has moved the motors" in watched.others.away


@pytest.mark.parametrize("times", [0.05, 0.2, 0.4])
@pytest.mark.parametrize("pause", [0.0, 0.1, 0.4])
def test_motors_without_power_are_told_however_often_commands_turn_or_rest(times, pause):
    """There and back, farther than is tolerated, before half a second is over."""
    watched = Watched(Motors(sticks=((0.0, np.inf),)), 0.04, 1.0)
    elsewhere = 0.0
    while not watched.others.away:
        told = watched.go(HOME + [times, 0.0], 1.0) or watched.go(HOME, 1.0)
        told = told or watched.rest(pause)
        assert told or elsewhere < SETTLING
        elsewhere += 2.0 * (times - GONE_ON) / 1.0 - 2.0 * PERIOD  # it is seen from tick to tick
    assert "the motors do not follow" in watched.others.away


def programme(watched, random, seconds):
    """Motions of all sizes and speeds, and pauses; whether something is said of the motors."""
    largest = random.choice([0.03, 0.1, 0.4])
    while watched.tick * PERIOD < seconds:
        target = HOME + random.choice([0.0, 0.5, 1.0, -1.0], 2) * largest * random.uniform(0.2, 1.0)
        speed = watched.max_speed * random.choice([1.0, 1.0, 0.3, 0.05, 0.01])
        lasts = random.choice([random.uniform(0.0, 1.5), np.inf])
        if watched.go(target, speed, lasts):
            return True
        longest = random.choice([0.0, 0.6, 1.2])
        if watched.rest(random.uniform(0.0, longest)):
            return True
    return False


limits = st.sampled_from([(0.025, 0.2), (0.05, 1.0), (0.1, 1.0), (0.1, 3.0)])
leads = st.sampled_from([0.0, 0.2, 0.5])
rates = st.sampled_from([5.0, 10.0, 20.0, 100.0])
seeds = st.integers(0, 10**6)


@settings(max_examples=20, deadline=None)
@given(limits=limits, max_lead=leads, rate=rates, late=st.floats(0.0, 0.3), seed=seeds)
def test_motors_that_follow_late_are_never_said_not_to(limits, max_lead, rate, late, seed):
    (tolerance, max_speed), random = limits, np.random.default_rng(seed)
    lag = random.choice([0.0, 0.2 * (0.4 - late)])
    longest = 0.45 - late - 3.0 * lag
    motors = Motors(
        late=late,
        lag=lag,
        rate=rate,
        noise=random.choice([0.0, 0.0015]),
        offset=random.choice([0.0, 0.3 * min(tolerance, (max_lead or 1.0) * max_speed)]),
        sticks=tuple((begin, random.uniform(0.0, longest)) for begin in random.uniform(0, 8, 3)),
    )
    watched = Watched(motors, tolerance, max_speed, max_lead)
    assert not programme(watched, random, 8.0), (watched.others.away, motors)


@settings(max_examples=20, deadline=None)
@given(limits=limits, max_lead=leads, rate=rates, late=st.floats(0.0, 0.3), seed=seeds)
def test_motors_that_follow_no_more_are_told_in_time(limits, max_lead, rate, late, seed):
    """Farther from their command than is tolerated they are for no longer, whatever commands do."""
    (tolerance, max_speed), random = limits, np.random.default_rng(seed)
    dies = random.uniform(0.5, 3.0)
    watched = Watched(
        Motors(late, rate=rate, sticks=((dies, np.inf),)), tolerance, max_speed, max_lead
    )
    programme(watched, random, 12.0)
    since, now = watched.far_since, watched.tick * PERIOD
    patience = max(SETTLING, RESTING / (FOLLOWING * max_speed))
    seen = 2.0 / rate + 2.0 * PERIOD  # that they moved last, and that they rest since
    assert since is None or now - max(since, dies) <= patience + seen

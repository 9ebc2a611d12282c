# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Everything that exists while the node is configured: one robot, where it is, where it goes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cpr_core import CprError, Loads, Robot
from cpr_core.model.assessment import Assessment

from ..closed_loop.jogging import Jogger
from ..closed_loop.loop_status import LoopStatus
from ..closed_loop.pose_loop import PoseLoop
from ..following.external_wrench import ExternalWrench
from ..following.felt_wrench import FeltWrench
from ..following.first_step import FirstStep
from ..following.goals import PoseGoal
from ..following.measured_motors import MeasuredMotors
from ..following.motor_commands import MotorCommands
from ..following.motor_tracking import MotorTracking
from ..following.moved_by_others import MovedByOthers
from ..following.outcome import Outcome
from ..following.setpoint_following import SetpointFollower
from ..following.supervision import BLIND, Refusal, State, Verdict, slowed_where_unseen
from ..following.trajectory_following import Trajectories
from ..following.watchdog import Watchdog
from ..messages.frames import Frames
from ..settings.node_settings import LiveParameters, Parameters
from .applied_solutions import check_applied
from .kept_state import KnownPlace
from .orders import Orders
from .outgoing import Outgoing
from .present import Present
from .senses import Senses
from .solver import Solver

__all__ = ["Session"]

Floats = NDArray[np.float64]


class Session:
    """A robot in operation: its parts, and the order of a tick. No rclpy here: times are given.

    Attributes:
        robot: The robot.
        period: Time of a tick [s].
        solver: Its current equilibrium and answers about it.
        follower: Setpoint following.
        trajectories: Timed trajectories, which it follows too.
        tracking: Tracking of measured motors; None if the node moves the motors itself.
        wrench: External wrench.
        felt: The wrench that measured motors tell of; it moves nothing.
        loop: Correction of platform setpoints by measured poses.
        jogger: Platform setpoint moved by twists.
        first_step: Judges ahead, at rest, what a motor setpoint may ask for.
        commands: Where the motors are sent, if the node moves them.
        measured: Measured motors of a robot that the node moves.
        moved_by_others: Whether measured motors are elsewhere than the node has sent them.
        outgoing: What leaves for the motors.
        present: What the robot does.
        orders: What it is asked to do.
        senses: What is to be measured of it, and is not.
        unplaced: Whether the first measured motors say where the robot is; until it moves.
    """

    def __init__(
        self, robot: Robot, frames: Frames, parameters: Parameters, live: LiveParameters
    ) -> None:
        """Start at home, idle.

        Raises:
            CprError: The robot has no motors, or the home of its description cannot be used.
        """
        _check_motors(robot)
        self.robot, self.period = robot, 1.0 / parameters.tick_rate
        self.commands = MotorCommands(robot, self.period, live.max_lead, live.moved_tolerance)
        self.measured = MeasuredMotors(live.measured_timeout)
        self.moved_by_others = MovedByOthers(robot, live.moved_tolerance)
        self.wrench = ExternalWrench(robot, live.wrench_timeout)
        self.felt = FeltWrench(robot, live.felt_wrench)
        self.loop = PoseLoop(robot, self.period, live.loop)
        self.jogger = Jogger(robot, self.period, self.loop, live.twist_timeout)
        self.follower = SetpointFollower(
            robot,
            self.period,
            live.settings,
            self.loop.corrected,
            lambda motors: self.outgoing.part_in_reach(motors),
        )
        self.trajectories = Trajectories(robot, self.follower, self.period, self.measured)
        self.first_step = FirstStep(robot, self.period, self.follower)
        self.tracking = (
            MotorTracking(robot, live.measured_timeout, self.follower)
            if parameters.motor_source == "measured"
            else None
        )
        self.solver = Solver(
            robot,
            frames,
            self.follower,
            time_limit=live.time_limit,
            characteristic_length=parameters.characteristic_length,
            check_applied=lambda found, deadline: check_applied(found, deadline, self.orders),
        )
        self.outgoing = Outgoing(
            solver=self.solver,
            follower=self.follower,
            tracking=self.tracking,
            commands=self.commands,
            measured=self.measured,
            moved_by_others=self.moved_by_others,
        )
        self.present = Present(self.solver.current, self.follower, self.outgoing)
        self.orders = Orders(
            solver=self.solver,
            present=self.present,
            follower=self.follower,
            trajectories=self.trajectories,
            jogger=self.jogger,
            loop=self.loop,
            outgoing=self.outgoing,
        )
        measured = self.measured if self.tracking is None else None
        self.senses = Senses(measured, self.wrench, self.loop_status, self.outgoing.lag)
        self.unplaced, self._told_stopped = False, ""

    @property
    def at_rest(self) -> bool:
        """Whether a tick would change nothing, until something comes: then none is needed.

        Whatever wants ticks says so here.
        """
        current, last = self.solver.current, self.present.outcome
        if last.moved or last.assessment is not current or last.state == State.ALIGNING:
            return False
        if self.outgoing.stopped != self._told_stopped:
            return False
        goal = self.follower.goal
        if self.orders.awaiting or not (
            self.trajectories.at_rest and self.loop.at_rest(goal) and self.jogger.at_rest(goal)
        ):
            return False
        if self.tracking is not None:
            return self.tracking.at_rest and not self.wrench.watchdog.expires
        return (
            self.follower.at_rest
            and self.wrench.at_rest(current.equilibrium.loads)
            and (self.follower.paused or self.outgoing.aligned)
        )

    def tick(
        self,
        now: float,
        send: Callable[[Floats, bool], None],
        keep: Callable[[], None] = lambda: None,
    ) -> Outcome:
        """Move on by one tick: what the motor command does not need comes after it.

        Args:
            now: Steady time [s].
            send: Called with a motor command, (n,) [rad or m], as soon as it is known, and whether
                where it leads is still to be solved.
            keep: Called when the tick is solved, before a command leaves that was not ahead: where the
                robot is may be remembered before anybody hears of it.
        """
        before, ahead = self.solver.current, self._command_ahead(now)
        if ahead is not None:
            self.unplaced = False
            send(ahead, True)
        self.orders.end_if_not_seen(now)
        self.orders.end_if_stopped()
        self.trajectories.before_tick(before, now)
        if self.jogger.drives(self.follower.goal):
            start = before.equilibrium
            self.jogger.advance(start, self.follower.arrived(start), now)
        self.loop.advance(now)
        loads = self._loads(before.equilibrium.loads, now)
        self._be_cautious(now)
        outcome = self._moved(before, loads, ahead is not None or self.outgoing.aligned, now)
        self.present.outcome, self.solver.current = outcome, outcome.assessment
        command = self.outgoing.next(outcome, now)
        keep()
        if command is not None:
            self.unplaced = False
            send(command, False)
        # The motors are on their way; nobody waits for the rest.
        after, goal = outcome.assessment.equilibrium, self.follower.goal
        arrived = outcome.state == State.IDLE or self.follower.arrived(after)
        self.loop.note(after, goal, outcome.state, arrived, now)
        if self.tracking is None:
            self.present.velocity = (after.motors - before.equilibrium.motors) / self.period
        else:
            self.present.velocity = self.tracking.velocity(self.period)
        self.trajectories.after_tick(outcome, now)
        return outcome

    def _command_ahead(self, now: float) -> Floats | None:
        """The motor command of this tick, (n,), if it is judged already; else None."""
        current = self.solver.current
        if not self.first_step.knows(current):
            return None
        self._be_cautious(now)
        aim, goal = self.follower.aim(current, now), self.follower.goal
        if aim is None or not self.loop.at_rest(goal) or self.jogger.drives(goal):
            return None  # the goal is another in this tick
        if not self.wrench.at_rest(current.equilibrium.loads):
            return None
        return self.outgoing.ahead(aim, self.present.outcome, now)

    def _loads(self, known: Loads, now: float) -> Loads:
        """Loads that act now. That a wrench is measured no more moves no motor.

        Those that hold a pose would go where they hold it without the wrench, and where it was not borne
        whatever it held back would set off, though it may well push on.
        """
        was_missing, unborne = self.wrench.missing, self.wrench.unborne(known)
        loads = self.wrench.loads(known, now)
        if self.tracking is None and self.wrench.missing and not was_missing:
            if unborne:
                self.orders.lose(self.wrench.missing)
            elif isinstance(self.follower.goal, PoseGoal):
                self.follower.lose(self.wrench.missing)
        return loads

    def _be_cautious(self, now: float) -> None:
        """What is not seen is moved slowly."""
        self.follower.pace.caution = (
            BLIND if self.follower.moving and self.senses.unseen(now) else 1.0
        )

    def _moved(self, before: Assessment, loads: Loads, aligned: bool, now: float) -> Outcome:
        """Where a tick leads, and what is told of it.

        Args:
            before: Where the robot is.
            loads: Loads that act now.
            aligned: Whether the motors have been sent there; else they go there first.
            now: Steady time [s].
        """
        if self.tracking is None and not aligned and not self.follower.paused:
            borne, burden = self.follower.borne_loads.at(before, loads, now)
            told, moved = self.follower.judge(borne, burden), borne is not before
            outcome = Outcome(borne, moved, State.ALIGNING, told, refusal=burden)
        else:
            mover = self.follower if self.tracking is None else self.tracking
            outcome = mover.tick(before, loads, now)
        self._told_stopped = self.outgoing.stopped
        if self._told_stopped and outcome.refusal is None:
            refusal = Refusal("stale", self._told_stopped)
            told = self.follower.judge(outcome.assessment, refusal)
            outcome = replace(outcome, verdict=told, refusal=refusal)
        return outcome

    def take_measured(self, motors: Floats, now: float, several: bool = True) -> bool:
        """Take measured motors of a robot that the node moves; whether it has to begin there.

        Where others have moved them, what was to lead elsewhere ends.

        Args:
            motors: (n,) [rad or m].
            now: Steady time [s].
            several: Whether there may be several who measure them.
        """
        self.measured.take(motors, now)
        if self.unplaced:
            return True
        begin = self.moved_by_others.take(
            motors,
            self.commands.newest,
            now,
            max_speed=self.follower.settings.max_speed,
            waited_for=self.outgoing.waits,
            several=several,
        )
        self.orders.end_if_stopped()
        return begin

    def stand(self) -> None:
        """Be at rest as the node becomes active: setpoint and what was measured are forgotten.

        Not that others have moved the motors: commands would begin where they are no more.
        """
        self.follower.drop()
        self.loop.forget_poses()
        self.measured.forget()
        self.moved_by_others.forget_places()
        self.wrench.forget_missing()
        self.senses.forget()
        if self.tracking is not None:
            self.tracking.forget()
        self.present.rest()

    @property
    def known_place(self) -> KnownPlace | None:
        """What is to be remembered of where the robot is; None: nothing is known."""
        equilibrium, state = self.solver.current.equilibrium, self.present.outcome.state
        if self.moved_by_others.away:
            return KnownPlace(equilibrium, None)
        if self.tracking is None:
            commands = self.commands.newest
            if commands is None:
                return None
            return KnownPlace(equilibrium, commands, self.measured.heard)
        if state not in (State.TRACKING, State.LOST):
            return None
        motors = equilibrium.motors if state == State.TRACKING else None
        return KnownPlace(equilibrium, motors, measured=True)

    def verdict(self, now: float) -> Verdict:
        """What is told of the last tick; of a robot that may be elsewhere, at least to be slow."""
        elsewhere = self.outgoing.held_on_the_way or self.senses.unseen(now)
        return slowed_where_unseen(self.present.outcome.verdict, elsewhere)

    def loop_status(self, now: float) -> LoopStatus:
        """Whether the measured pose corrects the setpoint."""
        return self.loop.status(self.follower.goal, now)

    @property
    def input_watchdog(self) -> Watchdog:
        """Age of the newest setpoint, or of the measured motors."""
        return self.follower.watchdog if self.tracking is None else self.tracking.watchdog


def _check_motors(robot: Robot) -> None:
    """Whether there are any to move or track.

    Raises:
        CprError: There are none.
    """
    if not robot.motor_count:
        source = robot.description.source
        raise CprError(f"{source}: expected a robot with motors, there are none to move or track")

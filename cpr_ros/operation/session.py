# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Everything that exists while the node is configured: one robot, where it is, where it goes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from cpr_msgs.msg import ErrorCode
from numpy.typing import NDArray

from cpr_core import Equilibrium, Loads, Robot, solve_home
from cpr_core.model.assessment import Assessment

from ..closed_loop.jogging import Jogger, PlatformTwist
from ..closed_loop.pose_loop import Loop, LoopStatus, PoseLoop
from ..error_codes import RequestError
from ..following.external_wrench import ExternalWrench
from ..following.felt_wrench import FeltWrench
from ..following.first_step import FirstStep
from ..following.goals import MotorGoal, PoseGoal
from ..following.measured_motors import MeasuredMotors
from ..following.motor_commands import MotorCommands
from ..following.motor_tracking import MotorTracking
from ..following.moved_by_others import MovedByOthers
from ..following.outcome import Outcome
from ..following.setpoint_following import SetpointFollower
from ..following.supervision import BLIND, Refusal, State, Verdict, seen
from ..following.trajectory_following import Ending, Motion, Trajectories
from ..following.trajectory_order import TrajectoryOrder
from ..following.watchdog import Watchdog
from ..messages.conversions import Frames
from ..settings.node_settings import LiveParameters, Parameters
from .admission import Admission
from .senses import Senses
from .solver import Solver

__all__ = ["Session"]


class Session:
    """A robot in operation. No rclpy here: times are given.

    Attributes:
        robot: The robot.
        solver: Its current equilibrium and answers about it.
        follower: Setpoint following.
        trajectories: Timed trajectories, which it follows too.
        tracking: Tracking of measured motors; None if the node moves the motors itself.
        wrench: External wrench.
        felt: The wrench that measured motors tell of; it moves nothing.
        loop: Correction of platform setpoints by measured poses.
        jogger: Platform setpoint moved by twists.
        commands: Where the motors are sent, if the node moves them.
        first_step: Judges ahead, at rest, what a motor setpoint may ask for.
        outcome: Of the last tick.
        velocity: Of the motors in the last tick, or between the last measurements, (n,) [rad/s, m/s].
        unplaced: Whether the first measured motors say where the robot is; until it moves.
        measured: Measured motors of a robot that the node moves.
        others: Whether measured motors are elsewhere than the node has sent them.
        left_behind: Why the last goal was forgotten, if its motors did not follow or others moved them.
        senses: What is to be measured of the robot, and is not.
        admission: What is taken now.
    """

    def __init__(
        self, robot: Robot, frames: Frames, parameters: Parameters, live: LiveParameters
    ) -> None:
        """Start at home, idle.

        Raises:
            CprError: The home of the description cannot be used.
        """
        self.robot, self.period = robot, 1.0 / parameters.tick_rate
        self.measured = MeasuredMotors(live.measured_timeout)
        self.commands = MotorCommands(robot, self.period, live.max_lead)
        self.loop = PoseLoop(robot, self.period, live.loop)
        self.follower = SetpointFollower(
            robot, self.period, live.settings, self.loop.corrected, self._part_in_reach
        )
        self.trajectories = Trajectories(robot, self.follower, self.period, self.measured)
        self.solver = Solver(
            robot,
            frames,
            self.follower,
            live.time_limit,
            parameters.characteristic_length,
            lambda solution, deadline: self.admission.check_applied(solution, deadline),
        )
        self.tracking = (
            MotorTracking(robot, live.measured_timeout, self.follower)
            if parameters.motor_source == "measured"
            else None
        )
        self.wrench = ExternalWrench(robot, live.wrench_timeout)
        self.felt = FeltWrench(robot, live.felt_wrench)
        self.jogger = Jogger(robot, self.period, self.loop, live.twist_timeout)
        self.first_step = FirstStep(robot, self.period, self.follower)
        self._commanded_ahead = False
        self._before = home = self.solver.current
        self.outcome = Outcome(home, False, State.IDLE, self.follower.judge(home))
        self.velocity: NDArray[np.float64] = np.zeros(robot.motor_count)
        self.unplaced = False
        self.others = MovedByOthers(robot, live.moved_tolerance)
        self._told_away = self.left_behind = ""
        measured = self.measured if self.tracking is None else None
        self.senses = Senses(measured, self.wrench, lambda now: self.loop_status(now), self._lag)
        self.admission = Admission(
            self.solver,
            self.follower,
            self.trajectories,
            self.tracking,
            self.commands,
            self.others,
        )

    def apply(self, live: LiveParameters, now: float) -> bool:
        """Take new live parameters; they start no motion.

        A robot that is held back forgets where it was sent, else it would set off where a threshold or
        a timeout lets it; a frozen correction and an old twist are of the kind. So does one at its goal
        if a wrench is given another time: motors hold a pose against the wrench.

        Returns:
            Whether a setpoint was forgotten.
        """
        follower, current = self.follower, self.solver.current.equilibrium
        held_back = (
            self.outcome.state in (State.HALTED, State.STALE) or follower.stale(now) or self._waits
        )
        other_wrench = live.wrench_timeout != self.wrench.watchdog.timeout
        other_loop = live.loop != self.loop.settings
        other_jog = live.twist_timeout != self.jogger.watchdog.timeout
        forgotten = follower.goal is not None and (
            held_back
            or (other_wrench and follower.arrived(current))
            or (
                other_loop
                and self.loop_status(now).loop == Loop.FROZEN
                and follower.arrived(current)
            )
            or (other_jog and self.jogger.drives(follower.goal))
            or self.loop.beyond(live.loop)
        )
        if forgotten:
            reason = "parameters changed: the setpoint is forgotten"
            self.trajectories.stop(ErrorCode.PREEMPTED, reason)
            self.follower.drop(reason)
        self.follower.settings = live.settings
        self.solver.time_limit = live.time_limit
        self.wrench.watchdog.timeout = live.wrench_timeout
        if other_wrench and self.outcome.state == State.ALIGNING and self.outcome.refusal:
            self.pause(True)  # commands that the wrench holds back would go out without it
            forgotten = True
        if self.loop.beyond(live.loop):
            self.loop.forget()  # the robot holds where that has led it
        self.loop.settings = live.loop
        self.jogger.watchdog.timeout = live.twist_timeout
        self.felt.settings = live.felt_wrench
        held, self.others.tolerance = self.others.in_question, live.moved_tolerance
        if held and not self.others.in_question:
            self.commands.said = False  # else saying it again would move the motors
            self.hold_commands()
        if self._waits and not forgotten:
            self.hold_commands()  # on their way to where the robot was put
        self.measured.watchdog.timeout = live.measured_timeout
        self.commands.max_lead = live.max_lead
        if self.tracking is not None:
            self.tracking.watchdog.timeout = live.measured_timeout
            self.tracking.at_rest = False
        return forgotten

    @property
    def input_watchdog(self) -> Watchdog:
        """Age of the newest setpoint, or of the measured motors."""
        return self.follower.watchdog if self.tracking is None else self.tracking.watchdog

    @property
    def at_rest(self) -> bool:
        """Whether a tick would change nothing, until something comes: then none is needed.

        Whatever wants ticks says so here.
        """
        current, last = self.solver.current, self.outcome
        if last.moved or last.assessment is not current or last.state == State.ALIGNING:
            return False
        if self.others.away != self._told_away:
            return False
        goal = self.follower.goal
        if self.admission.awaiting or not (
            self.trajectories.at_rest and self.loop.at_rest(goal) and self.jogger.at_rest(goal)
        ):
            return False
        if self.tracking is not None:
            return self.tracking.at_rest and not self.wrench.watchdog.expires
        return (
            self.follower.at_rest
            and self.wrench.at_rest(current.equilibrium.loads)
            and (self.follower.paused or self.admission.aligned)
        )

    def tick(self, now: float) -> Outcome:
        """Move on by one tick, and take note of it; who sends commands does so in between."""
        outcome = self.move(now)
        self.take_note(now)
        return outcome

    def move(self, now: float) -> Outcome:
        """The first half of a tick, all that its motor command needs."""
        self._before = before = self.solver.current
        self._end_what_is_not_seen(now)
        self.trajectories.before_tick(before, now)
        if self.jogger.drives(self.follower.goal):
            start = before.equilibrium
            self.jogger.advance(start, self.follower.arrived(start), now)
        self.loop.advance(now)
        loads = self._loads(before.equilibrium.loads, now)
        self._be_cautious(now)
        aligned, self._commanded_ahead = self._commanded_ahead or self.admission.aligned, False
        if self.tracking is None and not aligned and not self.follower.paused:
            borne, burden = self.follower.borne_loads.at(before, loads, now)
            told = self.follower.judge(borne, burden)
            moved = borne is not before
            self.outcome = Outcome(borne, moved, State.ALIGNING, told, refusal=burden)
        else:
            mover = self.follower if self.tracking is None else self.tracking
            self.outcome = mover.tick(before, loads, now)
        self._told_away = self.others.away
        if self._told_away and self.outcome.refusal is None:
            refusal = Refusal("stale", self._told_away)
            told = self.follower.judge(self.outcome.assessment, refusal)
            self.outcome = replace(self.outcome, verdict=told, refusal=refusal)
        self.solver.current = self.outcome.assessment
        return self.outcome

    def _loads(self, known: Loads, now: float) -> Loads:
        """Loads that act now. Motors that hold a pose do not follow a wrench that is too old."""
        was_missing = self.wrench.missing
        loads = self.wrench.loads(known, now)
        if self.wrench.missing and not was_missing and isinstance(self.follower.goal, PoseGoal):
            self.follower.drop(self.wrench.missing)
        return loads

    def _be_cautious(self, now: float) -> None:
        """What is not seen is moved slowly."""
        self.follower.caution = BLIND if self.follower.moving and self.senses.unseen(now) else 1.0

    def _part_in_reach(self, motors: NDArray[np.float64], now: float) -> float:
        """Part of the way to motors, (n,), that commands may go: measured ones may be too far behind."""
        max_speed = self.follower.settings.max_speed
        return self.commands.part_in_reach(motors, max_speed, self.measured.newest_motors(now))

    @property
    def _waits(self) -> bool:
        """Whether commands wait for measured motors that are too far behind."""
        return self.follower.waits or (self.commands.waits and not self.admission.aligned)

    def _lag(self) -> str:
        """That commands wait for motors that are too far behind, in words; empty if they do not."""
        if not self._waits:
            return ""
        return (
            f"the commands wait for a motor: it was measured as far behind as max_lead "
            f"{self.commands.max_lead:g} s allows"
        )

    def told(self, now: float) -> Verdict:
        """What is told of the last tick; of a robot that is not seen, at least to be slow."""
        return seen(self.outcome.verdict, self.senses.unseen(now))

    def take_note(self, now: float) -> None:
        """The second half of a tick: what follows from where the robot is now, at the time of `move`."""
        after, state = self.outcome.assessment.equilibrium, self.outcome.state
        arrived = state == State.IDLE or self.follower.arrived(after)
        self.loop.note(after, self.follower.goal, state, arrived, now)
        if self.tracking is None:
            self.velocity = (after.motors - self._before.equilibrium.motors) / self.period
        else:
            self.velocity = self.tracking.velocity(self.period)
        self.trajectories.after_tick(self.outcome, now)

    def look_around(self, now: float, resting: bool) -> None:
        """Settle doubts; at rest, judge what may be asked for next, a bit at a time."""
        self.others.look(now)
        if self.others.away:
            self._end_what_others_ended()
        if resting and self.tracking is None and not self.follower.paused:
            self.first_step.look(self.solver.current, now)
        else:
            self.first_step.wait()

    def command_ahead(self, now: float) -> NDArray[np.float64] | None:
        """The motor command of this tick, (n,) [rad or m], if it is judged already; else None.

        It goes out before `move` solves where it leads. Should that be refused after all, the next
        commands lead back, as they do wherever the motors are not where the node has the robot.
        """
        current = self.solver.current
        if not self.first_step.knows(current):
            return None
        self._be_cautious(now)
        aim = self.first_step.aim(current, now)
        if aim is None or self._commands_held or not self.admission.aligned:
            return None
        goal = self.follower.goal
        if not self.loop.at_rest(goal) or self.jogger.drives(goal):
            return None  # the goal is another in this tick
        if self.commands.newest is None or not self.wrench.at_rest(current.equilibrium.loads):
            return None
        if self._part_in_reach(aim, now) < 1.0:
            return None
        self._commanded_ahead = True
        return self._command(aim, now)

    def next_command(self, now: float) -> NDArray[np.float64] | None:
        """The motor command of this tick, (n,) [rad or m]; None where there is nothing new.

        New commands leave the node here and by `command_ahead` only: none is farther from the one before
        than a tick's way, nor farther from the measured motors than they may be behind.
        Where nothing is known of the motors, there is none before a setpoint is obeyed; one that asks
        for what the node believes anyway is told to the motors too, which may be elsewhere.
        """
        known = self.commands.newest is not None
        nothing_new = self.admission.aligned if known else not self.outcome.obeyed
        if nothing_new or self._commands_held:
            return None
        return self._command(self.solver.current.equilibrium.motors, now)

    @property
    def _commands_held(self) -> bool:
        """Whether no new command may leave the node, wherever the robot is to go."""
        held_back = self.follower.paused or self.outcome.refusal is not None
        return self.tracking is not None or held_back or bool(self.others.in_question)

    def _command(self, motors: NDArray[np.float64], now: float) -> NDArray[np.float64] | None:
        self.unplaced = False
        max_speed = self.follower.settings.max_speed
        command = self.commands.step_to(motors, max_speed, self.measured.newest_motors(now))
        if command is not None:
            self.others.commanded(now, command)
        return command

    @property
    def known_place(self) -> tuple[Equilibrium, NDArray[np.float64] | None] | None:
        """What is to be remembered: an equilibrium, and where its motors were sent or measured, (n,).

        No motors: they are measured, but not where it is. None: nothing is known.
        """
        equilibrium, state = self.solver.current.equilibrium, self.outcome.state
        if self.others.away:
            return equilibrium, None
        if self.tracking is None:
            commands = self.commands.newest
            return None if commands is None else (equilibrium, commands)
        if state not in (State.TRACKING, State.LOST):
            return None
        return equilibrium, equilibrium.motors if state == State.TRACKING else None

    def repeated_command(self, now: float) -> NDArray[np.float64] | None:
        """The last motor command once more, (n,), for a controller that came later; None: there is none.

        Motors that others have moved are not sent back, nor such that are farther off than new commands
        may be ahead of them.
        """
        silent = self.tracking is not None or self.others.in_question or not self.commands.said
        max_speed = self.follower.settings.max_speed
        if silent or not self.commands.in_reach(self.measured.newest_motors(now), max_speed):
            return None
        return self.commands.newest

    def take_measured(self, motors: NDArray[np.float64], now: float, several: bool = True) -> bool:
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
        begin = self.others.take(
            motors,
            self.commands.newest,
            now,
            max_speed=self.follower.settings.max_speed,
            waited_for=self._waits,
            several=several,
        )
        if self.others.away:
            self._end_what_others_ended()
        return begin

    def _end_what_others_ended(self) -> None:
        """Forget where the robot was to go: others have moved it."""
        self.trajectories.stop(ErrorCode.CONTROL_FAILED, self.others.away)
        if self.follower.goal is not None:
            self.left_behind = self.others.away
            self.follower.drop(self.left_behind)

    def _end_what_is_not_seen(self, now: float) -> None:
        """Forget where the robot was to go, if commands wait for motors that are measured no more."""
        missing = self.measured.missing(now, with_age=False) or self.measured.silent(now)
        if not self._waits or not missing:
            return
        self.left_behind = f"{self._lag()}, and {missing}"
        self.trajectories.stop(ErrorCode.CONTROL_FAILED, self.left_behind)
        self.drop(self.left_behind)

    def begin_at(
        self, equilibrium: Equilibrium, motors: NDArray[np.float64] | None, solve_time: float
    ) -> None:
        """Be at an equilibrium, at rest: what was to lead elsewhere, or is thought reached, ends.

        Args:
            equilibrium: Where the robot is.
            motors: Where its motors are known to be, (n,); None: unknown, commands begin there.
            solve_time: Time it took to find it [s].
        """
        reason = "the robot was found to be elsewhere"
        self.trajectories.stop(ErrorCode.PREEMPTED, reason)
        if self.follower.goal is not None:
            self.follower.drop(reason)
        length = self.solver.current.characteristic_length
        self.solver.current = Assessment(equilibrium, length, solve_time=solve_time)
        self.commands.place(motors, said=not self.others.away)
        self.others.begin()
        current = self.solver.current
        self.outcome = Outcome(current, False, self._state_at_rest, self.follower.judge(current))

    def stand(self) -> None:
        """Be at rest as the node becomes active: setpoint and what was measured are forgotten.

        Not that others have moved the motors: commands would begin where they are no more.
        """
        self.follower.drop()
        self.loop.forget_poses()
        self.measured.forget()
        self.others.forget_places()
        self.wrench.forget_missing()
        self.senses.forget()
        if self.tracking is not None:
            self.tracking.forget()
        self._be(self._state_at_rest)

    def follow(self, goal: MotorGoal | PoseGoal, now: float, *, ages: bool = True) -> None:
        """Take a setpoint; arguments as in :meth:`SetpointFollower.follow`.

        Raises:
            RequestError: The node takes none now, or its numbers look like another unit.
        """
        self.admission.check_free()
        self.admission.check_meant(goal)
        self.follower.follow(goal, now, ages=ages)

    def follow_trajectory(
        self, order: TrajectoryOrder, now: float, told: Callable[[Ending], None]
    ) -> Motion | None:
        """Take a timed trajectory; one without points is always a stop, and there is none then.

        Args:
            order: The trajectory.
            now: Steady time [s].
            told: Called with its end, once, perhaps before this returns; must not raise.

        Raises:
            RequestError: The node takes none now, or it cannot be followed.
        """
        if not len(order.times):
            self._hold()
            told(Ending(ErrorCode.SUCCESS))
            return None
        self.admission.check_free()
        if not self.admission.aligned:
            raise RequestError(
                ErrorCode.NOT_READY, "the motor commands are on their way to where the robot is"
            )
        return self.trajectories.take(order, self.solver.current, now, told)

    @property
    def _state_at_rest(self) -> State:
        """What the node does without a setpoint."""
        if self.follower.paused:
            return State.PAUSED
        return State.IDLE if self.admission.aligned else State.ALIGNING

    def _hold(self) -> None:
        """End every motion.

        Raises:
            RequestError: The node moves nothing.
        """
        self.admission.check_moving()
        reason = "an empty trajectory came: hold"
        self.trajectories.stop(ErrorCode.PREEMPTED, reason)
        self.drop(reason)

    def drop(self, reason: str = "") -> None:
        """Forget the setpoint and hold; the reason is for who sent it."""
        self.follower.drop(reason)
        self.hold_commands()  # nothing else does

    def hold_commands(self) -> bool:
        """Pause where commands are on their way to where the node has the robot; whether they were."""
        if self.admission.aligned:
            return False
        self.pause(True)
        return True

    def jog(self, twist: PlatformTwist, now: float) -> None:
        """Take a twist: it moves the platform setpoint from where the robot is.

        A twist of zero does not end what others do.

        Raises:
            RequestError: The node takes none now.
        """
        if not self.jogger.drives(self.follower.goal):
            if twist.rests:
                return
            self.follow(self.jogger.begin(self.solver.current.equilibrium, now), now)
        self.follower.watchdog.feed(now)
        self.jogger.take(twist, now)

    def loop_status(self, now: float) -> LoopStatus:
        """Whether the measured pose corrects the setpoint."""
        return self.loop.status(self.follower.goal, now)

    def pause(self, paused: bool) -> str:
        """Pause or release; says what was done.

        Raises:
            RequestError: There is nothing to pause.
        """
        if self.tracking is not None:
            raise RequestError(
                ErrorCode.NOT_READY, "the node tracks measured motors, it moves none"
            )
        self.follower.pause(paused)
        if paused:
            self.commands.waits = False  # they are held, for nobody
            self._be(State.PAUSED)
        elif self.outcome.state == State.PAUSED:
            self._be(self._state_at_rest)
        return "paused, the setpoint is forgotten" if paused else "waiting for a setpoint"

    def reset(self) -> str:
        """Go home; says what was done.

        Raises:
            RequestError: The node is paused.
        """
        if self.tracking is not None:
            length = self.solver.current.characteristic_length
            self.solver.current = Assessment(solve_home(self.robot), length)
            return "tracking from home again"
        if self.follower.paused:
            raise RequestError(ErrorCode.NOT_READY, "the node is paused: release it first")
        self.admission.check_where_commanded()
        self.follower.reset()
        self.loop.forget()
        self._be(State.RETURNING)
        return "walking home along the branch; the stability stream says when it is there"

    def _be(self, state: State) -> None:
        """Be in a state before the next tick: who has the answer believes the stream from then on."""
        self.outcome = replace(self.outcome, state=state)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Everything that exists while the node is configured: one robot, where it is, where it goes."""

from __future__ import annotations

import numpy as np
from cpr_msgs.msg import ErrorCode
from numpy.typing import NDArray

from cpr_core import Equilibrium, Robot, solve_home

from .assessment import Assessment
from .conversions import Frames
from .error_codes import RequestError
from .external_wrench import ExternalWrench
from .goals import Goal
from .motor_commands import MotorCommands
from .motor_tracking import MotorTracker
from .parameters import LiveParameters, Parameters
from .setpoint_following import ARRIVED, Outcome, SetpointFollower
from .solver import Solver
from .supervision import State
from .watchdog import Watchdog

__all__ = ["Session"]


class Session:
    """A robot in operation. No rclpy here: times are given.

    Attributes:
        robot: The robot.
        solver: Its current equilibrium and answers about it.
        follower: Setpoint following.
        tracker: Tracking of measured motors; None if the node moves the motors itself.
        wrench: External wrench.
        commands: Where the motors are sent, if the node moves them.
        outcome: Of the last tick.
        velocity: Of the motors in the last tick, (n,) [rad/s or m/s].
    """

    def __init__(
        self, robot: Robot, frames: Frames, parameters: Parameters, live: LiveParameters
    ) -> None:
        """Start at home, idle.

        Raises:
            CprError: The home of the description cannot be used.
        """
        self.robot, self.period = robot, 1.0 / parameters.tick_rate
        self.follower = SetpointFollower(robot, self.period, live.settings)
        self.solver = Solver(
            robot, frames, self.follower, live.time_limit, parameters.characteristic_length
        )
        self.tracker = (
            MotorTracker(robot, live.measured_timeout, self.follower)
            if parameters.motor_source == "measured"
            else None
        )
        self.wrench = ExternalWrench(robot, live.wrench_timeout)
        self.commands = MotorCommands(robot, self.period)
        home = self.solver.current
        self.outcome = Outcome(home, False, State.IDLE, self.follower.judge(home))
        self.velocity: NDArray[np.float64] = np.zeros(robot.motor_count)

    def apply(self, live: LiveParameters, now: float) -> bool:
        """Take new live parameters; they start no motion.

        A robot that is held back forgets where it was sent, else it would set off where a threshold or
        a timeout lets it. So does one at its goal if a wrench is given another time: motors hold a pose
        against the wrench.

        Returns:
            Whether a setpoint was forgotten.
        """
        goal = self.follower.goal
        held_back = self.outcome.state in (State.HALTED, State.STALE)
        other_wrench = live.wrench_timeout != self.wrench.watchdog.timeout
        forgotten = goal is not None and (
            held_back
            or self.follower.watchdog.stale(now)
            or (other_wrench and goal.remaining(self.solver.current.equilibrium) <= ARRIVED)
        )
        if forgotten:
            self.follower.drop()
        self.follower.settings = live.settings
        self.solver.time_limit = live.time_limit
        self.wrench.watchdog.timeout = live.wrench_timeout
        if self.tracker is not None:
            self.tracker.watchdog.timeout = live.measured_timeout
        return forgotten

    @property
    def input_watchdog(self) -> Watchdog:
        """Age of the newest setpoint, or of the measured motors."""
        return self.follower.watchdog if self.tracker is None else self.tracker.watchdog

    def tick(self, now: float) -> Outcome:
        """Move on by one tick."""
        before = self.solver.current
        if self.tracker is None and not self.commands.there(before.equilibrium.motors):
            told = self.follower.judge(before)
            self.outcome = Outcome(before, False, State.ALIGNING, told)
        else:
            loads = self.wrench.loads(before.equilibrium.loads, now)
            mover = self.follower if self.tracker is None else self.tracker
            self.outcome = mover.tick(before, loads, now)
        self.solver.current = self.outcome.assessment
        moved = self.outcome.assessment.equilibrium.motors - before.equilibrium.motors
        self.velocity = moved / self.period
        return self.outcome

    def next_command(self) -> NDArray[np.float64] | None:
        """The motor command of this tick, (n,) [rad or m]; None where there is nothing new.

        The only way commands leave the node: none is farther from the one before than a tick's way.
        Where nothing is known of the motors, there is none before the first motion.
        """
        motors = self.solver.current.equilibrium.motors
        begun = self.commands.newest is not None or self.outcome.moved
        if self.tracker is not None or not begun:
            return None
        if self.commands.newest is not None and self.commands.there(motors):
            return None
        return self.commands.step_to(motors, self.follower.settings.max_speed)

    def begin_at(
        self, equilibrium: Equilibrium, motors: NDArray[np.float64] | None, solve_time: float
    ) -> None:
        """Be at an equilibrium, at rest.

        Args:
            equilibrium: Where the robot is.
            motors: Where its motors are known to be, (n,); None: unknown, commands begin there.
            solve_time: Time it took to find it [s].
        """
        length = self.solver.current.characteristic_length
        self.solver.current = Assessment(equilibrium, length, solve_time=solve_time)
        self.commands.place(motors)
        current = self.solver.current
        self.outcome = Outcome(current, False, State.IDLE, self.follower.judge(current))

    def follow(self, goal: Goal, now: float) -> None:
        """Take a setpoint.

        Raises:
            RequestError: The node takes none now.
        """
        if self.tracker is not None:
            raise RequestError(
                ErrorCode.NOT_READY, "the node tracks measured motors and takes no setpoints"
            )
        if self.follower.paused:
            raise RequestError(ErrorCode.NOT_READY, "the node is paused")
        if self.follower.returning:
            raise RequestError(ErrorCode.NOT_READY, "the node is on its way home")
        self.follower.follow(goal, now)

    def pause(self, paused: bool) -> str:
        """Pause or release; says what was done.

        Raises:
            RequestError: There is nothing to pause.
        """
        if self.tracker is not None:
            raise RequestError(
                ErrorCode.NOT_READY, "the node tracks measured motors, it moves none"
            )
        self.follower.pause(paused)
        return "paused, the setpoint is forgotten" if paused else "waiting for a setpoint"

    def reset(self) -> str:
        """Go home; says what was done.

        Raises:
            RequestError: The node is paused.
        """
        if self.tracker is not None:
            length = self.solver.current.characteristic_length
            self.solver.current = Assessment(solve_home(self.robot), length)
            return "tracking from home again"
        if self.follower.paused:
            raise RequestError(ErrorCode.NOT_READY, "the node is paused: release it first")
        self.follower.reset()
        return "walking home along the branch; the stability stream says when it is there"

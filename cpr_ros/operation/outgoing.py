# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Which motor commands leave the node: one ahead of its solution, the next, the last again, or none.

None is farther from the one before than a tick's way, nor farther from the measured motors than they may
be behind. No rclpy here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpr_core.errors import distinct

from ..following.measured_motors import MeasuredMotors
from ..following.motor_commands import MotorCommands
from ..following.motor_tracking import MotorTracking
from ..following.moved_by_others import MovedByOthers
from ..following.outcome import Outcome
from ..following.setpoint_following import SetpointFollower
from .solver import Solver

__all__ = ["Outgoing"]

Floats = NDArray[np.float64]


@dataclass
class Outgoing:
    """What leaves for the motors, by where the robot is, where they are measured and who has moved them.

    Attributes:
        solver: Where the robot is believed to be.
        follower: Setpoint following.
        tracking: Tracking of measured motors; None: the node moves the motors.
        commands: Where the motors are sent.
        measured: Where they are measured.
        moved_by_others: Whether others have moved them.
        unkept: That the next start would begin elsewhere, in words; empty if it would not.
    """

    solver: Solver
    follower: SetpointFollower
    tracking: MotorTracking | None
    commands: MotorCommands
    measured: MeasuredMotors
    moved_by_others: MovedByOthers
    unkept: str = ""

    @property
    def stopped(self) -> str:
        """Why what leads anywhere has to end, in words; empty: nothing is against it."""
        return self.moved_by_others.away or self.unkept

    @property
    def in_question(self) -> str:
        """The same, or that it may have to; empty: commands may go out."""
        return self.moved_by_others.in_question or self.unkept

    @property
    def aligned(self) -> bool:
        """Whether the motors have been sent where the node has the robot."""
        return self.commands.aligned_with(self.solver.current.equilibrium.motors)

    @property
    def on_the_way(self) -> str:
        """From where to where commands are on their way, in words; empty: they are where it is."""
        last = self.commands.newest
        if self.tracking is not None or last is None or self.aligned:
            return ""
        targets = self.solver.current.equilibrium.motors
        ways = []
        for motor, sent, target in zip(
            self.solver.robot.description.motors, last.tolist(), targets.tolist(), strict=True
        ):
            if sent != target:
                begin, end = distinct(sent, target)
                ways.append(f"{motor.name} from {begin} to {end} {motor.unit}")
        return ", ".join(ways)

    @property
    def held_on_the_way(self) -> str:
        """That a pause holds commands on their way, in words; empty: it does not."""
        way = self.on_the_way if self.follower.paused else ""
        if not way:
            return ""
        return (
            f"the motors are not where the node has the robot: commands are held on their way, {way}; "
            "~/pause false lets them go on"
        )

    @property
    def waits(self) -> bool:
        """Whether commands wait for measured motors that are too far behind."""
        return self.follower.pace.waits or (self.commands.waits and not self.aligned)

    def lag(self) -> str:
        """That commands wait for motors that are too far behind, in words; empty if they do not."""
        if not self.waits:
            return ""
        if self.commands.beside:
            return (
                f"the commands wait for {self.commands.beside}: it was measured beside its way, farther "
                f"from its command than max_lead {self.commands.max_lead:g} s and moved_tolerance "
                f"{self.commands.tolerance:g} allow"
            )
        return (
            f"the commands wait for a motor: it was measured as far behind as max_lead "
            f"{self.commands.max_lead:g} s allows"
        )

    def part_in_reach(self, motors: Floats) -> float:
        """Part of the way to motors, (n,), that commands may go: measured ones may be too far behind."""
        max_speed = self.follower.settings.max_speed
        return self.commands.part_in_reach(motors, max_speed, self.measured.last_motors)

    def ahead(self, aim: Floats, last: Outcome, now: float) -> Floats | None:
        """The motor command of a tick, (n,) [rad or m], before the tick is solved; None: not before.

        Should where it leads be refused after all, the next commands lead back, as they do wherever the
        motors are not where the node has the robot.

        Args:
            aim: Where the tick takes the motors, (n,), which is judged already.
            last: Of the tick before.
            now: Steady time [s].
        """
        if self.commands.newest is None or self._held(last) or not self.aligned:
            return None
        return self._step_to(aim, now) if self.part_in_reach(aim) >= 1.0 else None

    def next(self, outcome: Outcome, now: float) -> Floats | None:
        """The motor command of a tick, (n,) [rad or m]; None where there is nothing new.

        Where nothing is known of the motors, there is none before a setpoint is obeyed; one that asks
        for what the node believes anyway is told to the motors too, which may be elsewhere.

        Args:
            outcome: Of the tick.
            now: Steady time [s].
        """
        known = self.commands.newest is not None
        nothing_new = self.aligned if known else not outcome.obeyed
        if nothing_new or self._held(outcome):
            return None
        return self._step_to(self.solver.current.equilibrium.motors, now)

    def repeated(self) -> Floats | None:
        """The last motor command once more, (n,), for a controller that came later; None: there is none.

        Motors that others have moved are not sent back, nor such that are farther off than new commands
        may be ahead of them.
        """
        silent = (
            self.tracking is not None
            or self.moved_by_others.in_question
            or not self.commands.repeatable
        )
        max_speed = self.follower.settings.max_speed
        if silent or not self.commands.in_reach(self.measured.last_motors, max_speed):
            return None
        return self.commands.newest

    def _held(self, outcome: Outcome) -> bool:
        """Whether no new command may leave the node, wherever the robot is to go."""
        held_back = self.follower.paused or outcome.refusal is not None
        return self.tracking is not None or held_back or bool(self.in_question)

    def _step_to(self, motors: Floats, now: float) -> Floats | None:
        max_speed = self.follower.settings.max_speed
        command = self.commands.step_to(motors, max_speed, self.measured.last_motors)
        if command is not None:
            self.moved_by_others.commanded(now, command)
        return command

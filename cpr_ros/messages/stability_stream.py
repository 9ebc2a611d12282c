# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The stability message a supervisory controller acts on."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator
from typing import NamedTuple

from cpr_msgs.msg import Singularity as SingularityMessage
from cpr_msgs.msg import StabilityMetrics
from std_msgs.msg import Header

from cpr_core.model.assessment import Assessment, Thresholds

from ..closed_loop.loop_status import LoopStatus
from ..following.outcome import Outcome
from ..following.supervision import Verdict, slowed_where_unseen
from ..middleware.repeated_message import RepeatedMessage, Stamp
from .analysis import singularity_message, stiffness_message
from .frames import Frames
from .model_error import estimated_error, warned_error

__all__ = ["Moment", "StabilityStream"]

_OPEN = LoopStatus()
#: What changes while the robot rests.
_AGES = ("margin_trend", "setpoint_age", "wrench_age", "measured_pose_age")


class Moment(NamedTuple):
    """When the robot was looked at.

    Attributes:
        outcome: Of the last tick.
        now: Steady time [s].
        stamp: ROS time.
    """

    outcome: Outcome
    now: float
    stamp: Stamp


class _Made(NamedTuple):
    """The last message, and what it was made of: it is said again as long as that is the same.

    Attributes:
        outcome: Of the tick.
        thresholds: That were in force.
        loop: Correction by the measured pose, its age left out.
        unseen: What was not measured, in words.
        message: All of it.
    """

    outcome: Outcome
    thresholds: Thresholds
    loop: LoopStatus
    unseen: str
    message: RepeatedMessage


class StabilityStream:
    """Makes the messages of the stream; remembers the last one for the trend."""

    def __init__(self) -> None:
        """Start without a trend."""
        self._last: tuple[float, float] | None = None  # margin, and steady time [s]
        self._made: _Made | None = None

    def measure(self, look: Callable[[], Moment]) -> Generator[None, None, Moment]:
        """Find what a message takes time for, in pieces; all of it is kept.

        Args:
            look: At the robot now.

        Returns:
            What the message is about: the tick in which this began; of a robot that has come to rest
            elsewhere meanwhile, where it is now.
        """
        told = look()
        yield from self._pieces(told.outcome.assessment)
        newest = look()
        if newest.outcome.assessment is not told.outcome.assessment and not newest.outcome.moved:
            told = newest
            yield from self._pieces(told.outcome.assessment)
            newest = look()
        return newest if newest.outcome.assessment is told.outcome.assessment else told

    def _pieces(self, assessment: Assessment) -> Iterator[None]:
        if self._made is not None and self._made.outcome.assessment is assessment:
            return
        equilibrium = assessment.equilibrium
        for find in (
            lambda: equilibrium.spectrum_locked.eigenvalues,
            lambda: equilibrium.spectrum_free.eigenvalues,
            lambda: assessment.kinemato_statics.matrices(assessment.characteristic_length),
            lambda: assessment.forward,
            lambda: assessment.inverse,
        ):
            find()
            yield

    def message(
        self,
        moment: Moment,
        thresholds: Thresholds,
        frames: Frames,
        *,
        setpoint_age: float,
        wrench_age: float,
        loop: LoopStatus = _OPEN,
        unseen: str = "",
    ) -> StabilityMetrics | bytes:
        """Metrics of the equilibrium after a tick, and what they ask for.

        What differs from message to message is given by name.

        Args:
            moment: What it is about.
            thresholds: In force.
            frames: Names of the frames.
            setpoint_age: Age of the newest setpoint [s], -1 without.
            wrench_age: Age of the external wrench [s], -1 without.
            loop: Whether the measured pose corrects the setpoint.
            unseen: What is not measured, in words; empty: nothing is missing.

        Returns:
            The message, as bytes where nothing but time has gone on since the last one.
        """
        message = self._of_tick(moment.outcome, thresholds, frames, loop, unseen)
        trend = self._trend(message.message.margin, moment.now)
        return message.at(moment.stamp, trend, setpoint_age, wrench_age, loop.age)

    def _of_tick(
        self,
        outcome: Outcome,
        thresholds: Thresholds,
        frames: Frames,
        loop: LoopStatus,
        unseen: str,
    ) -> RepeatedMessage:
        """All but what changes with time alone; between ticks the message of before."""
        made, ageless = self._made, loop._replace(age=0.0)
        if (
            made is None
            or made.outcome is not outcome
            or made.thresholds is not thresholds
            or made.loop != ageless
            or made.unseen != unseen
        ):
            message = _metrics(
                outcome, slowed_where_unseen(outcome.verdict, unseen), thresholds, frames
            )
            message.loop, message.loop_text = int(loop.loop), loop.text
            message.position_error = loop.position_error
            message.rotation_error = loop.rotation_error
            repeated = RepeatedMessage(message, _AGES)
            self._made = made = _Made(outcome, thresholds, ageless, unseen, repeated)
        return made.message

    def _trend(self, margin: float, now: float) -> float:
        """Change of the margin since the last message [1/s]."""
        last, self._last = self._last, (margin, now)
        if last is None or now <= last[1]:
            return 0.0
        return (margin - last[0]) / (now - last[1])


def _metrics(
    outcome: Outcome, told: Verdict, thresholds: Thresholds, frames: Frames
) -> StabilityMetrics:
    """What a tick led to, and what is told of it."""
    assessment = outcome.assessment
    equilibrium = assessment.equilibrium
    locked, free = equilibrium.spectrum_locked, equilibrium.spectrum_free
    robot = equilibrium.robot
    return StabilityMetrics(
        header=Header(frame_id=frames.base),
        status=int(told.status),
        status_text=told.text,
        action=int(told.action),
        speed_scale=told.speed_scale,
        state=int(outcome.state),
        converged=equilibrium.converged,
        residual=equilibrium.residual,
        energy_criterion_applies=locked.energy_criterion_applies,
        index_locked=locked.index,
        index_free=free.index,
        smallest_eigenvalues_locked=locked.eigenvalues[:4].tolist(),
        smallest_eigenvalues_free=free.eigenvalues[:4].tolist(),
        inverse_condition_number=locked.inverse_condition_number,
        margin=locked.margin,
        margin_warning=thresholds["margin"].warning,
        margin_stop=thresholds["margin"].stop,
        characteristic_length=assessment.characteristic_length or robot.mean_length,
        forward=singularity_message(robot, assessment.forward),
        inverse=_inverse_singularity(assessment),
        motor_range=assessment.motor_range,
        effort_reserve=assessment.effort_reserve,
        strain_reserve=assessment.strain_reserve,
        model_error=estimated_error(equilibrium),
        model_error_warning=warned_error(equilibrium),
        nearest_threshold=told.nearest,
        distance_to_threshold=told.distance,
        stiffness=stiffness_message(assessment.kinemato_statics),
        solve_time=assessment.solve_time,
    )


def _inverse_singularity(assessment: Assessment) -> SingularityMessage:
    if assessment.inverse is None:
        return SingularityMessage(
            smallest_singular_value=math.nan, inverse_condition_number=math.nan
        )
    return singularity_message(assessment.equilibrium.robot, assessment.inverse)

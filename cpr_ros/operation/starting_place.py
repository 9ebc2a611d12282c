# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a robot is when the node begins to move it. No rclpy here."""

from __future__ import annotations

import time

import numpy as np
from cpr_msgs.msg import ErrorCode
from numpy.typing import NDArray

from cpr_core import CprError, Equilibrium, NotReached, solve_forward, solve_home
from cpr_core.model.assessment import Assessment
from cpr_core.solving.deadline import Deadline

from ..following.measured_range import within_range
from ..following.straight_way import hindrance_on_straight_way
from .kept_state import KnownPlace
from .session import Session

__all__ = [
    "HELD",
    "begin_at",
    "begin_at_commands",
    "begin_at_home",
    "begin_at_last",
    "begin_at_measured",
    "begin_on_way_home",
]

Floats = NDArray[np.float64]

#: What is said of commands that are not to go on by themselves.
HELD = "paused, ~/pause with false lets them go on"
#: Motors nearer than this to where the node has them belong to the same equilibrium [rad, rod lengths].
_NEAR = 0.1
#: A walk to where the robot is takes this long at most [s].
_LONGEST_WALK = 10.0


def begin_at(
    session: Session, equilibrium: Equilibrium, motors: Floats | None, solve_time: float
) -> None:
    """Be at an equilibrium, at rest: what was to lead elsewhere, or is thought reached, ends.

    Args:
        session: The robot in operation.
        equilibrium: Where it is.
        motors: Where its motors are known to be, (n,); None: unknown, commands begin there.
        solve_time: Time it took to find it [s].
    """
    session.orders.end(ErrorCode.PREEMPTED, "the robot was found to be elsewhere")
    place = Assessment(equilibrium, session.solver.current.characteristic_length, solve_time)
    session.solver.current = place
    session.commands.place(motors, repeatable=not session.moved_by_others.away)
    session.moved_by_others.begin(session.commands.newest)
    session.present.begin(place)


def begin_at_home(session: Session, motors: Floats | None, *, measured: bool = False) -> str:
    """Begin at home; commands go there at max_speed from where the motors are. Says what was done.

    Args:
        session: The robot in operation.
        motors: Where they are, (n,); None: unknown.
        measured: Whether they are measured there, or were sent there last.
    """
    home = solve_home(session.robot)
    begin_at(session, home, motors, session.solver.current.solve_time)
    if motors is None:
        return "nothing is known of where the robot is: the first motion begins at home"
    if session.commands.aligned_with(home.motors):
        return (
            "the motors are measured at home"
            if measured
            else "the last commands were those of home"
        )
    begin = "where the motors are measured" if measured else "the last ones"
    return f"commands go from {begin}, {_words(motors)}, to home at max_speed"


def begin_on_way_home(
    session: Session,
    motors: Floats | None,
    *,
    measured: bool = False,
    last: Equilibrium | None = None,
) -> str:
    """The same where commands set off at once, if the way is clear. Says what was done.

    No halt guards that way. Where the robot would cross a stop threshold on it, or does not stand on the
    branch of home, commands are held until somebody lets them go.

    Args:
        session: The robot in operation.
        motors: As of :func:`begin_at_home`.
        measured: As of :func:`begin_at_home`.
        last: The equilibrium they were sent to; None: unknown, it is on the branch of home.
    """
    said = begin_at_home(session, motors, measured=measured)
    if motors is None or session.outgoing.aligned:
        return said
    hindrance = _hindrance_on_way_home(session, motors, last)
    if hindrance:
        session.orders.hold_commands()
        return f"{said}, not yet: {hindrance}; {HELD}"
    return f"{said}; {HELD}" if session.follower.paused else said


def _hindrance_on_way_home(session: Session, motors: Floats, last: Equilibrium | None) -> str:
    """Why the motors may not go straight home from where they are, (n,), in words; empty: they may."""
    robot, length = session.robot, session.solver.current.characteristic_length
    home, thresholds = solve_home(robot), session.follower.settings.thresholds
    try:
        start = _stable_at(home, _within_range(session, motors)) if last is None else last
    except CprError as error:
        return f"how the robot stands there is not known: {error}"
    deadline = Deadline(_LONGEST_WALK)
    way = hindrance_on_straight_way(Assessment(start, length), motors, home, thresholds, deadline)
    if way is None:
        return ""
    return f"time was over before {way.why}" if way.too_late else way.why


def begin_at_last(session: Session, last: KnownPlace) -> str:
    """Begin where the robot was last, without the wrench it may have borne. Says what was done.

    Commands that were on their way there are held: nobody has asked this node for them.

    Raises:
        CprError: It cannot be there any more.
    """
    begin = time.perf_counter()
    try:
        found = _unburdened(last.equilibrium)
    except NotReached as error:
        raise CprError(
            f"the robot cannot be at its last equilibrium without external wrench: {error}"
        ) from None
    if found.index_locked > 0:
        raise CprError("the robot cannot rest at its last equilibrium, which is unstable")
    begin_at(session, found, last.motors, time.perf_counter() - begin)
    said = f"where it was last, motors {_words(found.motors)}"
    if last.motors is not None and session.orders.hold_commands():
        said += f"; commands were on their way there from {_words(last.motors)}: {HELD}"
    return said


def begin_at_measured(session: Session, measured: Floats) -> str:
    """Begin at the measured motors: near by on the branch it is on, else on that of home.

    Without the wrench that acts now or acted last: the next tick bears what acts then. One that came
    with a solution that was applied acts no more. Says what was done.

    Raises:
        CprError: No stable equilibrium of these branches is there, or a motor is beyond its range.
    """
    begin, current = time.perf_counter(), session.solver.current.equilibrium
    measured = _within_range(session, measured)
    ways = np.abs(measured - current.motors) / session.robot.motor_units
    try:
        if float(ways.max(initial=0.0)) <= _NEAR:
            branch = "the branch it is on, without external wrench,"
            found = _stable_at(_unburdened(current), measured)
        else:
            branch = "the branch of home"
            found = _stable_at(solve_home(session.robot), measured)
    except NotReached as error:
        raise CprError(
            f"the robot is measured at motors {_words(measured)}, where {branch} does not lead: {error}"
        ) from None
    begin_at(session, found, measured, time.perf_counter() - begin)
    said = f"where it is measured, motors {_words(measured)}"
    if not session.wrench.acts and current.loads.differences(found.loads):
        said += ", without the wrench of the solution that was applied"
    return said


def begin_at_commands(session: Session, commands: Floats) -> str:
    """Begin where motors were sent by a node with another description, on the branch of home.

    Says what was done.

    Raises:
        CprError: No stable equilibrium of it is there, or a motor is beyond its range.
    """
    begin = time.perf_counter()
    try:
        found = _stable_at(
            solve_home(session.robot), _within_range(session, commands, "was sent to")
        )
    except NotReached as error:
        raise CprError(
            f"the last commands, under another description, were {_words(commands)}, "
            f"where the branch of home does not lead: {error}"
        ) from None
    begin_at(session, found, commands, time.perf_counter() - begin)
    return (
        f"where the last commands were, {_words(commands)}, on the branch of home: "
        "the description is another one"
    )


def _within_range(session: Session, motors: Floats, known: str = "is measured at") -> Floats:
    """Motors, (n,), within their ranges, which rounding may have left.

    Raises:
        CprError: One is beyond.
    """
    within, beyond = within_range(session.robot, motors, known)
    if beyond:
        raise CprError(
            f"no place to begin: {beyond}; bring it back, or with start_from:=home have commands lead "
            "back from there, when ~/pause false lets them"
        )
    return within


def _unburdened(found: Equilibrium) -> Equilibrium:
    """The equilibrium under the loads of the description alone, at the same motors."""
    robot, loads = found.robot, found.robot.default_loads
    if found.loads is loads:
        return found
    return solve_forward(robot, found.motors, start=found, loads=loads, time_limit=_LONGEST_WALK)


def _stable_at(start: Equilibrium, measured: Floats) -> Equilibrium:
    return solve_forward(
        start.robot, measured, start=start, stable_only=True, time_limit=_LONGEST_WALK
    )


def _words(motors: Floats) -> str:
    return "(" + ", ".join(f"{motor:.4g}" for motor in motors) + ")"

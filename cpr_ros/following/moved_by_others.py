# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that the node moves, measured elsewhere than it has sent them. No ROS here.

Somebody has moved them by hand, or through another controller, while nothing was commanded: the next
command would have sent them back at once. Or they stand still while commands go on, without power or
jammed: the farther these are ahead, the farther they jump when they can. A measurement that is wrong
once is neither: until others agree with it, it is a doubt, in which no command goes out and nothing
ends. Measurements that contradict each other again and again tell nothing of where the motors are.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot
from cpr_core.errors import distinct

from .approach import Approach
from .constant_offset import ConstantOffset
from .motor_ways import largest_way, motor_steps
from .standstill import RESTING, Standstill
from .two_places import OFTEN, TwoPlaces, apart_in_words

__all__ = ["SETTLING", "MovedByOthers"]

Floats = NDArray[np.float64]

#: How much later than their last command motors may arrive, and how long they have to rest elsewhere
#: before the robot is begun with there [s].
SETTLING = 0.5
#: After they were measured elsewhere for this time, they are there. Whoever reads the encoders less
#: often than it publishes them may repeat a wrong number [s].
_CERTAIN = 0.05
#: How long it is watched, where motors are measured for the first time, whether all who publish them
#: agree [s].
_TRIAL = 1.0
#: How many returns to an earlier place show meanwhile that they do not; later on it takes more.
_OFTEN_ON_TRIAL = 2
#: Motors that are measured at minus their commands have a wrong sign if that is farther from the
#: commands than so many tolerances: nobody comes there by chance.
_FAR = 4.0
#: Motors that follow are expected to go at this part of their speed limit at least: slow ones may
#: rest for longer before they are said not to follow.
FOLLOWING = 0.1


class MovedByOthers:
    """Compares measured motors with the last command, once they have had the time to get there.

    Attributes:
        away: That they are elsewhere, in words, until a measurement, a command or the tolerance says
            otherwise; empty if they are not.
        doubt: That they may be, in words, until the next measurements tell; empty if they are, or not.
    """

    def __init__(self, robot: Robot, tolerance: float) -> None:
        """Know of no motors yet."""
        self._tolerance, self._way, self.away, self.doubt = tolerance, 0.0, "", ""
        self._robot, self._units = robot, robot.motor_units.tolist()
        self._max_speed, self._patience = math.inf, SETTLING
        self._commanded, self._approach = -math.inf, Approach()
        self._in_motion = self._waited_for = False  # when the way was measured
        self._places, self._apart = TwoPlaces(robot), 0.0
        self._trial, self._tried_since = "", -math.inf
        self._mirrored = False
        self._offset, self._off_again = ConstantOffset(robot), ""
        self._standstill = Standstill(robot)
        self._measured: Floats | None = None
        self._far_since = math.inf

    @property
    def in_question(self) -> str:
        """That they are or may be elsewhere, in words; empty: commands may go out."""
        return self.away or self.doubt or self._trial

    @property
    def tolerance(self) -> float:
        """Motors farther from their command were moved by others; 0: never [rad, rod lengths]."""
        return self._tolerance

    @tolerance.setter
    def tolerance(self, tolerance: float) -> None:
        self._tolerance = tolerance
        # Only a measurement tells that they are elsewhere.
        self.away, self.doubt = self.away and self._where(), self.doubt and self._words_of_doubt()

    def commanded(self, now: float, command: Floats) -> None:
        """Take note of a new command, (n,)."""
        rested, far = now - self._commanded >= SETTLING, 0.0 < self._tolerance < self._way
        arrived = rested and not (far or self._waited_for)
        if arrived or self.away:  # else a pause in which they did not come is none
            self._standstill.begin(command)
        self._trust(now)
        self._offset.sent(command, now)
        self._places.sent(command, now)
        self._standstill.commanded(command, now, self._is_late(command))

    def _is_late(self, command: Floats) -> bool:
        """Whether motors are farther from a command, (n,), than is tolerated, or it waits for them."""
        if self._waited_for or self._measured is None:
            return self._waited_for
        return 0.0 < self._tolerance < largest_way(command, self._measured, self._units)

    def _trust(self, now: float) -> None:
        """The motors are taken to be where the node has them."""
        self._commanded, self.away, self.doubt, self._apart = now, "", "", 0.0
        self._approach.begin(now)

    def begin(self, place: Floats | None = None) -> None:
        """The motors are known to be where the node has them, whatever was measured before.

        Args:
            place: Where they are, (n,); None: unknown, commands begin there.
        """
        self._trust(-math.inf)
        self._offset.begin(place)
        self._standstill.begin(None)
        self.forget_places()

    def forget_places(self) -> None:
        """What was measured before tells nothing of what is measured from now on."""
        self._places = TwoPlaces(self._robot)

    def prove(self, now: float) -> None:
        """Where the motors are was just measured, and several may say so: send them nowhere for a while.

        Args:
            now: Steady time [s].
        """
        self._tried_since, self._places.often = now, _OFTEN_ON_TRIAL
        self._trial = (
            f"where the motors are was just measured: it is looked for {_TRIAL:g} s whether all who "
            "publish it agree"
        )

    @property
    def due(self) -> float:
        """Steady time at which a doubt ends, whatever is measured [s]; infinite without."""
        trial = self._tried_since + _TRIAL if self._trial else math.inf
        return min(trial, self._far_since + SETTLING) if self.doubt else trial

    def look(self, now: float) -> None:
        """Where nothing comes after a doubt, nobody knows where the motors are: they are elsewhere."""
        if self._trial and now >= self._tried_since + _TRIAL:
            self._trial, self._places.often = "", OFTEN
        if self.doubt and now >= self._far_since + SETTLING:
            self.away = self._words()
            self.doubt = ""

    def _limit_speed(self, max_speed: float) -> None:
        """Wait for as long as motors that follow may take to move at all."""
        if max_speed != self._max_speed:
            slowest = FOLLOWING * motor_steps(self._robot, max_speed, 1.0)  # in a second
            times = RESTING * self._robot.motor_units / slowest
            self._patience = max(SETTLING, float(times.max(initial=0.0)))
            self._max_speed = max_speed

    def take(
        self,
        measured: Floats,
        commands: Floats | None,
        now: float,
        *,
        max_speed: float = math.inf,
        waited_for: bool = False,
        several: bool = True,
    ) -> bool:
        """Take measured motors; whether they rest elsewhere, and the robot is to be begun with there.

        Args:
            measured: (n,) [rad or m].
            commands: Where they were sent, (n,); None: nowhere yet.
            now: Steady time [s].
            max_speed: Speed no motor exceeds [rad/s, rod lengths/s]: slow ones follow slowly.
            waited_for: Whether commands go no farther until the motors follow.
            several: Whether there may be several who measure them: else they are in one place.
        """
        self._measured = measured
        self._standstill.measured(measured, commands, now)
        self._limit_speed(max_speed)
        self._waited_for = waited_for
        if commands is not None:
            self._standstill.commanded(commands, now, self._is_late(commands))
        stuck = self._standstill.lasted(now) >= self._patience
        self._way = 0.0 if commands is None else largest_way(commands, measured, self._units)
        self._approach.take(self._way, now)
        self._in_motion = waited_for or now - self._commanded < SETTLING or self._comes_nearer(now)
        self._mirrored = commands is not None and self._is_mirrored(measured, commands)
        self._off_again = self._said_of_offset(measured, commands, now)
        far = self._words()
        self._far_since = min(self._far_since, now) if far else math.inf
        self.away, self.doubt = "", ""
        self._apart = 0.0
        if several and commands is not None and self._tolerance > 0.0:
            self._apart = self._places.take(measured, commands, self._tolerance, now)
        if self._trial and self._places.returned(now):
            self._tried_since = now
        if self._apart > 0.0:
            self.away = self._where()
            return False
        if self._in_motion and not stuck:
            return False
        if far and now - min(self._far_since, self._standstill.since) >= _CERTAIN:
            self.away = far
        elif far:
            self.doubt = self._words_of_doubt()
        # Those that do not follow are begun with a little later: it is told first that they do not.
        rest = now - self._standstill.since >= SETTLING and not self._in_motion
        begin = bool(self.away) and rest and not (self._mirrored or self._off_again)
        if begin and commands is not None:
            self._offset.begun_with(measured - commands)
        return begin

    def _comes_nearer(self, now: float) -> bool:
        """Whether the motors are still on their way to the last command, however slowly they follow."""
        sent = self._commanded > -math.inf and not self._approach.leaving
        return sent and now - self._approach.since < self._patience

    def _said_of_offset(self, measured: Floats, commands: Floats | None, now: float) -> str:
        """That a motor is off its command as before it was begun with; until they agree, once said."""
        if commands is None:
            return ""
        again = self._offset.take(measured, commands, self._tolerance, now)
        if not 0.0 < self._tolerance < self._way:
            return ""
        return (self.away and self._off_again) or again

    def _is_mirrored(self, measured: Floats, commands: Floats) -> bool:
        """Whether all motors are measured where they were sent, but for a sign, and that is far."""
        either = np.minimum(np.abs(measured - commands), np.abs(measured + commands))
        near = bool((either <= self._tolerance * self._robot.motor_units).all())
        return near and self._way > _FAR * self._tolerance

    def _where(self) -> str:
        """That they are in two places, or elsewhere, if the tolerance of now has it so."""
        if 0.0 < self._tolerance < self._apart:
            return apart_in_words(self._apart)
        return self._words()

    def _words_of_doubt(self) -> str:
        """That they may be elsewhere, if the tolerance of now has it so."""
        if not self._words():
            return ""
        told, tolerance = distinct(self._way, self._tolerance)
        return (
            f"a motor was just measured {told} (rad or rod lengths) from its last command, more than "
            f"moved_tolerance {tolerance}: the next measurements tell whether somebody has moved it"
        )

    def _words(self) -> str:
        """That the motors were measured farther from their last command than is tolerated."""
        if not 0.0 < self._tolerance < self._way:
            if not self._waited_for:
                return ""
            return (
                f"the motors do not follow: one was measured {self._way:.3g} (rad or rod lengths) from "
                f"its command, as far as max_lead allows, and all at rest for {self._patience:.3g} s "
                "while commands waited for them"
            )
        if self._off_again:
            return self._off_again
        told, tolerance = distinct(self._way, self._tolerance)
        if self._in_motion:
            return (
                f"the motors do not follow: one was measured {told} (rad or rod lengths) from its "
                f"command, more than moved_tolerance {tolerance}, and all at rest for "
                f"{self._patience:.3g} s though commands went on; the node begins where they are"
            )
        if self._mirrored:
            return (
                f"one motor was measured {told} (rad or rod lengths) from its last command, more than "
                f"moved_tolerance {tolerance}, where it would be with the other sign: the node does not "
                "begin there"
            )
        return (
            f"somebody else has moved the motors: one was measured {told} (rad or rod lengths) from its "
            f"last command, more than moved_tolerance {tolerance}; the node begins where they are as "
            "soon as they are measured at rest"
        )

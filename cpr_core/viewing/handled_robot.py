# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot in somebody's hands: where it is, what was asked of it in vain, and the way back."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.controlled_coordinates import pose_of
from ..description.loads import Loads
from ..errors import CprError, InvalidRequest
from ..kernels.twist_layout import ANGULAR, LINEAR
from ..lie import quaternion_from_rotation, rotation_from_quaternion
from ..model.configurations import SAME_EQUILIBRIUM, configuration_distance
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot, checked_robot
from ..model.shape import Pose
from ..solving.geometrico_statics import checked_start, solve_forward, solve_inverse
from ..solving.home import solve_home
from ..solving.not_reached import NotReached, TimeLimitExceeded
from ..solving.requests import split_pose
from ..validation import checked_vector
from .refused import Asked, Refused

__all__ = ["HandledRobot"]

Floats = NDArray[np.float64]

#: Gravity that is switched on where the description has none [m/s^2].
_EARTH = (0.0, 0.0, -9.81)
#: A walk that takes longer is refused: whoever drags waits for the picture [s].
_TIME_LIMIT = 2.0
#: Requests of one hand that follow each other faster are one gesture, undone together [s].
_GESTURE = 1.0
#: Hands that say when they let go: they may rest meanwhile, but not so long [s].
DRAGGED, _HELD = ("platform", "force"), 60.0
#: Equilibria that can be gone back to.
_KEPT = 200
#: Platforms nearer than this, in rod lengths, are at the same place after other modes were chosen.
_SAME = 0.02


class HandledRobot:
    """Moves a robot along its branch. What the walk refuses leaves it at the last equilibrium before.

    A robot that is stable stays so: a request that would let it buckle is refused where it would.
    Nothing of the page here; one thread at a time.

    Attributes:
        equilibrium: Where the robot is.
        refused: What was asked last, if that was in vain.
        words: What was done last, in words.
    """

    def __init__(
        self,
        robot: Robot,
        start: Equilibrium | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """At a start, or at home under the loads of the description.

        Args:
            robot: The robot.
            start: Where to begin.
            clock: Tells the time [s].

        Raises:
            InvalidRequest: No robot, or a start of another one.
        """
        self.equilibrium = checked_start(checked_robot(robot), start)
        self.refused: Refused | None = None
        self.words = "at home" if start is None else "at the start"
        self._clock, self._last = clock, -np.inf
        self._history: deque[Equilibrium] = deque(maxlen=_KEPT)
        self._hand = ""

    @property
    def robot(self) -> Robot:
        """The robot, with the modes chosen."""
        return self.equilibrium.robot

    @property
    def undoable(self) -> bool:
        """Whether there is something to undo."""
        return bool(self._history)

    @property
    def has_gravity(self) -> bool:
        """Whether gravity acts."""
        return bool(np.any(self.equilibrium.loads.gravity))

    @property
    def force(self) -> Floats:
        """Force on the platform origin, fixed in space, (3,) [N]."""
        return self.equilibrium.loads.wrench_world[LINEAR]

    def move_motors(self, motors: ArrayLike, hand: str = "motors") -> bool:
        """Go to motor positions; whether they were reached.

        Args:
            motors: Motor positions, (n,) [rad or m].
            hand: Who asks: consecutive requests of one hand are undone together.
        """

        def solve() -> Equilibrium:
            return solve_forward(self.robot, motors, **self._from_current())

        def asked() -> Asked:
            return Asked(motors=checked_vector("motors", motors, self.robot.motor_count))

        return self._ask(hand, solve, asked)

    def move_motor(self, number: int, position: float) -> bool:
        """Move one motor, the others stay."""
        motors = self.equilibrium.motors.copy()
        motors[number] = position
        return self.move_motors(motors, self.robot.motor_names[number])

    def move_pose(self, pose: ArrayLike, hand: str = "pose") -> bool:
        """Go to controlled coordinates, as ``solve_inverse`` takes them; whether they were reached."""

        def solve() -> Equilibrium:
            return solve_inverse(self.robot, pose, **self._from_current())

        return self._ask(hand, solve, lambda: Asked(platform=self._pose_meant(pose)))

    def move_platform(self, position: ArrayLike, quaternion: ArrayLike) -> bool:
        """Drag the platform: of a whole pose the controlled coordinates count.

        Args:
            position: (3,) [m].
            quaternion: w x y z.
        """
        try:
            rotation = rotation_from_quaternion(quaternion)
            place = checked_vector("platform", position, 3, "x y z, m")
        except CprError as error:
            return self.refuse(error)
        controlled = self.robot.description.controlled
        pose = pose_of(controlled, place, rotation, lambda: quaternion_from_rotation(rotation))
        return self.move_pose(pose, "platform")

    def load(self, loads: Loads, hand: str = "loads") -> bool:
        """Let other loads act, motors held; whether they are borne."""

        def solve() -> Equilibrium:
            way = self._from_current() | {"loads": loads}
            # Of loads without a potential no energy tells whether the robot stays stable.
            way["stable_only"] = way["stable_only"] and self.robot.has_potential(loads)
            return solve_forward(self.robot, self.equilibrium.motors, **way)

        return self._ask(hand, solve, lambda: Asked(loads=loads))

    def push(self, force: ArrayLike, hand: str = "force") -> bool:
        """Let a force act on the platform origin, fixed in space, (3,) [N]; its moment stays."""
        try:
            new = checked_vector("force", force, 3, "x y z, N")
        except CprError as error:
            return self.refuse(error)
        loads = self.equilibrium.loads
        wrench = np.concatenate([loads.wrench_world[ANGULAR], new])
        return self.load(loads.with_(wrench_world=wrench), hand)

    def switch_gravity(self, on: bool) -> bool:
        """With the gravity of the description (that of the earth where it has none), or without."""
        described = self.robot.description.gravity
        gravity = np.zeros(3) if not on else described if np.any(described) else np.array(_EARTH)
        if on and self.robot.planar:
            gravity = np.array([gravity[0], gravity[1], 0.0])
            gravity = gravity if np.any(gravity) else np.array([0.0, _EARTH[2], 0.0])
        return self.load(self.equilibrium.loads.with_(gravity=gravity), "gravity")

    def go_home(self) -> bool:
        """Walk home, with the loads of home; jump there if the walk leads to another equilibrium."""
        home = solve_home(self.robot)

        def solve() -> Equilibrium:
            way = self._from_current() | {"loads": home.loads, "time_limit": 10.0 * _TIME_LIMIT}
            return solve_forward(self.robot, home.motors, **way)

        reached = self._ask("home", solve, lambda: Asked(motors=home.motors, loads=home.loads))
        if reached:
            found, self.equilibrium, self.words = self.equilibrium, home, "at home"
            apart = configuration_distance(self.robot, found.configuration, home.configuration)
            if apart > SAME_EQUILIBRIUM:
                away = np.linalg.norm(found.platform_position - home.platform_position)
                self.words += (
                    f", by a jump: the way led to another branch, platform {away:.3g} m from home, "
                    f"index {found.index_locked}"
                )
        return reached

    def check_shown(self, equilibrium: Equilibrium) -> None:
        """Whether an equilibrium is one of the robot that is shown.

        Raises:
            InvalidRequest: Another robot's, be it the same with other numbers or another copy of it.
        """
        if equilibrium.robot is not self.robot:
            raise InvalidRequest("equilibrium", "expected one of the robot that is shown")

    def take(self, equilibrium: Equilibrium, words: str) -> None:
        """Jump to an equilibrium of the same robot, on whatever branch: it was chosen by hand.

        Raises:
            InvalidRequest: Another robot's.
        """
        self.check_shown(equilibrium)
        self._remember("take")
        self._last = -np.inf
        self.equilibrium, self.refused, self.words = equilibrium, None, words

    def show(self, equilibrium: Equilibrium, words: str) -> None:
        """One picture of a path that is played: all of them are undone together."""
        self._remember("show")
        self.equilibrium, self.refused, self.words = equilibrium, None, words

    def choose_modes(self, modes: int) -> bool:
        """The same robot with other strain modes, at the same motors and under the same loads."""
        current = self.equilibrium
        try:
            robot = self.robot.with_description(self.robot.description.with_modes(modes))
            found = solve_forward(robot, current.motors, loads=current.loads, time_limit=10.0)
        except CprError as error:
            return self.refuse(error)
        apart = np.linalg.norm(found.platform_position - current.platform_position)
        if apart > _SAME * robot.mean_length:
            words = (
                f"{modes} modes: not chosen, because the way from home at these motors leads to another "
                f"equilibrium, {apart:.3g} m away; go home first"
            )
            self.refused, self.words = Refused(words, "branch"), words
            return False
        self._remember("modes")
        self.equilibrium, self.refused = found, None
        self.words = f"{modes} modes: the platform is {1e3 * apart:.3g} mm from where it was"
        return True

    def undo(self) -> bool:
        """Back to where the last gesture began; whether there was one."""
        if not self._history:
            return False
        before = self._history.pop()
        self.equilibrium, self.refused, self.words = before, None, "undone"
        self._hand, self._last = "", -np.inf
        return True

    def end_gesture(self) -> None:
        """What comes next is another gesture, whoever's it is."""
        self._last = -np.inf

    def _from_current(self) -> dict:
        current = self.equilibrium
        return {"start": current, "stable_only": current.stable, "time_limit": _TIME_LIMIT}

    def _ask(
        self, hand: str, solve: Callable[[], Equilibrium], asked: Callable[[], Asked | None]
    ) -> bool:
        """Solve; keep the result, or how far it came and why not farther."""
        try:
            found = solve()
        except NotReached as error:
            last = error.last
            if last is not None and last is not self.equilibrium:
                self._remember(hand)
                self.equilibrium = last
            return self.refuse(error, asked())
        except CprError as error:  # numbers that mean nothing, or no inverse problem
            return self.refuse(error)
        self._remember(hand)
        self.equilibrium, self.refused, self.words = found, None, ""
        return True

    def refuse(self, error: CprError, asked: Asked | None = None) -> bool:
        """Say what is wrong with a request, None: one that did not get as far as being one; false."""
        event = error.event if isinstance(error, NotReached) else None
        kind = event.kind if event is not None else error.code.lower()
        words = str(error)
        if isinstance(error, TimeLimitExceeded):
            words = f"not there in time, ask again to go on: {words}"
        self.refused, self.words = Refused(words, kind, asked), words
        return False

    def _remember(self, hand: str) -> None:
        """Keep where the robot is, unless this goes on with a gesture."""
        now = self._clock()
        if hand != self._hand or now - self._last > (_HELD if hand in DRAGGED else _GESTURE):
            self._history.append(self.equilibrium)
        self._hand, self._last = hand, now

    def _pose_meant(self, pose: ArrayLike) -> Pose:
        position, rotation = split_pose(self.equilibrium, pose)
        return Pose(rotation, position)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the robot was last, in a small file. No ROS here.

What was written is in the file even if the process is killed in the next moment: it is in the memory
of the system then, as that of a memory-mapped file is. It is written and not mapped because a write
that fails (a full disk, a file that somebody has truncated) is an error, and a map ends the process.

An equilibrium is of one description. Commands are of motors: they stand where they were sent, however
their robot is described later, which its calibration does.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpr_core import CprError, Equilibrium, Robot, restore_equilibrium

from .locked_file import LockedFile
from .state_layout import HEADER_SIZE, StateLayout, header_of, is_header

__all__ = ["KeptState", "KnownPlace", "state_folder"]

Floats = NDArray[np.float64]

#: What requests and messages change of the loads, and how many numbers each has.
_LOADS = {"gravity": 3, "wrench_world": 6, "wrench_body": 6}


class KnownPlace(NamedTuple):
    """What is known of where a robot is, or was last.

    Attributes:
        equilibrium: Its last equilibrium.
        motors: Where its motors were sent, or measured, (n,) [rad or m]; None: not there any more.
        measured: Whether the motors are measured, or were since the node was started.
    """

    equilibrium: Equilibrium
    motors: Floats | None
    measured: bool = False

    def same_as(self, other: KnownPlace | None) -> bool:
        """Whether two places are one."""
        if other is None or self.equilibrium is not other.equilibrium:
            return False
        if self.measured != other.measured:
            return False
        if self.motors is None or other.motors is None or self.motors is other.motors:
            return self.motors is other.motors
        return np.array_equal(self.motors, other.motors)


def state_folder(given: str, parameter: str = "state_directory") -> Path:
    """Where files are kept if nothing else is asked for: beside the logs of ROS.

    Args:
        given: What a parameter says; empty: nothing else.
        parameter: Its name.

    Raises:
        CprError: It is in the home of a user, who has none.
    """
    try:
        if given:
            return Path(given).expanduser()
        return Path(os.environ.get("ROS_HOME") or Path.home() / ".ros") / "cpr_ros"
    except RuntimeError as error:
        hint = "" if given else " ROS_HOME may name one."
        raise CprError(f"{parameter}: expected a folder, got {given!r}: {error}{hint}") from None


class KeptState:
    """The file of one node.

    Attributes:
        problem: Why what another robot left in the file is of no use, in words; empty if there is none.
        commands_before: The last commands of these motors under another description, (n,) [rad or m];
            NaN: they are not there any more; None: there is no such file.
        damage: Why the file cannot be read, in words; empty if it can. The robot was somewhere then.
    """

    def __init__(self, file: Path, robot: Robot) -> None:
        """Open or make the file, and lock it.

        Args:
            file: Where.
            robot: The robot.

        Raises:
            OSError: It cannot be written, or a link on the way to it leads nowhere.
            BlockingIOError: Another node keeps its state there.
        """
        self.problem, self.damage, self._robot, self._path = "", "", robot, file
        self.commands_before: Floats | None = None
        self._layout = StateLayout(header_of(robot, sum(_sizes(robot).values())))
        #: What is to be in the file; what is in it stays until the robot is placed or moved.
        self._content = bytearray(self._layout.empty())
        self._file = LockedFile(file, self._content)
        try:
            self._read()
        except OSError:
            self._file.close()
            raise
        self._turn, _ = self._layout.newest(self._content)

    def _read(self) -> None:
        """Look whether what is in the file is of use, and where it is, take it."""
        content = self._file.read(len(self._content) + 1)
        header = content[:HEADER_SIZE]
        self._own = header == self._layout.header
        if is_header(header) and not self._own:
            before = StateLayout(header)
            whole = self._file.read(before.size)
            slots = before.slots(whole) if len(whole) == before.size else []
            if [turn for turn, _ in slots] == [0, 0]:
                return  # made for it, and nothing was ever kept there
            self._take_commands(before, slots)
            others = "another robot" if self.commands_before is None else "another description"
            self.problem = f"{self._path} is of {others}; it stays until a new state is kept"
        elif not self._own:
            self._spoil("it does not begin as a file of this version does")
        elif len(content) != len(self._content):
            self._spoil("its length is not that of a file of this robot")
        elif [turn for turn, _ in self._layout.slots(content)] in ([], [0]):  # new: two of turn 0
            self._spoil("its checksums are wrong")
        else:
            self._content[:] = content
            self._file.reserve(len(content))

    def _take_commands(self, before: StateLayout, slots: list[tuple[int, bytes]]) -> None:
        """Take the commands that the same motors had under another description."""
        count = self._robot.motor_count
        if before.motors != self._layout.motors or before.count < count:
            return
        turn, numbers = max(slots, default=(0, b""))
        if turn > 0:
            self.commands_before = np.array(np.frombuffer(numbers)[-count:])

    def _spoil(self, reason: str) -> None:
        """Read nothing of the file."""
        self._own = False
        self.damage = (
            f"{self._path} cannot be read, {reason}: it is damaged or of another version, and may be "
            "removed once the motors are at home"
        )

    def close(self) -> None:
        """Let the file go; what is in it stays."""
        self._file.close()

    @property
    def empty(self) -> bool:
        """Whether it is of this robot, and no state was ever kept in it."""
        return self._own and self._turn == 0

    def keep(self, equilibrium: Equilibrium, motors: Floats | None, measured: bool = False) -> None:
        """Write where the robot is, in some microseconds; only now what another one left is gone.

        Args:
            equilibrium: As in :class:`KnownPlace`.
            motors: As in :class:`KnownPlace`.
            measured: As in :class:`KnownPlace`.

        Raises:
            OSError: It is not in the file; `mend` tries again.
        """
        if motors is None:
            motors = np.full(self._robot.motor_count, np.nan)
        loads = [getattr(equilibrium.loads, name) for name in _LOADS]
        parts = [equilibrium.configuration, *loads, np.array([float(measured)]), motors]
        self._turn += 1
        slot = self._layout.slot(self._turn, b"".join([part.tobytes() for part in parts]))
        place = HEADER_SIZE + (self._turn % 2) * len(slot)
        self._content[place : place + len(slot)] = slot
        if self._own:
            self._file.write(slot, place)
        else:
            self._own, self.problem, self.damage, self.commands_before = True, "", "", None
            self._file.rewrite(self._content)

    def clear(self) -> bool:
        """Take away what is old in the file, so that nobody begins there; whether nobody will.

        A file that others have removed or replaced is not this one any more.
        """
        try:
            old = is_header(self._file.read(HEADER_SIZE)) and not self._is_whole
            if old and self._file.named:
                self._file.clear()
        except OSError:
            return False
        return True

    def mend(self) -> bool:
        """Make the file whole where others have removed, replaced or changed it; whether they have.

        Nobody tells: it has to be called now and then.

        Raises:
            OSError: It cannot be written.
            BlockingIOError: Another node keeps its state there meanwhile.
        """
        if not self._own:
            return False
        if self._file.named and self._is_whole:
            return False
        self._file.rewrite(self._content)
        return True

    @property
    def _is_whole(self) -> bool:
        """Whether what is to be in the file is."""
        return self._file.read(len(self._content) + 1) == self._content

    def last(self) -> KnownPlace | None:
        """Where the robot was last; None if that is not known.

        Raises:
            CprError: The file cannot be read, what is kept is no equilibrium of the robot, or its
                motors have left it.
        """
        if self.damage:
            raise CprError(self.damage)
        numbers = self._newest()
        if numbers is None:
            return None
        if self.last_commands() is None:
            raise CprError(
                "the motors were measured where no equilibrium explained them, or others had moved them"
            )
        robot, sizes = self._robot, _sizes(self._robot)
        ends = np.cumsum([*sizes.values()])[:-1]
        parts = dict(zip(sizes, np.split(numbers, ends), strict=True))
        state, default = parts["state"], robot.default_loads
        changed: dict[str, Any] = {name: parts[name] for name in _LOADS}
        loads = default.with_(**changed)
        equilibrium = restore_equilibrium(
            robot,
            loads
            if loads.differences(default)
            else default,  # that of the description is one object
            state[robot.motor_indices],
            state[robot.elastic_indices],
            state[robot.multiplier_indices],
            parts["platform_rotation"].reshape(3, 3),
            parts["platform_position"],
        )
        return KnownPlace(equilibrium, np.array(parts["commands"]), bool(parts["measured"][0]))

    def last_commands(self) -> Floats | None:
        """The last motor commands, (n,) [rad or m], whatever the equilibrium; None: not known."""
        numbers = self._newest() if self.commands_before is None else self.commands_before
        if numbers is None or np.isnan(numbers[-1]):
            return None
        return np.array(numbers[-self._robot.motor_count :])

    def _newest(self) -> Floats | None:
        """The numbers that were written last; None if none were."""
        turn, numbers = self._layout.newest(self._content)
        return np.frombuffer(numbers) if turn > 0 else None


def _sizes(robot: Robot) -> dict[str, int]:
    """The numbers of a slot in their order; the first three are the configuration of an equilibrium."""
    configuration = {"state": robot.state_size, "platform_rotation": 9, "platform_position": 3}
    return configuration | _LOADS | {"measured": 1, "commands": robot.motor_count}

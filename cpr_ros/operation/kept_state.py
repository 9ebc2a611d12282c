# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the robot was last, in a small memory-mapped file. No ROS here.

What was written is in the file even if the process is killed in the next moment. Two slots are written
in turn, each with a checksum: one that was being written counts for nothing, the other one does.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import mmap
import os
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cpr_core import CprError, Equilibrium, Loads, Robot, restore_equilibrium

__all__ = ["KeptState", "LastState", "state_folder"]

Floats = NDArray[np.float64]

_MAGIC = b"cpr_ros state 1\n"
#: Before the slots: what this is, whose it is, how many numbers a slot has; before these: which turn
#: they are of, and a checksum.
_HEADER, _SLOT = struct.Struct("=16s32sQ"), struct.Struct("=QII")


@dataclass(frozen=True, eq=False)
class LastState:
    """What is known of where a robot was.

    Attributes:
        equilibrium: Its last equilibrium.
        commands: The last motor commands, (n,) [rad or m].
    """

    equilibrium: Equilibrium
    commands: Floats


def state_folder(given: str) -> Path:
    """Where files are kept if nothing else is asked for: beside the logs of ROS."""
    if given:
        return Path(given).expanduser()
    return Path(os.environ.get("ROS_HOME") or Path.home() / ".ros") / "cpr_ros"


def _lock(file: int) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise BlockingIOError(
            error.errno, "another node of this name keeps its state there"
        ) from None


class KeptState:
    """The file of one node.

    Attributes:
        problem: Why what is in the file is of no use, in words; empty if it is, or if there is nothing.
    """

    def __init__(self, file: Path, robot: Robot) -> None:
        """Open or make the file, and lock it.

        Args:
            file: Where.
            robot: The robot.

        Raises:
            OSError: It cannot be written.
            BlockingIOError: Another node keeps its state there.
        """
        self.problem, self._robot = "", robot
        self._count = robot.state_size + 27 + robot.motor_count
        file.parent.mkdir(parents=True, exist_ok=True)
        self._file = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            _lock(self._file)
            size = _HEADER.size + 2 * self._slot_size
            if os.fstat(self._file).st_size < size:
                # All of it: writing to a hole in it would end the process on a full disk.
                os.posix_fallocate(self._file, 0, size)
            self._memory = mmap.mmap(self._file, size)
        except OSError:
            os.close(self._file)
            raise
        self._header = _HEADER.pack(_MAGIC, _fingerprint(robot), self._count)
        found = self._memory[: _HEADER.size]
        self._own = found == self._header
        if any(found) and not self._own:
            self.problem = (
                f"{file} is of another robot or description; it stays until a new state is kept"
            )
        self._turn = max((turn for turn, _ in self._slots()), default=0)

    @property
    def _slot_size(self) -> int:
        return _SLOT.size + 8 * self._count

    def close(self) -> None:
        """Let the file go; what is in it stays."""
        with contextlib.suppress(BufferError):  # somebody still reads; it ends with the process
            self._memory.close()
        os.close(self._file)

    def keep(self, equilibrium: Equilibrium, commands: Floats | None) -> None:
        """Write where the robot is, in some microseconds; only now what another one left is gone.

        Args:
            equilibrium: Its last equilibrium.
            commands: The last motor commands, (n,) [rad or m]; None: the motors are not there any more.
        """
        if commands is None:
            commands = np.full(self._robot.motor_count, np.nan)
        if not self._own:
            self._take_over()
        loads = equilibrium.loads
        parts = (
            equilibrium.configuration,
            loads.gravity,
            loads.wrench_world,
            loads.wrench_body,
            commands,
        )
        numbers = b"".join([part.tobytes() for part in parts])
        turn = self._turn + 1
        place = _HEADER.size + (turn % 2) * self._slot_size
        self._memory[place + _SLOT.size : place + self._slot_size] = numbers
        head = _SLOT.pack(turn, _checksum(turn, numbers), 0)
        self._memory[place : place + _SLOT.size] = head
        self._turn = turn

    def last(self) -> LastState | None:
        """Where the robot was last; None if that is not known.

        Raises:
            CprError: What is kept is no equilibrium of the robot, or its motors have left it.
        """
        numbers = self._newest()
        if numbers is None:
            return None
        if self.last_commands() is None:
            raise CprError("the motors were measured where no equilibrium explained them")
        robot, size = self._robot, self._robot.state_size
        ends = np.cumsum([size, 9, 3, 3, 6, 6])
        state, rotation, position, gravity, world, body, commands = np.split(numbers, ends)
        equilibrium = restore_equilibrium(
            robot,
            _loads(robot, gravity, world, body),
            state[robot.motor_indices],
            state[robot.elastic_indices],
            state[robot.multiplier_indices],
            rotation.reshape(3, 3),
            position,
        )
        return LastState(equilibrium, np.array(commands))

    def last_commands(self) -> Floats | None:
        """The last motor commands, (n,) [rad or m], whatever the equilibrium; None: not known."""
        numbers = self._newest()
        if numbers is None or np.isnan(numbers[-1]):
            return None
        return np.array(numbers[-self._robot.motor_count :])

    def _newest(self) -> Floats | None:
        """The numbers that were written last."""
        slots = self._slots()
        return np.frombuffer(max(slots)[1]) if slots else None

    def _take_over(self) -> None:
        """Make the file this robot's: what is in it must not pass for its slots."""
        self._memory[_HEADER.size :] = bytes(2 * self._slot_size)
        self._memory[: _HEADER.size] = self._header
        self._own = True

    def _slots(self) -> list[tuple[int, bytes]]:
        """Turns and numbers of the slots that were written whole."""
        found: list[tuple[int, bytes]] = []
        if not self._own:
            return found
        for slot in range(2):
            place = _HEADER.size + slot * self._slot_size
            turn, checksum, _ = _SLOT.unpack_from(self._memory, place)
            numbers = self._memory[place + _SLOT.size : place + self._slot_size]
            if turn > 0 and checksum == _checksum(turn, numbers):
                found.append((turn, numbers))
        return found


def _checksum(turn: int, numbers: bytes) -> int:
    return zlib.crc32(numbers, zlib.crc32(turn.to_bytes(8)))


def _fingerprint(robot: Robot) -> bytes:
    """What tells a robot, its description and its modes from others."""
    text, written = robot.description.text, robot.description.written
    if written is not None and "tracker" in written.content:  # it moves nothing of the robot
        rest = {name: field for name, field in written.content.items() if name != "tracker"}
        text = json.dumps(rest, default=repr)
    described = f"{text}\0{robot.motor_list}\0{robot.state_size}"
    return hashlib.sha256(described.encode()).digest()


def _loads(robot: Robot, gravity: Floats, world: Floats, body: Floats) -> Loads:
    """Loads as they were; the object of the description if they are its own."""
    default = robot.default_loads
    same = all(
        np.array_equal(given, described)
        for given, described in (
            (gravity, default.gravity),
            (world, default.wrench_world),
            (body, default.wrench_body),
        )
    )
    if same:
        return default
    return default.with_(gravity=gravity, wrench_world=world, wrench_body=body)

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the robot was last, in a small file. No ROS here.

What was written is in the file even if the process is killed in the next moment: it is in the memory
of the system then, as that of a memory-mapped file is. It is written and not mapped because a write
that fails (a full disk, a file that somebody has truncated) is an error, and a map ends the process.

Two slots are written in turn, each with a checksum: one that was being written counts for nothing, the
other one does. A new file has two slots of turn 0, and no state; it gets its name when it is whole. So
what has no slot that is whole had a state once, which is lost, and is no file of a robot that never
moved.

An equilibrium is of one description. Commands are of motors: they stand where they were sent, however
their robot is described later, which its calibration does.
"""

from __future__ import annotations

import errno
import fcntl
import hashlib
import json
import os
import secrets
import struct
import zlib
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpr_core import CprError, Equilibrium, Robot, restore_equilibrium

__all__ = ["KeptState", "LastState", "link_to_nowhere", "state_folder"]

Floats = NDArray[np.float64]

_MAGIC = b"cpr_ros state 3\n"
#: Before the slots: what this is, of which description and motors, how many numbers a slot has, and a
#: checksum.
_HEADER, _CHECKSUM = struct.Struct("=16s32s32sQ"), struct.Struct("=I")
_HEADER_SIZE = _HEADER.size + _CHECKSUM.size
#: Before the numbers of a slot: which turn they are of, and a checksum.
_SLOT = struct.Struct("=QI")
#: What requests and messages change of the loads, and how many numbers each has.
_LOADS = {"gravity": 3, "wrench_world": 6, "wrench_body": 6}


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


def link_to_nowhere(file: Path) -> Path | None:
    """A link on the way to a file, or the file itself, whose target is not there; None: there is none.

    The target may be on a disk that is away for now, and know where the robot is.
    """
    return next(
        (part for part in (file, *file.parents) if part.is_symlink() and not _is_there(part)), None
    )


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
        if link := link_to_nowhere(file):
            raise FileNotFoundError(errno.ENOENT, "a link that leads nowhere", str(link))
        self.problem, self.damage, self._robot, self._path = "", "", robot, file
        self.commands_before: Floats | None = None
        self._layout = _layout_of(robot)
        #: What is to be in the file; what is in it stays until the robot is placed or moved.
        self._content = bytearray(self._layout.empty())
        file.parent.mkdir(parents=True, exist_ok=True)
        self._file = _open_or_make(file, self._content)
        try:
            self._read()
        except OSError:
            os.close(self._file)
            raise
        self._turn, _ = self._layout.newest(self._content)

    def _read(self) -> None:
        """Look whether what is in the file is of use, and where it is, take it."""
        content = os.pread(self._file, len(self._content) + 1, 0)
        header = content[:_HEADER_SIZE]
        self._own = header == self._layout.header
        if _is_header(header) and not self._own:
            self._read_commands(_Layout(header))
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
            written = os.fstat(self._file)
            os.posix_fallocate(self._file, 0, len(content))  # a full disk is told of now
            with suppress(PermissionError):  # that is no writing; others' files have their time
                os.utime(self._file, ns=(written.st_atime_ns, written.st_mtime_ns))

    def _read_commands(self, before: _Layout) -> None:
        """Take the commands that the same motors had under another description."""
        count = self._robot.motor_count
        if before.motors != self._layout.motors or before.count < count:
            return
        content = os.pread(self._file, before.size, 0)
        if len(content) == before.size:
            turn, numbers = max(before.slots(content), default=(0, b""))
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
        os.close(self._file)

    @property
    def empty(self) -> bool:
        """Whether it is of this robot, and no state was ever kept in it."""
        return self._own and self._turn == 0

    def keep(self, equilibrium: Equilibrium, commands: Floats | None) -> None:
        """Write where the robot is, in some microseconds; only now what another one left is gone.

        Args:
            equilibrium: Its last equilibrium.
            commands: The last motor commands, (n,) [rad or m]; None: the motors are not there any more.

        Raises:
            OSError: It is not in the file; `mend` tries again.
        """
        if commands is None:
            commands = np.full(self._robot.motor_count, np.nan)
        loads = [getattr(equilibrium.loads, name) for name in _LOADS]
        parts = [equilibrium.configuration, *loads, commands]
        self._turn += 1
        slot = self._layout.slot(self._turn, b"".join([part.tobytes() for part in parts]))
        place = _HEADER_SIZE + (self._turn % 2) * len(slot)
        self._content[place : place + len(slot)] = slot
        if self._own:
            _write(self._file, slot, place)
        else:
            self._own, self.problem, self.damage, self.commands_before = True, "", "", None
            self._write_all()

    def mend(self) -> bool:
        """Make the file whole where others have removed, replaced or changed it; whether they have.

        Nobody tells: it has to be called now and then.

        Raises:
            OSError: It cannot be written.
            BlockingIOError: Another node keeps its state there meanwhile.
        """
        if not self._own:
            return False
        named = _has_name(self._file, self._path)
        if named and os.pread(self._file, len(self._content) + 1, 0) == self._content:
            return False
        if not named:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            removed, self._file = self._file, _open_or_make(self._path, self._content)
            os.close(removed)
        self._write_all()
        return True

    def _write_all(self) -> None:
        """Header and slots at once: no slot that another one left passes for one of this header."""
        _write(self._file, self._content, 0)
        os.ftruncate(self._file, len(self._content))

    def last(self) -> LastState | None:
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
        return LastState(equilibrium, np.array(parts["commands"]))

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


class _Layout:
    """Where things are in a file that begins with a header.

    Attributes:
        header: With its checksum.
        motors: Fingerprint of the motors.
        count: How many numbers a slot has.
        size: Bytes of the file.
    """

    def __init__(self, header: bytes) -> None:
        self.header = header
        _, _, self.motors, self.count = _HEADER.unpack(header[: _HEADER.size])
        self._slot_size = _SLOT.size + 8 * self.count
        self.size = _HEADER_SIZE + 2 * self._slot_size

    def empty(self) -> bytes:
        """A file without a state."""
        return self.header + 2 * self.slot(0, bytes(8 * self.count))

    def newest(self, content: bytes | bytearray) -> tuple[int, bytes]:
        """Turn and numbers of the newer slot."""
        return max(self.slots(content))

    def slots(self, content: bytes | bytearray) -> list[tuple[int, bytes]]:
        """Turns and numbers of the slots that are whole."""
        found: list[tuple[int, bytes]] = []
        for place in (_HEADER_SIZE, _HEADER_SIZE + self._slot_size):
            slot = bytes(content[place : place + self._slot_size])
            turn, _ = _SLOT.unpack_from(slot)
            if slot == self.slot(turn, slot[_SLOT.size :]):
                found.append((turn, slot[_SLOT.size :]))
        return found

    def slot(self, turn: int, numbers: bytes) -> bytes:
        """What is written of a turn; slots of other headers have other checksums."""
        # Of a header with its own checksum the checksum is always the same.
        of_header = zlib.crc32(self.header[: _HEADER.size])
        checksum = zlib.crc32(numbers, zlib.crc32(turn.to_bytes(8), of_header))
        return _SLOT.pack(turn, checksum) + numbers


def _sizes(robot: Robot) -> dict[str, int]:
    """The numbers of a slot in their order; the first three are the configuration of an equilibrium."""
    configuration = {"state": robot.state_size, "platform_rotation": 9, "platform_position": 3}
    return configuration | _LOADS | {"commands": robot.motor_count}


def _layout_of(robot: Robot) -> _Layout:
    """The layout of the file of a robot."""
    count = sum(_sizes(robot).values())
    header = _HEADER.pack(_MAGIC, _fingerprint(robot), _fingerprint_of_motors(robot), count)
    return _Layout(header + _CHECKSUM.pack(zlib.crc32(header)))


def _open_or_make(path: Path, content: bytes | bytearray) -> int:
    """Open a file and lock it; where there is none, make one of some content.

    Raises:
        OSError: It cannot be written.
        BlockingIOError: Another node keeps its state there.
    """
    try:
        file = os.open(path, os.O_RDWR | os.O_CLOEXEC)
    except FileNotFoundError:
        return _make(Path(os.path.realpath(path)), content)  # where a link leads, if it is one
    try:
        _lock(file)
        if not _has_name(file, path):
            raise _taken()  # another one has just made or mended it
    except OSError:
        os.close(file)
        raise
    return file


def _make(path: Path, content: bytes | bytearray) -> int:
    """Make a file and lock it; it gets its name when it is whole, or not at all."""
    unfinished = path.with_name(f"{path.name}.{secrets.token_hex(4)}")
    file = os.open(unfinished, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
    try:
        _lock(file)
        os.posix_fallocate(file, 0, len(content))  # a full disk is told of now
        _write(file, content, 0)
        try:
            os.link(unfinished, path)  # unlike a renaming, it takes no other node's file away
        except FileExistsError:
            raise _taken() from None
        except OSError:
            unfinished.rename(path)  # a file system without links
    except OSError:
        os.close(file)
        raise
    finally:
        unfinished.unlink(missing_ok=True)
    return file


def _write(file: int, content: bytes | bytearray, place: int) -> None:
    """Write all of it, or raise OSError."""
    if os.pwrite(file, content, place) < len(content):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _lock(file: int) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise _taken() from None


def _taken() -> BlockingIOError:
    return BlockingIOError(errno.EAGAIN, "another node of this name keeps its state there")


def _has_name(file: int, path: Path) -> bool:
    """Whether an open file is the one of a name."""
    try:
        return os.path.samestat(os.fstat(file), path.stat())
    except FileNotFoundError:
        return False


def _is_there(path: Path) -> bool:
    """Whether a link leads somewhere; one that goes in a circle or where nobody may look does."""
    try:
        path.stat()
    except FileNotFoundError:
        return False
    except OSError:
        pass
    return True


def _is_header(header: bytes) -> bool:
    """Whether a file of this version may begin so, whosever it is."""
    whole = header[: _HEADER.size]
    return header.startswith(_MAGIC) and header == whole + _CHECKSUM.pack(zlib.crc32(whole))


def _fingerprint(robot: Robot) -> bytes:
    """What tells a robot, its description and its modes from others.

    All fields count but those of the tracker, which moves nothing of the robot; comments do not.
    """
    written = robot.description.written
    fields = {} if written is None else {**written.content, "tracker": None}
    text = json.dumps(fields, default=repr, sort_keys=True)
    described = f"{text}\0{robot.motor_list}\0{robot.state_size}"
    return hashlib.sha256(described.encode()).digest()


def _fingerprint_of_motors(robot: Robot) -> bytes:
    """What tells the motors of a robot from those of others, whatever else is said of it."""
    return hashlib.sha256(f"{robot.description.name}\0{robot.motor_list}".encode()).digest()

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A small file that one process has at a time; under its name it is whole or not there. No ROS here."""

from __future__ import annotations

import errno
import fcntl
import os
import secrets
from contextlib import suppress
from pathlib import Path

__all__ = ["LockedFile", "link_to_nowhere"]


def link_to_nowhere(file: Path) -> Path | None:
    """A link on the way to a file, or the file itself, whose target is not there; None: there is none.

    The target may be on a disk that is away for now, and know where the robot is.
    """
    return next(
        (part for part in (file, *file.parents) if part.is_symlink() and not _is_there(part)), None
    )


class LockedFile:
    """An open file with a lock, which goes with the process."""

    def __init__(self, path: Path, content: bytes | bytearray) -> None:
        """Open a file and lock it; where there is none, make one of some content.

        Raises:
            OSError: It cannot be written, or a link on the way to it leads nowhere.
            BlockingIOError: Another node has it.
        """
        if link := link_to_nowhere(path):
            raise FileNotFoundError(errno.ENOENT, "a link that leads nowhere", str(link))
        path.parent.mkdir(parents=True, exist_ok=True)
        self._path, self._file = path, _open_or_make(path, content)

    def close(self) -> None:
        """Let the file go; what is in it stays."""
        os.close(self._file)

    @property
    def named(self) -> bool:
        """Whether the file is still the one of its name: others may have removed or replaced it."""
        return _has_name(self._file, self._path)

    def read(self, count: int) -> bytes:
        """The first bytes, as many as there are of so many."""
        return os.pread(self._file, count, 0)

    def write(self, content: bytes | bytearray, place: int) -> None:
        """Write all of it, or raise OSError."""
        _write(self._file, content, place)

    def rewrite(self, content: bytes | bytearray) -> None:
        """Let this be all that is in the file; under its name again, if that was taken away.

        Raises:
            OSError: It cannot be written.
            BlockingIOError: Another node has its name meanwhile.
        """
        if not self.named:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            removed, self._file = self._file, _open_or_make(self._path, content)
            os.close(removed)
        self.write(content, 0)
        os.ftruncate(self._file, len(content))

    def clear(self) -> None:
        """Let nothing be in the file, or raise OSError."""
        os.ftruncate(self._file, 0)

    def reserve(self, size: int) -> None:
        """Ask the disk for so many bytes, so that a full one is told of now; its times stay."""
        written = os.fstat(self._file)
        os.posix_fallocate(self._file, 0, size)
        with suppress(PermissionError):  # others' files have their time
            os.utime(self._file, ns=(written.st_atime_ns, written.st_mtime_ns))


def _open_or_make(path: Path, content: bytes | bytearray) -> int:
    """The file, open and locked."""
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

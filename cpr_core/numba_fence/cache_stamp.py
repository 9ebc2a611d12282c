# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Machine code on disk that is renewed when anything changes that it was made from.

numba renews a cached function when the file that defines it changes, but not when a function it calls
from another file does; after an edit or an upgrade stale code would run. It compares a stamp, which is
the time and the size of the file, unless it is replaced.

It also writes into an index which file holds the code for which types before it writes that file:
another process could read, or number, a file in between. Reading and writing are therefore locked.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba import njit
from numba.core.caching import IndexDataCacheFile

from .kept_code import KeptCode

__all__ = ["CacheFile", "stamp_cache"]


class CacheFile(IndexDataCacheFile):
    """The machine code of a function on disk, for all types it has been compiled for."""

    def load(self, key: Any) -> Any:
        """Code for some types, or None."""
        with self._locked(fcntl.LOCK_SH):
            return super().load(key)

    def save(self, key: Any, data: Any) -> None:
        """Keep code for some types."""
        with self._locked(fcntl.LOCK_EX):
            super().save(key, data)

    def _load_index(self) -> Any:
        # It may name types that an earlier version had: then it is as good as not there.
        try:
            return super()._load_index()
        except (AttributeError, ImportError):
            return {}

    @contextmanager
    def _locked(self, how: int) -> Iterator[None]:
        """Lock the folder, which may be without permission to write, or not there yet."""
        try:
            folder = os.open(self._cache_path, os.O_RDONLY)
        except OSError:
            yield
            return
        try:
            fcntl.flock(folder, how)
            yield
        finally:
            os.close(folder)


def stamp_cache(dispatcher: Any, stamp: tuple[str, int]) -> None:
    """Replace the stamp of a compiled function's machine code, before it is called first."""
    dispatcher._cache.__class__ = KeptCode
    cache_file = dispatcher._cache._cache_file
    cache_file._source_stamp = stamp
    cache_file.__class__ = CacheFile


def _probe() -> None:
    pass


# What has another name in this version would be replaced without effect.
for _name in ("_source_stamp", "_cache_path", "_load_index", "load", "save"):
    getattr(njit(cache=True)(_probe)._cache._cache_file, _name)

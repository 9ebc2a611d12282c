# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Machine code on disk that is renewed when anything changes that it was made from.

numba renews a cached function when the file that defines it changes, but not when a function it calls
from another file does; after an edit or an upgrade stale code would run. It compares a stamp, which is
the time and the size of the file, unless it is replaced.
"""

from __future__ import annotations

from typing import Any

from numba import njit
from numba.core.caching import IndexDataCacheFile

__all__ = ["stamp_cache"]


class _CacheFile(IndexDataCacheFile):
    """What is on disk may name types that an earlier version had: then it is as good as not there."""

    def _load_index(self) -> Any:
        try:
            return super()._load_index()
        except (AttributeError, ImportError):
            return {}


def stamp_cache(dispatcher: Any, stamp: tuple[str, int]) -> None:
    """Replace the stamp of a compiled function's machine code, before it is called first."""
    cache_file = dispatcher._cache._cache_file
    cache_file._source_stamp = stamp
    cache_file.__class__ = _CacheFile


def _probe() -> None:
    pass


# A stamp under another name would be set without effect.
for _name in ("_source_stamp", "_load_index"):
    getattr(njit(cache=True)(_probe)._cache._cache_file, _name)

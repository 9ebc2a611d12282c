# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Machine code that cannot be kept on disk.

Where it cannot be written, on a full disk say, numba ends the call that asked for it, though the code is
there to run. Here that is said, once.
"""

from __future__ import annotations

import warnings
from functools import cache
from typing import Any

from numba.core.caching import FunctionCache

__all__ = ["KeptCode"]


class KeptCode(FunctionCache):
    """Keeps machine code where that is possible; where it is not, a warning says so."""

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep code for some types."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            _warn_of(self.cache_path, error.strerror or str(error))


@cache
def _warn_of(folder: str, reason: str) -> None:
    warnings.warn(
        f"compiled kernels cannot be kept in {folder} ({reason}): every process compiles them again; "
        "NUMBA_CACHE_DIR names another folder",
        RuntimeWarning,
        stacklevel=2,
    )

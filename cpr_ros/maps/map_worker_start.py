# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How the process that makes a map begins: ``python -m cpr_ros.maps.map_worker_start FD``."""

from __future__ import annotations

import gc
import sys

__all__ = ["main"]


def main(arguments: list[str]) -> int:
    """Import everything and make the map; returns the exit status.

    Args:
        arguments: Of :func:`map_worker.main`.
    """
    gc.disable()  # all of this stays: to look for garbage in it took a tenth of the time of a small map
    from .map_worker import main as make

    gc.freeze()
    gc.enable()
    return make(arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The command ``cpr_demo``: a node, driven along a path of the paper."""

from __future__ import annotations

import sys

from .process.missing_packages import what_is_missing_told

__all__ = ["main"]


def main(arguments: list[str] | None = None) -> int:
    """Run the demonstration.

    Args:
        arguments: With the name of the program first; None for those of the process.

    Returns:
        Exit status: 0; 1 if something is not installed or does not work.
    """
    with what_is_missing_told("cpr_demo"):
        from .demonstration import run
    return run(sys.argv if arguments is None else arguments)


if __name__ == "__main__":
    sys.exit(main())

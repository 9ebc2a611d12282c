# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The command ``cpr_view``: the page of a running node."""

from __future__ import annotations

import sys

from .process.missing_packages import what_is_missing_told

__all__ = ["main"]


def main(arguments: list[str] | None = None) -> int:
    """Show the page until SIGINT or SIGTERM.

    Args:
        arguments: With the name of the program first; None for those of the process.

    Returns:
        Exit status: 0; 1 if something is not installed, the address cannot be had, or the name is none.
    """
    with what_is_missing_told("cpr_view"):
        from .page.view_run import run
    return run(sys.argv if arguments is None else arguments)


if __name__ == "__main__":
    sys.exit(main())

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The command ``cpr_node``. It takes signals over before it imports anything that takes time."""

from __future__ import annotations

import gc
import signal
import sys

from .process.missing_packages import what_is_missing_told
from .process.stop_signal import StopSignal

__all__ = ["main"]


def main(arguments: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM, and end the process.

    Args:
        arguments: With the name of the program first; None for those of the process.

    Returns:
        Exit status: 0; 1 if the node cannot start; 2 for arguments it does not know.
    """
    stop = StopSignal()
    from .settings.node_arguments import unknown_arguments, usage

    arguments = sys.argv if arguments is None else arguments
    if {"-h", "--help"} & set(arguments[1:]):
        return _print_usage(usage())
    unknown = unknown_arguments(arguments[1:])
    if unknown:
        for line in unknown:
            print(f"cpr_node: {line}", file=sys.stderr)
        print("cpr_node: see cpr_node --help", file=sys.stderr)
        return 2
    gc.disable()  # all of this stays: to look for garbage in it took a seventh of the time
    with what_is_missing_told("cpr_node"):
        from .node import CprNode
        from .node_run import run
    gc.freeze()
    gc.enable()
    return run(CprNode, arguments, stop)


def _print_usage(text: str) -> int:
    """Print it, and end as other programs do when nobody reads on (`cpr_node --help | head`)."""
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    print(text, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

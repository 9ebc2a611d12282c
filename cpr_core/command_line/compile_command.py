# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the command line shows while kernels are compiled."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from tqdm import tqdm

from ..kernel_warmup import compile_kernels, kernel_names, watch_compilation

__all__ = ["compile_all", "show_compilation"]


@contextmanager
def show_compilation() -> Iterator[None]:
    """Say on standard error when kernels are compiled, with their names on a terminal."""
    bars: list[tqdm] = []
    seen: set[str] = set()

    def begun(name: str) -> None:
        if not bars:
            print(
                "cpr: compiling kernels, once after an installation or an upgrade (one or two minutes)",
                file=sys.stderr,
                flush=True,
            )
            bars.append(tqdm(total=len(kernel_names()), unit=" kernels", disable=None, leave=False))
        seen.add(name)
        bars[0].set_postfix_str(name, refresh=False)
        bars[0].update(len(seen) - bars[0].n)

    try:
        with watch_compilation(begun):
            yield
    finally:
        for bar in bars:
            bar.close()


def compile_all() -> str:
    """Compile every kernel; returns what to print."""
    begin, compiled = time.monotonic(), list[str]()
    with watch_compilation(compiled.append):
        for _ in compile_kernels():
            pass
    if not compiled:
        return f"all {len(kernel_names())} kernels were compiled before"
    return f"{len(set(compiled))} kernels compiled in {time.monotonic() - begin:.0f} s"

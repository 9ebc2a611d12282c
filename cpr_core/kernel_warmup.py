# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Compiling the kernels before they are needed, and telling whoever waits when one is compiled.

Importing compiles nothing. A kernel is compiled when it is called first after an installation; the
machine code is kept on disk, from where later processes load it.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event
from numba.core.dispatcher import Dispatcher

from .kernels.kernel_decorators import KERNEL_MODULES
from .model.robot import load_robot
from .solving.geometrico_statics import solve_forward
from .solving.home import solve_home

__all__ = ["compile_kernels", "kernel_names", "watch_compilation"]


class _Listener(event.Listener):
    """Hears when numba compiles; loading from disk is no such event."""

    def __init__(self, begun: Callable[[str], None]) -> None:
        self._begun = begun

    def on_start(self, event: Any) -> None:
        function = event.data["dispatcher"].py_func
        if (function.__module__ or "").startswith(f"{__package__}."):
            self._begun(_name(function))

    def on_end(self, event: Any) -> None:
        pass


@contextmanager
def watch_compilation(begun: Callable[[str], None]) -> Iterator[None]:
    """Call ``begun`` with the name of every kernel that begins to be compiled, in any thread.

    A kernel that is compiled for two kinds of arguments is named twice.
    """
    with event.install_listener("numba:compile", _Listener(begun)):
        yield


def compile_kernels() -> Iterator[str]:
    """Compile every kernel that is not on disk yet; yields what can be used from then on.

    Kernels know every robot as arrays of the same types: what one robot needs is what all need.
    """
    robot = load_robot("rfrfr", modes=2)
    home = solve_home(robot)
    solve_forward(robot, home.motors, start=home)
    yield "solver"
    from .workspace import map_workspace, pose_grid

    x, y = home.platform_position[:2].tolist()
    grid = pose_grid(robot, {"x": [x - 0.01, x], "y": [y - 0.01, y]}, resolution=0.01)
    map_workspace(robot, grid, workers=0)
    yield "maps"


def kernel_names() -> tuple[str, ...]:
    """Names of all kernels, as they are called while they are compiled."""
    kernels = {
        member.py_func
        for module in KERNEL_MODULES
        for member in vars(importlib.import_module(f"{__package__}.{module}")).values()
        if isinstance(member, Dispatcher)
    }
    return tuple(sorted(_name(function) for function in kernels))


def _name(function: Callable[..., Any]) -> str:
    return f"{function.__module__.removeprefix(f'{__package__}.')}.{function.__name__}"

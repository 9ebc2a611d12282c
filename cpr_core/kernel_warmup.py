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

import numpy as np

from .identification.felt_wrench import estimate_wrench
from .kernels.kernel_sources import kernel_modules, read_sources
from .kernels.prepared_robot import evaluate_record
from .lie import roll_pitch_yaw, rotation_from_angles
from .model.kinemato_statics import kinemato_statics
from .numba_fence import hear_compilation
from .solving.discretisation_error import error_of
from .solving.geometrico_statics import solve_forward
from .solving.home import solve_home
from .solving.limits import undisturbed
from .solving.load_robot import load_robot
from .solving.parameter_derivatives import derivatives

__all__ = ["compile_kernels", "kernel_names", "watch_compilation"]

_PACKAGE = __name__.partition(".")[0]


@contextmanager
def watch_compilation(begun: Callable[[str], None]) -> Iterator[None]:
    """Call ``begun`` with the name of every kernel that begins to be compiled, in any thread.

    A kernel that is compiled for two kinds of arguments is named twice. None is named if this version of
    numba does not tell.
    """

    def heard(function: Callable[..., Any]) -> None:
        if (function.__module__ or "").startswith(f"{_PACKAGE}."):
            begun(_name(function))

    with hear_compilation(heard):
        yield


def compile_kernels() -> Iterator[str]:
    """Compile every kernel that is not on disk yet; yields what can be used from then on.

    References are left out: they take long to compile, and few compare with them.

    Kernels know every robot as arrays of the same types: what one robot needs is what all need.
    """
    robot = load_robot("rfrfr", modes=2)
    home = solve_home(robot)
    solve_forward(robot, home.motors, start=home)
    _ = home.margin
    rotation_from_angles(*roll_pitch_yaw(home.platform_rotation))
    undisturbed(np.ones((2, 1)))  # as robots with limits are
    kinemato_statics(home).smallest_singular_value("forward")
    evaluate_record(robot.prepared, home.load_arrays, home.record)  # as straight legs are
    error_of(home)
    estimate_wrench(robot, home.motors, efforts=home.efforts, effort_deviation=1.0)
    yield "solver"
    from .solving.find_equilibria import find_equilibria
    from .workspace import map_workspace, pose_grid

    find_equilibria(robot, home.motors, starts=1)
    x, y = home.platform_position[:2].tolist()
    grid = pose_grid(robot, {"x": [x - 0.01, x], "y": [y - 0.01, y]}, resolution=0.01)
    map_workspace(robot, grid, workers=0)
    yield "maps"
    derivatives(home, "legs[0].base.position[0]")
    yield "derivatives"


def kernel_names() -> tuple[str, ...]:
    """Names of all kernels, as they are called while they are compiled."""
    modules = (
        importlib.import_module(f"{_PACKAGE}.{module}") for module in kernel_modules(read_sources())
    )
    functions = {
        member.py_func
        for module in modules
        for member in vars(module).values()
        if getattr(getattr(member, "py_func", None), "__module__", None) == module.__name__
    }
    return tuple(sorted(_name(function) for function in functions))


def _name(function: Callable[..., Any]) -> str:
    return f"{function.__module__.removeprefix(f'{_PACKAGE}.')}.{function.__name__}"

# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Ways from Python into kernels that only kernels call."""

from inspect import getfile, signature

import numpy as np

from cpr_core.kernels.pencil import pencil_of
from cpr_core.kernels.prepared_robot import PreparedRobot
from cpr_core.kernels.workspace_arrays import workspace
from cpr_core.numba_fence import njit
from helpers.kept_kernel import kept

#: Parameters of kernels that are handed over by their address.
_PREPARED = ("robot", "work", "pencil")


def entry(kernel):
    """What calls a kernel, or a function that calls kernels: without, Python would crash.

    Its robot, workspace and pencil go through a :class:`PreparedRobot`. To take their hundred arrays
    apart would be longer to compile than all the rest.
    """
    function = getattr(kernel, "py_func", kernel)
    names = list(signature(function).parameters)
    others = [name for name in names if name not in _PREPARED]
    passed = ", ".join(f"prepared.{name}" if name in _PREPARED else name for name in names)
    name = f"{function.__module__.rpartition('.')[2]}_{function.__name__}"
    source = f"def {name}({', '.join(['prepared', *others])}): return kernel({passed})"
    called = njit(kernel) if kernel is function else kernel
    call = kept(name, source, getfile(function), kernel=called)

    def enter(*arguments):
        given = dict(zip(names, arguments, strict=True))
        robot, work, pencil = (given.pop(name, None) for name in _PREPARED)
        return call(None if robot is None else prepared(robot, work, pencil), *given.values())

    return enter


def prepared(robot, work=None, pencil=None):
    """The three for kernels; what is not given, no kernel looks at."""
    if work is None:
        work = workspace(robot)
    if pencil is None:
        pencil = pencil_of(robot, np.zeros((robot.platform_index,) * 2))
    return PreparedRobot(robot, work, pencil)

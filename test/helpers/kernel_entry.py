# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Ways from Python into kernels that only kernels call."""

import hashlib
from inspect import getfile, signature
from pathlib import Path

import numpy as np

from cpr_core.kernels import kernel_decorators
from cpr_core.kernels.kernel_arrays import workspace
from cpr_core.kernels.pencil import pencil_of
from cpr_core.kernels.prepared_robot import PreparedRobot
from cpr_core.numba_fence import compile_kernel, njit

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
    # Its machine code is kept beside this file, under a name of its own.
    name = f"{function.__module__.rpartition('.')[2]}_{function.__name__}"
    source = f"def {name}({', '.join(['prepared', *others])}): return kernel({passed})"
    scope = {"kernel": njit(kernel) if kernel is function else kernel, "__name__": __name__}
    exec(compile(source, __file__, "exec"), scope)
    call = compile_kernel(scope[name], _stamp(function), False, no_cfunc_wrapper=True)

    def enter(*arguments):
        given = dict(zip(names, arguments, strict=True))
        robot, work, pencil = (given.pop(name, None) for name in _PREPARED)
        return call(None if robot is None else prepared(robot, work, pencil), *given.values())

    return enter


def _stamp(function):
    """Fingerprint of what an entry is made from: all kernels, the function, and this file."""
    fingerprint, size = kernel_decorators._STAMP
    sources = b"".join(Path(path).read_bytes() for path in (getfile(function), __file__))
    return hashlib.sha256(fingerprint.encode() + sources).hexdigest(), size + len(sources)


def prepared(robot, work=None, pencil=None):
    """The three for kernels; what is not given, no kernel looks at."""
    if work is None:
        work = workspace(robot)
    if pencil is None:
        pencil = pencil_of(robot, np.zeros((robot.platform_index,) * 2))
    return PreparedRobot(robot, work, pencil)

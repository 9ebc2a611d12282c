# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Functions around kernels that only tests have, kept on disk as kernels are: each takes 0.1 to 2 s."""

import hashlib
from pathlib import Path

from cpr_core.kernels import kernel_decorators
from cpr_core.numba_fence import compile_kernel


def kept(name, source, file, **called):
    """The compiled function of that name; what it calls is given beside its source.

    Its machine code is kept beside this file, and renewed when a kernel changes, its source, this file,
    or the one whose functions it calls. The name has to be its own.
    """
    scope = {"__name__": __name__, **called}
    exec(compile(source, __file__, "exec"), scope)
    fingerprint, size = kernel_decorators._STAMP
    sources = b"".join([source.encode(), *(Path(path).read_bytes() for path in (file, __file__))])
    stamp = hashlib.sha256(fingerprint.encode() + sources).hexdigest(), size + len(sources)
    return compile_kernel(scope[name], stamp, False, no_cfunc_wrapper=True)

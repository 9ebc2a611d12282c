# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What types of our own are made with: numba's low-level extension interface, and what it rests on."""

from numba.core import cgutils, types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model
from numba.np import arrayobj

__all__ = [
    "AbstractTemplate",
    "arrayobj",
    "cgutils",
    "infer_global",
    "intrinsic",
    "ir",
    "lower_builtin",
    "models",
    "register_model",
    "signature",
    "types",
]

ir = cgutils.ir  # llvmlite's, as numba brings it
